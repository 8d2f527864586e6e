//! Model files, whole and foreign, and trainings from a file.

use std::path::PathBuf;

use tunenet_core::network::DataSet as _;
use tunenet_core::network::{Course, Model, Preset, TrainOptions, train_on};

use super::*;
use crate::Error;
use crate::dataset::{DatasetFile, generate};
use tunenet_core::testing::reflected_point::{ReflectedPoint, draw, header};

fn dataset(folder: &tempfile::TempDir, pairs: u64, samples: u32) -> PathBuf {
    let out = folder.path().join("pairs.mcap");
    generate(&ReflectedPoint::new(), &header(pairs, samples), None, &draw, &out, &mut |_, _| true).unwrap();
    out
}

fn options(steps: u64) -> TrainOptions {
    let preset = Preset { course: Course::Remixed { steps, noise: 0.11, cut: 0.1 }, batch: 32, ..Preset::default() };
    TrainOptions::new(preset, 7)
}

#[test]
fn a_model_file_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let model = train_file(&dataset(&folder, 30, 60), &options(40), None, &mut |_| true).unwrap();
    let path = folder.path().join("model.safetensors");
    save_model(&model, &path).unwrap();
    let loaded = load_model(&path).unwrap();
    assert_eq!(loaded.weights().unwrap(), model.weights().unwrap());
    assert_eq!(model_to_bytes(&loaded).unwrap(), std::fs::read(&path).unwrap());
}

#[test]
fn what_is_no_model_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let model = train_file(&dataset(&folder, 30, 60), &options(20), None, &mut |_| true).unwrap();
    let path = folder.path().join("model.safetensors");
    assert!(matches!(load_model(&path), Err(Error::Io { .. })));
    std::fs::write(&path, "no tensors here").unwrap();
    assert!(load_model(&path).unwrap_err().to_string().contains("not safetensors"));
    let good = model_to_bytes(&model).unwrap();
    let (from, to) = ("\\\"version\\\":1", "\\\"version\\\":9");
    let at = good.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
    let mut bytes = good.clone();
    bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
    std::fs::write(&path, bytes).unwrap();
    let refused = load_model(&path).unwrap_err();
    assert!(
        refused.to_string().ends_with("model.safetensors: expected a model of version 1, found version 9"),
        "{refused}"
    );
    assert_eq!(refused.hint(), Some("train it again with this version of `tunenet train`"));
}

#[test]
fn weights_that_are_no_numbers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let model = train_file(&dataset(&folder, 30, 60), &options(20), None, &mut |_| true).unwrap();
    let mut bytes = model_to_bytes(&model).unwrap();
    let end = bytes.len();
    // Not a number by itself, and as the upper half of a double.
    bytes[end - 4..].copy_from_slice(&0x7ff8_0000u32.to_le_bytes());
    let refused = model_from_bytes("model.safetensors", &bytes).unwrap_err().to_string();
    assert!(refused.contains("expected finite numbers in `") && refused.contains("NaN or infinity"), "{refused}");
}

#[test]
fn a_file_and_memory_give_the_same_network() {
    let folder = tempfile::tempdir().unwrap();
    let out = dataset(&folder, 40, 30);
    let pairs: Vec<_> = DatasetFile::open(&out).unwrap().pairs().unwrap().collect::<tunenet_core::Result<_>>().unwrap();
    let from_memory = train_on(&header(40, 30), &pairs, &options(40), &mut |_| true).unwrap();
    // With the rollouts in memory, and in a temporary file.
    for memory_bytes in [TrainOptions::MEMORY_BYTES, 0] {
        let options = TrainOptions { memory_bytes, ..options(40) };
        let from_file = train_file(&out, &options, None, &mut |_| true).unwrap();
        assert_eq!(from_file.weights().unwrap(), from_memory.weights().unwrap());
    }
}

#[test]
fn a_data_set_that_does_not_fit_names_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let out = dataset(&folder, 20, 30);
    let preset =
        Preset { input: tunenet_core::network::InputChoice::Raw { channel: Some("q".into()) }, ..Preset::paper() };
    let refused = train_file(&out, &TrainOptions::new(preset, 7), None, &mut |_| true).unwrap_err();
    assert!(refused.to_string().ends_with("pairs.mcap: expected a channel `q`, found x, y, z"), "{refused}");
    assert!(matches!(refused, Error::File { .. }));
}

#[test]
fn a_killed_training_is_resumed_from_its_checkpoint_and_by_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let (out, kept) = (dataset(&folder, 40, 30), folder.path().join("checkpoint"));
    let trained = |options: &TrainOptions, stop: u64| train_file(&out, options, Some(&kept), &mut |at| at.step < stop);
    let whole: Model = train_file(&out, &options(100), None, &mut |_| true).unwrap();
    assert!(matches!(trained(&options(100), 40), Err(Error::Core(tunenet_core::Error::Stopped))));
    let refused = trained(&TrainOptions { seed: 8, ..options(100) }, 100).unwrap_err();
    let expected = "checkpoint: expected a checkpoint of this training, found one of another dataset, preset or seed";
    assert!(refused.to_string().ends_with(expected), "{refused}");
    assert_eq!(refused.hint(), Some("delete it, or write to another --out"));
    let resumed = trained(&options(100), u64::MAX).unwrap();
    assert_eq!(resumed.weights().unwrap(), whole.weights().unwrap());
}
