//! The code under test, asked about one set. Recordings, and the simulator as its user declares it, are all that goes in.

use anyhow::Result;
use serde::{Deserialize, Serialize};
use tunenet_core::diagnose::{Recording, Settings, Subject, Verdict, diagnose};

use super::Asked;
use super::set::{DrivenSet, Hidden};
use crate::diagnose::blind::stream;

/// The truth of one set, and the answer to it; `None` where no size of the effect reaches the ratio.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct DrivenTrial {
    pub plant: String,
    pub truth: String,
    pub ratio: f64,
    pub declared: bool,
    pub recordings: usize,
    pub answer: Option<Answer>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Answer {
    pub verdict: Verdict,
    /// The effects named, or the confusable set; the nearest where it is `unknown`.
    pub names: Vec<String>,
    /// Whether the answer says that something in no catalogue could look the same.
    pub doubt: bool,
    pub rollouts: usize,
}

impl DrivenTrial {
    fn is(&self, verdict: Verdict) -> bool {
        self.answer.as_ref().is_some_and(|answer| answer.verdict == verdict)
    }

    fn names(&self) -> &[String] {
        self.answer.as_ref().map_or(&[], |answer| &answer.names)
    }

    /// Whether nothing is hidden.
    pub fn clean(&self) -> bool {
        self.ratio == 0.0
    }

    pub fn exact(&self) -> bool {
        self.is(Verdict::Named) && self.names() == [self.truth.as_str()]
    }

    pub fn in_set(&self) -> bool {
        self.exact() || self.is(Verdict::OneOf) && self.names().contains(&self.truth)
    }

    /// Whether one effect is named alone that was not hidden.
    pub fn wrong_lone_name(&self) -> bool {
        self.is(Verdict::Named) && self.names().len() == 1 && !self.exact()
    }

    /// Whether a name is given, alone or in a set.
    pub fn named(&self) -> bool {
        self.is(Verdict::Named) || self.is(Verdict::OneOf)
    }

    /// Whether it is left open what it is.
    pub fn open(&self) -> bool {
        self.unknown() || self.is(Verdict::OneOf) && self.answer.as_ref().is_some_and(|answer| answer.doubt)
    }

    pub fn unknown(&self) -> bool {
        self.is(Verdict::Unknown)
    }
}

pub fn trial(asked: &Asked, purpose: &str, seed: u64) -> Result<DrivenTrial> {
    let Asked { plant, hidden, ratio, number } = *asked;
    let truth = hidden.name(plant);
    let mut random = stream(purpose, seed, &format!("{} {truth} {ratio}", plant.name), number);
    let set = DrivenSet::draw(plant, hidden, ratio, &mut random)?;
    let answer = set.as_ref().map(|set| answer(asked, set)).transpose()?;
    let declared = !matches!(hidden, Hidden::Undeclared(_));
    let recordings = set.map_or(0, |set| set.seen.len() + set.held_out.len());
    Ok(DrivenTrial { plant: plant.name.into(), truth: truth.into(), ratio, declared, recordings, answer })
}

fn answer(asked: &Asked, set: &DrivenSet) -> Result<Answer> {
    let simulator = asked.plant.simulator()?;
    let subjects = [Subject { name: asked.plant.name.into(), simulator: simulator.as_ref() }];
    let fitted = set.seen.iter().map(|seen| (false, seen));
    let all = fitted.chain(set.held_out.iter().map(|seen| (true, seen))).enumerate();
    let recordings: Vec<Recording> = all
        .map(|(i, (held_out, seen))| Recording { name: format!("recording {i}"), object: 0, held_out, seen })
        .collect();
    let found = diagnose(&subjects, &recordings, &Settings::default(), &|_| {})?;
    Ok(Answer {
        verdict: found.verdict(),
        names: found.names().into_iter().map(str::to_owned).collect(),
        doubt: found.conclusion.doubt().is_some(),
        rollouts: found.rollouts,
    })
}
