//! Several files, each described on its own, one after the other.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};

use super::{Found, Standing};
use crate::answers::motion::Motion;
use crate::exit_status::Exit;
use crate::failure::{hint, sentence};
use crate::files::names;
use crate::view::answer::Printout;
use crate::view::text::without_try;

/// What was found in the files so far.
pub struct Listing {
    pub shown: Printout,
    /// The object of each file, refused ones as well.
    pub objects: Vec<Value>,
    /// How the command ends with them: a file that is refused outweighs one that is of no use.
    pub worst: Exit,
}

impl Listing {
    pub fn new() -> Self {
        Self { shown: Printout::default(), objects: Vec::new(), worst: Exit::Done }
    }

    /// Adds the file at `path` as `look` describes it, or why it is refused; its motion, where it shows one.
    pub fn add(&mut self, path: &Path, look: impl FnOnce(&mut Printout) -> Result<Found>) -> Option<Motion> {
        let name = names::file_name(path);
        self.shown.row("file", &name);
        let (standing, object, motion) = match look(&mut self.shown) {
            Ok(found) => (found.standing, found.object, found.motion),
            Err(error) => {
                let text = sentence(&error);
                self.shown.row("refused", &text);
                if let Some(hint) = hint(&error) {
                    self.shown.line(&format!("  try: {}", without_try(hint)));
                }
                let object = json!({ "schema": "tunenet.inspect/1", "file": name, "usable": false, "error": text, "remedy": hint(&error) });
                (Standing::Refused, object, None)
            }
        };
        self.worst = match (self.worst, standing) {
            (Exit::Refused, _) | (_, Standing::Refused) => Exit::Refused,
            (Exit::Done, standing) => standing.exit(),
            (worst, _) => worst,
        };
        self.objects.push(object);
        self.shown.line("");
        motion
    }
}
