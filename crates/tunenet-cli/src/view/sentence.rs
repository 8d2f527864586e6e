//! Answers in one line, the same on the terminal and on a page.

use tunenet_sim::shot::Candidate;

use super::text::in_words;
use crate::answers::plan::Answer;

/// The answer of `tunenet plan`.
pub fn plan(answer: &Answer) -> String {
    let best = answer.plan.best();
    let chance = best.probability.map_or(String::new(), |p| format!(", success probability {:.0} %", 100.0 * p));
    if answer.plan.reachable {
        let passes = in_words(best.pass.miss_m, "m");
        return format!("PLANNED  release at {:.3} m: passes {passes} from the hoop's centre{chance}", best.height_m);
    }
    format!("OUT OF REACH  {}", missing(best))
}

/// By how much a hoop is missed.
fn missing(best: &Candidate) -> String {
    let by = in_words(best.pass.miss_m, "m");
    let height = best.height_m;
    if best.pass.falls {
        format!("no height brings the ball through the hoop; from {height:.3} m it misses the centre by {by}")
    } else {
        format!("no height brings the ball up to the hoop; from {height:.3} m it comes within {by} of its centre")
    }
}
