//! The whole way: a closed-form bouncing ball, a dataset, a training, an estimate.

use crate::simulator::Scale;
use std::path::{Path, PathBuf};

use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::observation::{Channel, Kind, Observation};
use crate::simulator::{Parameter, Simulator, rollout};
use crate::{Error, Result};

const GRAVITY: f64 = 9.81;

/// A point that falls from `own[0]` metres and rebounds with its restitution; exact at every instant.
struct Bouncer {
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
}

impl Bouncer {
    fn new() -> Self {
        Self {
            parameters: vec![Parameter::new("restitution", "1", 0.5, 0.0, 1.0).unwrap()],
            channels: Channel::positions(),
        }
    }
}

impl Simulator for Bouncer {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn kind(&self) -> Kind {
        Kind::Positions
    }

    fn rollout(
        &self,
        parameters: &[f64],
        own: &[f64],
        clock: &[f64],
        values: &mut [f64],
    ) -> std::result::Result<(), String> {
        let (restitution, height) = (parameters[0], own[0]);
        // The arc in flight: where it began, how fast, how long it lasts.
        let (mut began, mut low, mut speed) = (0.0, height, 0.0);
        let mut lasts = (2.0 * height / GRAVITY).sqrt();
        let mut impact = GRAVITY * lasts;
        for (t, row) in clock.iter().zip(values.chunks_exact_mut(3)) {
            while t - began > lasts && impact > 1e-9 {
                began += lasts;
                impact *= restitution;
                (low, speed, lasts) = (0.0, impact, 2.0 * impact / GRAVITY);
            }
            let s = t - began;
            let z = if s > lasts { 0.0 } else { low + speed * s - 0.5 * GRAVITY * s * s };
            row.copy_from_slice(&[0.0, 0.0, z.max(0.0)]);
        }
        Ok(())
    }
}

fn header(pairs: u64, samples: u32) -> DatasetHeader {
    DatasetHeader {
        preset: "bouncer".into(),
        seed: 1,
        pairs,
        parameters: vec![CoveredParameter {
            name: "restitution".into(),
            unit: "1".into(),
            min: 0.0,
            max: 1.0,
            tuned: true,
        }],
        channels: Channel::positions(),
        clock: (0..samples).map(|i| f64::from(i) / 60.0).collect(),
        scene: "kind = \"ball\"\n".into(),
    }
}

fn scale(height: f64) -> Scale {
    Scale::new(0.0, height, 0.0, (height / GRAVITY).sqrt()).unwrap()
}

fn draw(_: u64, random: &mut ChaCha8Rng) -> PairDraw {
    let height = random.random_range(4.0..5.0);
    PairDraw {
        proposed: vec![random.random()],
        target: vec![random.random()],
        own: vec![height],
        scale: Some(scale(height)),
    }
}

