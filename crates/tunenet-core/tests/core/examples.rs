//! The examples do what they say, in as few lines as they promise.

#[path = "../../examples/pendulum.rs"]
mod pendulum;

use tunenet_core::tune::Verdict;

#[test]
fn the_pendulum_gets_its_length_and_damping_back() {
    let outcome = pendulum::tuned().unwrap();
    assert_eq!(outcome.verdict, Verdict::Tuned, "{:?}", outcome.notes);
    for (found, (name, truth)) in outcome.parameters.iter().zip([("length", 0.62), ("damping", 0.24)]) {
        assert_eq!(found.name, name);
        assert!((found.value - truth).abs() < 1e-6, "{name}: {}", found.value);
    }
    pendulum::main().unwrap();
}

#[test]
fn a_simulator_of_your_own_takes_at_most_forty_lines() {
    assert!(include_str!("../../examples/pendulum.rs").lines().count() <= 40);
}
