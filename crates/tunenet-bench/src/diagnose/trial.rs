//! One blind set, asked about once: what was hidden, what was answered.

use serde::{Deserialize, Serialize};

use super::blind::EffectKind;

/// What the code under test said of a set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// As in the JSON of `tunenet diagnose`.
    pub verdict: String,
    /// Effects that it named.
    pub effects: Vec<String>,
    /// Effects that it left to choose from.
    pub candidates: Vec<String>,
    /// Residual of the held-out recordings with the improved model, m.
    pub held_out_m: Option<f64>,
    /// The same, started from the first 40 % alone.
    pub forecast_m: Option<f64>,
    pub rollouts: u64,
    pub seconds: f64,
}

/// A set and its answer.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BlindTrial {
    /// Names of what was hidden.
    pub truth: Vec<String>,
    pub drops: usize,
    /// `None` where the effect cannot be made that large.
    pub answer: Option<Answer>,
    /// What the true world leaves of the held-out recordings, m.
    pub floor_m: Option<(f64, f64)>,
    /// The answer after the experiment that the first one asked for, where there was one.
    pub then: Option<Answer>,
}

/// How near an answer comes to the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// The truth alone was named; of exact twins, they were named together and nothing else.
    Exact,
    /// The truth is in the set that was named.
    Set,
    /// Part of the truth was named, and nothing else.
    Part,
    /// Something else was named.
    Wrong,
    /// A set without the truth was named.
    WrongSet,
    /// Something is missing, it said, and named nothing.
    Unknown,
    /// Nothing is missing, it said, or too little was recorded.
    Nothing,
}

impl BlindTrial {
    pub fn mark(&self) -> Option<Mark> {
        self.answer.as_ref().map(|answer| answer.mark(&self.truth))
    }
}

impl Answer {
    fn mark(&self, truth: &[String]) -> Mark {
        let has = |all: &[String], name: &String| all.contains(name);
        match self.verdict.as_str() {
            "named" if !twins(truth).is_empty() => Mark::Wrong,
            "named" if self.effects.iter().any(|name| !has(truth, name)) => Mark::Wrong,
            "named" if self.effects.len() == truth.len() => Mark::Exact,
            "named" => Mark::Part,
            "one_of" => {
                let offered: Vec<&String> = self.effects.iter().chain(&self.candidates).collect();
                let twins = twins(truth);
                if !truth.iter().all(|name| offered.contains(&name)) {
                    Mark::WrongSet
                } else if !twins.is_empty()
                    && offered.iter().all(|name| twins.contains(&name.as_str()))
                    && twins.iter().all(|twin| offered.iter().any(|name| name == twin))
                {
                    Mark::Exact
                } else {
                    Mark::Set
                }
            }
            "unknown" => Mark::Unknown,
            _ => Mark::Nothing,
        }
    }

    /// Whether any effect was named, alone or in a set.
    pub fn names_something(&self) -> bool {
        matches!(self.verdict.as_str(), "named" | "one_of")
    }

    /// The answer in a few words.
    pub fn words(&self) -> String {
        match self.verdict.as_str() {
            "named" => self.effects.join(" + "),
            "one_of" => {
                let mut offered: Vec<&str> = self.effects.iter().chain(&self.candidates).map(String::as_str).collect();
                offered.sort_unstable();
                offered.dedup();
                format!("{{{}}}", offered.join(", "))
            }
            other => other.to_owned(),
        }
    }
}

/// The exact twins of a single effect, itself included; empty where it has none.
pub fn twins(truth: &[String]) -> Vec<&'static str> {
    let [one] = truth else { return vec![] };
    let kind = EffectKind::CATALOGUE.into_iter().find(|kind| kind.name() == one);
    kind.map_or(vec![], |kind| kind.twins().iter().map(|twin| twin.name()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(truth: &[&str], verdict: &str, effects: &[&str], candidates: &[&str]) -> Mark {
        let owned = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
        let answer = Answer {
            verdict: verdict.into(),
            effects: owned(effects),
            candidates: owned(candidates),
            held_out_m: None,
            forecast_m: None,
            rollouts: 0,
            seconds: 0.0,
        };
        answer.mark(&owned(truth))
    }

    #[test]
    fn answers_are_marked_by_what_they_claim() {
        assert_eq!(mark(&["wind"], "named", &["wind"], &[]), Mark::Exact);
        assert_eq!(mark(&["wind"], "named", &["magnus"], &[]), Mark::Wrong);
        assert_eq!(mark(&["wind"], "named", &["wind", "magnus"], &[]), Mark::Wrong);
        assert_eq!(mark(&[], "named", &["wind"], &[]), Mark::Wrong);
        assert_eq!(mark(&["wind", "magnus"], "named", &["wind"], &[]), Mark::Part);
        assert_eq!(mark(&["wind"], "one_of", &[], &["magnus", "wind"]), Mark::Set);
        assert_eq!(mark(&["wind"], "one_of", &[], &["magnus", "linear_drag"]), Mark::WrongSet);
        assert_eq!(mark(&["wind"], "unknown", &[], &["magnus"]), Mark::Unknown);
        assert_eq!(mark(&[], "none", &[], &[]), Mark::Nothing);
    }

    #[test]
    fn twins_have_to_be_named_together() {
        let together = ["effective_gravity", "time_scale", "length_scale", "aspect_ratio"];
        assert_eq!(mark(&["time_scale"], "one_of", &[], &together), Mark::Exact);
        assert_eq!(mark(&["time_scale"], "one_of", &[], &["time_scale", "linear_drag"]), Mark::Set);
        assert_eq!(mark(&["aspect_ratio"], "one_of", &[], &["time_scale", "aspect_ratio"]), Mark::Set);
        assert_eq!(mark(&["time_scale"], "named", &["time_scale"], &[]), Mark::Wrong);
    }
}
