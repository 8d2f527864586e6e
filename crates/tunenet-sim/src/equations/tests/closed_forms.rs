//! Smooth equations.

use proptest::prelude::*;

use super::{Given, clock, rk4, run, system};

const PENDULUM: &str = "states.angle_rad = {}
states.rate_rad_s = {}
start.angle_rad.value = 0.5
start.rate_rad_s.value = 0.0
derivatives.angle_rad = \"rate_rad_s\"
derivatives.rate_rad_s = \"-gravity/length*sin(angle_rad) - damping*rate_rad_s\"
constants.gravity = 9.81
";

#[test]
fn a_linear_oscillator_follows_its_closed_form() {
    let text = "states.x_m = {}\nstates.v_m_s = {}\nstart.v_m_s.value = 0\nstart.x_m.value = 1\n\
                derivatives.x_m = \"v_m_s\"\nderivatives.v_m_s = \"-k*x_m - 2*d*v_m_s\"\noutputs.x_m = \"x_m\"\n";
    let system = system(text, &["k", "d"]);
    let times = clock(2000, 0.01);
    // The start stands in the order of the file's [start], not of its [states].
    let given = Given { parameters: vec![9.0, 0.2], start: vec![0.0, 1.0], ..Given::default() };
    let rate = (9.0_f64 - 0.04).sqrt();
    for (t, x) in times.iter().zip(run(&system, &given, &times)) {
        let wanted = (-0.2 * t).exp() * ((rate * t).cos() + 0.2 / rate * (rate * t).sin());
        assert!((x - wanted).abs() < 2e-7, "{t}: {x} {wanted}");
    }
}

#[test]
fn a_damped_pendulum_agrees_with_tiny_steps() {
    let system = system(PENDULUM, &["length", "damping"]);
    let times = clock(216, 1.0 / 72.0);
    let given = Given { parameters: vec![0.62, 0.3], start: vec![2.0, -1.0], ..Given::default() };
    let found = run(&system, &given, &times);
    let slow = rk4(|_, [q, w]| [w, -9.81 / 0.62 * q.sin() - 0.3 * w], [2.0, -1.0], &times, 1e-4);
    for (i, wanted) in slow.iter().enumerate() {
        for k in 0..2 {
            assert!((found[2 * i + k] - wanted[k]).abs() < 1e-6, "{i}: {} {}", found[2 * i + k], wanted[k]);
        }
    }
}

#[test]
fn the_state_holds_before_the_first_stamp_and_the_clock_is_the_recordings() {
    let text = "states.x_m = {}\nstart.x_m.value = 0\nderivatives.x_m = \"k*(t_s - 10)\"\noutputs.x_m = \"x_m\"\n\
                outputs.late_s = \"t_s\"\n";
    let system = system(text, &["k"]);
    let given = Given { parameters: vec![1.0], start: vec![1.0], start_s: 10.0, ..Given::default() };
    let found = run(&system, &given, &[9.5, 10.0, 12.0]);
    let wanted = [1.0, 9.5, 1.0, 10.0, 3.0, 12.0];
    assert!(found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-12), "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    /// The value at an instant does not depend on which others are asked for.
    #[test]
    fn a_rollout_does_not_depend_on_its_clock(mut some in proptest::collection::vec(0.0..3.0_f64, 1..20), more in 3.0..5.0_f64) {
        let system = system(PENDULUM, &["length", "damping"]);
        let given = Given { parameters: vec![0.8, 0.1], start: vec![1.2, 0.4], ..Given::default() };
        some.sort_by(f64::total_cmp);
        some.dedup();
        let together = run(&system, &given, &[some.clone(), vec![more]].concat());
        for (i, t) in some.iter().enumerate() {
            let alone = run(&system, &given, &[*t]);
            prop_assert_eq!(&alone[..], &together[2 * i..2 * i + 2]);
        }
        prop_assert_eq!(run(&system, &given, &some), &together[..2 * some.len()]);
    }
}

/// A body on a spring with friction |v|^p sign(v): how far another p moves it is the same by steps of a millionth and of a thousandth, and so
/// is no noise of the integration.
#[test]
fn differences_of_rollouts_with_a_sharp_bend_are_those_of_the_motion() {
    let text = "states.x_m = {}\nstates.v_m_s = {}\nstart.x_m.value = 1\nstart.v_m_s.value = 0\n\
                derivatives.x_m = \"v_m_s\"\nderivatives.v_m_s = \"-30*x_m - 1.1*abs(v_m_s)^p*sign(v_m_s)\"\n";
    let system = system(text, &["p"]);
    let times = clock(80, 0.05);
    let at = |p: f64| run(&system, &Given { parameters: vec![p], start: vec![1.0, 0.0], ..Given::default() }, &times);
    for p in [0.25, 0.5, 0.8] {
        let slope = |step: f64| -> Vec<f64> { at(p + step).iter().zip(at(p)).map(|(a, b)| (a - b) / step).collect() };
        let (short, long) = (slope(1e-5), slope(1e-3));
        let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
        let apart = norm(&mut short.iter().zip(&long).map(|(a, b)| a - b));
        assert!(apart < 0.02 * norm(&mut long.iter().copied()), "{p}: {apart}");
    }
}
