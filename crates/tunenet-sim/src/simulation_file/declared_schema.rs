//! The keys of `[inputs]`, `[start]`, `[candidates]` and of the tables of equations, whose names a file chooses.

use tunenet_core::observation::Kind;
use tunenet_core::simulator::measurement_effects;

use super::equations_keys::{ADDS, CONSTANT, DERIVATIVE, EVENT_KEYS, OUTPUT, STATE_KEYS, THEN};
use super::robot_keys::{JOINT_KEYS, LOAD_KEYS};
use super::schema::{GREATEST, Key, Shape, is_name, key};
use crate::arm::effects as arm;
use crate::ball::effects as ball;
use crate::robot::effects as robot;

const ANY: Shape = Shape::Number(-GREATEST, GREATEST);
const TEXT: Shape = Shape::Word(&[]);

/// The keys of `[inputs.NAME]`.
pub const INPUT_KEYS: &[Key] = &[
    key(
        "hold",
        Shape::Word(&["previous", "linear"]),
        false,
        "its value between samples: that of the sample before, or on the line between both (default: previous)",
    ),
    key("column", TEXT, false, "what the file calls it (default: its name)"),
    key("file", TEXT, false, "the file that holds it, from the folder of the recording (default: the recording)"),
    key("topic", TEXT, false, "the topic of a log that holds it"),
    key("time_column", TEXT, false, "the column of its own clock, in s (default: that of its file)"),
    key("unit", TEXT, false, "its unit, where its name does not end in one"),
    key("default", ANY, false, "its value where a recording does not have it"),
];

/// The keys of `[start.NAME]`.
pub const START_KEYS: &[Key] = &[
    key(
        "value",
        Shape::NumberOrWord(-GREATEST, GREATEST, "first"),
        true,
        "the state at the first stamp: a number, or the first sample of the channel of its name; alone it is fixed",
    ),
    key("sd", Shape::Number(1e-12, GREATEST), false, "standard deviation of the prior around `value`: it is estimated"),
    key("min", ANY, false, "least value; with `max` and without `sd` it is estimated freely between both"),
    key("max", ANY, false, "greatest value"),
];

/// The keys of `[candidates.NAME]`.
pub const CANDIDATE_KEYS: &[Key] = &[
    key("sentence", TEXT, true, "one sentence that says what it does"),
    key(
        "acts",
        TEXT,
        true,
        "where it acts, in a word: flight, contact, joint, measurement, sensor, actuator or another",
    ),
    key("mistaken_for", Shape::Names, false, "effects that some recordings cannot distinguish from it"),
];

/// The further keys of `[candidates.NAME]` in the file of a ball, an arm or a robot, where a formula says what it does.
pub const FORMULA_KEYS: &[Key] = &[
    key("formula", TEXT, true, "what it adds: a formula of the world's variables and its own coefficients"),
    key(
        "along",
        Shape::Names,
        false,
        "in flight, the directions: v, r, x, y, z, spin, across, around; at a joint dq or none",
    ),
    key(
        "gives",
        TEXT,
        false,
        "what the formula gives: m_s2 or n in flight, restitution at a contact, nm at a joint, n at one that slides (default: the first)",
    ),
    key(
        "per_direction",
        Shape::Names,
        false,
        "coefficients with one number for each direction, or for each of `joints`",
    ),
    key("centre", Shape::Numbers(3, -1e6, 1e6), false, "from where `r_m` is measured, in m (default: the origin)"),
    key("joints", Shape::Texts, false, "the joints at which it acts (default: all)"),
];
const RANGE: Key = key(
    "valid",
    Shape::Numbers(2, -GREATEST, GREATEST),
    false,
    "between which values of a variable it was seen to hold",
);
const NUMBERS: Shape = Shape::NumberOrList(-GREATEST, GREATEST);

/// The keys of `[candidates.NAME.coefficients.KEY]`.
pub const COEFFICIENT_KEYS: &[Key] = &[
    key("unit", TEXT, false, "its unit (default: 1)"),
    key(
        "absent",
        ANY,
        false,
        "the value at which the effect is absent (default: 0; of a formula's number, none: it only shapes the effect)",
    ),
    key("min", ANY, true, "least value that is fitted"),
    key("max", ANY, true, "greatest value that is fitted"),
    key(
        "typical",
        Shape::Number(1e-100, GREATEST),
        true,
        "how far from `absent` fits begin; a formula's number may leave it out",
    ),
    key("plausible", Shape::Numbers(2, -GREATEST, GREATEST), false, "outside it fits, and is not plausible"),
];

const TUNE: Key = key("tune", Shape::Flag, false, "whether `tune` may change these numbers (default: false)");
const NUMBER: Key = key("effects", NUMBERS, false, "coefficient of a declared candidate");

/// What a kind of file declares itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Declares {
    /// Inputs, initial states and candidates of a program.
    Program,
    /// Candidates of a ball.
    Ball,
    /// Candidates of an arm.
    Arm,
    /// States, formulas, constants, events, inputs, initial states and candidates of equations.
    Equations,
    /// Joints, loads, inputs, initial states and candidates of a robot.
    Robot,
}

