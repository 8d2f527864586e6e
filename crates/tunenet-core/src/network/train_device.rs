//! Where a network is trained.

use candle_core::Device;

use crate::{Error, Result};

/// Where a network is trained.
///
/// The same code runs everywhere; the sums are rounded otherwise, so that the weights differ in their last digits at first,
/// and then as two trainings do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TrainDevice {
    /// The processor, on the thread that asks: the same bits for any number of threads.
    #[default]
    Cpu,
    /// The first GPU of NVIDIA, through candle; a build with the feature `cuda` can use it.
    Cuda,
}

impl TrainDevice {
    /// The GPU where this build can use one and one answers, else the CPU.
    #[must_use]
    pub fn at_hand() -> Self {
        if Self::Cuda.check().is_ok() { Self::Cuda } else { Self::Cpu }
    }

    /// `cpu` or `cuda`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Cuda => "cuda",
        }
    }

    /// Whether it can be used, by this build and on this machine.
    ///
    /// # Errors
    /// [`Error::DeviceUnsupported`] in a build without the feature `cuda`; [`Error::Device`] where no GPU answers.
    pub fn check(self) -> Result<()> {
        self.device().map(|_| ())
    }

    /// As [`check`](Self::check).
    pub(super) fn device(self) -> Result<Device> {
        match self {
            Self::Cpu => Ok(Device::Cpu),
            Self::Cuda if !candle_core::utils::cuda_is_available() => Err(Error::DeviceUnsupported { device: self }),
            Self::Cuda => Device::new_cuda(0).map_err(|e| {
                // A trace of calls may follow.
                let message = e.to_string().lines().next().unwrap_or_default().to_owned();
                Error::Device { message }
            }),
        }
    }
}
