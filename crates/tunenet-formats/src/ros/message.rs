//! The fields of a message, in any encoding.

use tunenet_core::observation::Kind;

use super::numbers::Numbers;

/// Why a message of another kind cannot be used.
pub(crate) const NOTHING: &str = "carries no positions, joints or bounces";

/// Why a message of numbers is not used by itself.
pub(crate) const NUMBERS: &str = "carries numbers, which `--columns` has to name";

/// One message of a kind that an observation can be made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Decoded {
    /// The stamp in its header, in ns.
    pub stamp_ns: Option<i64>,
    pub sample: Sample,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Sample {
    /// x, y, z in m.
    Position([f64; 3]),
    Joints(JointMessage),
    /// The number of an impact; its time is the stamp.
    Bounce(f64),
    Way(Way),
    /// Numbers of a message of another type.
    Numbers(Numbers),
}

impl Sample {
    pub fn kind(&self) -> Kind {
        match self {
            Self::Position(_) => Kind::Positions,
            Self::Joints(_) | Self::Way(_) => Kind::Joints,
            Self::Bounce(_) => Kind::EventTimes,
            Self::Numbers(_) => Kind::Other,
        }
    }
}

/// The points of a way, and whose joints they are.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Way {
    pub name: Vec<String>,
    /// The time after the stamp, in ns; positions, velocities and efforts, as in a [`JointMessage`].
    pub points: Vec<(i64, [Vec<f64>; 3])>,
}

/// Joints by name; each array is as long as `name` or empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct JointMessage {
    pub name: Vec<String>,
    /// rad.
    pub position: Vec<f64>,
    /// rad/s.
    pub velocity: Vec<f64>,
    /// N·m.
    pub effort: Vec<f64>,
}
