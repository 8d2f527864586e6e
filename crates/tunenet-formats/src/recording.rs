//! An observation from a file, and how a file is to be read.

use tunenet_core::observation::{Channel, Note, Observation};

use crate::units::UnitRule;

/// Most numbers of one observation, its clock apart: ten million positions and a third more. A file with more is refused,
/// since it would take gigabytes of memory.
pub const MOST_NUMBERS: usize = 40_000_000;

/// Greatest size of a number in an observation, in SI units: seconds since 1970 fit, and nothing that a user measures
/// is larger.
pub const LARGEST: f64 = 1e10;

/// An observation from a file, and what was noticed while reading it.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// What was seen.
    pub observation: Observation,
    /// What the reader did that a user may want to know, in the order in which it was noticed.
    pub notes: Vec<Note>,
}

/// How to read a file that does not speak this project's names.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Pairs (ours, theirs): ours is a column name with its unit (`t_s`, `z_mm`), theirs a name from the file's header, or
    /// a column number from 1, with a `-` before it where its axis points the other way (`-z`); for joints also ranges,
    /// (`q1..6_rad`, `2..7`) or (`q1..6_rad`, `joint_*`).
    pub columns: Vec<(String, String)>,
    /// The topic of a log to read; `None` takes the only one that can be used.
    pub topic: Option<String>,
    /// Skip malformed lines of a CSV file, as long as they are few, instead of refusing the file.
    pub skip_broken: bool,
    /// Definitions of ROS messages that a log does not define: the name of the type without its package, and the text of its `.msg`
    /// file.
    pub definitions: Vec<(String, String)>,
    /// Units of columns whose file states none; the last one about a column counts.
    pub units: Vec<UnitRule>,
    /// Frames per second, for files without a time base.
    pub rate_hz: Option<f64>,
    /// Names of joints, in the order in which they are to be numbered: those of messages are matched to them, and hints on the
    /// columns of a table speak of them. Where empty, the first message decides.
    pub joints: Vec<String>,
    /// The channels that a custom simulator predicts, in its order: they are looked for by their
    /// [headers](Channel::header), and the series becomes one of [`Kind::Other`](tunenet_core::observation::Kind::Other). Empty where the file's
    /// columns or messages decide.
    pub channels: Vec<Channel>,
    /// What [`channels`](Self::channels) are to the simulator.
    pub role: Role,
    /// What else of the simulator may stand in the same file, in the other role: neither looked for here, nor taken for forgotten
    /// columns.
    pub others: Vec<Channel>,
    /// The joint that an input commands, and what of it: its commands are looked for by its name.
    pub commanded: Option<Channel>,
    /// Topics of a log that inputs of the simulator name: none is proposed for what it predicts.
    pub input_topics: Vec<String>,
}

/// What the channels of a custom simulator are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Role {
    /// It predicts them.
    #[default]
    Predicted,
    /// They drive it.
    Driving,
    /// Their first samples are its initial state.
    Starting,
}
