//! Why a rollout has no values.

use std::fmt;

/// Why a rollout has no values; one sentence for users.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RolloutError {
    /// These values cannot be simulated. A fit tries others.
    Refused(String),
    /// The simulator itself failed, so that no other values help: its program ended, for one. A fit ends.
    Broken(String),
}

/// What a rollout returns.
pub type RolloutResult = Result<(), RolloutError>;

impl RolloutError {
    /// The sentence.
    #[must_use]
    pub fn message(&self) -> &str {
        match self {
            Self::Refused(message) | Self::Broken(message) => message,
        }
    }
}

impl From<String> for RolloutError {
    fn from(message: String) -> Self {
        Self::Refused(message)
    }
}

impl From<&str> for RolloutError {
    fn from(message: &str) -> Self {
        Self::Refused(message.into())
    }
}

impl fmt::Display for RolloutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl std::error::Error for RolloutError {}
