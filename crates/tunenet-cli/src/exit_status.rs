//! Exit status of commands: 0 done, 1 refused, 2 wrong usage, 3 completed without a usable result.

use std::process::ExitCode;

use tunenet_core::{diagnose, tune};

use crate::answers::law::AnswerVerdict;

/// How a command ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// Done.
    Done = 0,
    /// I/O or invalid input.
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

impl From<AnswerVerdict> for Exit {
    /// One effect or one law is an answer; a set of laws is none, like one of effects.
    fn from(verdict: AnswerVerdict) -> Self {
        match verdict {
            AnswerVerdict::Law => Self::Done,
            AnswerVerdict::OneOfLaws => Self::Inconclusive,
            AnswerVerdict::Effects(verdict) => verdict.into(),
        }
    }
}
