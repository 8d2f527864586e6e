//! Named arrays as safetensors, with one JSON text next to them.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use tunenet_core::network::{Array, Numbers, Weights};

use crate::documents::refuse_pointer;
use crate::source::{open, read_bytes};
use crate::{Action, Error, Result};

/// The one metadata key, so that no map decides the order of the bytes.
const KEY: &str = "tunenet";

/// Largest file that is read, in bytes: thousands of times what a network of two branches has.
const MOST_BYTES: u64 = 256 << 20;

/// What to try with a file that is no such thing.
pub(crate) const HINT: &str = "`tunenet train` writes models";

/// The file as bytes; equal arrays give equal bytes. `path` names it in messages.
pub(crate) fn to_bytes(path: &Path, weights: &Weights) -> Result<Vec<u8>> {
    let raw = |array: &Array| match &array.numbers {
        Numbers::F32(numbers) => (Dtype::F32, numbers.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()),
        Numbers::F64(numbers) => (Dtype::F64, numbers.iter().flat_map(|v| v.to_le_bytes()).collect()),
    };
    let raw: Vec<_> = weights.arrays.iter().map(|(name, array)| (name, &array.shape, raw(array))).collect();
    let refused = |e: safetensors::SafeTensorError| Error::file(path, format!("the arrays cannot be written: {e}"), "");
    let mut views = Vec::with_capacity(raw.len());
    for (name, shape, (dtype, bytes)) in &raw {
        views.push((name.as_str(), TensorView::new(*dtype, (*shape).clone(), bytes).map_err(refused)?));
    }
    safetensors::serialize(views, Some(HashMap::from([(KEY.to_owned(), weights.about.clone())]))).map_err(refused)
}

/// Reads a file. `kind` names what was expected: "a model".
pub(crate) fn read(path: &Path, kind: &str) -> Result<Weights> {
    let failed = |e| Error::io(path, Action::Reading, e);
    let size = open(path)?.metadata().map_err(failed)?.len();
    if size > MOST_BYTES {
        let message = format!("expected {kind} of at most {MOST_BYTES} bytes, found {size}");
        return Err(Error::file(path, message, HINT));
    }
    let bytes = read_bytes(path, MOST_BYTES)?;
    refuse_pointer(path, &bytes)?;
    from_bytes(path, &bytes, kind)
}

/// As [`read`], from bytes that stand or would stand at `path`.
pub(crate) fn from_bytes(path: &Path, bytes: &[u8], kind: &str) -> Result<Weights> {
    let refuse = |found: String| Error::file(path, format!("expected {kind} in safetensors, found {found}"), HINT);
    let (_, metadata) =
        SafeTensors::read_metadata(bytes).map_err(|e| refuse(format!("a file that is not safetensors ({e})")))?;
    let about = metadata.metadata().as_ref().and_then(|m| m.get(KEY)).cloned();
    let about = about.ok_or_else(|| refuse(format!("a file of another program, without `{KEY}` in its metadata")))?;
    let file = SafeTensors::deserialize(bytes).map_err(|e| refuse(format!("a damaged file ({e})")))?;
    let mut arrays = BTreeMap::new();
    for (name, view) in file.iter() {
        let numbers = match view.dtype() {
            Dtype::F32 => Numbers::F32(numbers(view.data(), f32::from_le_bytes)),
            Dtype::F64 => Numbers::F64(numbers(view.data(), f64::from_le_bytes)),
            other => return Err(refuse(format!("numbers of kind {other:?} in `{name}`"))),
        };
        arrays.insert(name.to_owned(), Array { shape: view.shape().to_vec(), numbers });
    }
    Ok(Weights { about, arrays })
}

fn numbers<const N: usize, T>(bytes: &[u8], from: impl Fn([u8; N]) -> T) -> Vec<T> {
    bytes.as_chunks::<N>().0.iter().map(|chunk| from(*chunk)).collect()
}
