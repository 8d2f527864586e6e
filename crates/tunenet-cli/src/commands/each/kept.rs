//! Answers in files: those of each recording, and all of them together.

use std::path::Path;

use anyhow::{Context, Result};
use serde::Deserialize as _;
use serde_json::{Value, json};
use tunenet_core::network::Shard;
use tunenet_formats::{Action, Error, write_atomically};

use super::verdict::Verdict;
use crate::exit_status::Exit;
use crate::view::json::print_json;
use crate::view::text::stage;

/// The answer that lies at `path`, where it was made by this very run and is no error.
pub fn kept(path: &Path, run: &str) -> Option<Value> {
    let text = std::fs::read_to_string(path).ok()?;
    let value: Value = serde_json::from_str(&text).ok()?;
    if value[RUN] != run || value.get("error").is_some() {
        return None;
    }
    Some(without_run(value))
}

fn without_run(mut value: Value) -> Value {
    if let Some(object) = value.as_object_mut() {
        object.shift_remove(RUN);
    }
    value
}

/// Writes an answer, and makes its folder.
pub fn write(path: &Path, value: &Value) -> Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|source| Error::io(folder, Action::Creating, source))?;
    }
    let text = format!("{value:#}\n");
    Ok(write_atomically(path, |file| file.write_all(text.as_bytes()))?)
}

/// The one object of all answers, and how the command ends with them.
pub fn together(tool: &str, objects: Vec<Value>, shard: Option<Shard>) -> (Exit, Value) {
    let refused = objects.iter().filter(|object| object.get("error").is_some()).count();
    let done =
        |object: &Value| Verdict::deserialize(&object["verdict"]).is_ok_and(|verdict| verdict.exit() == Exit::Done);
    let exit = if refused > 0 {
        Exit::Refused
    } else if objects.iter().all(done) {
        Exit::Done
    } else {
        Exit::Inconclusive
    };
    stage("done", &format!("{} observations, {refused} refused", objects.len()));
    let mut all = json!({ "schema": format!("tunenet.{tool}.each/1") });
    if let Some(shard) = shard {
        all["shard"] = json!(shard.to_string());
    }
    all["observations"] = Value::Array(objects);
    (exit, all)
}

/// What one run would have answered, from the answers that shards have brought to `folder`.
pub fn merged(tool: &str, recordings: &[String], folder: &Path, as_json: bool) -> Result<Exit> {
    let mut objects = Vec::with_capacity(recordings.len());
    for name in recordings {
        let path = folder.join(name);
        let text = std::fs::read_to_string(&path).map_err(|source| Error::io(&path, Action::Reading, source))?;
        let value = serde_json::from_str(&text).with_context(|| format!("{} is no answer", path.display()))?;
        objects.push(without_run(value));
    }
    let (exit, all) = together(tool, objects, None);
    write(&folder.join(ALL), &all)?;
    if as_json {
        print_json(&all)?;
    }
    stage("wrote", &folder.display().to_string());
    Ok(exit)
}

/// The key of an answer's file that says what it was made by; the answer itself is everything else.
pub const RUN: &str = "run";

/// All answers together, in addition to those for each recording.
pub const ALL: &str = "each.json";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_verdict_ends_as_its_own_command_does() {
        let exit = |verdict: &str| Verdict::deserialize(&json!(verdict)).ok().map(Verdict::exit);
        for done in ["tuned", "none", "named"] {
            assert_eq!(exit(done), Some(Exit::Done), "{done}");
        }
        for open in ["rejected", "poor_fit", "not_identifiable", "one_of", "unknown", "insufficient"] {
            assert_eq!(exit(open), Some(Exit::Inconclusive), "{open}");
        }
        assert_eq!(exit("refused"), None);
    }

    #[test]
    fn together_end_as_the_worst_of_them() {
        let exit = |objects: Vec<Value>| together("tune", objects, None).0;
        let (tuned, poor, refused) =
            (json!({"verdict": "tuned"}), json!({"verdict": "poor_fit"}), json!({"error": "no"}));
        assert_eq!(exit(vec![tuned.clone()]), Exit::Done);
        assert_eq!(exit(vec![tuned.clone(), poor.clone()]), Exit::Inconclusive);
        assert_eq!(exit(vec![tuned, poor, refused]), Exit::Refused);
    }
}
