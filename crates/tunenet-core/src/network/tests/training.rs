//! What is learned, and that it is always the same.

use std::hash::{Hash as _, Hasher as _};

use rand::Rng as _;

use super::*;

#[test]
fn training_finds_the_difference() {
    let out = dataset(300, 400);
    let preset = Preset { batch: 128, ..short(800) };
    let mut validation = None;
    let model = train(&out, &options(preset), Keeping::default(), &mut |at| {
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
    let out = dataset(60, 60);
    for (name, preset) in
        [("default", short(200)), ("paper", Preset { course: Course::Epochs { epochs: 60 }, ..Preset::paper() })]
    {
        let whole = learned(&out, preset.clone()).weights().unwrap();
        let (kept, options) = (Kept::default(), options(preset));
        let stopped = train(&out, &options, kept.here(), &mut |at| at.step < 60);
        assert!(matches!(stopped, Err(Error::Stopped)));
        let mut first = u64::MAX;
        let mut progress = |at: &TrainProgress| {
            first = first.min(at.step);
            true
        };
        let resumed = train(&out, &options, kept.here(), &mut progress).unwrap().weights().unwrap();
        assert_eq!(first, 80, "{name}");
        assert!(resumed == whole, "{name}");
    }
}

#[test]
fn a_checkpoint_of_another_training_is_refused() {
    let out = dataset(30, 30);
    let (kept, options) = (Kept::default(), options(short(40)));
    train(&out, &options, kept.here(), &mut |_| true).unwrap();
    let refused = train(&out, &TrainOptions { seed: 8, ..options }, kept.here(), &mut |_| true).unwrap_err();
    assert!(refused.to_string().contains("another dataset, preset or seed"), "{refused}");
}

#[test]
fn threads_do_not_change_the_weights() {
    let out = dataset(40, 400);
    for preset in [short(40), Preset { course: Course::Epochs { epochs: 10 }, ..Preset::paper() }] {
        let bytes = [1, 2].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| learned(&out, preset.clone())).weights().unwrap()
        });
        assert!(bytes[0] == bytes[1]);
    }
}

#[test]
fn rollouts_on_disk_give_the_same_weights() {
    let out = dataset(60, 400);
    let presets = [
        Preset { library: 21, ..short(60) },
        Preset { course: Course::Epochs { epochs: 10 }, held_back: 0.2, ..Preset::paper() },
    ];
    for preset in presets {
        let learned = |memory_bytes: usize| {
            let mut validation = None;
            let options = TrainOptions { memory_bytes, ..options(preset.clone()) };
            let overflow = || tempfile::tempfile();
            let keeping = Keeping { checkpoint: None, overflow: Some(&overflow) };
            let model = train(&out, &options, keeping, &mut |at| {
                validation = at.validation;
                true
            });
            (model.unwrap().weights().unwrap(), validation.unwrap())
        };
        let in_memory = learned(TrainOptions::MEMORY_BYTES);
        // From the first rollout on, and from the middle on.
        for memory_bytes in [0, 10_000] {
            assert!(learned(memory_bytes) == in_memory, "{} {memory_bytes}", preset.name);
        }
    }
}

#[test]
fn without_a_scale_all_channels_are_standardised() {
    let plain = |number: u64, random: &mut ChaCha8Rng| PairDraw { own: vec![4.5], scale: None, ..draw(number, random) };
    let out = made(header(200, 200), &plain);
    let mut validation = None;
    let model = train(&out, &options(Preset { batch: 64, ..short(400) }), Keeping::default(), &mut |at| {
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

/// Prints the weights as a digest, for [`processes_do_not_change_the_weights`] to compare.
#[test]
#[ignore = "a part of another test"]
fn digest_of_a_training() {
    let out = dataset(40, 400);
    for preset in [short(40), Preset { course: Course::Epochs { epochs: 10 }, ..Preset::paper() }] {
        let weights = learned(&out, Preset { batch: 256, ..preset }).weights().unwrap();
        let mut hash = std::hash::DefaultHasher::new();
        format!("{weights:?}").hash(&mut hash);
        println!("digest {}", hash.finish());
    }
}

#[test]
fn processes_do_not_change_the_weights() {
    let digests = ["1", "2", "7"].map(|threads| {
        let mut itself = std::process::Command::new(std::env::current_exe().unwrap());
        itself.args(["--exact", "network::tests::training::digest_of_a_training", "--ignored", "--nocapture"]);
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
    let out = dataset(800, 400);
    for preset in [Preset::paper(), Preset::default()] {
        let (name, started) = (preset.name.clone(), std::time::Instant::now());
        let model = learned(&out, preset);
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

#[test]
fn stored_rollouts_start_near_without_a_rollout() {
    let out = dataset(300, 400);
    let model = learned(&out, Preset { library: 61, ..short(400) });
    let without = learned(&out, Preset { library: 0, ..short(400) });
    let scale = scale(4.3);
    for truth in [0.05, 0.33, 0.71, 0.98] {
        let target = seen(truth, 4.3, 400);
        let side = Side { observation: &target, scale: Some(&scale) };
        let start = model.start(side).unwrap().unwrap()[0];
        assert!((start - truth).abs() < 0.02, "{start} is not {truth}");
        assert_eq!(without.start(side).unwrap(), None);
        // The slope between stored rollouts leads on from a rollout nearby.
        let near = seen(truth - 0.004, 4.3, 400);
        let rolled = Side { observation: &near, scale: Some(&scale) };
        let step = model.library_step(truth - 0.004, rolled, side).unwrap().unwrap();
        assert!((step - 0.004).abs() < 0.002, "{step} at {truth}");
    }
}
