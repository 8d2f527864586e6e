//! A training that can be killed.

use std::path::Path;

use candle_core::DType;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::learner::Place;
use super::model::{self, About};
use super::optimiser::Descent;
use super::two_branch::TwoBranch;
use super::weights_file;
use crate::{Error, Result};

/// What a checkpoint says beside its numbers.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mark {
    /// Of the dataset, the preset and the seed: a checkpoint goes on with the same training or not at all.
    fingerprint: String,
    /// Steps done.
    step: u64,
    /// Who did the sums; see [`Place::name`](super::learner::Place::name).
    #[serde(default = "by_hand", skip_serializing_if = "is_by_hand")]
    device: String,
}

/// What a checkpoint need not say.
fn by_hand() -> String {
    Place::ByHand.name().into()
}

fn is_by_hand(device: &str) -> bool {
    device == Place::ByHand.name()
}

/// What makes a training this one: every byte of its dataset, its preset and its seed.
pub(super) fn fingerprint(dataset: &Path, about: &About) -> Result<String> {
    let mut hash = Sha256::new();
    let failed = |e| Error::io(dataset, "reading", e);
    let mut file = std::io::BufReader::new(crate::observation::recording::open(dataset)?);
    loop {
        let bytes = std::io::BufRead::fill_buf(&mut file).map_err(failed)?;
        if bytes.is_empty() {
            break;
        }
        hash.update(bytes);
        let read = bytes.len();
        std::io::BufRead::consume(&mut file, read);
    }
    hash.update(serde_json::to_vec(about).map_err(|e| candle_core::Error::Msg(e.to_string()))?);
    let digits = b"0123456789abcdef";
    let hex = |byte: u8| [digits[usize::from(byte >> 4)], digits[usize::from(byte & 15)]].map(char::from);
    Ok(hash.finalize().into_iter().flat_map(hex).collect())
}

/// Which training, and where it runs.
///
/// A training ends where it began: half of it on a GPU and half on a CPU would be a network that no one command makes again.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kept<'a> {
    pub(super) path: &'a Path,
    /// See [`fingerprint`].
    pub(super) fingerprint: &'a str,
    pub(super) place: &'a Place,
}

/// Writes where the training stands; a kill leaves the one before or this one, never half of it.
pub(super) fn save(kept: Kept<'_>, step: u64, network: &TwoBranch, descent: &Descent) -> Result<()> {
    let mut tensors = model::named(network);
    for (name, (mean, square)) in TwoBranch::NAMES.iter().zip(&descent.memory) {
        tensors.push((format!("mean.{name}"), mean.clone()));
        tensors.push((format!("square.{name}"), square.clone()));
    }
    let mark = Mark { fingerprint: kept.fingerprint.to_owned(), step, device: kept.place.name().into() };
    let mark = serde_json::to_string(&mark).map_err(|e| candle_core::Error::Msg(e.to_string()))?;
    weights_file::write(kept.path, &weights_file::to_bytes(mark, &tensors)?)
}

/// Goes on from the checkpoint: sets the network and the optimiser, returns the steps done; `None` where there is no file.
pub(super) fn load(
    Kept { path, fingerprint, place }: Kept<'_>,
    about: &About,
    network: &mut TwoBranch,
    descent: &mut Descent,
) -> Result<Option<u64>> {
    if !path.exists() {
        return Ok(None);
    }
    let mut contents = weights_file::read(path, "a checkpoint")?;
    let refuse = |found: &str| {
        let text = format!("expected a checkpoint of this training, found {found}");
        Error::file(path, text, "delete it, or write to another --out")
    };
    let mark: Mark = serde_json::from_str(&contents.about).map_err(|_| refuse("a model or another file"))?;
    if mark.fingerprint != fingerprint {
        return Err(refuse("one of another dataset, preset or seed"));
    }
    if mark.device != place.name() {
        let (device, found) = (&mark.device, place.name());
        let text = format!("expected a checkpoint of a training on `{found}`, found one on `{device}`");
        return Err(Error::file(
            path,
            text,
            format!("go on with `--device {device}`, delete it, or write to another --out"),
        ));
    }
    *network = model::take_network(path, &mut contents, about)?;
    for (name, (mean, square)) in TwoBranch::NAMES.iter().zip(&mut descent.memory) {
        let (expected, number) = (mean.shape().clone(), DType::F32);
        *mean = contents.take(path, &format!("mean.{name}"), number, expected.dims())?;
        *square = contents.take(path, &format!("square.{name}"), number, expected.dims())?;
    }
    Ok(Some(mark.step))
}
