//! What an outcome of tuning says.

use tunenet_core::observation::{Check, Note, State};
use tunenet_core::tune::{Outcome, Verdict};

/// The one note that says why there is no answer, or none about a contact.
pub fn reason(outcome: &Outcome) -> Option<&Note> {
    let failed: Vec<&str> =
        outcome.preflight.iter().flatten().filter(|c| c.state == State::Failed).map(|c| c.code).collect();
    let rejected = outcome.verdict == Verdict::Rejected;
    // What rejects without a list of checks says why in its one note.
    if rejected && failed.is_empty() {
        return outcome.notes.iter().find(|n| n.code.ends_with(".unusable"));
    }
    let silent = ["contact.none", "recordings.short"];
    outcome.notes.iter().find(|n| if rejected { failed.contains(&n.code) } else { silent.contains(&n.code) })
}

/// Whether a recording was used although its checks reject it.
pub fn forced(outcome: &Outcome) -> bool {
    let failed = |checks: &[Check]| checks.iter().any(|c| c.state == State::Failed);
    outcome.used.iter().zip(&outcome.preflight).any(|(used, checks)| *used && failed(checks))
}
