//! A finding about a video, as it crosses from one program to the other.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use tunenet_core::finding::FindingKind;
use tunenet_core::observation::Note;

use crate::findings;

/// What was found, in words, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VideoFinding {
    /// What it is.
    #[serde(rename = "code", deserialize_with = "known")]
    pub kind: FindingKind,
    /// One sentence: what was found and where.
    pub text: String,
    /// What to try.
    pub remedy: String,
}

impl VideoFinding {
    /// A finding from its three parts.
    pub fn new(kind: FindingKind, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind, text: text.into(), remedy: remedy.into() }
    }

    /// The same as a note of any recording.
    #[must_use]
    pub fn note(&self) -> Note {
        Note::new(self.kind, &self.text, &self.remedy)
    }
}

/// The kind with a code that this crate declares.
fn known<'de, D: Deserializer<'de>>(deserializer: D) -> Result<FindingKind, D::Error> {
    let code = String::deserialize(deserializer)?;
    let kind = findings::ALL.iter().find(|kind| kind.code() == code);
    kind.copied()
        .ok_or_else(|| D::Error::custom(format!("expected the code of a finding about a video, found `{code}`")))
}
