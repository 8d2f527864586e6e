//! How many frames a second one core rolls out: 400 frames at 60 Hz, the clock of the published data set.
//!
//! The elements per second that criterion prints are frames per second.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use tunenet_sim::ball::{Forces, Scene, State, positions};

const FRAMES: usize = 400;

fn clock() -> Vec<f64> {
    (0..FRAMES).map(|i| i as f64 / 60.0).collect()
}

fn scene(restitution: f64) -> Scene {
    Scene { radius_m: 0.5, restitution, ..Scene::default() }
}

fn start() -> State {
    State::at([0.0, 0.0, 5.0])
}

/// The mean over a restitution that is uniform between 0 and 1, as 100 rollouts at the middles of 100 equal parts.
fn mean(criterion: &mut Criterion) {
    let (clock, start) = (clock(), start());
    let mut out = vec![0.0; 3 * FRAMES];
    let mut group = criterion.benchmark_group("uniform restitution");
    group.throughput(Throughput::Elements(100 * FRAMES as u64)).sample_size(20);
    group.bench_function("drop", |bencher| {
        bencher.iter(|| {
            for i in 0..100 {
                let scene = scene((f64::from(i) + 0.5) / 100.0);
                positions(black_box(&scene), &start, 0.0, &clock, &mut out).expect("a plain drop");
            }
        });
    });
    group.finish();
}

/// One restitution at a time; around 0.7 most bounces fit into the clock.
fn single(criterion: &mut Criterion) {
    let (clock, start) = (clock(), start());
    let mut out = vec![0.0; 3 * FRAMES];
    let mut group = criterion.benchmark_group("restitution");
    group.throughput(Throughput::Elements(FRAMES as u64)).sample_size(20);
    for percent in [0, 30, 50, 60, 65, 70, 75, 80, 90, 100] {
        let scene = scene(f64::from(percent) / 100.0);
        group.bench_with_input(BenchmarkId::from_parameter(percent), &scene, |bencher, scene| {
            bencher.iter(|| positions(black_box(scene), &start, 0.0, &clock, &mut out).expect("a plain drop"));
        });
    }
    group.finish();
}

/// What a force that follows the velocity costs, and a ball that ends up rolling.
fn others(criterion: &mut Criterion) {
    let (clock, start) = (clock(), start());
    let mut out = vec![0.0; 3 * FRAMES];
    let mut group = criterion.benchmark_group("others");
    group.throughput(Throughput::Elements(FRAMES as u64)).sample_size(20);
    let drag = Scene { flight: Forces { quadratic_drag_1_m: 0.0245, ..Forces::default() }, ..scene(0.7) };
    let rolling = State { velocity_m_s: [1.0, 0.0, 0.0], ..start };
    for (name, scene, start) in [("drag", &drag, &start), ("rolling", &scene(0.5), &rolling)] {
        group.bench_with_input(name, scene, |bencher, scene| {
            bencher.iter(|| positions(black_box(scene), start, 0.0, &clock, &mut out).expect("a plain throw"));
        });
    }
    group.finish();
}

criterion_group!(benches, mean, single, others);
criterion_main!(benches);
