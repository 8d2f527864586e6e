//! The fields of a message, in any encoding.

use tunenet_core::observation::Kind;

/// Why a message of another kind cannot be used.
pub(crate) const NOTHING: &str = "carries no positions, joints or bounces";

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
}

impl Sample {
    pub fn kind(&self) -> Kind {
        match self {
            Self::Position(_) => Kind::Positions,
            Self::Joints(_) => Kind::Joints,
            Self::Bounce(_) => Kind::EventTimes,
        }
    }
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
