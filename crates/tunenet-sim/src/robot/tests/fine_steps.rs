//! Against an integrator of its own: explicit Euler steps of 5 µs with a sign, and the formulas written anew.

use super::*;

/// What the reference simulates.
#[derive(Clone, Copy)]
struct Truth {
    mass: f64,
    length: f64,
    kp: f64,
    speed_limit: f64,
    delay: f64,
    lag: f64,
    mu: f64,
    kd: f64,
    stribeck: f64,
    quadratic: f64,
    dead_band: f64,
    offset: f64,
}

/// Positions every 10 ms for 6 s, off after `off_s`.
fn reference(truth: Truth, goal: &dyn Fn(f64) -> f64, off_s: f64) -> Vec<f64> {
    let Truth { mass, length, kp, speed_limit, delay, lag, mu, kd, stribeck, quadratic, dead_band, offset } = truth;
    let dt = 5e-6;
    let inertia = 0.022 + mass * length * length + 1e-9;
    let (mut q, mut w, mut own) = (0.0_f64, 0.0_f64, goal(-delay));
    let mut late = own;
    let mut found = vec![q];
    for k in 0..1_200_000_u32 {
        let t = f64::from(k) * dt;
        let wanted = goal(t - delay);
        own = if speed_limit > 0.0 { own + (wanted - own).clamp(-speed_limit * dt, speed_limit * dt) } else { wanted };
        late = if lag > 0.0 { late + dt / lag * (own - late) } else { own };
        let error = late + offset - q;
        let error = error - error.clamp(-dead_band, dead_band);
        let duty = (0.166 * kp * error - kd * w).clamp(-1.0, 1.0);
        let motor = if t < off_s { 6.0 * duty - 1.2 * w } else { 0.0 };
        let weight = -mass * 9.81 * length * q.sin();
        let dry = 0.12 + mu * (weight - motor).abs() + stribeck * (-(w / 0.1_f64).powi(2)).exp();
        let free = motor + weight - 0.02 * w - quadratic * w * w.abs();
        let ahead = w + dt / inertia * free;
        let most = dt / inertia * dry;
        w = if ahead.abs() <= most { 0.0 } else { ahead - most * ahead.signum() };
        q += dt * w;
        if (k + 1).is_multiple_of(2000) {
            found.push(q);
        }
    }
    found
}

const NONE: Truth = Truth {
    mass: 0.6,
    length: 0.15,
    kp: 16.0,
    speed_limit: 0.0,
    delay: 0.0,
    lag: 0.0,
    mu: 0.0,
    kd: 0.0,
    stribeck: 0.0,
    quadratic: 0.0,
    dead_band: 0.0,
    offset: 0.0,
};

/// On the straight lines between the samples of the command.
fn sampled(goal: impl Fn(f64) -> f64) -> impl Fn(f64) -> f64 {
    move |t: f64| {
        let place = (100.0 * t).clamp(0.0, 600.0);
        let at = |i: f64| goal(i / 100.0);
        at(place.floor()) + (place - place.floor()) * (at(place.ceil()) - at(place.floor()))
    }
}

#[test]
fn one_millisecond_is_within_half_a_milliradian_of_five_microseconds() {
    let all = Truth {
        speed_limit: 4.8,
        delay: 0.033,
        lag: 0.02,
        mu: 0.19,
        kd: 0.05,
        stribeck: 0.05,
        quadratic: 0.01,
        dead_band: 0.005,
        offset: 0.03,
        ..NONE
    };
    let three = Truth { speed_limit: 4.8, delay: 0.033, mu: 0.19, ..NONE };
    let step = |t: f64| if (1.5..4.0).contains(&t) { 1.57 } else { 0.0 };
    let swing = |t: f64| 0.8 * (t * t).sin();
    let mut squares = Vec::new();
    for truth in [NONE, three, all, Truth { kp: 32.0, ..three }, Truth { mass: 1.2, kp: 8.0, ..all }] {
        for (number, goal) in [&step as &dyn Fn(f64) -> f64, &swing].into_iter().enumerate() {
            let joint = JointNumbers { kp: truth.kp, kd: truth.kd, ..servo() };
            let names =
                ["speed_limit", "command_delay", "load_friction", "quadratic_friction", "dead_band", "command_offset"];
            let names = [&names[..], &["command_lag", "stribeck_friction"]].concat();
            let slow = if truth.speed_limit > 0.0 { truth.speed_limit.recip() } else { 0.0 };
            let Truth { delay, mu, quadratic, dead_band, offset, lag, stribeck, .. } = truth;
            let numbers = [slow, delay, mu, quadratic, dead_band, offset, lag, stribeck, 0.1];
            let robot = pendulum(truth.mass, truth.length, joint, &names, 0.001);
            let off = if number == 0 { 99.0 } else { 4.003_7 };
            let found = rolled(&robot, vec![command(goal), on_until(off)], &[0.0; 2], &numbers, &clock(6.0));
            let error = root_mean_square(&found, &reference(truth, &sampled(goal), off));
            assert!(error < 1.5e-3, "{number}: {error}");
            squares.push(error * error);
        }
    }
    let whole = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(whole < 5e-4, "{whole}");
}

/// Positions of the link every 10 ms for 6 s of a motor behind a gear with this compliance.
fn behind_a_gear(compliance: f64, kp: f64, goal: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let dt = 5e-6;
    let (mass, length) = (1.0, 0.15);
    let inertia = mass * length * length + 1e-9;
    let (mut q, mut w, mut shaft, mut turning) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let mut found = vec![q];
    for k in 0..1_200_000_u32 {
        let duty = (0.166 * kp * (goal(f64::from(k) * dt) - q)).clamp(-1.0, 1.0);
        let gear = (shaft - q) / compliance;
        let free = 6.0 * duty - 1.2 * turning - gear - 0.02 * turning;
        let ahead = turning + dt / 0.022 * free;
        let most = dt / 0.022 * 0.12;
        turning = if ahead.abs() <= most { 0.0 } else { ahead - most * ahead.signum() };
        w += dt / inertia * (gear - mass * 9.81 * length * q.sin());
        q += dt * w;
        shaft += dt * turning;
        if (k + 1).is_multiple_of(2000) {
            found.push(q);
        }
    }
    found
}

/// A gear that gives way swings for the whole of a record: a rule of the first order would damp it within one.
#[test]
fn a_gear_swings_as_with_steps_of_five_microseconds() {
    for (compliance, kp) in [(0.01, 24.0), (0.03, 12.0), (0.05, 8.0)] {
        let step = |t: f64| if t < 1.0 { 0.0 } else { 1.2 };
        let robot = pendulum(1.0, 0.15, JointNumbers { kp, ..servo() }, &["joint_elasticity"], 0.001);
        let found = rolled(&robot, vec![command(step), on_until(99.0)], &[0.0; 2], &[compliance], &clock(6.0));
        let error = root_mean_square(&found, &behind_a_gear(compliance, kp, &sampled(step)));
        assert!(error < 1.5e-3, "{compliance}: {error}");
    }
}
