//! Events: bounces against the geometric series, rest, and rest that ends.

use super::{Given, clock, run, system};

const BALL: &str = "states.z_m = {}
states.vz_m_s = {}
start.z_m.value = 1
start.vz_m_s.value = 0
derivatives.z_m = \"vz_m_s\"
derivatives.vz_m_s = \"-9.81\"
constants.radius_m = 0.02
events.bounce.when = \"z_m - radius_m\"
events.bounce.then.vz_m_s = \"-restitution*vz_m_s\"
";

/// Height of a ball that is let go at `height` above rest: parabolas between bounces, whose times are a geometric series.
fn bouncing(height: f64, e: f64, t: f64) -> f64 {
    let g = 9.81_f64;
    let (mut left, mut speed) = (t - (2.0 * height / g).sqrt(), e * (2.0 * g * height).sqrt());
    if left < 0.0 {
        return height - 0.5 * g * t * t;
    }
    for _ in 0..10_000 {
        let hop = 2.0 * speed / g;
        if left < hop {
            return speed * left - 0.5 * g * left * left;
        }
        left -= hop;
        speed *= e;
    }
    0.0
}

#[test]
fn bounces_follow_the_geometric_series_into_rest() {
    let system = system(BALL, &["restitution"]);
    let times = clock(1000, 0.01);
    for e in [0.0, 0.3, 0.7, 0.9] {
        let given = Given { parameters: vec![e], start: vec![1.02, 0.0], ..Given::default() };
        for (t, row) in times.iter().zip(run(&system, &given, &times).chunks(2)) {
            let wanted = 0.02 + bouncing(1.0, e, *t);
            assert!((row[0] - wanted).abs() < 1e-8, "e = {e}, {t} s: {} {wanted}", row[0]);
        }
    }
}

#[test]
fn a_ball_at_rest_stays_there_until_it_is_lifted() {
    let lifted = BALL.replace("\"-9.81\"", "\"-9.81 + a*t_s\"");
    let system = system(&lifted, &["restitution", "a"]);
    let given = Given { parameters: vec![0.5, 9.81], start: vec![0.02, 0.0], ..Given::default() };
    let found = run(&system, &given, &[0.5, 1.0, 2.0]);
    for (row, wanted) in found.chunks(2).zip([0.02, 0.02, 0.02 + 9.81 / 6.0]) {
        assert!((row[0] - wanted).abs() < 1e-9, "{row:?} {wanted}");
    }
}

#[test]
fn an_event_may_count_and_reset() {
    // A sawtooth: it falls by 1/s and is set to 1 whenever it is below 0.
    let text = "states.x_1 = {}\nstates.count_1 = {}\nstart.x_1.value = 1\nstart.count_1.value = 0\n\
                derivatives.x_1 = \"-rate\"\nderivatives.count_1 = \"0\"\n\
                events.reset.when = \"x_1\"\nevents.reset.then.x_1 = \"1\"\nevents.reset.then.count_1 = \"count_1 + 1\"\n";
    let system = system(text, &["rate"]);
    let found =
        run(&system, &Given { parameters: vec![1.0], start: vec![1.0, 0.0], ..Given::default() }, &[0.5, 1.25, 7.75]);
    let wanted = [0.5, 0.0, 0.75, 1.0, 0.25, 7.0];
    assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
}
