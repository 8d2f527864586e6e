//! Something a person should know about a recording.

use serde::Serialize;

/// Something noticed: what it is, in words, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Note {
    /// A fixed code for scripts: `release.late`.
    pub code: &'static str,
    /// One sentence: what was found and where.
    pub text: String,
    /// What to try; may be empty.
    pub remedy: String,
}

impl Note {
    /// A note from its three parts.
    pub fn new(code: &'static str, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { code, text: text.into(), remedy: remedy.into() }
    }
}
