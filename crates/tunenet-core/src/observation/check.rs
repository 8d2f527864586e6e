//! What was checked of a recording before anything is tuned to it, and how each check ended.

use serde::{Deserialize, Serialize};

use super::Note;
use crate::finding::FindingKind;

/// How a check ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Nothing is wrong.
    Passed,
    /// Something was found that a user should know; the recording is used.
    Noticed,
    /// The recording cannot be used.
    Failed,
    /// The check could not be made, for want of data or because it does not apply.
    NotRun,
}

impl State {
    /// A word for users: "not run".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Noticed => "noticed",
            Self::Failed => "failed",
            Self::NotRun => "not run",
        }
    }
}

/// One check of one recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Check {
    /// What is checked; its code serves scripts.
    #[serde(rename = "code")]
    pub kind: FindingKind,
    /// How it ended.
    pub state: State,
    /// What was found, in one sentence; for a check that was not run, why.
    pub text: String,
    /// What to try; empty where there is nothing to do.
    pub remedy: String,
}

impl Check {
    /// A check that found nothing wrong.
    #[must_use]
    pub fn passed(kind: FindingKind, text: impl Into<String>) -> Self {
        Self { kind, state: State::Passed, text: text.into(), remedy: String::new() }
    }

    /// A check that noticed something; the recording is used.
    #[must_use]
    pub fn noticed(kind: FindingKind, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind, state: State::Noticed, text: text.into(), remedy: remedy.into() }
    }

    /// A check that rejects the recording.
    #[must_use]
    pub fn failed(kind: FindingKind, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind, state: State::Failed, text: text.into(), remedy: remedy.into() }
    }

    /// A check that could not be made.
    #[must_use]
    pub fn not_run(kind: FindingKind, why: impl Into<String>) -> Self {
        Self { kind, state: State::NotRun, text: why.into(), remedy: String::new() }
    }

    /// What a user should know of it, where it noticed something or failed.
    #[must_use]
    pub fn note(&self) -> Option<Note> {
        matches!(self.state, State::Noticed | State::Failed).then(|| Note {
            kind: self.kind,
            text: self.text.clone(),
            remedy: self.remedy.clone(),
        })
    }
}
