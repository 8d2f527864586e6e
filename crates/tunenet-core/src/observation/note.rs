//! Something a person should know about a recording.

use serde::Serialize;

use crate::finding::FindingKind;

/// Something noticed: what it is, in words, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Note {
    /// What kind of finding it is; its code serves scripts.
    #[serde(rename = "code")]
    pub kind: FindingKind,
    /// One sentence: what was found and where.
    pub text: String,
    /// What to try; may be empty.
    pub remedy: String,
}

impl Note {
    /// A note from its three parts.
    pub fn new(kind: FindingKind, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind, text: text.into(), remedy: remedy.into() }
    }
}
