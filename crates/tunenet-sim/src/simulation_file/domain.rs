//! What a simulation file describes: its keys and its parameters, by kind.

use super::arm_effects::ARM_EFFECT_KEYS;
use super::arm_schema::{ARM_KEYS, ARM_PARAMETERS};
use super::declared_schema::Declares;
use super::equations_keys::EQUATIONS_KEYS;
use super::process_schema::{PROCESS_EFFECT_KEYS, PROCESS_KEYS, SETTING};
use super::robot_keys::{ROBOT_EFFECT_KEYS, ROBOT_KEYS};
use super::schema::{BALL_KEYS, Definition, EFFECT_KEYS, Key, PARAMETER_KEYS, is_name};
use crate::scene::BallParameters;

/// What a simulation file describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Domain {
    /// A ball that falls and bounces.
    Ball,
    /// An arm that moves a payload.
    Arm,
    /// A model simulated by an external program; the program names its parameters.
    Process,
    /// A model whose equations stand in the file, which names its parameters.
    Equations,
    /// Robot joints that follow commands; parameters are named `JOINT__NAME`.
    Robot,
}

/// The parameters of a ball.
const BALL_PARAMETERS: &[Definition] = &[
    Definition {
        name: BallParameters::RESTITUTION,
        unit: "1",
        default: [0.5, 0.0, 1.0],
        tune: true,
        bounds: (0.0, 1.0),
        within: "bounds within 0 to 1 (above 1 a bounce gains energy)",
        meaning: "Speed after a bounce over speed before it, along the surface's normal",
    },
    Definition {
        name: BallParameters::FRICTION,
        unit: "1",
        default: [0.0, 0.0, 2.0],
        tune: false,
        bounds: (0.0, f64::INFINITY),
        within: "0 or more",
        meaning: "Coulomb's coefficient between ball and surface; only a throw shows it",
    },
];

impl Domain {
    /// Every kind.
    pub const ALL: [Self; 5] = [Self::Ball, Self::Arm, Self::Process, Self::Equations, Self::Robot];

    /// As `kind` has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ball => "ball",
            Self::Arm => "arm",
            Self::Process => "process",
            Self::Equations => "equations",
            Self::Robot => "robot",
        }
    }

    /// The kind of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|domain| domain.name() == name)
    }

    /// All keys besides parameters and provenance.
    pub fn keys(self) -> impl Iterator<Item = &'static Key> {
        let (own, effects): (_, &[Key]) = match self {
            Self::Ball => (BALL_KEYS, &EFFECT_KEYS),
            Self::Arm => (ARM_KEYS, &ARM_EFFECT_KEYS),
            Self::Process => (PROCESS_KEYS, &PROCESS_EFFECT_KEYS),
            Self::Equations => (EQUATIONS_KEYS, &PROCESS_EFFECT_KEYS),
            Self::Robot => (ROBOT_KEYS, &ROBOT_EFFECT_KEYS),
        };
        own.iter().chain(effects)
    }

    /// The parameters that `[parameters.NAME]` may describe, in the order in which simulators take them; none where the file
    /// [names them itself](Self::declares).
    #[must_use]
    pub fn parameters(self) -> &'static [Definition] {
        match self {
            Self::Ball => BALL_PARAMETERS,
            Self::Arm => ARM_PARAMETERS,
            Self::Process | Self::Equations | Self::Robot => &[],
        }
    }

    /// The parameter of this name.
    #[must_use]
    pub fn parameter(self, name: &str) -> Option<&'static Definition> {
        self.parameters().iter().find(|known| known.name == name)
    }

    /// Whether a file may describe a parameter of this name.
    #[must_use]
    pub fn has_parameter(self, name: &str) -> bool {
        self.parameter(name).is_some() || self.declares() && is_name(name)
    }

    /// Whether a file declares its channels, parameters, inputs and initial states itself: what it simulates is the user's own.
    #[must_use]
    pub fn declares(self) -> bool {
        matches!(self, Self::Process | Self::Equations | Self::Robot)
    }

    /// What a file declares itself.
    #[must_use]
    pub fn declared(self) -> Declares {
        match self {
            Self::Ball => Declares::Ball,
            Self::Arm => Declares::Arm,
            Self::Process => Declares::Program,
            Self::Equations => Declares::Equations,
            Self::Robot => Declares::Robot,
        }
    }

    /// The key at `path`, parameters included.
    #[must_use]
    pub fn find(self, path: &str) -> Option<Key> {
        if let Some(rest) = path.strip_prefix("parameters.") {
            let (name, field) = rest.split_once('.')?;
            if !self.has_parameter(name) {
                return None;
            }
            return PARAMETER_KEYS.iter().find(|k| k.path == field).cloned();
        }
        if self == Self::Process && path.starts_with("settings.") {
            return Some(SETTING);
        }
        let known = self.keys().find(|k| k.path == path).cloned();
        known.or_else(|| self.declared().find(path))
    }

    /// The keys that could have been meant instead of `path`: those of its table, or all tables.
    #[must_use]
    pub fn siblings(self, path: &str) -> Vec<String> {
        let table = path.rsplit_once('.').map_or("", |(table, _)| table);
        let parameters = || match self {
            own if own.declares() => vec!["parameters.NAME, of letters, digits and _".to_owned()],
            _ => self.parameters().iter().map(|p| format!("parameters.{}", p.name)).collect(),
        };
        if table == "parameters" {
            return parameters();
        }
        if let Some(name) = table.strip_prefix("parameters.") {
            return if self.has_parameter(name) {
                PARAMETER_KEYS.iter().map(|k| k.path.to_string()).collect()
            } else {
                parameters()
            };
        }
        let declared = self.declared().siblings(table);
        if !declared.is_empty() {
            return declared;
        }
        // Of an effect's table the coefficients; of an unknown effect, the effects.
        let inside = format!("{table}.");
        let within = |k: &&Key| !table.is_empty() && k.path.starts_with(&inside);
        let near: Vec<String> = self.keys().filter(within).map(|k| k.path.to_string()).collect();
        if !near.is_empty() {
            return near;
        }
        let depth = if table.starts_with("effects") { 2 } else { 1 };
        let head = |k: &Key| k.path.split('.').take(depth).collect::<Vec<_>>().join(".");
        let mut near: Vec<String> =
            self.keys().filter(|k| depth == 1 || k.path.starts_with("effects.")).map(head).collect();
        if depth == 1 {
            near.extend((self == Self::Process).then(|| "settings".to_string()));
            near.extend(self.declared().heads().iter().map(|head| (*head).to_owned()));
            near.extend(["parameters".to_string(), "provenance".to_string()]);
        }
        near.dedup();
        near
    }
}
