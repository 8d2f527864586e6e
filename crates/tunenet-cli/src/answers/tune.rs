//! What an outcome of tuning says.

use tunenet_ball::findings as ball_findings;
use tunenet_core::finding::FindingKind;
use tunenet_core::findings as core_findings;
use tunenet_core::observation::{Check, Note, State};
use tunenet_core::tune::{Outcome, Verdict};
use tunenet_sim::{ChosenNetwork, findings as sim_findings};

/// What a tuning cost in addition to its rollouts. It differs from run to run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spent {
    /// How long it took.
    pub seconds: f64,
    /// Rollouts that a program was asked for again, to test that it is deterministic.
    pub re_asks: u64,
}

/// A finished fit.
pub struct Fitted {
    pub outcome: Outcome,
    /// The network that it started with.
    pub chosen: ChosenNetwork,
    /// Rollouts that a program was asked for again, to test that it is deterministic.
    pub re_asks: u64,
}

/// The one note that says why there is no answer, or none about a contact.
pub fn reason(outcome: &Outcome) -> Option<&Note> {
    let failed: Vec<FindingKind> =
        outcome.preflight.iter().flatten().filter(|c| c.state == State::Failed).map(|c| c.kind).collect();
    let rejected = outcome.verdict == Verdict::Rejected;
    // What rejects without a list of checks says why in its one note.
    if rejected && failed.is_empty() {
        return outcome.notes.iter().find(|n| n.kind == sim_findings::ARM_UNUSABLE);
    }
    let silent = [ball_findings::CONTACT_NONE, core_findings::RECORDINGS_SHORT];
    outcome.notes.iter().find(|n| if rejected { failed.contains(&n.kind) } else { silent.contains(&n.kind) })
}

/// Which of the recordings that were given the answer rests on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Use<'a> {
    /// Their names, in their order.
    pub used: Vec<&'a str>,
    /// Those of the others, which the checks reject.
    pub rejected: Vec<&'a str>,
}

impl<'a> Use<'a> {
    /// Of the recordings that are called `names`.
    pub fn of(outcome: &Outcome, names: &'a [String]) -> Self {
        let of = |wanted: bool| {
            let pairs = names.iter().zip(&outcome.used).filter(|(_, used)| **used == wanted);
            pairs.map(|(name, _)| name.as_str()).collect()
        };
        Self { used: of(true), rejected: of(false) }
    }

    /// "1 of 2 recordings used; rejected: b.csv"; nothing where all are used, or none is.
    pub fn sentence(&self) -> Option<String> {
        let (used, rejected) = (self.used.len(), self.rejected.len());
        (used > 0 && rejected > 0)
            .then(|| format!("{used} of {} recordings used; rejected: {}", used + rejected, self.rejected.join(", ")))
    }
}

/// Whether a recording was used although its checks reject it.
pub fn forced(outcome: &Outcome) -> bool {
    let failed = |checks: &[Check]| checks.iter().any(|c| c.state == State::Failed);
    outcome.used.iter().zip(&outcome.preflight).any(|(used, checks)| *used && failed(checks))
}

/// Only an answer is worth a file.
pub fn is_written(outcome: &Outcome) -> bool {
    matches!(outcome.verdict, Verdict::Tuned | Verdict::PoorFit)
}

/// Numbers that are not all determined are worth a model where they leave less than this share of the gap.
const WORTH: f64 = 0.8;

/// Why the numbers of a fit go into no model.
pub fn why_no_model(outcome: &Outcome) -> Option<&'static str> {
    let fell = || outcome.gap.as_ref().is_some_and(|gap| gap.after < WORTH * gap.before);
    if outcome.parameters.iter().all(|one| !one.identified) {
        Some("nothing was tuned")
    } else if is_written(outcome) || fell() {
        None
    } else {
        Some("the fit leaves as much as the simulation did before")
    }
}
