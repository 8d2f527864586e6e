//! What a file declares of a simulator that is not ours: inputs, initial states and candidate effects.

use std::path::PathBuf;

use indexmap::IndexMap;
use serde::Deserialize;
use tunenet_core::observation::Channel;

/// `[inputs.NAME]`, in the order of the file.
pub type Inputs = IndexMap<String, Input>;
/// `[start.NAME]`, in the order of the file.
pub type Starts = IndexMap<String, Start>;
/// `[candidates.NAME]`, in the order of the file.
pub type Candidates = IndexMap<String, Candidate>;

/// What drives the thing: a column of every recording, or a file with a clock of its own.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Input {
    /// What it is between its samples.
    pub hold: Hold,
    /// What the file calls it, where that is not its name.
    pub column: Option<String>,
    /// The file in which it stands, from the folder of the recording; the recording itself where it is `None`.
    pub file: Option<PathBuf>,
    /// The topic of a log in which it stands.
    pub topic: Option<String>,
    /// The column of its own clock, s.
    pub time_column: Option<String>,
    /// Its unit, where its name does not end in one.
    pub unit: Option<String>,
    /// Its value where a recording does not have it.
    pub default: Option<f64>,
}

impl Input {
    /// The channel of an input of this name; `None` where neither its name nor `unit` says its unit.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<Channel> {
        let of_name = Channel::from_header(name);
        match (&self.unit, of_name) {
            (Some(unit), Some(channel)) if channel.unit == *unit => Some(channel),
            (Some(unit), _) => Some(Channel::new(name, unit.clone())),
            (None, of_name) => of_name,
        }
    }
}

/// What an input is between its samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// The value of the sample before (zero-order hold).
    #[default]
    Previous,
    /// On the straight line between two samples.
    Linear,
}

impl Hold {
    /// As the file has it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Previous => "previous",
            Self::Linear => "linear",
        }
    }
}

/// One state at the first stamp of a recording. With neither `sd` nor bounds it is fixed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Where it starts.
    pub value: StartValue,
    /// Standard deviation of the prior around `value`: it is estimated then.
    #[serde(default)]
    pub sd: Option<f64>,
    /// Least value.
    #[serde(default)]
    pub min: Option<f64>,
    /// Greatest value.
    #[serde(default)]
    pub max: Option<f64>,
}

/// Where a state starts.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum StartValue {
    /// At this number.
    Number(f64),
    /// At the first sample of the channel of its name.
    Word(First),
}

/// The one word that a start may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum First {
    /// The first sample.
    First,
}

/// An effect that `diagnose` may find missing; absent until `[effects.NAME]` has it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Candidate {
    /// One sentence for users.
    pub sentence: String,
    /// Where it acts: any word.
    pub acts: String,
    /// Names of effects that some recordings cannot distinguish from it.
    #[serde(default)]
    pub mistaken_for: Vec<String>,
    /// What it adds in a world of ours: a formula of that world's variables and its own coefficients.
    #[serde(default)]
    pub formula: Option<String>,
    /// Along which directions.
    #[serde(default)]
    pub along: Vec<String>,
    /// What the formula gives: an acceleration, a force, a torque, a restitution.
    #[serde(default)]
    pub gives: Option<String>,
    /// The coefficients that have one number for every direction, or for every joint of `joints`.
    #[serde(default)]
    pub per_direction: Vec<String>,
    /// Between which values of its variables the formula was seen to hold.
    #[serde(default)]
    pub valid: IndexMap<String, (f64, f64)>,
    /// From where distances are measured, m.
    #[serde(default)]
    pub centre: Option<[f64; 3]>,
    /// The joints at which it acts; all where it is `None`.
    #[serde(default)]
    pub joints: Option<Vec<String>>,
    /// What it adds to the derivatives of states in equations: a formula for each of these states.
    #[serde(default)]
    pub adds: IndexMap<String, String>,
    /// Its numbers, in order.
    pub coefficients: IndexMap<String, CandidateCoefficient>,
}

impl Candidate {
    /// How many directions or joints have numbers of their own; `spin` counts as three.
    #[must_use]
    pub fn directions(&self) -> usize {
        let along = self.along.iter().map(|word| if word == "spin" { 3 } else { 1 }).sum::<usize>();
        self.joints.as_ref().map_or(along, Vec::len).max(1)
    }

    /// The value of a coefficient at which the effect is absent: 0 where nothing is said, and the middle of the range for a
    /// formula's number, which only shapes the effect then.
    #[must_use]
    pub fn absent(&self, of: &CandidateCoefficient) -> f64 {
        let unsaid = if self.formula.is_some() { 0.5 * (of.min + of.max) } else { 0.0 };
        of.absent.unwrap_or(unsaid)
    }

    /// How many numbers the coefficient of this key has.
    #[must_use]
    pub fn numbers_of(&self, key: &str) -> usize {
        if self.per_direction.iter().any(|one| one == key) { self.directions() } else { 1 }
    }
}

/// One number of a candidate.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CandidateCoefficient {
    /// Its unit.
    #[serde(default = "one")]
    pub unit: String,
    /// The value that means "absent". Of a formula's number that shapes the effect and does not switch it off, none.
    #[serde(default)]
    pub absent: Option<f64>,
    /// The least value that is fitted.
    pub min: f64,
    /// The greatest value that is fitted.
    pub max: f64,
    /// Where fits begin, as a distance from `absent`.
    #[serde(default)]
    pub typical: Option<f64>,
    /// Outside it fits, and is not plausible.
    #[serde(default)]
    pub plausible: Option<(f64, f64)>,
}

impl CandidateCoefficient {
    /// Where fits begin, as a distance from `absent`: where nothing is said, a share of the range. What switches an effect off begins near
    /// its absence; what only `shapes` it begins anywhere.
    #[must_use]
    pub fn typical(&self, shapes: bool) -> f64 {
        let share = if shapes { 0.25 } else { 0.05 };
        self.typical.unwrap_or(share * (self.max - self.min))
    }
}

fn one() -> String {
    "1".into()
}
