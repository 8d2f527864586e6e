//! Training from a file, with a checkpoint next to it.

use std::io::BufRead as _;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tunenet_core::network::{Checkpoint, Keeping, Model, TrainOptions, TrainProgress, Weights, train};

use super::file::at;
use super::safetensors;
use crate::dataset::DatasetFile;
use crate::source::open;
use crate::{Action, Error, Result, write_atomically};

/// Trains a network on the dataset at `dataset`; see [`train()`]. Its state is kept at `checkpoint`, where one is given; what
/// does not fit into memory waits in a temporary file next to that, or else in the system's folder for such files.
///
/// # Errors
/// As [`train()`]; [`Error::File`] and [`Error::Io`] where the dataset or the checkpoint cannot be used.
pub fn train_file(
    dataset: &Path,
    options: &TrainOptions,
    checkpoint: Option<&Path>,
    progress: &mut dyn FnMut(&TrainProgress) -> bool,
) -> Result<Model> {
    options.preset.check()?;
    let kept = checkpoint.map(|path| CheckpointFile { path, dataset });
    let folder = folder(checkpoint);
    let overflow = || tempfile::tempfile_in(&folder);
    let keeping = Keeping { checkpoint: kept.as_ref().map(|kept| kept as &dyn Checkpoint), overflow: Some(&overflow) };
    train(&DatasetFile::open(dataset)?, options, keeping, progress).map_err(|error| match error {
        tunenet_core::Error::Dataset { expected, found, remedy } => {
            Error::file(dataset, format!("expected {expected}, found {found}"), remedy)
        }
        tunenet_core::Error::Overflow { action, source } => {
            Error::io(folder.join("temporary file of the training"), action, source)
        }
        tunenet_core::Error::Weights { .. } => at(checkpoint.unwrap_or(dataset), error),
        other => other.into(),
    })
}

/// Where the temporary file belongs.
fn folder(checkpoint: Option<&Path>) -> PathBuf {
    match checkpoint.and_then(Path::parent) {
        Some(folder) if folder.as_os_str().is_empty() => PathBuf::from("."),
        Some(folder) => folder.into(),
        None => std::env::temp_dir(),
    }
}

/// The state of a training on `dataset`, kept at `path`.
struct CheckpointFile<'a> {
    path: &'a Path,
    dataset: &'a Path,
}

impl Checkpoint for CheckpointFile<'_> {
    fn fingerprint(&self, settings: &[u8]) -> tunenet_core::Result<String> {
        let mut hash = Sha256::new();
        let mut file = std::io::BufReader::new(open(self.dataset)?);
        loop {
            let bytes = file.fill_buf().map_err(|e| Error::io(self.dataset, Action::Reading, e))?;
            if bytes.is_empty() {
                break;
            }
            hash.update(bytes);
            let read = bytes.len();
            file.consume(read);
        }
        hash.update(settings);
        Ok(hex::encode(hash.finalize()))
    }

    fn load(&self) -> tunenet_core::Result<Option<Weights>> {
        Ok(self.path.exists().then(|| safetensors::read(self.path, "a checkpoint")).transpose()?)
    }

    fn save(&self, weights: &Weights) -> tunenet_core::Result<()> {
        let bytes = safetensors::to_bytes(self.path, weights)?;
        Ok(write_atomically(self.path, |file| file.write_all(&bytes))?)
    }
}
