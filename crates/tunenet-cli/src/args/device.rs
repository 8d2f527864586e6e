//! `--device`.

use clap::ValueEnum;
use tunenet_core::network::TrainDevice;

/// Where the sums of a training are done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DeviceChoice {
    /// A GPU if this build supports it and one is available, otherwise the CPU
    Auto,
    /// The CPU; the result does not depend on the number of threads
    Cpu,
    /// The first NVIDIA GPU, in a build with `--features cuda`
    Cuda,
}

impl DeviceChoice {
    /// What that is here.
    ///
    /// # Errors
    /// Where it was named and cannot be used; see [`TrainDevice::check`].
    pub fn here(self) -> tunenet_core::Result<TrainDevice> {
        match self {
            Self::Auto => Ok(TrainDevice::at_hand()),
            Self::Cpu => Ok(TrainDevice::Cpu),
            Self::Cuda => TrainDevice::Cuda.check().map(|()| TrainDevice::Cuda),
        }
    }
}
