//! A drop that is recorded down to its last small hops, in air: what bends slowly may not pass for noise that remembers.

use std::fmt::Write as _;

use crate::common::{Folder, Noise, SCENE};

/// That of the scene.
const RADIUS_M: f64 = 0.02;
const RESTITUTION: f64 = 0.72;
const DRAG_1_M: f64 = 0.08;

/// Heights of the centre every 10 ms for 3 s, in steps of 10 µs, with 2 mm of white noise.
fn drop_in_air(fall_m: f64, seed: u64) -> String {
    let (mut z, mut v, mut random) = (RADIUS_M + fall_m, 0.0_f64, Noise(seed));
    let mut text = String::from("t_s,z_m\n");
    let step_s = 1e-5;
    for i in 0..300_000_u32 {
        if i.is_multiple_of(1000) {
            writeln!(text, "{},{}", f64::from(i) * step_s, z + 0.002 * random.normal()).unwrap();
        }
        let a = -9.81 - DRAG_1_M * v.abs() * v;
        z += step_s * (v + 0.5 * step_s * a);
        v += step_s * a;
        if z < RADIUS_M && v < 0.0 {
            v *= -RESTITUTION;
            z = RADIUS_M;
        }
    }
    text
}

#[test]
fn air_is_found_however_long_the_record_goes_on() {
    let folder = Folder::new();
    folder.write("ball.toml", SCENE);
    for seed in 1..=4 {
        folder.write("drop.csv", drop_in_air(1.2, seed));
        let answer = folder.run("diagnose --sim ball.toml --observation drop.csv --json").json();
        assert_eq!(answer["verdict"], "one_of", "a single throw does not identify one effect; seed {seed}");
        let effect = &answer["effects"][0];
        assert_eq!(effect["name"], "quadratic_drag", "seed {seed}");
        let restitution = &answer["parameters"][0]["interval95"];
        let (low, high) = (restitution[0].as_f64().unwrap(), restitution[1].as_f64().unwrap());
        assert!(low < RESTITUTION + 0.001 && RESTITUTION - 0.001 < high, "seed {seed}: {low} to {high}");
    }
}
