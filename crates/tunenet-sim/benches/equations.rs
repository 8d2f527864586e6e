//! Rollouts of equations: the damped pendulum, 216 samples, on one core.

use std::hint::black_box;
use std::path::Path;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use tunenet_core::observation::{Channel, Circumstances, Hold, Input};
use tunenet_core::simulator::Simulator;
use tunenet_sim::SimulationFile;
use tunenet_sim::observed_equations::equations;
use tunenet_sim::simulation_file::{Domain, template};

fn rollouts(criterion: &mut Criterion) {
    let file = SimulationFile::parse(Path::new("swing.toml"), &template(Domain::Equations)).expect("a valid file");
    let simulator = equations(&[&file]).expect("a simulator");
    let clock: Vec<f64> = (0..216).map(|i| f64::from(i) / 72.0).collect();
    let driven = |values: Vec<f64>| {
        let input = Input::sampled(Channel::new("u", "V"), Hold::Previous, clock.clone(), values).expect("an input");
        Circumstances { start: vec![0.5, 0.0], ..Circumstances::driven_by(vec![input]) }
    };
    let undriven = driven(vec![0.0; 216]);
    let stepped = driven((0..216).map(|i| f64::from(i % 7) - 3.0).collect());
    let rubbing = simulator.with_effects(&["dry_friction"]).expect("a candidate");
    let mut group = criterion.benchmark_group("equations");
    group.throughput(Throughput::Elements(1));
    for (name, model, parameters, recording) in [
        ("pendulum, 216 samples", &simulator as &dyn Simulator, vec![0.62, 0.1], &undriven),
        ("pendulum, an input that jumps at every sample", &simulator, vec![0.62, 0.1], &stepped),
        ("pendulum, dry friction", &rubbing, vec![0.62, 0.1, 0.3], &undriven),
    ] {
        group.bench_function(name, |bencher| {
            bencher.iter_batched_ref(
                || vec![0.0; clock.len()],
                |values| {
                    let start = [0.5];
                    model.rollout_driven(black_box(&parameters), &start, recording, &clock, values).expect("a rollout");
                },
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, rollouts);
criterion_main!(benches);
