//! Evaluations per second of formulas; `cargo bench -p tunenet-formula`.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use tunenet_formula::{Formula, Name};

fn evaluate(criterion: &mut Criterion) {
    let names = ["c", "p", "h", "speed", "z"].map(|name| Name::new(name, None));
    for text in ["-c*speed", "-c*speed^p*exp(-z/h)"] {
        let formula = Formula::parse(text, &names).expect("a formula");
        let values = [0.13, 2.0, 1.5, 3.0, 0.8];
        criterion.bench_function(text, |b| b.iter(|| formula.program().value(black_box(&values))));
    }
}

criterion_group!(benches, evaluate);
criterion_main!(benches);
