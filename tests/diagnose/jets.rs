//! A push of a tenth of a second that moves every drop alike: the draws of `bounce_scatter` follow it, and it is no scatter.

use crate::common::{Drop, Folder, Noise};
use serde_json::Value;

const NOISE_M: f64 = 0.002;
const GRAVITY_M_S2: f64 = 9.81;
const RADIUS_M: f64 = 0.02;
const RESTITUTION: f64 = 0.8;
/// When the push begins, how long it lasts, and its acceleration.
const BEGINS_S: f64 = 0.5;
const LASTS_S: f64 = 0.1;
const PUSH_M_S2: f64 = 0.2;
/// Standard deviation of the tilt of the floor at each bounce.
const SCATTER_RAD: f64 = 0.01;

/// What is said of these paths (m), the last one held out, that are seen at 120 Hz.
fn answer(draw: &mut Noise, paths: &[Box<dyn Fn(f64) -> [f64; 3]>]) -> Value {
    let folder = Folder::new();
    folder.write("ball.toml", "kind = \"ball\"\nball.radius_m = 0.02\n");
    for (k, path) in paths.iter().enumerate() {
        let rows = (0..216).map(|i| {
            let t = f64::from(i) / 120.0;
            let [x, y, z] = path(t).map(|exact| exact + NOISE_M * draw.normal());
            format!("{t:.6},{x:.6},{y:.6},{z:.6}\n")
        });
        let text = "t_s,x_m,y_m,z_m\n".to_owned() + &rows.collect::<String>();
        folder.write(&format!("{k}.csv"), text);
    }
    folder.run("diagnose 0.csv 1.csv 2.csv --held-out 3.csv --sim ball.toml --json").json()
}

/// Of a drop that slides along the floor without friction and is pushed that way.
fn pushed(draw: &mut Noise, turn_rad: f64) -> Box<dyn Fn(f64) -> [f64; 3]> {
    let drop = Drop { height_m: draw.between(0.7, 1.3), restitution: RESTITUTION, ..Drop::default() };
    let steady_m_s = [draw.between(-0.5, 0.5), draw.between(-0.5, 0.5)];
    let (sin, cos) = turn_rad.sin_cos();
    Box::new(move |t| {
        let (acts_s, since_s) = ((t - BEGINS_S).clamp(0.0, LASTS_S), (t - BEGINS_S - LASTS_S).max(0.0));
        let moved_m = PUSH_M_S2 * acts_s * (0.5 * acts_s + since_s);
        [steady_m_s[0] * t + moved_m * cos, steady_m_s[1] * t + moved_m * sin, drop.height_at(t)]
    })
}

/// Of a drop each of whose bounces meets a normal of its own: v' = v − (1 + e)(v·n) n.
fn scattered(draw: &mut Noise) -> Box<dyn Fn(f64) -> [f64; 3]> {
    let mut at = [0.0, 0.0, draw.between(0.7, 1.3) + RADIUS_M];
    let mut v = [draw.between(-0.5, 0.5), draw.between(-0.5, 0.5), 0.0];
    let mut begins_s = 0.0;
    let mut flights = Vec::new();
    for _ in 0..12 {
        flights.push((begins_s, at, v));
        let lasts_s = (v[2] + (v[2] * v[2] + 2.0 * GRAVITY_M_S2 * (at[2] - RADIUS_M)).sqrt()) / GRAVITY_M_S2;
        at = [at[0] + v[0] * lasts_s, at[1] + v[1] * lasts_s, RADIUS_M];
        v[2] -= GRAVITY_M_S2 * lasts_s;
        begins_s += lasts_s;
        let tilted = [SCATTER_RAD * draw.normal(), SCATTER_RAD * draw.normal(), 1.0];
        let square: f64 = tilted.iter().map(|n| n * n).sum();
        let along: f64 = v.iter().zip(tilted).map(|(v, n)| v * n).sum();
        v.iter_mut().zip(tilted).for_each(|(v, n)| *v -= (1.0 + RESTITUTION) * along * n / square);
    }
    Box::new(move |t| {
        let (begins_s, at, v) = flights.iter().rev().find(|(begins_s, ..)| *begins_s <= t).unwrap();
        let since_s = t - begins_s;
        let fall_m = 0.5 * GRAVITY_M_S2 * since_s * since_s;
        [at[0] + v[0] * since_s, at[1] + v[1] * since_s, at[2] + v[2] * since_s - fall_m]
    })
}

#[test]
fn a_short_push_is_not_named_scatter_of_bounces() {
    for seed in 1..=6 {
        let mut draw = Noise(seed);
        let turn_rad = draw.between(0.0, std::f64::consts::TAU);
        let paths: Vec<_> = (0..4).map(|_| pushed(&mut draw, turn_rad)).collect();
        let json = answer(&mut draw, &paths);
        assert!(json["verdict"] == "one_of" || json["verdict"] == "unknown", "{seed}: {}", json["verdict"]);
    }
}

#[test]
fn scatter_of_bounces_keeps_its_name() {
    let mut named = 0;
    for seed in 11..=14 {
        let mut draw = Noise(seed);
        let paths: Vec<_> = (0..4).map(|_| scattered(&mut draw)).collect();
        let json = answer(&mut draw, &paths);
        let names: Vec<&str> =
            json["effects"].as_array().into_iter().flatten().filter_map(|e| e["name"].as_str()).collect();
        assert_eq!(names, ["bounce_scatter"], "{seed}: {}", json["verdict"]);
        named += usize::from(json["verdict"] == "named");
    }
    assert!(named >= 2, "{named} of 4");
}
