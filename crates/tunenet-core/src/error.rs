//! The one error type of this crate.

use std::fmt;

use crate::network::{TrainDevice, WeightsFault};

/// What this crate returns.
pub type Result<T> = std::result::Result<T, Error>;

/// Who set what is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Origin {
    /// A flag of the program that calls this library.
    Flag,
    /// A file.
    File,
    /// Whoever called the library: a command with what its line says, or a program.
    Caller,
}

/// What the operating system was asked to do with a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Action {
    /// Make a new file or folder.
    Creating,
    /// Open what is there.
    Opening,
    /// Read from it.
    Reading,
    /// Write into it.
    Writing,
    /// Give it another name.
    Renaming,
    /// Take it away.
    Removing,
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Creating => "creating",
            Self::Opening => "opening",
            Self::Reading => "reading",
            Self::Writing => "writing",
            Self::Renaming => "renaming",
            Self::Removing => "removing",
        })
    }
}

/// Everything that can go wrong, each with where it happened, what was expected and what was found.
///
/// Every message is one sentence for users. This crate knows no files: who reads them has an error with their paths,
/// and hands it through a trait of this crate as [`Error::Supplied`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An observation's numbers cannot be one.
    #[error("{what}: expected {expected}, found {found}")]
    Observation {
        /// The channel, sample or clock concerned.
        what: String,
        /// What a usable observation has there.
        expected: String,
        /// What this one has.
        found: String,
    },
    /// A parameter's definition contradicts itself.
    #[error("parameter `{name}`: expected {expected}, found {found}")]
    Parameter {
        /// Which parameter.
        name: String,
        /// What is allowed.
        expected: String,
        /// What was given.
        found: String,
    },
    /// A simulator could not roll out.
    #[error("the simulator refused {at}: {message}")]
    Simulator {
        /// The parameter values, as `name=value` pairs.
        at: String,
        /// What it said.
        message: String,
    },
    /// A simulator itself failed, so that no other values help.
    #[error("the simulator failed: {message}")]
    SimulatorBroken {
        /// What it said.
        message: String,
    },
    /// A simulator answered a number that is unusable: not finite, or beyond
    /// [`GREATEST`](crate::observation::GREATEST).
    #[error("the simulator answered {found} for {place} with {at}: expected {expected}")]
    Prediction {
        /// The parameter values, as `name=value` pairs.
        at: String,
        /// The channel and the sample, from 1.
        place: String,
        /// The range of usable numbers.
        expected: String,
        /// The number.
        found: String,
    },
    /// A trained model does not fit what it is asked to do.
    #[error("the model {what}: expected {expected}, found {found}")]
    Model {
        /// What does not fit: its shape, its parameters, its input.
        what: String,
        /// What the task needs.
        expected: String,
        /// What the model has.
        found: String,
    },
    /// A data set cannot be learned from.
    #[error("the data set: expected {expected}, found {found}")]
    Dataset {
        /// What the preset needs.
        expected: String,
        /// What the data set has.
        found: String,
        /// What to try; may be empty.
        remedy: &'static str,
    },
    /// Stored weights cannot be used.
    #[error("stored weights: expected {expected}, found {found}")]
    Weights {
        /// What was looked for.
        expected: String,
        /// What is there.
        found: String,
        /// What kind of fault it is.
        fault: WeightsFault,
    },
    /// Rollouts that do not fit into memory could not be written to a file.
    #[error("temporary file of the training: {action} failed: {source}")]
    Overflow {
        /// What was being done.
        action: Action,
        /// What the system said.
        source: std::io::Error,
    },
    /// What the caller supplied (a data set, a checkpoint, a simulator) failed, with the caller's own error.
    #[error(transparent)]
    Supplied(Box<dyn std::error::Error + Send + Sync>),
    /// A setting is outside its range.
    #[error("`{name}`: expected {expected}, found {found}")]
    Setting {
        /// Who set it.
        origin: Origin,
        /// Which setting.
        name: &'static str,
        /// Its range.
        expected: String,
        /// What was given.
        found: String,
    },
    /// This build has no support for a device.
    #[error("`device`: expected `cpu` or `auto` in a build without support for GPUs, found `{}`", device.name())]
    DeviceUnsupported {
        /// The device that was asked for.
        device: TrainDevice,
    },
    /// A device cannot be used.
    #[error("expected a GPU that CUDA can use, found none: {message}")]
    Device {
        /// What its driver said.
        message: String,
    },
    /// The network library failed.
    #[error("the network library failed: {message}")]
    Network {
        /// What it said.
        message: String,
    },
    /// The work was asked to stop (the progress callback said so); what is on disk can be resumed.
    #[error("stopped on request")]
    Stopped,
}