fn fill(out: &Path, header: &DatasetHeader) -> Result<()> {
    generate(&Bouncer::new(), header, &draw, out, &mut |_, _| true)
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn dataset(folder: &tempfile::TempDir, pairs: u64, samples: u32) -> PathBuf {
    let out = folder.path().join("pairs.mcap");
    fill(&out, &header(pairs, samples)).unwrap();
    out
}

/// A training short enough for a test.
fn short(steps: u64) -> Preset {
    Preset { course: Course::Remixed { steps, noise: 0.11, cut: 0.1 }, batch: 32, ..Preset::default() }
}

fn options(preset: Preset, checkpoint: Option<PathBuf>) -> TrainOptions {
    TrainOptions { preset, seed: 7, checkpoint }
}

fn seen(restitution: f64, height: f64, samples: u32) -> Observation {
    let clock = header(0, samples).clock;
    let values = rollout(&Bouncer::new(), &[restitution], &[height], &clock).unwrap();
    Observation::new(Kind::Positions, Channel::positions(), clock, values).unwrap()
}

#[test]
fn a_dataset_comes_back_as_it_was_written() {
    let folder = folder();
    let out = dataset(&folder, 20, 50);
    let reader = DatasetReader::open(&out).unwrap();
    assert_eq!(*reader.header(), header(20, 50));
    let pairs: Vec<Pair> = reader.map(Result::unwrap).collect();
    assert_eq!(pairs.len(), 20);
    for pair in &pairs {
        let again = rollout(&Bouncer::new(), &pair.target_parameters, &pair.own, &header(20, 50).clock).unwrap();
        assert_eq!(pair.target, again);
        assert_eq!(pair.scale, Some(scale(pair.own[0])));
    }
    assert!(!folder.path().join("pairs.mcap.partial").exists());
}

#[test]
fn threads_do_not_change_the_bytes() {
    let folder = folder();
    let bytes = [1, 3].map(|threads| {
        let out = folder.path().join(format!("{threads}.mcap"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fill(&out, &header(150, 30))).unwrap();
        std::fs::read(out).unwrap()
    });
    assert_eq!(bytes[0], bytes[1]);
}

#[test]
fn an_interrupted_dataset_goes_on_to_the_same_bytes() {
    let folder = folder();
    let whole = std::fs::read(dataset(&folder, 70, 40)).unwrap();
    let out = folder.path().join("again.mcap");
    let partial = folder.path().join("again.mcap.partial");
    for cut in [0, 5, 100, whole.len() / 5, whole.len() / 2, whole.len() * 4 / 5, whole.len() - 1, whole.len()] {
        std::fs::write(&partial, &whole[..cut]).unwrap();
        let mut from = u64::MAX;
        let mut progress = |done, _| {
            from = from.min(done);
            true
        };
        generate(&Bouncer::new(), &header(70, 40), &draw, &out, &mut progress).unwrap();
        assert!(std::fs::read(&out).unwrap() == whole, "cut at byte {cut}");
        assert!(cut < whole.len() / 2 || from >= 16, "cut at byte {cut} of {}: started from {from}", whole.len());
    }
}

#[test]
fn a_stopped_dataset_goes_on() {
    let folder = folder();
    let whole = std::fs::read(dataset(&folder, 300, 10)).unwrap();
    let out = folder.path().join("again.mcap");
    let stopped = generate(&Bouncer::new(), &header(300, 10), &draw, &out, &mut |done, _| done == 0);
    assert!(matches!(stopped, Err(Error::Stopped)));
    assert!(!out.exists());
    let mut first = None;
    let mut progress = |done, _| {
        first.get_or_insert(done);
        true
    };
    generate(&Bouncer::new(), &header(300, 10), &draw, &out, &mut progress).unwrap();
    assert_eq!(first, Some(128));
    assert!(std::fs::read(&out).unwrap() == whole);
}

#[test]
fn a_partial_of_something_else_is_refused() {
    let folder = folder();
    let out = folder.path().join("pairs.mcap");
    let partial = folder.path().join("pairs.mcap.partial");
    fill(&folder.path().join("other.mcap"), &DatasetHeader { seed: 2, ..header(20, 30) }).unwrap();
    std::fs::rename(folder.path().join("other.mcap"), &partial).unwrap();
    let refused = fill(&out, &header(20, 30)).unwrap_err();
    assert!(refused.to_string().contains("other settings"), "{refused}");
    assert!(refused.hint().unwrap().contains("--out"));
    std::fs::write(&partial, "a shopping list, and not a short one").unwrap();
    assert!(fill(&out, &header(20, 30)).unwrap_err().to_string().contains("another kind of file"));
}

#[test]
fn what_is_no_dataset_is_refused_in_one_sentence() {
    let folder = folder();
    let out = dataset(&folder, 40, 40);
    let bytes = std::fs::read(&out).unwrap();
    let refusal = |bytes: &[u8]| {
        let path = folder.path().join("bad.mcap");
        std::fs::write(&path, bytes).unwrap();
        let all = DatasetReader::open(&path).and_then(Iterator::collect::<Result<Vec<_>>>);
        let text = all.unwrap_err().to_string();
        assert!(!text.contains('\n'));
        text
    };
    assert!(refusal(b"t_s,z_m\n0,1\n").contains("expected an MCAP file"));
    assert!(refusal(&bytes[..bytes.len() / 2]).contains("cut short"));
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 0xff;
    assert!(refusal(&damaged).contains("expected"));
    assert!(matches!(DatasetReader::open(folder.path().join("none.mcap")), Err(Error::Io { .. })));
}

#[test]
fn training_finds_the_difference() {
    let folder = folder();
    let out = dataset(&folder, 300, 400);
    let preset = Preset { batch: 128, ..short(800) };
    let mut validation = None;
    let model = train(&out, &options(preset, None), &mut |at| {
        validation = at.validation;
        true
    })
    .unwrap();
    assert!(validation.unwrap() < 0.02, "{validation:?}");

    let (mut untuned, mut tuned) = (0.0, 0.0);
    for i in 0..50 {
        // A height outside the training set: only the dimensionless shape counts.
        let (truth, proposed, height) = (0.31 + 0.008 * f64::from(i), 0.5, 3.0);
        let one = seen(proposed, height, 400);
        let two = seen(truth, height, 400);
        let change = model.estimate(&one, Some(&scale(height)), &two, Some(&scale(height))).unwrap()[0];
        untuned += (truth - proposed).abs() / 50.0;
        tuned += (truth - proposed - change).abs() / 50.0;
    }
    assert!(tuned < 0.05 * untuned, "{tuned} of {untuned}");
    let same = seen(0.4, 4.5, 400);
    assert_eq!(model.estimate(&same, Some(&scale(4.5)), &same, Some(&scale(4.5))).unwrap(), [0.0]);
}

#[test]
fn a_resumed_training_ends_with_the_same_bits() {
    let folder = folder();
    let out = dataset(&folder, 60, 60);
    for (name, preset) in
        [("default", short(200)), ("paper", Preset { course: Course::Epochs { epochs: 60 }, ..Preset::paper() })]
    {
        let whole = train(&out, &options(preset.clone(), None), &mut |_| true).unwrap().to_bytes().unwrap();
        let kept = options(preset, Some(folder.path().join(name)));
        let stopped = train(&out, &kept, &mut |at| at.step < 60);
        assert!(matches!(stopped, Err(Error::Stopped)));
        let mut first = u64::MAX;
        let mut progress = |at: &TrainProgress| {
            first = first.min(at.step);
            true
        };
        let resumed = train(&out, &kept, &mut progress).unwrap().to_bytes().unwrap();
        assert_eq!(first, 80, "{name}");
        assert!(resumed == whole, "{name}");
    }
}

#[test]
fn a_checkpoint_of_another_training_is_refused() {
    let folder = folder();
    let out = dataset(&folder, 30, 30);
    let kept = options(short(40), Some(folder.path().join("checkpoint")));
    train(&out, &kept, &mut |_| true).unwrap();
    let refused = train(&out, &TrainOptions { seed: 8, ..kept }, &mut |_| true).unwrap_err();
    assert!(refused.to_string().contains("another dataset, preset or seed"), "{refused}");
}

#[test]
fn threads_do_not_change_the_weights() {
    let folder = folder();
    let out = dataset(&folder, 40, 400);
    for preset in [short(40), Preset { course: Course::Epochs { epochs: 10 }, ..Preset::paper() }] {
        let bytes = [1, 2].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| train(&out, &options(preset.clone(), None), &mut |_| true)).unwrap().to_bytes().unwrap()
        });
        assert!(bytes[0] == bytes[1]);
    }
}