impl Declares {
    /// Heads of the tables that a file names itself.
    pub(super) fn heads(self) -> &'static [&'static str] {
        match self {
            Self::Program => &["inputs", "start", "candidates"],
            Self::Equations => {
                &["states", "derivatives", "outputs", "constants", "inputs", "start", "events", "candidates"]
            }
            Self::Robot => &["joints", "loads", "inputs", "start", "candidates"],
            Self::Ball | Self::Arm => &["candidates"],
        }
    }

    /// Whether candidates are formulas.
    pub(super) fn formulas(self) -> bool {
        matches!(self, Self::Ball | Self::Arm | Self::Robot)
    }

    /// Whether a candidate has to say where fits of its numbers begin; a formula's number has a range to begin in.
    pub(super) fn needs_typical(self) -> bool {
        self == Self::Program
    }

    /// Whether candidates may state where they were seen to hold.
    fn takes_ranges(self) -> bool {
        self.formulas() || self == Self::Equations
    }

    /// Whether a built-in effect bears this name.
    pub(super) fn is_built_in(self, name: &str) -> bool {
        self.built_in().iter().any(|known| known == name)
    }

    /// The names of the effects that are built in.
    pub(super) fn built_in(self) -> Vec<String> {
        let measured = |kind| measurement_effects(kind).into_iter().map(|effect| effect.name.into_owned());
        match self {
            Self::Program | Self::Equations => {
                // The first are those that a series of any kind can show.
                let mut all: Vec<String> = measured(Kind::Other).collect();
                all.extend(measured(Kind::Positions).filter(|name| measured(Kind::Other).all(|known| known != *name)));
                all
            }
            Self::Ball => ball::ALL.iter().map(|e| e.name.to_owned()).chain(measured(Kind::Positions)).collect(),
            Self::Arm => arm::ALL.iter().map(|e| e.name.to_owned()).collect(),
            Self::Robot => robot::all().iter().map(|e| e.name.to_owned()).collect(),
        }
    }

    /// The keys of the table at `path`, where it is one that a file names itself.
    pub(super) fn keys(self, path: &[&str]) -> Option<Vec<&'static Key>> {
        let only = |keys: &'static [Key]| Some(keys.iter().collect());
        match *path {
            [head, ..] if !self.heads().contains(&head) => None,
            ["inputs", name] if is_name(name) => only(INPUT_KEYS),
            ["start", name] if is_name(name) => only(START_KEYS),
            ["states", name] if is_name(name) => only(STATE_KEYS),
            ["joints", name] if is_name(name) => only(JOINT_KEYS),
            ["loads", name] if is_name(name) => only(LOAD_KEYS),
            ["events", name] if is_name(name) => only(EVENT_KEYS),
            ["candidates", name] if is_name(name) && self.formulas() => {
                Some(CANDIDATE_KEYS.iter().chain(FORMULA_KEYS).collect())
            }
            ["candidates", name] if is_name(name) => only(CANDIDATE_KEYS),
            ["candidates", name, "coefficients", one] if is_name(name) && is_name(one) => only(COEFFICIENT_KEYS),
            _ => None,
        }
    }

    /// The key of whatever name stands in the table at `path`, where names of the file are its keys.
    fn named(self, path: &[&str]) -> Option<Key> {
        match path {
            _ if self != Self::Equations => None,
            ["derivatives"] => Some(DERIVATIVE),
            ["outputs"] => Some(OUTPUT),
            ["constants"] => Some(CONSTANT),
            ["events", name, "then"] if is_name(name) => Some(THEN),
            ["candidates", name, "adds"] if is_name(name) => Some(ADDS),
            _ => None,
        }
    }

    /// The key at `path`.
    pub(super) fn find(self, path: &str) -> Option<Key> {
        let parts: Vec<&str> = path.split('.').collect();
        let (last, table) = parts.split_last()?;
        match table {
            ["effects", name] if is_name(name) && !self.is_built_in(name) && is_name(last) => {
                Some(if *last == "tune" { TUNE } else { NUMBER })
            }
            ["candidates", name, "valid"] if self.takes_ranges() && is_name(name) && is_name(last) => Some(RANGE),
            _ if self == Self::Equations && is_name(last) && self.named(table).is_some() => self.named(table),
            _ => self.keys(table)?.into_iter().find(|key| key.path == *last).cloned(),
        }
    }

    /// Whether there is a table at `path`.
    pub(super) fn has_table(self, path: &str) -> bool {
        let parts: Vec<&str> = path.split('.').collect();
        match parts[..] {
            [head] => self.heads().contains(&head),
            ["effects", name] => is_name(name) && !self.is_built_in(name),
            ["candidates", name, "coefficients"] => is_name(name),
            ["candidates", name, "valid"] => self.takes_ranges() && is_name(name),
            _ if self.named(&parts).is_some() => true,
            _ => self.keys(&parts).is_some(),
        }
    }

    /// What could have been meant in the table at `table`; empty where a file does not name it itself.
    pub(super) fn siblings(self, table: &str) -> Vec<String> {
        let parts: Vec<&str> = table.split('.').collect();
        let named = |keys: Vec<&Key>| keys.iter().map(|key| key.path.to_string()).collect::<Vec<_>>();
        match parts[..] {
            ["candidates", _] => {
                let own = self.keys(&parts).map(named).unwrap_or_default();
                let adds = (self == Self::Equations).then(|| "adds.STATE".to_owned());
                [own, adds.into_iter().collect(), vec!["coefficients.KEY".into()]].concat()
            }
            ["candidates", _, "coefficients"] => vec!["a key of letters, digits and _, with its own table".into()],
            ["events", _] if self == Self::Equations => vec!["when".into(), "then.STATE".into()],
            [head] if self.heads().contains(&head) => vec![format!("{head}.NAME, of letters, digits and _")],
            _ if self.named(&parts).is_some() => vec!["a name of letters, digits and _".into()],
            _ => self.keys(&parts).map(named).unwrap_or_default(),
        }
    }
}
