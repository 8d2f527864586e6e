//! A model's file.

use std::path::Path;

use tunenet_core::network::{Model, WeightsFault};

use super::safetensors;
use crate::{Error, Result, write_atomically};

/// The bytes of a model's file: its [weights](Model::weights) in safetensors. The same training gives the same bytes.
///
/// # Errors
/// [`Error::Network`](tunenet_core::Error::Network) where a tensor cannot be read.
pub fn model_to_bytes(model: &Model) -> Result<Vec<u8>> {
    safetensors::to_bytes(Path::new("the model"), &model.weights()?)
}

/// Writes a model's file; `path` never holds half of one.
///
/// # Errors
/// [`Error::Io`] where the disk refuses.
pub fn save_model(model: &Model, path: impl AsRef<Path>) -> Result<()> {
    let bytes = model_to_bytes(model)?;
    write_atomically(path, |file| file.write_all(&bytes))
}

/// Reads a model's file.
///
/// # Errors
/// [`Error::Io`] where the file cannot be read; [`Error::File`] where it is not safetensors, is not a model, has another
/// version, or a weight is missing or has another shape.
pub fn load_model(path: impl AsRef<Path>) -> Result<Model> {
    let path = path.as_ref();
    Model::from_weights(safetensors::read(path, "a model")?).map_err(|e| at(path, e))
}

/// As [`load_model`], from bytes at hand; `path` names them in messages.
///
/// # Errors
/// [`Error::File`] as [`load_model`].
pub fn model_from_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<Model> {
    let path = path.as_ref();
    Model::from_weights(safetensors::from_bytes(path, bytes, "a model")?).map_err(|e| at(path, e))
}

/// What is wrong with stored weights, with the file that they stand in.
pub(crate) fn at(path: &Path, error: tunenet_core::Error) -> Error {
    let tunenet_core::Error::Weights { expected, found, fault } = error else { return error.into() };
    let hint = match fault {
        WeightsFault::Version => "train it again with this version of `tunenet train`".into(),
        WeightsFault::OtherTraining => "delete it, or write to another --out".into(),
        WeightsFault::OtherDevice(device) => {
            format!("go on with `--device {device}`, delete it, or write to another --out")
        }
        _ => safetensors::HINT.to_owned(),
    };
    Error::file(path, format!("expected {expected}, found {found}"), hint)
}
