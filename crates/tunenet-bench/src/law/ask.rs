//! The tool under test, started as a user starts it. A simulation file and recordings are all that it gets.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::Result;

use super::answer::Answer;
use super::files::Files;
use crate::tool::{Said, answered};

/// What came back.
pub enum Reply {
    /// An answer, and the file that it wrote, if it wrote one.
    Answered(Answer, Option<PathBuf>),
    /// No answer: the first line of its errors.
    Failed(String),
}

/// Asks the installed tool about the recordings of `files`.
pub fn ask(files: &Files) -> Result<Reply> {
    let improved = files.folder.join("improved.toml");
    let words = ["diagnose", "--law", "--json", "--quiet", "--jobs", "1", "--sim"].map(OsString::from);
    let mut given: Vec<OsString> = words.into();
    given.push(files.simulation.clone().into());
    given.extend(files.fitted.iter().map(OsString::from));
    given.push("--held-out".into());
    given.extend(files.held_out.iter().map(OsString::from));
    given.extend(["--out".into(), improved.clone().into()]);
    let object = match answered(&given, &files.folder)? {
        Said::Failed(why) => return Ok(Reply::Failed(why)),
        Said::Answered(object) => object,
    };
    Ok(match Answer::read(&object) {
        Ok(answer) => Reply::Answered(answer, improved.is_file().then_some(improved)),
        Err(error) => Reply::Failed(format!("an answer of another form: {error:#}")),
    })
}
