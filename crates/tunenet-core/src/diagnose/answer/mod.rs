//! What a diagnosis ends with.

pub(in crate::diagnose) mod assemble;
pub(in crate::diagnose) mod driven_experiment;
pub(in crate::diagnose) mod insufficient;
pub(in crate::diagnose) mod intervals;
pub(in crate::diagnose) mod judgement;
pub(in crate::diagnose) mod next_experiment;
pub(in crate::diagnose) mod notes;
pub(in crate::diagnose) mod odd_recording;
pub(in crate::diagnose) mod per_object;
pub(in crate::diagnose) mod residual_description;
pub(in crate::diagnose) mod verdict;

use crate::diagnose::hypothesis::plausibility::Exclusion;
use crate::diagnose::judge::Test;
use crate::diagnose::judge::validation_doubt::Doubt;
use crate::estimate::UNINFORMATIVE_SHARE;
use crate::observation::{Note, Observation};
use crate::simulator::{Effect, Parameter, Phase, Text};
use serde::{Deserialize, Serialize, Serializer};

/// The answer in one word. Each is a result, none an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing is missing that these recordings could show.
    None,
    /// These effects are missing, and no others explain the recordings as well.
    Named,
    /// Something of the catalogue is missing, but the recordings do not separate several explanations.
    OneOf,
    /// Something is missing, and nothing in the catalogue explains it.
    Unknown,
    /// The recordings are too few or too short to say.
    Insufficient,
}

/// A number of an effect for one object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Value {
    /// The object's position among the subjects; `None` where all objects share it (how they were seen).
    pub object: Option<usize>,
    /// The estimate.
    pub value: f64,
    /// Its 95 % interval, within the bounds of what can be simulated.
    pub interval95: (f64, f64),
}

/// One coefficient of a named effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fitted {
    /// Its key in a simulation file: `c_1_m`.
    pub key: Text,
    /// Its unit.
    pub unit: Text,
    /// One for each object that has recordings, or a single shared one.
    pub values: Vec<Value>,
}

/// Why an effect is plausible.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evidence {
    /// How much the Bayesian information criterion falls by having this effect in addition to the others (Schwarz 1978).
    pub bic_gain: f64,
    /// The next best explanation in its place, where there is any.
    pub runner_up: Option<Text>,
    /// How much higher the criterion is with that one in its place; infinite where there is none.
    pub runner_up_bic_gap: f64,
    /// Probability of such a gain by chance, already multiplied by the number of candidates (Bonferroni).
    pub p_value: f64,
    /// Whether nothing else in the catalogue is as likely, so that alternatives are left for a doubt alone.
    pub is_distinct: bool,
}

/// An effect of the answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedEffect {
    /// Its entry in the catalogue; where it acts is [`Effect::phase`].
    pub effect: Effect,
    /// Its numbers.
    pub coefficients: Vec<Fitted>,
    /// Why it is plausible.
    pub evidence: Evidence,
    /// Other effects that could be in its place, best first: they explain the recordings as well, or the recordings show a
    /// single motion, of which the next best is left whatever its distance.
    pub alternatives: Vec<Text>,
}

impl NamedEffect {
    /// Whether the recordings show this value of the coefficient `key`: of a joint that does not move with the effect, its interval is all
    /// that a fit allows.
    #[must_use]
    pub fn shows(&self, key: &str, value: &Value) -> bool {
        let allowed = self.effect.coefficients.iter().find(|one| one.key == key).map(|one| (one.min, one.max));
        allowed != Some(value.interval95)
    }

    /// Whether the recordings determine this value of the coefficient `key`: its interval says more than the bounds of a fit do.
    #[must_use]
    pub fn determines(&self, key: &str, value: &Value) -> bool {
        let bounds = self.effect.coefficients.iter().find(|one| one.key == key);
        bounds.is_none_or(|one| says_more(value.interval95, one.max - one.min))
    }
}

/// Whether an interval says more than bounds that are `span` apart.
fn says_more((low, high): (f64, f64), span: f64) -> bool {
    high - low < UNINFORMATIVE_SHARE * span
}

