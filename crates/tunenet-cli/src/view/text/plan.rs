//! The answer of `tunenet plan` for readers.

use crate::answers::plan::Answer;
use crate::view::answer::Printout;
use crate::view::sentence;

/// The answer for readers.
pub fn printout(answer: &Answer) -> Printout {
    let mut shown = Printout::default();
    shown.verdict(&sentence::plan(answer).to_string());
    let best = answer.plan.best();
    if !answer.plan.reachable {
        shown.line(&format!("  try: {}", what_to_move(answer)));
    } else if let Some(joints) = best.joints_rad.as_deref().filter(|j| !j.is_empty()) {
        let each: Vec<String> = joints.iter().map(|q| format!("{q:.4}")).collect();
        shown.line(&format!("  joints {} rad", each.join(", ")));
    }
    shown.warn_all(&answer.notes);
    shown
}

/// What would bring the ball through a hoop that no height brings it through.
fn what_to_move(answer: &Answer) -> &'static str {
    let plan = &answer.plan;
    let reached = || (0..plan.candidates.len()).filter(|i| plan.candidates[*i].joints_rad.is_some());
    if plan.best().pass.falls && reached().next_back() == Some(plan.best) {
        "higher releases in `release.heights_m` that the arm reaches, or a hoop that is nearer"
    } else if plan.best().pass.falls && reached().next() == Some(plan.best) {
        "lower releases in `release.heights_m` that the arm reaches, or a hoop that is farther away"
    } else {
        "a hoop that stands lower or nearer, or a plane of another tilt"
    }
}