#[test]
fn a_model_file_comes_back() {
    let folder = folder();
    let out = dataset(&folder, 30, 60);
    for preset in [short(40), Preset { course: Course::Epochs { epochs: 5 }, ..Preset::paper() }] {
        let model = train(&out, &options(preset, None), &mut |_| true).unwrap();
        let path = folder.path().join("model.safetensors");
        model.save(&path).unwrap();
        let loaded = Model::load(&path).unwrap();
        assert_eq!(loaded.to_bytes().unwrap(), std::fs::read(&path).unwrap());
        let (one, two, scale) = (seen(0.3, 4.2, 60), seen(0.6, 4.2, 60), scale(4.2));
        let estimate = |model: &Model| model.estimate(&one, Some(&scale), &two, Some(&scale)).unwrap();
        assert_eq!(estimate(&loaded), estimate(&model));
        assert_eq!(loaded.parameters(), model.parameters());
    }
}

#[test]
fn what_is_no_model_is_refused_in_one_sentence() {
    let folder = folder();
    let out = dataset(&folder, 30, 60);
    let model = train(&out, &options(short(20), None), &mut |_| true).unwrap();
    let path = folder.path().join("model.safetensors");
    assert!(matches!(Model::load(&path), Err(Error::Io { .. })));
    std::fs::write(&path, "no tensors here").unwrap();
    assert!(Model::load(&path).unwrap_err().to_string().contains("not safetensors"));

    let good = model.to_bytes().unwrap();
    let with = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len(), "the header's length must stay");
        let at = good.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
        let mut bytes = good.clone();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        std::fs::write(&path, bytes).unwrap();
        Model::load(&path).unwrap_err().to_string()
    };
    assert!(with("\\\"version\\\":1", "\\\"version\\\":9").contains("expected a model of version 1, found version 9"));
    let text = with("\\\"hidden\\\":32", "\\\"hidden\\\":31");
    assert!(text.contains("[64, 31]") && text.contains("[64, 32]"), "{text}");
}

#[test]
fn an_observation_of_something_else_is_refused() {
    let folder = folder();
    let out = dataset(&folder, 30, 60);
    let model = train(&out, &options(short(20), None), &mut |_| true).unwrap();
    let good = seen(0.4, 4.5, 60);
    assert!(model.estimate(&good, None, &good, None).unwrap_err().to_string().contains("scale"));
    let other =
        Observation::new(Kind::Other, vec![Channel::new("angle", "rad")], vec![0.0, 0.1, 0.2], vec![0.0; 3]).unwrap();
    let refused = model.estimate(&other, Some(&scale(4.5)), &good, Some(&scale(4.5))).unwrap_err().to_string();
    assert!(refused.contains("angle (rad)") && refused.contains("z (m)"), "{refused}");
}

