//! How long a training takes: the `paper` preset on 800 pairs of 400 heights, and steps of the `default` preset.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use tunenet_core::network::{Course, CoveredParameter, DatasetHeader, Pair, Preset, TrainOptions, train_on};
use tunenet_core::observation::Channel;
use tunenet_core::simulator::Scale;

/// Heights that depend on one parameter: a decaying cosine, since only the sizes matter here.
fn height(parameter: f64, time_s: f64) -> f64 {
    4.5 * (-parameter * time_s).exp() * (3.0 * time_s).cos().abs()
}

fn dataset() -> (DatasetHeader, Vec<Pair>) {
    let clock: Vec<f64> = (0..400).map(|i| f64::from(i) / 60.0).collect();
    let parameters = [("decay", 0.3, 0.7)].map(|(name, min, max)| CoveredParameter {
        name: name.into(),
        unit: "1/s".into(),
        min,
        max,
        tuned: true,
    });
    let header = DatasetHeader {
        preset: "cosine".into(),
        seed: 0,
        pairs: 800,
        parameters: parameters.to_vec(),
        channels: vec![Channel::new("z", "m")],
        target_channels: Vec::new(),
        clock: clock.clone(),
        scene: String::new(),
    };
    let pair = |i: u32| {
        let (proposed, target) = (0.3 + 0.0005 * f64::from(i), 0.7 - 0.0005 * f64::from(i * 7 % 800));
        let rollout = |parameter| clock.iter().map(|t| height(parameter, *t)).collect();
        Pair {
            proposed_parameters: vec![proposed],
            target_parameters: vec![target],
            own: vec![],
            scale: Scale::new(0.0, 4.5, 0.0, 0.677).ok(),
            proposed: rollout(proposed),
            target: rollout(target),
            clock: vec![],
        }
    };
    (header, (0..800).map(pair).collect())
}

fn training(criterion: &mut Criterion) {
    let (header, pairs) = dataset();
    let steps = Course::Remixed { steps: 400, noise: 0.06, cut: 0.05 };
    let mut group = criterion.benchmark_group("train");
    group.sample_size(10);
    for (name, preset) in [
        ("paper, 3200 steps of 50", Preset::paper()),
        ("default, 400 steps of 256", Preset { course: steps, ..Preset::default() }),
    ] {
        let options = TrainOptions::new(preset, 0);
        group.bench_function(name, |b| {
            b.iter(|| train_on(black_box(&header), black_box(&pairs), &options, &mut |_| true).expect("a training"));
        });
    }
    group.finish();
}

criterion_group!(benches, training);
criterion_main!(benches);
