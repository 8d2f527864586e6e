//! The tool under test, started as a user starts it.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use serde_json::Value;
use tunenet_cli::files::programs;

/// A search that takes longer has failed.
const PATIENCE: Duration = Duration::from_secs(900);
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// What came back.
pub enum Said {
    /// The object of `--json`.
    Answered(Value),
    /// No answer: the first line of its errors.
    Failed(String),
}

/// Runs `tunenet` with `arguments`; what it prints stays in `folder`.
///
/// # Errors
/// Where it cannot be started, or `folder` cannot be written.
pub fn answered<S: AsRef<std::ffi::OsStr>>(arguments: &[S], folder: &Path) -> Result<Said> {
    let tool = programs::sibling(programs::TUNENET)?;
    let (answer, errors) = (folder.join("answer.json"), folder.join("errors.txt"));
    let sink = |path: &Path| File::create(path).with_context(|| format!("creating {}", path.display()));
    let mut child = Command::new(&tool)
        .args(arguments)
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
            return Ok(Said::Failed(format!("no answer within {} s", PATIENCE.as_secs())));
        }
        std::thread::sleep(LOOK_EVERY);
    };
    // 3: finished, and without one answer.
    if !matches!(status.code(), Some(0 | 3)) {
        let text = std::fs::read_to_string(&errors)?;
        let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or("no message");
        return Ok(Said::Failed(format!("{status}: {first}")));
    }
    Ok(Said::Answered(serde_json::from_str(&std::fs::read_to_string(&answer)?)?))
}
