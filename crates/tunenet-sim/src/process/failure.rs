//! Why a program cannot continue, in one sentence for users.

use std::path::Path;

use tunenet_core::text::visible;
use tunenet_formats::Error;

/// Most characters of what a program printed that a sentence repeats.
const LONGEST_SHOWN: usize = 160;

/// What went wrong with a program, and what to try. Other parameters would not mend it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Failure {
    pub message: String,
    pub hint: String,
    /// Whether it answers otherwise than it did: nothing that it said before can be relied on either.
    pub drift: bool,
}

impl Failure {
    pub fn new(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { message: message.into(), hint: hint.into(), drift: false }
    }

    /// Of a program that answers otherwise than it did.
    pub fn drift(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { drift: true, ..Self::new(message, hint) }
    }

    /// As an error of the simulation file.
    pub fn error(self, file: &Path) -> Error {
        Error::file(file, self.message, self.hint)
    }
}

/// What a stranger's program printed, fit for a terminal and a sentence: one line without control characters, cut where it is
/// long.
pub(super) fn printable(text: &str) -> String {
    let (mut shown, left_out) = beginning(text);
    if left_out > 0 {
        shown.push('…');
    }
    shown
}

/// As much of it as a sentence repeats, and how many characters are left out.
pub(super) fn beginning(text: &str) -> (String, usize) {
    let text = text.trim();
    let shown: String = text.chars().take(LONGEST_SHOWN).collect();
    (visible(&shown), text.chars().count().saturating_sub(LONGEST_SHOWN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_program_prints_cannot_write_on_the_terminal() {
        assert_eq!(printable(" a\u{1b}[31mb\r\nc\u{202e} "), "a\u{fffd}[31mb\u{fffd}\u{fffd}c\u{fffd}");
        assert_eq!(printable(&"x".repeat(1000)).chars().count(), LONGEST_SHOWN + 1);
    }
}
