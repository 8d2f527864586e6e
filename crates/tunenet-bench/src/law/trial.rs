//! One blind set, asked about once: what was hidden, what was answered, and how well the answer predicts.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::answer::Answer;
use super::ask::Reply;
use super::files::Files;
use super::judge::{covered, likeness};
use super::motion::Force;
use super::predict::{BROKEN, Improved, errors, over_truth};
use super::rows::Asked;
use super::set::{BlindSet, stream};
use super::term::Term;

/// How near an answer comes to the truth. Where no formula of the grammar is hidden, every formula is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// The truth alone.
    Exact,
    /// A set with the truth in it.
    InSet,
    /// Something else alone.
    Wrong,
    /// A set without the truth.
    WrongSet,
    /// Something is missing, it said, and no formula passes.
    Refused,
    /// Nothing is missing, it said.
    Nothing,
    /// The tool gave no answer.
    Failed,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LawTrial {
    pub row: String,
    pub law: String,
    pub ratio: f64,
    pub number: u64,
    /// The true law, where it is inside the grammar.
    pub truth: Option<Term>,
    /// `None` where no size of the force reaches the ratio.
    pub outcome: Option<Outcome>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    pub mark: Mark,
    pub words: String,
    /// Laws that a gate refused, with the gate.
    pub refused: Vec<String>,
    /// What the improved file leaves of the held-out and of the faster recordings over what the true world leaves; `None`
    /// without such a file.
    pub held_out: Option<f64>,
    pub faster: Option<f64>,
    /// Errors of held-out motions from their true starts: over their variance, and over the errors without the law.
    pub nmse: Option<f64>,
    pub left: Option<f64>,
    /// Constants of an answer that is the truth: whose interval holds the true value, of how many.
    pub covered: usize,
    pub constants: usize,
    pub rollouts: u64,
    pub seconds: f64,
}

impl Outcome {
    /// Whether a formula or effects are given, alone or in a set.
    pub fn accepted(&self) -> bool {
        matches!(self.mark, Mark::Exact | Mark::InSet | Mark::Wrong | Mark::WrongSet)
    }
}

/// Draws a set, has it answered by `ask`, and judges the answer. The files of the set stay in `room` where the answer is not
/// right.
pub fn trial(
    asked: &Asked,
    purpose: &str,
    seed: u64,
    room: &Path,
    ask: &(dyn Fn(&Files) -> Result<Reply> + Sync),
) -> Result<LawTrial> {
    let cell = format!("{} {}", asked.row.name(), asked.recipe.hidden.name());
    let mut random = stream(purpose, seed, &cell, asked.number);
    let set = BlindSet::draw(&asked.recipe, &mut random);
    let truth = set.as_ref().and_then(|set| match &set.world.force {
        Force::Law(term) => Some(term.clone()),
        _ => None,
    });
    let mut outcome = None;
    if let Some(set) = &set {
        let folder = room.join(format!("{}-{}", cell.replace([' ', ','], "-"), asked.number));
        if folder.exists() {
            // Of a run that was interrupted.
            std::fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
        }
        let reply = ask(&Files::write(&folder, set)?)?;
        let found = judged(reply, set, truth.as_ref());
        let expected = if asked.nothing() { Mark::Nothing } else { Mark::Exact };
        if found.mark == expected {
            std::fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
        }
        outcome = Some(found);
    }
    Ok(LawTrial {
        row: asked.row.name().into(),
        law: asked.recipe.hidden.name().into(),
        ratio: asked.recipe.ratio,
        number: asked.number,
        truth,
        outcome,
    })
}

fn judged(reply: Reply, set: &BlindSet, truth: Option<&Term>) -> Outcome {
    let mut outcome = Outcome {
        mark: Mark::Failed,
        words: String::new(),
        refused: vec![],
        held_out: None,
        faster: None,
        nmse: None,
        left: None,
        covered: 0,
        constants: 0,
        rollouts: 0,
        seconds: 0.0,
    };
    let (answer, improved) = match reply {
        Reply::Failed(why) => return Outcome { words: why, ..outcome },
        Reply::Answered(answer, improved) => (answer, improved),
    };
    outcome.mark = mark(&answer, truth);
    outcome.words = answer.words();
    outcome.refused = answer.refused.iter().map(|one| format!("{}: {}", one.gate, one.text)).collect();
    (outcome.rollouts, outcome.seconds) = (answer.rollouts, answer.seconds);
    if let Some(truth) = truth {
        (outcome.covered, outcome.constants) = covered(&answer, truth);
    }
    if let Some(path) = improved {
        let broken = |_| (BROKEN, BROKEN, BROKEN, BROKEN);
        let (held_out, faster, nmse, left) = Improved::open(&path).map_or_else(broken, |improved| {
            let errors = errors(&improved, set, &set.held_out);
            let over = |recorded| over_truth(&improved, set, recorded);
            (over(&set.held_out), over(&set.faster), errors.nmse, errors.left)
        });
        (outcome.held_out, outcome.faster) = (Some(held_out), Some(faster));
        (outcome.nmse, outcome.left) = (Some(nmse), Some(left));
    }
    outcome
}

