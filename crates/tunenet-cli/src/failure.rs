//! Errors, printed once, and the exit codes.

use std::process::ExitCode;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use tunenet_core::{Error, Origin, diagnose, tune};

use crate::view::text::lines;

/// How a command ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// Done.
    Done = 0,
    /// A file's contents or the system refused.
    Refused = 1,
    /// The command line is wrong.
    Usage = 2,
    /// Completed, result inconclusive.
    Inconclusive = 3,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

impl From<tune::Verdict> for Exit {
    fn from(verdict: tune::Verdict) -> Self {
        match verdict {
            tune::Verdict::Tuned => Self::Done,
            tune::Verdict::Rejected | tune::Verdict::PoorFit | tune::Verdict::NotIdentifiable => Self::Inconclusive,
        }
    }
}

impl From<diagnose::Verdict> for Exit {
    fn from(verdict: diagnose::Verdict) -> Self {
        match verdict {
            diagnose::Verdict::None | diagnose::Verdict::Named => Self::Done,
            diagnose::Verdict::OneOf | diagnose::Verdict::Unknown | diagnose::Verdict::Insufficient => {
                Self::Inconclusive
            }
        }
    }
}

/// Prints an error to standard error and says how the process ends.
pub fn render(error: &anyhow::Error) -> Exit {
    let known = error.chain().find_map(|cause| cause.downcast_ref::<Error>());
    let exit = match known {
        Some(Error::Setting { origin: Origin::Flag | Origin::Caller, .. } | Error::DeviceUnsupported { .. }) => {
            Exit::Usage
        }
        _ => Exit::Refused,
    };
    if let Some(Error::Text { path, line, column, width, source_line, message, hint }) = known {
        anstream::eprintln!(
            "{}",
            snippet(&path.display().to_string(), *line, *column, *width, source_line, message, hint)
        );
        return exit;
    }
    let (red, reset) = (anstyle::AnsiColor::Red.on_default().bold(), anstyle::Reset);
    anstream::eprintln!("{red}error{reset}: {}", lines(&sentence(error)));
    if let Some(hint) = known.and_then(hint) {
        let cyan = anstyle::AnsiColor::Cyan.on_default().bold();
        anstream::eprintln!("{cyan}help{reset}: {}", lines(hint));
    }
    exit
}

/// What to type, where the error itself says no more than what is wrong.
fn hint(error: &Error) -> Option<&str> {
    match error {
        Error::DeviceUnsupported { .. } => {
            Some("install one with it: `cargo install --locked --path crates/tunenet-cli --features cuda`")
        }
        Error::Device { .. } => Some("check `nvidia-smi`, or train with `--device cpu`"),
        Error::Model { .. } => Some("train a model for this scene: `tunenet gen`, then `tunenet train`"),
        other => other.hint(),
    }
}

/// The whole chain in one sentence; what a message already ends with is not said again.
pub fn sentence(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if text.is_empty() {
            text = cause;
        } else if !text.ends_with(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// The offending line with a caret under what is wrong.
fn snippet(path: &str, line: usize, column: usize, width: usize, source: &str, message: &str, hint: &str) -> String {
    let byte = |characters: usize| source.char_indices().nth(characters).map_or(source.len(), |(at, _)| at);
    let (start, end) = (byte(column - 1), byte(column - 1 + width));
    let place = Snippet::source(source)
        .line_start(line)
        .path(path)
        .annotation(AnnotationKind::Primary.span(start..end.max(start)));
    let mut report: Vec<Group> = vec![Level::ERROR.primary_title(message).element(place)];
    if !hint.is_empty() {
        report.push(Group::with_title(Level::HELP.secondary_title(hint)));
    }
    Renderer::styled().render(&report)
}