/// One candidate as it stood alone, added to the tuned simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidate {
    /// Its name.
    pub name: Text,
    /// Gain of the information criterion over the tuned simulation without any effect; negative where the effect does not
    /// earn its coefficients.
    pub bic_gain: f64,
    /// How far it stays behind the best candidate.
    pub delta: f64,
    /// Whether the gain is that of a joint fit to the end. Otherwise it is estimated: promised or reached by one step, or by a fit that
    /// ended because it stayed far behind the best.
    pub fitted: bool,
    /// Residual on held-out recordings over that of the tuned simulation without it, where both are known.
    pub held_out_ratio: Option<f64>,
    /// Why it cannot be the answer.
    pub excluded: Option<Exclusion>,
}

/// A pair of numbers, before and after.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Change {
    /// Of the simulation as it was, tuned anew.
    pub before: f64,
    /// Of the simulation with the named effects.
    pub after: f64,
}

/// What a gap was measured on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GapOf {
    /// The recordings as they are.
    Recordings,
    /// Their segments between events, each with a start of its own: this says nothing of how far a whole recording is predicted.
    Segments,
    /// Their events, the segments de-trended: this says nothing of the segments.
    Events,
}

/// How far simulation and measurement lie apart (root mean square), and what noise alone leaves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// The unit of all: that of the channels, or σ ([`gap_unit`](crate::observation::gap_unit)).
    pub unit: String,
    /// What all these were measured on.
    pub of: GapOf,
    /// On the recordings that were fitted: the simulation as it was, its own parameters tuned anew.
    pub before: f64,
    /// With the named effects.
    pub after: f64,
    /// What noise alone leaves.
    pub noise_floor: f64,
    /// On recordings that were not fitted, of which only the start was.
    pub held_out: Option<Change>,
    /// On the same with a wrong effect added: its name and what it reaches. A gain that it reaches too proves nothing.
    #[serde(serialize_with = "control")]
    pub control: Option<(Text, f64)>,
    /// On the same, their later part predicted from the start of the first 40 %.
    pub forecast: Option<Change>,
}

/// The gap of one object's recordings, or of one channel of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartGap {
    /// The object's position among the subjects.
    pub object: usize,
    /// The channel; `None` for all together as one distance, which is left out where their units differ.
    pub channel: Option<String>,
    /// The unit of all.
    pub unit: String,
    /// On the recordings that were fitted: the simulation as it was, its own parameters tuned anew.
    pub before: f64,
    /// With the effects of the answer.
    pub after: f64,
    /// What noise alone leaves.
    pub noise_floor: f64,
    /// On recordings that were not fitted, of which only the start was.
    pub held_out: Option<Change>,
}

/// What to measure next.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NextExperiment {
    /// One sentence for users.
    pub text: String,
    /// Numbers of it by name, for scripts: `start.angle_rad`, `inputs.speed`.
    #[serde(serialize_with = "settings")]
    pub settings: Vec<(String, f64)>,
}

/// A tuned parameter of one object with the named effects in place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tuned {
    /// The object's position among the subjects.
    pub object: usize,
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its value in the simulation as given.
    pub given: f64,
    /// Its value tuned without any effect.
    pub before: f64,
    /// Its value now.
    pub value: f64,
    /// Its 95 % interval.
    pub interval95: (f64, f64),
}

impl Tuned {
    /// Whether the recordings determine it: its interval says more than the bounds of the parameter of its name do.
    #[must_use]
    pub fn is_determined(&self, parameters: &[Parameter]) -> bool {
        let bounds = parameters.iter().find(|parameter| parameter.name == self.name);
        bounds.is_none_or(|parameter| says_more(self.interval95, parameter.span()))
    }
}

