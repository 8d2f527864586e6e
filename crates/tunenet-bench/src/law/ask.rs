//! The tool under test, started as a user starts it. A simulation file and recordings are all that it gets.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use tunenet_cli::files::programs;

use super::answer::Answer;
use super::files::Files;

/// A search that takes longer has failed.
const PATIENCE: Duration = Duration::from_secs(900);
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// What came back.
pub enum Reply {
    /// An answer, and the file that it wrote, if it wrote one.
    Answered(Answer, Option<PathBuf>),
    /// No answer: the last line of its errors.
    Failed(String),
}

/// Asks the installed tool about the recordings of `files`.
pub fn ask(files: &Files) -> Result<Reply> {
    let tool = programs::sibling(programs::TUNENET)?;
    let improved = files.folder.join("improved.toml");
    let (answer, errors) = (files.folder.join("answer.json"), files.folder.join("errors.txt"));
    let mut command = Command::new(&tool);
    command.args(["diagnose", "--law", "--json", "--quiet", "--jobs", "1", "--sim"]).arg(&files.simulation);
    command.args(&files.fitted).arg("--held-out").args(&files.held_out).arg("--out").arg(&improved);
    let sink = |path: &Path| File::create(path).with_context(|| format!("creating {}", path.display()));
    let mut child = command
        .stdin(Stdio::null())
        .stdout(sink(&answer)?)
        .stderr(sink(&errors)?)
        .spawn()
        .with_context(|| format!("starting {}", tool.display()))?;
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if began.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            return Ok(Reply::Failed(format!("no answer within {} s", PATIENCE.as_secs())));
        }
        std::thread::sleep(LOOK_EVERY);
    };
    // 3: finished, and without one answer.
    if !matches!(status.code(), Some(0 | 3)) {
        let text = std::fs::read_to_string(&errors)?;
        let last = text.lines().find(|line| !line.trim().is_empty()).unwrap_or("no message");
        return Ok(Reply::Failed(format!("{status}: {last}")));
    }
    let object = serde_json::from_str(&std::fs::read_to_string(&answer)?)?;
    Ok(match Answer::read(&object) {
        Ok(answer) => Reply::Answered(answer, improved.is_file().then_some(improved)),
        Err(error) => Reply::Failed(format!("an answer of another form: {error:#}")),
    })
}
