//! The verdict of an answer that was read back from a file.

use serde::Deserialize;
use tunenet_core::{diagnose, tune};

use crate::exit_status::Exit;

/// The verdict of an answer, by either tool. No word is a verdict of both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
pub enum Verdict {
    Tune(tune::Verdict),
    Diagnose(diagnose::Verdict),
}

impl Verdict {
    /// How the command that gave the answer ended.
    pub fn exit(self) -> Exit {
        match self {
            Self::Tune(verdict) => verdict.into(),
            Self::Diagnose(verdict) => verdict.into(),
        }
    }
}
