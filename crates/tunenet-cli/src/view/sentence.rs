//! Answers in one line, the same on the terminal and on a page.

use std::fmt::{self, Display, Formatter};

use tunenet_sim::shot::Candidate;

use super::text::in_words;
use crate::answers::plan::Answer;

/// A verdict and its sentence.
pub struct Headline {
    pub word: &'static str,
    pub sentence: String,
}

impl Display for Headline {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}  {}", self.word, self.sentence)
    }
}

/// The answer of `tunenet plan`.
pub fn plan(answer: &Answer) -> Headline {
    let best = answer.plan.best();
    let chance = best.probability.map_or(String::new(), |p| format!(", success probability {:.0} %", 100.0 * p));
    if answer.plan.reachable {
        let passes = in_words(best.pass.miss_m, "m");
        let sentence = format!("release at {:.3} m: passes {passes} from the hoop's centre{chance}", best.height_m);
        return Headline { word: "PLANNED", sentence };
    }
    Headline { word: "OUT OF REACH", sentence: missing(best) }
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