/// One recording as it was seen and explained.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explained {
    /// Its position among the recordings given.
    pub recording: usize,
    /// The position of its object among the subjects.
    pub object: usize,
    /// Its name.
    pub name: String,
    /// Which of its segments between events this is, from 1, where they were cut apart.
    pub segment: Option<usize>,
    /// Whether it was kept out of the fit.
    pub held_out: bool,
    /// What was used of it.
    pub seen: Observation,
    /// Whether a value counted, shape `[sample · channel]`; residuals of those that did not are 0.
    pub kept: Vec<bool>,
    /// Measured − predicted without an effect, in units of the noise, shape `[sample · channel]`.
    pub before: Vec<f64>,
    /// The same with the named effects.
    pub after: Vec<f64>,
    /// Noise of each channel in its unit.
    pub noise: Vec<f64>,
    /// The same as measured, before any model discrepancy counts as noise.
    pub measured_noise: Vec<f64>,
    /// Events as the recording shows them, s.
    pub events: Vec<f64>,
    /// Its nuisance parameters with the named effects: name, value, unit.
    #[serde(serialize_with = "nuisances")]
    pub nuisances: Vec<(String, f64, String)>,
}

/// What becomes of one recording given.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Use {
    /// Its name.
    pub name: String,
    /// Whether it was used at all.
    pub used: bool,
    /// Whether it was kept out of the fit.
    pub held_out: bool,
    /// Why it was not used, or what was cut.
    pub notes: Vec<Note>,
}

/// What one object's own recordings say of an effect of the answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OwnEffect {
    /// The effect's name.
    pub name: Text,
    /// How much the Bayesian information criterion of this object's recordings falls by its own coefficients (from their
    /// squared distance from absence in standard errors; Wald 1943). `None` where all objects share them, or where events are
    /// not understood.
    pub bic_gain: Option<f64>,
    /// Whether its recordings show the effect.
    pub shown: bool,
    /// Whether the simulation of this object has to hold the effect: not where its own recordings do not show it, and those of
    /// another object do.
    pub needed: bool,
}

/// The answer of one object among several.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfObject {
    /// The object's position among the subjects.
    pub object: usize,
    /// The answer: `None` where others show an effect and its own recordings do not need it.
    pub verdict: Verdict,
    /// Every effect of the whole answer as this object shows it.
    pub effects: Vec<OwnEffect>,
}

/// The answer, each with what it alone has.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Conclusion {
    /// Nothing is missing that these recordings could show.
    None,
    /// These effects are missing, and no others explain the recordings as well.
    Named {
        /// Each with its numbers and its evidence.
        effects: Vec<NamedEffect>,
    },
    /// Something of the catalogue is missing, but the recordings do not separate several explanations.
    OneOf {
        /// The best explanation.
        effects: Vec<NamedEffect>,
        /// All names of the confusable set: a single one with what is in no catalogue, where nothing else explains anything
        /// and there is a doubt.
        names: Vec<Text>,
        /// Why the best explanation is not named alone, where the evidence distinguishes it from all others by far.
        doubt: Option<Doubt>,
    },
    /// Something is missing, and nothing in the catalogue explains it.
    Unknown {
        /// The effects that come nearest.
        nearest: Vec<Text>,
        /// What is left, in words.
        description: String,
        /// Where it acts, as far as that shows.
        remains: Option<Phase>,
    },
    /// The recordings are too few or too short to say.
    Insufficient,
}

impl Conclusion {
    /// The answer in one word.
    #[must_use]
    pub const fn verdict(&self) -> Verdict {
        match self {
            Self::None => Verdict::None,
            Self::Named { .. } => Verdict::Named,
            Self::OneOf { .. } => Verdict::OneOf,
            Self::Unknown { .. } => Verdict::Unknown,
            Self::Insufficient => Verdict::Insufficient,
        }
    }

    /// The named effects, or the best explanation of several. Empty otherwise.
    #[must_use]
    pub fn effects(&self) -> &[NamedEffect] {
        match self {
            Self::Named { effects } | Self::OneOf { effects, .. } => effects,
            Self::None | Self::Unknown { .. } | Self::Insufficient => &[],
        }
    }

