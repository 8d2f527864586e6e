//! The examples do what they say, in as few lines as they promise.

#[path = "../../examples/driven_cart.rs"]
mod driven_cart;
#[path = "../../examples/pendulum.rs"]
mod pendulum;

use tunenet_core::diagnose::Verdict as Named;
use tunenet_core::testing::PushedCart;
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

/// The recordings are closed forms: nothing of the example's integrator is in them.
#[test]
fn the_cart_shows_its_delay_or_its_spring_or_nothing() {
    let truth_kg = 1.8;
    let cart = PushedCart { mass_kg: truth_kg, damping_ns_m: 2.1, delay_s: 0.0, stiffness_n_m: 0.0 };
    let late = (PushedCart { delay_s: 0.025, ..cart }, "motor_delay", 0.025);
    let tied = (PushedCart { stiffness_n_m: 1.5, ..cart }, "cable_spring", 1.5);
    for (seed, (truth, name, value)) in [late, tied].into_iter().enumerate() {
        let found = driven_cart::diagnosed(&truth.recordings(4, 1e-3, seed as u64).unwrap()).unwrap();
        assert_eq!((found.verdict(), found.names()), (Named::Named, vec![name]), "{:?}", found.conclusion);
        let fitted = &found.effects()[0].coefficients[0].values[0];
        assert!((fitted.interval95.0..=fitted.interval95.1).contains(&value), "{name}: {fitted:?}");
    }
    let holds = |seed: u64| {
        let found = driven_cart::diagnosed(&late.0.recordings(4, 1e-3, seed).unwrap()).unwrap();
        let mass = &found.parameters[0];
        (mass.interval95.0..=mass.interval95.1).contains(&truth_kg)
    };
    let held = (100..140).filter(|seed| holds(*seed)).count();
    // Of 40 intervals of 95 %, fewer than 34 hold the truth once in 300 times.
    assert!(held >= 34, "{held} of 40");
    let found = driven_cart::diagnosed(&cart.recordings(4, 1e-3, 7).unwrap()).unwrap();
    assert_eq!(found.verdict(), Named::None, "{:?}", found.conclusion);
    driven_cart::main().unwrap();
}

#[test]
fn a_simulator_of_your_own_takes_at_most_forty_lines() {
    assert!(include_str!("../../examples/pendulum.rs").lines().count() <= 40);
    assert!(include_str!("../../examples/driven_cart.rs").lines().count() <= 40);
}
