//! A motor whose speed is recorded, driven in steps: dry friction is a law, an input that acts through a lag is no late reading for certain,
//! and autocorrelated noise is no law.

use std::fmt::Write as _;

use crate::common::{Folder, Noise};

const FILE: &str = "kind = \"equations\"\n[states.w_rad_s]\n[derivatives]\nw_rad_s = \"gain*u_v - b*w_rad_s\"\n\
[outputs]\nw_rad_s = \"w_rad_s\"\n[inputs.u_v]\nhold = \"previous\"\n[start.w_rad_s]\nvalue = \"first\"\nsd = 0.3\n\
[parameters.gain]\nvalue = 2.0\nmin = 0.1\nmax = 50.0\nunit = \"rad/s^2/V\"\n\
[parameters.b]\nvalue = 0.5\nmin = 0.0\nmax = 20.0\nunit = \"1/s\"\n";

/// What the file lacks.
#[derive(Debug, Clone, Copy, Default)]
struct Hidden {
    /// Dry friction, rad/s².
    friction: f64,
    /// The time constant of a lag between input and motor, s.
    lag_s: f64,
    /// The correlation of neighbouring samples of the noise.
    correlation: f64,
}

/// 4 s at 50 Hz, the input another one each 0.4 s, by the midpoint rule in short steps that end where friction holds; noise of 0.02 rad/s.
fn run(number: u64, hidden: Hidden) -> String {
    const STEP_S: f64 = 1e-5;
    let mut noise = Noise(number);
    let (mut u, mut acting, mut w, mut last) = (0.0, 0.0, noise.between(-2.0, 2.0), noise.normal());
    let mut text = String::from("t_s,u_v,w_rad_s\n");
    for i in 0..200 {
        if i % 20 == 0 {
            u = noise.between(-1.5, 1.5);
        }
        let fresh = (1.0 - hidden.correlation.powi(2)).sqrt() * noise.normal();
        last = hidden.correlation * last + fresh;
        writeln!(text, "{:.2},{u},{:.6}", f64::from(i) * 0.02, w + 0.02 * last).unwrap();
        for _ in 0..2000 {
            acting = if hidden.lag_s > 0.0 { acting + STEP_S / hidden.lag_s * (u - acting) } else { u };
            // Backward in the friction: what would turn the motion stops it.
            let free = w + STEP_S * (6.0 * acting - 1.2 * w);
            let most = STEP_S * hidden.friction;
            w = if free.abs() <= most { 0.0 } else { free - most * free.signum() };
        }
    }
    text
}

fn diagnosed(hidden: Hidden, seed: u64, options: &str) -> serde_json::Value {
    let folder = Folder::new();
    folder.write("motor.toml", FILE);
    for number in 0..5 {
        folder.write(&format!("{number}.csv"), run(seed + number, hidden));
    }
    let files = "0.csv 1.csv 2.csv --held-out 3.csv 4.csv";
    folder.run(&format!("diagnose --sim motor.toml {files} --json {options}")).json()
}

#[test]
fn dry_friction_of_a_recorded_speed_is_a_law() {
    for seed in [1, 11, 21] {
        let json = diagnosed(Hidden { friction: 1.5, ..Hidden::default() }, seed, "--law");
        let sign = |member: &serde_json::Value| member["terms"][0]["factors"][0]["kind"] == "sign";
        let members = json["law"]["members"].as_array().unwrap();
        assert!(members.iter().any(sign), "{json:#}");
        let size = members.iter().find(|member| sign(member)).unwrap()["terms"][0]["coefficients"][0]["value"].as_f64();
        assert!((size.unwrap() + 1.5).abs() < 0.05, "{size:?}");
    }
}

#[test]
fn an_input_through_a_lag_is_not_a_late_reading_for_certain() {
    let json = diagnosed(Hidden { lag_s: 0.1, ..Hidden::default() }, 31, "");
    assert_ne!(json["verdict"], "named", "{json:#}");
}

#[test]
fn autocorrelated_noise_is_no_law() {
    for seed in [41, 51, 61] {
        let json = diagnosed(Hidden { correlation: 0.6, ..Hidden::default() }, seed, "--law");
        assert!(["none", "unknown"].contains(&json["law"]["verdict"].as_str().unwrap()), "{json:#}");
        assert!(["none", "unknown"].contains(&json["verdict"].as_str().unwrap()), "{json:#}");
    }
}