    /// The names of the answer: the effects named, the confusable set, or the nearest.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        match self {
            Self::Named { effects } => effects.iter().map(|named| named.effect.name.as_ref()).collect(),
            Self::OneOf { names, .. } | Self::Unknown { nearest: names, .. } => {
                names.iter().map(AsRef::as_ref).collect()
            }
            Self::None | Self::Insufficient => Vec::new(),
        }
    }

    /// Why the first of a confusable set is not named alone although the evidence distinguishes it.
    #[must_use]
    pub const fn doubt(&self) -> Option<&Doubt> {
        if let Self::OneOf { doubt, .. } = self { doubt.as_ref() } else { None }
    }

    /// What an unknown effect leaves, in words.
    #[must_use]
    pub fn description(&self) -> Option<&str> {
        if let Self::Unknown { description, .. } = self { Some(description) } else { None }
    }

    /// Where an unknown effect acts, as far as that shows.
    #[must_use]
    pub const fn remains(&self) -> Option<&Phase> {
        if let Self::Unknown { remains, .. } = self { remains.as_ref() } else { None }
    }
}

/// Everything that a diagnosis found. Numbers that are not finite become null in JSON.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// The answer.
    pub conclusion: Conclusion,
    /// The answer of each object that has recordings to fit. Empty where nothing could be fitted.
    pub objects: Vec<OfObject>,
    /// Every candidate as it stood alone, best first, the excluded last.
    pub candidates: Vec<Candidate>,
    /// The gap; absent where nothing could be fitted.
    pub gap: Option<Gap>,
    /// The same for each object with recordings to fit, of all channels and of each. Empty where nothing could be fitted.
    pub gaps: Vec<PartGap>,
    /// What the final model leaves, test by test.
    pub adequacy: Vec<Test>,
    /// What would separate or show what these recordings cannot.
    pub next_experiment: Option<NextExperiment>,
    /// How far behind the best an explanation is still left; more of a single motion, less in the place of what has to be
    /// there in any case.
    pub margin: f64,
    /// How much the information criterion has to gain for an effect to be there at all.
    pub least_gain: f64,
    /// The tuned parameters.
    pub parameters: Vec<Tuned>,
    /// Names of numbers that are tied in the answer, group by group: parameters, and numbers that the simulation states, of which the
    /// recordings determine a combination only.
    pub tied: Vec<Vec<String>>,
    /// The recordings used, before and after.
    pub explained: Vec<Explained>,
    /// What became of every recording given.
    pub uses: Vec<Use>,
    /// What a person should know.
    pub notes: Vec<Note>,
    /// Rollouts in all.
    pub rollouts: usize,
}

impl Diagnosis {
    /// The answer in one word.
    #[must_use]
    pub const fn verdict(&self) -> Verdict {
        self.conclusion.verdict()
    }

    /// The named effects, or the best explanation of several; see [`Conclusion::effects`].
    #[must_use]
    pub fn effects(&self) -> &[NamedEffect] {
        self.conclusion.effects()
    }

    /// The names of the answer; see [`Conclusion::names`].
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        self.conclusion.names()
    }
}

/// The wrong effect and what it reaches, as an object.
#[expect(clippy::ref_option, reason = "the form that serde calls")]
fn control<S: Serializer>(control: &Option<(Text, f64)>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Control<'a> {
        name: &'a str,
        after: f64,
    }
    control.as_ref().map(|(name, after)| Control { name, after: *after }).serialize(serializer)
}

/// Numbers by name, as an object.
fn settings<S: Serializer>(settings: &[(String, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(settings.iter().map(|(name, value)| (name, value)))
}

/// Name, value and unit of each, as objects.
fn nuisances<S: Serializer>(nuisances: &[(String, f64, String)], serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Nuisance<'a> {
        name: &'a str,
        value: f64,
        unit: &'a str,
    }
    serializer.collect_seq(nuisances.iter().map(|(name, value, unit)| Nuisance { name, value: *value, unit }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bounds of a parameter are no interval of it.
    #[test]
    fn an_interval_as_wide_as_its_bounds_determines_nothing() {
        let gain = Parameter::new("gain", "1", 1.0, 0.001, 20.0).unwrap();
        let with = |interval95| Tuned {
            object: 0,
            name: "gain".into(),
            unit: "1".into(),
            given: 1.0,
            before: 1.0,
            value: 1.7,
            interval95,
        };
        assert!(!with((0.001, 20.0)).is_determined(std::slice::from_ref(&gain)));
        assert!(!with((0.5, 19.0)).is_determined(std::slice::from_ref(&gain)));
        assert!(with((1.5, 1.9)).is_determined(&[gain]));
    }
}
