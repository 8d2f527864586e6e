//! The answer to one recording: kept from an earlier run, or made now.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::kept::{RUN, kept, write};
use super::{Answered, Work};
use crate::failure::sentence;
use crate::files::hash;

impl Work<'_> {
    /// The answer to recording `number` and its line: from its file where it is there, otherwise made, and written there.
    pub(super) fn treat<C>(
        &self,
        number: usize,
        name: &str,
        place: Option<&Path>,
        one: &dyn Fn(&Path, &str) -> Result<Answered<C>>,
    ) -> Result<((Value, Option<C>), String)> {
        let (path, inputs) = (&self.observation[number], self.inputs.get(number));
        let read = || std::iter::once(path).chain(inputs.into_iter().flatten());
        // What cannot be read has no digest, and is refused by whoever reads it.
        let hashes = place.and_then(|_| read().map(|file| hash::sha256(file).ok()).collect::<Option<Vec<String>>>());
        let run = hashes.map(|hashes| {
            let all = json!([env!("CARGO_PKG_VERSION"), self.tool, self.run, name, hashes]);
            hex::encode(Sha256::digest(all.to_string()))
        });
        if let (Some(place), Some(run)) = (place, &run)
            && let Some(kept) = kept(place, run)
        {
            return Ok(((kept, None), format!("{name}: kept")));
        }
        let (object, line, case) = match one(path, name) {
            Ok(Answered { mut object, line, case }) => {
                object["file"] = Value::String(name.to_owned());
                (object, format!("{name}: {line}"), case)
            }
            Err(error) => {
                let text = sentence(&error);
                // Most errors begin with the path already.
                let place = if text.contains(name) { String::new() } else { format!("{name}: ") };
                let schema = format!("tunenet.{}/1", self.tool);
                (json!({ "schema": schema, "file": name, "error": text }), format!("{place}{text}"), None)
            }
        };
        if let Some(place) = place {
            let mut whole = object.clone();
            whole[RUN] = json!(run);
            write(place, &whole)?;
        }
        Ok(((object, case), line))
    }
}
