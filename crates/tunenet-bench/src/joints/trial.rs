//! One blind set, asked about once: what was hidden, and what was answered.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::ask::{Answer, Place, Reply};
use super::files::Files;
use super::rows::Asked;
use super::servo::are_twins;
use super::set::{JointSet, Surviving, stream};

/// How near an answer comes to the truth; exact twins count as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// The truth alone.
    Exact,
    /// A set with the truth in it.
    InSet,
    /// Something else alone, be it next to the truth.
    Wrong,
    /// A set without the truth.
    WrongSet,
    /// Something is missing, it said, and nothing of the catalogue is it.
    Unknown,
    /// Nothing is missing, it said.
    Nothing,
    /// The tool gave no answer.
    Failed,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointTrial {
    /// `None` where nothing is hidden.
    pub hidden: Option<String>,
    pub ratio: f64,
    pub number: u64,
    /// `None` where no physical size reaches the ratio.
    pub outcome: Option<Outcome>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    pub mark: Mark,
    pub words: String,
    pub surviving: Surviving,
    pub rollouts: u64,
    pub seconds: f64,
}

/// Draws a set, has it answered by `ask`, and judges the answer. The files of the set stay in `room` where the answer is not right.
///
/// # Errors
/// Where files cannot be written, or `ask` fails.
pub fn trial(
    asked: &Asked,
    purpose: &str,
    seed: u64,
    room: &Path,
    ask: &(dyn Fn(&Files) -> Result<Reply> + Sync),
) -> Result<JointTrial> {
    let name = asked.cell();
    let set = JointSet::draw(
        asked.hidden.map(|secret| (secret, asked.ratio)),
        &mut stream(purpose, seed, &name, asked.number),
    );
    let mut outcome = None;
    if let Some(set) = &set {
        let folder = room.join(format!("{name}-{}", asked.number));
        if folder.exists() {
            // Of a run that was interrupted.
            std::fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
        }
        let found = judged(ask(&Files::write(&folder, set)?)?, set, asked.hidden.map(|secret| secret.name));
        let expected = if asked.hidden.is_some() { Mark::Exact } else { Mark::Nothing };
        if found.mark == expected {
            std::fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
        }
        outcome = Some(found);
    }
    let hidden = asked.hidden.map(|secret| secret.name.to_owned());
    Ok(JointTrial { hidden, ratio: asked.ratio, number: asked.number, outcome })
}

fn judged(reply: Reply, set: &JointSet, truth: Option<&str>) -> Outcome {
    let surviving = set.surviving;
    match reply {
        Reply::Failed(words) => Outcome { mark: Mark::Failed, words, surviving, rollouts: 0, seconds: 0.0 },
        Reply::Answered(answer) => Outcome {
            mark: mark(&answer, truth, set.secrets.log_gain > 0.0),
            words: answer.words(),
            surviving,
            rollouts: answer.rollouts,
            seconds: answer.seconds,
        },
    }
}

fn mark(answer: &Answer, truth: Option<&str>, gain_above: bool) -> Mark {
    match answer.verdict.as_str() {
        "none" => return Mark::Nothing,
        "named" | "one_of" => {}
        _ => return Mark::Unknown,
    }
    let is_true = |name: &str| truth.is_some_and(|truth| are_twins(truth, name, gain_above));
    let holds = |place: &Place| is_true(&place.name) || place.alternatives.iter().any(|name| is_true(name));
    let alone = |place: &Place| {
        !answer.doubt && place.alternatives.iter().all(|name| are_twins(&place.name, name, place.gain_above))
    };
    if answer.effects.iter().any(|place| alone(place) && !holds(place)) {
        Mark::Wrong
    } else if matches!(answer.effects.as_slice(), [place] if alone(place) && holds(place)) {
        Mark::Exact
    } else if answer.effects.iter().any(holds) {
        Mark::InSet
    } else {
        Mark::WrongSet
    }
}

#[cfg(test)]
mod tests {
    use super::super::servo::SECRETS;
    use super::*;

    fn said(verdict: &str, places: &[&[&str]]) -> Answer {
        let place = |names: &&[&str]| Place {
            name: names[0].into(),
            alternatives: names[1..].iter().map(ToString::to_string).collect(),
            gain_above: false,
        };
        Answer { verdict: verdict.into(), effects: places.iter().map(place).collect(), ..Answer::default() }
    }

    #[test]
    fn answers_are_marked_and_twins_count_as_one() {
        let of = |verdict: &str, places: &[&[&str]]| mark(&said(verdict, places), Some("command_delay"), false);
        assert_eq!(of("named", &[&["time_delay"]]), Mark::Exact);
        assert_eq!(of("one_of", &[&["command_delay", "time_delay"]]), Mark::Exact);
        assert_eq!(of("one_of", &[&["position_latch", "command_delay"]]), Mark::InSet);
        assert_eq!(of("one_of", &[&["command_delay", "time_delay"], &["dead_band", "backlash"]]), Mark::InSet);
        // A second name that is alone is wrong, next to the right one as well.
        assert_eq!(of("one_of", &[&["command_delay", "time_delay"], &["dead_band"]]), Mark::Wrong);
        assert_eq!(of("named", &[&["backlash"]]), Mark::Wrong);
        assert_eq!(of("one_of", &[&["backlash", "dead_band"]]), Mark::WrongSet);
        assert_eq!((of("none", &[]), of("unknown", &[])), (Mark::Nothing, Mark::Unknown));
        let doubted = Answer { doubt: true, ..said("one_of", &[&["backlash"]]) };
        assert_eq!(mark(&doubted, Some("command_delay"), false), Mark::WrongSet);
        assert_eq!(mark(&said("named", &[&["backlash"]]), None, false), Mark::Wrong);
    }

    #[test]
    fn a_gain_below_the_stated_one_is_no_twin_of_the_duty() {
        let duty = said("named", &[&["duty_limit"]]);
        assert_eq!(mark(&duty, Some("firmware_gain"), true), Mark::Exact);
        assert_eq!(mark(&duty, Some("firmware_gain"), false), Mark::Wrong);
    }

    #[test]
    fn files_stay_where_the_answer_is_not_right() {
        let room = tempfile::tempdir().unwrap();
        let asked = Asked { hidden: Some(&SECRETS[1]), ratio: 10.0, number: 0 };
        let says = |answer: Answer| move |_: &Files| Ok(Reply::Answered(answer.clone()));
        let right = trial(&asked, "test", 1, room.path(), &says(said("named", &[&["command_delay"]]))).unwrap();
        assert_eq!(right.outcome.unwrap().mark, Mark::Exact);
        assert_eq!(std::fs::read_dir(room.path()).unwrap().count(), 0);
        let wrong = trial(&asked, "test", 1, room.path(), &says(said("none", &[]))).unwrap();
        let outcome = wrong.outcome.unwrap();
        assert!(outcome.mark == Mark::Nothing && outcome.surviving.sigma > 3.0);
        assert_eq!(std::fs::read_dir(room.path()).unwrap().count(), 1);
        let fails = |_: &Files| Ok(Reply::Failed("exit status: 1".into()));
        assert_eq!(trial(&asked, "test", 1, room.path(), &fails).unwrap().outcome.unwrap().mark, Mark::Failed);
    }
}
