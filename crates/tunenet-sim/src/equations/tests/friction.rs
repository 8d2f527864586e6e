//! Switching surfaces: crossing them, sticking, and letting go.

use tunenet_core::observation::Hold;

use super::super::System;
use super::{Given, clock, input, rk4, run, system};

/// A block of mass 1 kg on a table with Coulomb friction.
const BLOCK: &str = "states.x_m = {}
states.v_m_s = {}
start.x_m.value = 0
start.v_m_s.value = 0
derivatives.x_m = \"v_m_s\"
derivatives.v_m_s = \"force_n/mass - friction*sign(v_m_s)\"
constants.mass = 1
inputs.force_n = {}
";

fn block() -> System {
    system(BLOCK, &["friction"])
}

#[test]
fn a_block_stops_after_its_closed_distance_and_sticks() {
    let system = block();
    let given = Given {
        parameters: vec![2.0],
        start: vec![0.0, 3.0],
        inputs: vec![input(Hold::Previous, &[0.0, 4.0, 6.0], &[0.0, -1.5, -2.5])],
        ..Given::default()
    };
    let times = [0.5, 1.5, 3.0, 5.0, 6.0, 7.0];
    let found = run(&system, &given, &times);
    // 3 m/s, 2 m/s²: it stops after 1.5 s and 2.25 m; 1.5 N do not move it, and 2.5 N do.
    let wanted = [1.25, 2.0, 2.25, 0.0, 2.25, 0.0, 2.25, 0.0, 2.25, 0.0, 2.0, -0.5];
    for (i, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        assert!((found - wanted).abs() < 1e-9, "{i}: {found} {wanted}");
    }
}

#[test]
fn an_oscillator_with_dry_friction_loses_the_same_each_half_period() {
    // x'' = -x - c sign(v): each half period the amplitude falls by 2c; it stops within c of the middle.
    let text = "states.x_m = {}\nstates.v_m_s = {}\nstart.x_m.value = 1\nstart.v_m_s.value = 0\n\
                derivatives.x_m = \"v_m_s\"\nderivatives.v_m_s = \"-w2*x_m - c*sign(v_m_s)\"\n";
    let system = system(text, &["w2", "c"]);
    let pi = std::f64::consts::PI;
    let given = Given { parameters: vec![1.0, 0.15], start: vec![1.0, 0.0], ..Given::default() };
    let times: Vec<f64> = (0..8).map(|i| f64::from(i) * pi).collect();
    let found = run(&system, &given, &times);
    for (i, wanted) in [1.0, -0.7, 0.4, -0.1, -0.1, -0.1, -0.1, -0.1].into_iter().enumerate() {
        assert!((found[2 * i] - wanted).abs() < 1e-7, "{i}: {} {wanted}", found[2 * i]);
        assert!(i < 4 || found[2 * i + 1].abs() < 1e-9);
    }
}

#[test]
fn a_stick_is_left_where_the_force_exceeds_it() {
    // A force that grows by 1 N/s breaks 0.7 N loose after 0.7 s.
    let system = block();
    let given = Given {
        parameters: vec![0.7],
        start: vec![0.0, 0.0],
        inputs: vec![input(Hold::Linear, &[0.0, 5.0, 10.0], &[0.0, 5.0, 10.0])],
        ..Given::default()
    };
    let found = run(&system, &given, &[0.5, 0.7, 1.7, 3.7]);
    for (i, (t, wanted)) in [(0.5, 0.0), (0.7, 0.0), (1.7, 0.5), (3.7, 4.5)].into_iter().enumerate() {
        assert!((found[2 * i + 1] - wanted).abs() < 1e-8, "{t}: {} {wanted}", found[2 * i + 1]);
    }
}

#[test]
fn two_blocks_stick_to_each_other_and_to_the_table() {
    // A block on a block on a table: three phases, of which the last holds both surfaces.
    let text = "states.v_m_s = {}\nstates.w_m_s = {}\nstart.v_m_s.value = 2\nstart.w_m_s.value = 0\n\
                derivatives.v_m_s = \"-a*sign(v_m_s - w_m_s)\"\n\
                derivatives.w_m_s = \"a*sign(v_m_s - w_m_s) - table*sign(w_m_s)\"\n";
    let system = system(text, &["table", "a"]);
    let start = vec![2.0, 0.0];
    let found =
        run(&system, &Given { parameters: vec![0.6, 1.0], start: start.clone(), ..Given::default() }, &clock(9, 0.5));
    // Apart: v' = -1, w' = 0.4 until both are 4/7 m/s after 10/7 s; together -0.3 until they rest after another 40/21 s.
    for (i, row) in found.chunks(2).enumerate() {
        let t = 0.5 * i as f64;
        let together = (4.0 / 7.0 - 0.3 * (t - 10.0 / 7.0)).max(0.0);
        let wanted = if t < 10.0 / 7.0 { [2.0 - t, 0.4 * t] } else { [together; 2] };
        assert!(row.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{t}: {row:?} {wanted:?}");
    }
    let still = run(&system, &Given { parameters: vec![1.2, 1.0], start, ..Given::default() }, &[1.0, 3.0]);
    assert!(still.iter().zip([1.0, 0.0, 0.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{still:?}");
}

#[test]
fn an_absent_candidate_changes_no_bit_and_a_present_one_acts() {
    let plain = "states.q_rad = {}\nstates.w_rad_s = {}\nstart.q_rad.value = 1\nstart.w_rad_s.value = 0\n\
                 derivatives.q_rad = \"w_rad_s\"\nderivatives.w_rad_s = \"-k*q_rad\"\n";
    let rubs = format!(
        "{plain}[candidates.dry]\nsentence = \"it rubs\"\nacts = \"joint\"\nadds.w_rad_s = \"-c*sign(w_rad_s)\"\n\
         coefficients.c = {{ min = 0.0, max = 5.0, typical = 0.1, unit = \"1/s²\" }}\n"
    );
    let (without, with, times) = (system(plain, &["k"]), system(&rubs, &["k"]), clock(50, 0.1));
    let given =
        |c: Vec<f64>| Given { parameters: vec![9.0], coefficients: c, start: vec![1.0, 0.0], ..Given::default() };
    assert_eq!(run(&without, &given(vec![]), &times), run(&with, &given(vec![0.0]), &times));
    let found = run(&with, &given(vec![0.5]), &times);
    let slow = rk4(|_, [q, w]| [w, -9.0 * q - 0.5 * w.signum()], [1.0, -1e-9], &times, 1e-5);
    for (row, wanted) in found.chunks(2).zip(&slow) {
        assert!((row[0] - wanted[0]).abs() < 2e-5, "{row:?} {wanted:?}");
    }
}

#[test]
fn a_square_wave_of_the_time_gives_a_triangle() {
    let text = "states.v_m_s = {}\nstart.v_m_s.value = 0\nderivatives.v_m_s = \"a*sign(sin(w*t_s))\"\n";
    let system = system(text, &["a", "w"]);
    let times = clock(400, 0.02);
    for w in [1.0, 2.5, 3.0, 7.0, 20.0, 300.0] {
        let given = Given { parameters: vec![0.7, w], start: vec![0.0], ..Given::default() };
        let half = std::f64::consts::PI / w;
        for (t, found) in times.iter().zip(run(&system, &given, &times)) {
            let since = t % (2.0 * half);
            let wanted = 0.7 * since.min(2.0 * half - since);
            assert!((found - wanted).abs() < 1e-7, "{w} rad/s, {t} s: {found} {wanted}");
        }
    }
}
