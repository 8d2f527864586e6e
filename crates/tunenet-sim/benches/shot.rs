//! How long a shot takes to plan: the ready task, 100 heights. The goals are 10 ms by the nearest path and 1 s by the chance
//! among 256 drawn balls, both on two cores.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use tunenet_sim::SimulationFile;
use tunenet_sim::shot::reach::Anywhere;
use tunenet_sim::shot::{ArmReach, Belief, Reach, Rule, Settings, ShotScene, Task, plan};

const TUNED: &str = "\
kind = \"ball\"
ball.radius_m = 0.03
[parameters.restitution]
value = 0.72
min = 0.0
max = 1.0
[effects.quadratic_drag]
c_1_m = 0.05
[provenance]
verdict = \"tuned\"
interval95 = { restitution = [0.70, 0.74] }
";

fn plans(criterion: &mut Criterion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/shot.toml");
    let task = Task::read(&path).expect("the ready task");
    let scene = ShotScene::new(&task, 0.03).expect("its scene");
    let file = SimulationFile::parse(Path::new("tuned.toml"), TUNED).expect("a tuned ball");
    let belief = Belief::new(&file, &task).expect("what is known of it");
    let arm = ArmReach::new(task.arm.as_ref().expect("the ready task has an arm")).expect("its URDF");
    let mut group = criterion.benchmark_group("100 heights");
    group.sample_size(20);
    let ways: [(&str, Rule, &dyn Reach); 4] = [
        ("nearest", Rule::Nearest, &Anywhere),
        ("nearest, arm", Rule::Nearest, &arm),
        ("probability", Rule::Probability, &Anywhere),
        ("probability, arm", Rule::Probability, &arm),
    ];
    for (name, rule, reach) in ways {
        let settings = Settings { rule, ..Settings::default() };
        group.bench_function(name, |bencher| {
            bencher
                .iter(|| plan(black_box(&scene), &belief, task.release.heights_m, reach, &settings).expect("a plan"));
        });
    }
    group.finish();
}

criterion_group!(benches, plans);
criterion_main!(benches);
