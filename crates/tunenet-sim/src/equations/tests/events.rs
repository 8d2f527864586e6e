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

#[test]
fn a_ceiling_near_the_top_of_a_throw_is_met() {
    // Without drag the motion is a polynomial, and a step lasts as long as the throw.
    let text = BALL.replace("events.bounce", "events.ceiling").replace("z_m - radius_m", "ceiling - z_m");
    let system = system(&text, &["restitution", "ceiling"]);
    let g = 9.81_f64;
    let speed = (2.0 * g).sqrt();
    let times = clock(60, 0.01);
    for ceiling in [0.5, 0.9, 0.99, 0.9999] {
        let given = Given { parameters: vec![0.6, ceiling], start: vec![0.0, speed], ..Given::default() };
        let met = (speed - (speed * speed - 2.0 * g * ceiling).sqrt()) / g;
        let after = -0.6 * (speed - g * met);
        for (t, row) in times.iter().zip(run(&system, &given, &times).chunks(2)) {
            let since = t - met;
            let wanted = if since < 0.0 { speed - g * t } else { after - g * since };
            assert!((row[1] - wanted).abs() < 1e-7, "ceiling {ceiling} m, {t} s: {} {wanted}", row[1]);
        }
    }
}

#[test]
fn periodic_impulses_of_a_free_body_are_counted() {
    let text = "states.v_m_s = {}\nstart.v_m_s.value = 0\nderivatives.v_m_s = \"0\"\n\
                events.push.when = \"sin(w*t_s)\"\nevents.push.then.v_m_s = \"v_m_s + 1\"\n";
    let system = system(text, &["w"]);
    let times: Vec<f64> = (0..400).map(|i| 0.003 + 0.02 * f64::from(i)).collect();
    for w in [1.0, 2.0, 3.0, 10.0, 50.0, 300.0] {
        let given = Given { parameters: vec![w], start: vec![0.0], ..Given::default() };
        for (t, found) in times.iter().zip(run(&system, &given, &times)) {
            // It falls through zero at odd multiples of half a period.
            let wanted = (0.5 * w * t / std::f64::consts::PI + 0.5).floor();
            assert!((found - wanted).abs() < 1e-9, "{w} rad/s, {t} s: {found} {wanted}");
        }
    }
}

#[test]
fn a_thin_wall_is_met() {
    let text = "states.x_m = {}\nstates.v_m_s = {}\nstart.x_m.value = 0\nstart.v_m_s.value = 1.3\n\
                derivatives.x_m = \"v_m_s\"\nderivatives.v_m_s = \"0\"\n\
                events.enter.when = \"abs(x_m - 1) - half\"\nevents.enter.then.v_m_s = \"0.5*v_m_s\"\n";
    let system = system(text, &["half"]);
    for half in [0.1, 0.02, 0.005, 0.001] {
        let given = Given { parameters: vec![half], start: vec![0.0, 1.3], ..Given::default() };
        let found = run(&system, &given, &[0.5, 3.0]);
        let enters_s = (1.0 - half) / 1.3;
        let wanted = [0.65, 1.3, 1.0 - half + 0.65 * (3.0 - enters_s), 0.65];
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{half} m: {found:?} {wanted:?}");
    }
}