#[test]
fn without_a_scale_all_channels_are_standardised() {
    let folder = folder();
    let out = folder.path().join("pairs.mcap");
    let plain = |number: u64, random: &mut ChaCha8Rng| PairDraw { own: vec![4.5], scale: None, ..draw(number, random) };
    generate(&Bouncer::new(), &header(200, 200), &plain, &out, &mut |_, _| true).unwrap();
    let mut validation = None;
    let model = train(&out, &options(Preset { batch: 64, ..short(400) }, None), &mut |at| {
        validation = at.validation;
        true
    })
    .unwrap();
    assert!(matches!(model.input(), Input::Standardised { bins: 128, .. }));
    assert!(validation.unwrap() < 0.04, "{validation:?}");
    let batch = {
        let (one, two) = (seen(0.3, 4.5, 200), seen(0.7, 4.5, 200));
        let side = |observation| Side { observation, scale: None };
        model.estimate_batch(&[(side(&one), side(&two)), (side(&two), side(&one)), (side(&one), side(&one))]).unwrap()
    };
    assert!((batch[0][0] - 0.4).abs() < 0.05);
    assert_eq!(batch[0][0], -batch[1][0]);
    assert_eq!(batch[2], [0.0]);
}

/// Prints the weights' bytes as a digest, for [`processes_do_not_change_the_weights`] to compare.
#[test]
#[ignore = "a part of another test"]
fn digest_of_a_training() {
    let folder = folder();
    let out = dataset(&folder, 40, 400);
    for preset in [short(40), Preset { course: Course::Epochs { epochs: 10 }, ..Preset::paper() }] {
        let bytes = train(
            &out,
            &TrainOptions { preset: Preset { batch: 256, ..preset }, ..options(short(1), None) },
            &mut |_| true,
        )
        .unwrap()
        .to_bytes()
        .unwrap();
        println!("digest {:?}", <sha2::Sha256 as sha2::Digest>::digest(bytes));
    }
}

#[test]
fn processes_do_not_change_the_weights() {
    let digests = ["1", "2", "7"].map(|threads| {
        let mut itself = std::process::Command::new(std::env::current_exe().unwrap());
        itself.args(["--exact", "network::tests::digest_of_a_training", "--ignored", "--nocapture"]);
        let printed = itself.env("RAYON_NUM_THREADS", threads).output().unwrap().stdout;
        let lines = String::from_utf8(printed).unwrap();
        lines.lines().filter_map(|line| Some(line.split_once("digest ")?.1.to_owned())).collect::<Vec<_>>()
    });
    assert_eq!(digests[0].len(), 2);
    assert_eq!(digests[0], digests[1]);
    assert_eq!(digests[0], digests[2]);
}

/// Figures of the full presets; slow, so it runs on request: `cargo test -- --ignored --nocapture figures`.
#[test]
#[ignore = "measures; takes half a minute"]
fn figures_of_both_presets() {
    let folder = folder();
    let out = dataset(&folder, 800, 400);
    for preset in [Preset::paper(), Preset::default()] {
        let (name, started) = (preset.name.clone(), std::time::Instant::now());
        let model = train(&out, &options(preset, None), &mut |_| true).unwrap();
        println!("{name}: {:.2} s", started.elapsed().as_secs_f64());
        for (low, high) in [(0.3, 0.7), (0.0, 1.0)] {
            for noise_m in [0.0, 0.005, 0.02] {
                let by_rollout = error_by_rollout(&model, low, high, noise_m).map(|e| format!("{e:.1e}"));
                println!("  {low} to {high}, noise {noise_m} m: {}", by_rollout.join(" "));
            }
        }
    }
}

/// Mean absolute error after 0, 1, … rollouts, with white noise of `sd` metres on the target.
fn error_by_rollout(model: &Model, low: f64, high: f64, noise_m: f64) -> [f64; 6] {
    let mut random = <ChaCha8Rng as rand::SeedableRng>::seed_from_u64(9);
    let mut errors = [0.0; 6];
    for _ in 0..300 {
        let (height, truth) = (random.random_range(4.0..5.0), random.random_range(low..high));
        let mut guess: f64 = random.random_range(low..high);
        let clean = seen(truth, height, 400);
        let noisy = clean.values().iter().map(|z| z + noise_m * random.sample::<f64, _>(rand_distr::StandardNormal));
        let two =
            Observation::new(Kind::Positions, Channel::positions(), clean.clock().to_vec(), noisy.collect()).unwrap();
        for error in &mut errors {
            *error += (guess - truth).abs() / 300.0;
            let one = seen(guess, height, 400);
            let change = model.estimate(&one, Some(&scale(height)), &two, Some(&scale(height))).unwrap()[0];
            guess = (guess + change).clamp(0.0, 1.0);
        }
    }
    errors
}