fn mark(answer: &Answer, truth: Option<&Term>) -> Mark {
    let like = likeness(answer, truth);
    match answer.verdict.as_str() {
        _ if answer.alone() && like.first => Mark::Exact,
        _ if answer.alone() => Mark::Wrong,
        "one_of" if like.any => Mark::InSet,
        "one_of" => Mark::WrongSet,
        "none" => Mark::Nothing,
        _ => Mark::Refused,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::answer::{Effect, SaidConstant};
    use crate::law::arena::Arena;
    use crate::law::rows::LawRow;
    use crate::law::set::{Hidden, Recipe};

    fn asked(hidden: Hidden, ratio: f64) -> Asked {
        Asked { row: LawRow::Ratio10, recipe: Recipe { hidden, ratio, colour: 0.0, outliers: 0.0 }, number: 0 }
    }

    /// A tool that knows the answer: it names quadratic drag, and writes it into the file with the coefficient of `truth.json`.
    fn knows(files: &Files) -> Result<Reply> {
        let truth: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(files.folder.join("truth.json"))?)?;
        let size = truth["world"]["force"]["Law"]["size"].as_f64().unwrap();
        let restitution = truth["world"]["base"]["numbers"][0].as_f64().unwrap();
        let text = std::fs::read_to_string(&files.simulation)?
            .replace("value = 0.5", &format!("value = {restitution}"))
            + &format!("\n[effects.quadratic_drag]\nc_1_m = {}\n", -size);
        let improved = files.folder.join("improved.toml");
        std::fs::write(&improved, text)?;
        let interval95 = Some([-0.9 * size, -1.1 * size]);
        let coefficient = SaidConstant { key: "c_1_m".into(), value: -size, interval95, ..SaidConstant::default() };
        let effect = Effect { name: "quadratic_drag".into(), coefficients: vec![coefficient] };
        let answer = Answer { verdict: "named".into(), effects: vec![effect], rollouts: 7, ..Answer::default() };
        Ok(Reply::Answered(answer, Some(improved)))
    }

    #[test]
    fn a_tool_that_knows_is_exact_and_predicts_like_the_truth() {
        let room = tempfile::tempdir().unwrap();
        let found =
            trial(&asked(Hidden::Inside("drag-2", Arena::Flight), 10.0), "test", 1, room.path(), &knows).unwrap();
        let outcome = found.outcome.unwrap();
        assert_eq!((outcome.mark, outcome.covered, outcome.constants), (Mark::Exact, 1, 1));
        for ratio in [outcome.held_out.unwrap(), outcome.faster.unwrap()] {
            assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
        }
        assert!(outcome.nmse.unwrap() < 1e-6 && outcome.left.unwrap() < 1e-4);
        // What is right leaves no files.
        assert_eq!(std::fs::read_dir(room.path()).unwrap().count(), 0);
    }

    #[test]
    fn another_law_is_wrong_and_its_files_stay() {
        let room = tempfile::tempdir().unwrap();
        let found =
            trial(&asked(Hidden::Inside("drag-3", Arena::Flight), 10.0), "test", 1, room.path(), &knows).unwrap();
        let outcome = found.outcome.unwrap();
        assert_eq!(outcome.mark, Mark::Wrong);
        assert!(outcome.held_out.unwrap() > 1.01, "{outcome:?}");
        assert_eq!(std::fs::read_dir(room.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_tool_that_fails_is_counted() {
        let room = tempfile::tempdir().unwrap();
        let fails = |_: &Files| Ok(Reply::Failed("exit status: 1".into()));
        let found = trial(&asked(Hidden::Nothing(Arena::Plane), 0.0), "test", 1, room.path(), &fails).unwrap();
        assert_eq!(found.outcome.unwrap().mark, Mark::Failed);
    }

    #[test]
    fn verdicts_are_marked() {
        let said = |verdict: &str| mark(&Answer { verdict: verdict.into(), ..Answer::default() }, None);
        let marks = ["law", "named", "one_of", "none", "unknown", "insufficient"].map(said);
        let expected = [Mark::Wrong, Mark::Wrong, Mark::WrongSet, Mark::Nothing, Mark::Refused, Mark::Refused];
        assert_eq!(marks, expected);
    }
}
