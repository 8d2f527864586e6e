//! The versions of the protocol.

/// A version of the protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Version {
    /// Parameters and settings.
    One,
    /// Recordings with inputs, initial states and candidate effects too, and many rollouts in one line.
    Two,
}

impl Version {
    /// As the lines have it.
    pub fn number(self) -> u64 {
        match self {
            Self::One => 1,
            Self::Two => 2,
        }
    }
}
