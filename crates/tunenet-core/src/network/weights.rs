//! Trained weights as named arrays, independent of the file format.

use std::collections::BTreeMap;

use candle_core::{DType, Device, Tensor};

use crate::{Error, Result};

/// The numbers of an array.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers {
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

/// An array in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Its lengths; their product is the number of [`Array::numbers`].
    pub shape: Vec<usize>,
    /// Its numbers.
    pub numbers: Numbers,
}

/// Named arrays and what is said about them, as JSON.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// What they are: a model or a checkpoint, with its settings.
    pub about: String,
    /// By name.
    pub arrays: BTreeMap<String, Array>,
}

/// Why stored weights cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum WeightsFault {
    /// An array is missing or has another shape.
    Array,
    /// The model is of another version.
    Version,
    /// The checkpoint is of another training.
    OtherTraining,
    /// The checkpoint is of a training on this other device.
    OtherDevice(String),
}

impl Weights {
    pub(super) fn new(about: String, tensors: &[(String, Tensor)]) -> Result<Self> {
        let array = |tensor: &Tensor| -> Result<Array> {
            let flat = tensor.flatten_all()?;
            let numbers = match tensor.dtype() {
                DType::F64 => Numbers::F64(flat.to_vec1()?),
                _ => Numbers::F32(flat.to_vec1()?),
            };
            Ok(Array { shape: tensor.dims().to_vec(), numbers })
        };
        let arrays = tensors.iter().map(|(name, tensor)| Ok((name.clone(), array(tensor)?)));
        Ok(Self { about, arrays: arrays.collect::<Result<_>>()? })
    }

    /// The lengths of one array.
    pub(super) fn shape(&self, name: &str) -> Option<&[usize]> {
        self.arrays.get(name).map(|array| array.shape.as_slice())
    }

    /// Takes one tensor out, of exactly this shape and kind of number.
    pub(super) fn take(&mut self, name: &str, dtype: DType, shape: &[usize]) -> Result<Tensor> {
        let refuse = |found: String| Error::Weights {
            expected: format!("`{name}` of shape {shape:?} in {}", dtype.as_str()),
            found,
            fault: WeightsFault::Array,
        };
        let Some(Array { shape: lengths, numbers }) = self.arrays.remove(name) else {
            return Err(refuse("none".into()));
        };
        let kind = match numbers {
            Numbers::F32(_) => DType::F32,
            Numbers::F64(_) => DType::F64,
        };
        if lengths != shape || kind != dtype {
            return Err(refuse(format!("shape {lengths:?} in {}", kind.as_str())));
        }
        let strange = match &numbers {
            Numbers::F32(numbers) => numbers.iter().position(|number| !number.is_finite()),
            Numbers::F64(numbers) => numbers.iter().position(|number| !number.is_finite()),
        };
        if let Some(at) = strange {
            let expected = format!("finite numbers in `{name}`");
            let found = format!("NaN or infinity at place {}", at + 1);
            return Err(Error::Weights { expected, found, fault: WeightsFault::Array });
        }
        Ok(match numbers {
            Numbers::F32(numbers) => Tensor::from_vec(numbers, lengths, &Device::Cpu)?,
            Numbers::F64(numbers) => Tensor::from_vec(numbers, lengths, &Device::Cpu)?,
        })
    }
}
