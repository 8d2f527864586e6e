//! Safetensors in and out, with one JSON text beside the tensors.

use std::collections::HashMap;
use std::io::Read as _;
use std::path::Path;

use candle_core::{DType, Device, Tensor};
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};

use crate::observation::recording::{open, write_atomically};
use crate::{Error, Result};

/// The one metadata key, so that no map decides the order of the bytes.
const KEY: &str = "tunenet";

/// Largest file that is read, in bytes: thousands of times what a network of two branches has.
const MOST_BYTES: u64 = 256 << 20;

/// What to try with a file that is no such thing.
const HINT: &str = "`tunenet train` writes models";

/// Named tensors and what is said about them.
pub(super) struct Contents {
    pub(super) about: String,
    pub(super) tensors: HashMap<String, Tensor>,
}

/// The file as bytes; equal tensors give equal bytes.
pub(super) fn to_bytes(about: String, tensors: &[(String, Tensor)]) -> Result<Vec<u8>> {
    let mut raw = Vec::with_capacity(tensors.len());
    for (name, tensor) in tensors {
        let flat = tensor.flatten_all()?;
        let (dtype, bytes) = match tensor.dtype() {
            DType::F64 => {
                (Dtype::F64, flat.to_vec1::<f64>()?.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())
            }
            _ => (Dtype::F32, flat.to_vec1::<f32>()?.iter().flat_map(|v| v.to_le_bytes()).collect()),
        };
        raw.push((name, dtype, tensor.dims().to_vec(), bytes));
    }
    let refused = |e: safetensors::SafeTensorError| candle_core::Error::Msg(e.to_string());
    let mut views = Vec::with_capacity(raw.len());
    for (name, dtype, shape, bytes) in &raw {
        views.push((name.as_str(), TensorView::new(*dtype, shape.clone(), bytes).map_err(refused)?));
    }
    Ok(safetensors::serialize(views, Some(HashMap::from([(KEY.to_owned(), about)]))).map_err(refused)?)
}

/// Writes `bytes` so that `path` holds either what it held before or all of them.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_atomically(path, |file| file.write_all(bytes))
}

/// Reads what [`write`] wrote. `kind` names what was expected: "a model".
pub(super) fn read(path: &Path, kind: &str) -> Result<Contents> {
    from_bytes(path, &read_bytes(path, kind)?, kind)
}

/// The bytes of the file at `path`, where it is one and not too large.
pub(super) fn read_bytes(path: &Path, kind: &str) -> Result<Vec<u8>> {
    let failed = |e| Error::io(path, "reading", e);
    let mut file = open(path)?;
    let size = file.metadata().map_err(failed)?.len();
    if size > MOST_BYTES {
        let message = format!("expected {kind} of at most {MOST_BYTES} bytes, found {size}");
        return Err(Error::file(path, message, HINT));
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// As [`read`], from bytes that stand or would stand at `path`.
pub(super) fn from_bytes(path: &Path, bytes: &[u8], kind: &str) -> Result<Contents> {
    let refuse = |found: String| Error::file(path, format!("expected {kind} in safetensors, found {found}"), HINT);
    let (_, metadata) =
        SafeTensors::read_metadata(bytes).map_err(|e| refuse(format!("a file that is not safetensors ({e})")))?;
    let about = metadata.metadata().as_ref().and_then(|m| m.get(KEY)).cloned();
    let about = about.ok_or_else(|| refuse(format!("a file of another program, without `{KEY}` in its metadata")))?;
    let file = SafeTensors::deserialize(bytes).map_err(|e| refuse(format!("a damaged file ({e})")))?;
    let mut tensors = HashMap::new();
    for (name, view) in file.iter() {
        let tensor = match view.dtype() {
            Dtype::F32 => Tensor::from_vec(numbers(view.data(), f32::from_le_bytes), view.shape(), &Device::Cpu)?,
            Dtype::F64 => Tensor::from_vec(numbers(view.data(), f64::from_le_bytes), view.shape(), &Device::Cpu)?,
            other => return Err(refuse(format!("numbers of kind {other:?} in `{name}`"))),
        };
        tensors.insert(name.to_owned(), tensor);
    }
    Ok(Contents { about, tensors })
}

fn numbers<const N: usize, T>(bytes: &[u8], from: impl Fn([u8; N]) -> T) -> Vec<T> {
    bytes.as_chunks::<N>().0.iter().map(|chunk| from(*chunk)).collect()
}

impl Contents {
    /// Takes one tensor out, of exactly this shape and kind of number.
    pub(super) fn take(&mut self, path: &Path, name: &str, dtype: DType, shape: &[usize]) -> Result<Tensor> {
        let expected = format!("`{name}` of shape {shape:?} in {}", dtype.as_str());
        let refuse = |found: String| Error::file(path, format!("expected {expected}, found {found}"), HINT);
        match self.tensors.remove(name) {
            None => Err(refuse("none".into())),
            Some(tensor) if tensor.dims() != shape || tensor.dtype() != dtype => {
                Err(refuse(format!("shape {:?} in {}", tensor.dims(), tensor.dtype().as_str())))
            }
            Some(tensor) => Ok(tensor),
        }
    }
}
