//! Rollouts of a servo that swings a pendulum: 6 s in steps of 1 ms, on one core.

use std::hint::black_box;
use std::path::Path;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use tunenet_core::observation::{Channel, Circumstances, Hold, Input};
use tunenet_core::simulator::Simulator;
use tunenet_sim::SimulationFile;
use tunenet_sim::observed_robot::robot;
use tunenet_sim::simulation_file::{Domain, template};

const MODEL: &str = r#"<robot name="p"><link name="base"/><link name="pendulum"><inertial><mass value="0.000001"/>
<inertia ixx="1e-9" iyy="1e-9" izz="1e-9" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="pendulum"/><axis xyz="0 -1 0"/></joint></robot>"#;

fn rollouts(criterion: &mut Criterion) {
    let folder = std::env::temp_dir().join("tunenet-bench-robot");
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("arm.urdf"), MODEL).expect("a model");
    let path = folder.join("robot.toml");
    let file = SimulationFile::parse(Path::new(&path), &template(Domain::Robot)).expect("a valid file");
    let simulator = robot(&[&file]).expect("a simulator");
    let clock: Vec<f64> = (0..600).map(|i| f64::from(i) / 100.0).collect();
    let input = |name: &str, hold: Hold, of: &dyn Fn(f64) -> f64| {
        let values = clock.iter().map(|t| of(*t)).collect();
        Input::sampled(Channel::new(name, "1"), hold, clock.clone(), values).expect("an input")
    };
    let goal = input("goal", Hold::Linear, &|t| 0.8 * (t * t).sin());
    let on = input("on", Hold::Previous, &|t| f64::from(u8::from(t < 4.0)));
    let driven = Circumstances { start: vec![0.0, 0.0], ..Circumstances::driven_by(vec![goal, on]) };
    let parameters: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let three = simulator.with_effects(&["speed_limit", "command_delay", "load_friction"]).expect("effects");
    let mut group = criterion.benchmark_group("robot");
    group.throughput(Throughput::Elements(1));
    for (name, model, numbers) in [
        ("servo, 6 s", &simulator as &dyn Simulator, parameters.clone()),
        ("servo with three effects, 6 s", &three, [parameters.as_slice(), &[0.21, 0.033, 0.19]].concat()),
    ] {
        group.bench_function(name, |bencher| {
            bencher.iter_batched_ref(
                || vec![0.0; clock.len()],
                |values| {
                    model.rollout_driven(black_box(&numbers), &[], &driven, &clock, values).expect("a rollout");
                },
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, rollouts);
criterion_main!(benches);
