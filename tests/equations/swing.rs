//! A pendulum: from the file that `init` writes to its missing effect.

use std::fmt::Write as _;

use crate::common::{Folder, Noise, codes};

#[test]
fn the_file_that_init_writes_simulates_tunes_and_generates() {
    let folder = Folder::new();
    folder.run("init equations").ends(0);
    folder.run("simulate --sim equations.toml --set parameters.length.value=0.62 --out swing.csv").ends(0);
    let json =
        folder.run("tune --sim equations.toml swing.csv --out tuned.toml --report swing.html --json").ends(0).json();
    let length = json["parameters"]["length"]["value"].as_f64().unwrap();
    assert!((length - 0.62).abs() < 1e-6 && json["rollouts"].as_u64().unwrap() < 100, "{json:#}");
    let tuned = folder.text("tuned.toml");
    assert!(
        tuned.contains("rate_rad_s = \"-gravity/length*sin(angle_rad)") && tuned.contains("[provenance]"),
        "{tuned}"
    );
    let json = folder.run("inspect equations.toml --json").ends(0).json();
    assert_eq!(json["channels"], serde_json::json!(["angle_rad"]));
    assert_eq!(json["candidates"], serde_json::json!(["dry_friction"]));
    folder.run("gen equations --sim equations.toml --pairs 20 --out swings.mcap").ends(0);
    folder.run("train --data swings.mcap --out swings.safetensors --preset paper").ends(0);
    let begun = folder.run("tune --sim equations.toml swing.csv --model swings.safetensors --json").json();
    assert_eq!(begun["model"]["source"], "given");
}

/// A recording of a driven pendulum with dry friction, by the classical Runge–Kutta method in short steps.
fn recorded(gravity: f64, start_rad: f64, seed: u64) -> String {
    const RATE_HZ: f64 = 72.0;
    const STEPS: u32 = 400;
    let (length, damping, friction) = (0.62, 0.24, 0.35);
    let voltage = |i: usize| {
        let (t, s) = (i as f64 / RATE_HZ, seed as f64);
        4.0 * ((3.0 + s) * t).sin() + 3.0 * ((5.0 + 0.7 * s) * t + 1.0).sin()
    };
    let mut noise = Noise(seed);
    let (mut text, mut state) = (String::from("t_s,angle_rad,u_v\n"), [start_rad, 0.0]);
    for i in 0..216 {
        let u = voltage(i);
        writeln!(text, "{},{},{u}", i as f64 / RATE_HZ, state[0] + 2e-3 * noise.normal()).unwrap();
        let slope =
            |[q, w]: [f64; 2]| [w, -gravity / length * f64::sin(q) - damping * w + u - friction * f64::tanh(w / 1e-4)];
        let h = 1.0 / RATE_HZ / f64::from(STEPS);
        let moved = |s: [f64; 2], k: [f64; 2], by: f64| [s[0] + by * k[0], s[1] + by * k[1]];
        for _ in 0..STEPS {
            let a = slope(state);
            let b = slope(moved(state, a, h / 2.0));
            let c = slope(moved(state, b, h / 2.0));
            let d = slope(moved(state, c, h));
            for j in 0..2 {
                state[j] += h / 6.0 * (a[j] + 2.0 * b[j] + 2.0 * c[j] + d[j]);
            }
        }
    }
    text
}

#[test]
fn a_missing_effect_is_named_validated_and_written() {
    let folder = Folder::new();
    folder.run("init equations").ends(0);
    let mut manifest = String::new();
    // The last ones were recorded on the moon: a constant of their setup.
    for (seed, start, gravity) in [(1, 0.5, 9.81), (2, -0.4, 9.81), (3, 0.2, 1.62), (4, 0.8, 1.62)] {
        folder.write(&format!("rec{seed}.csv"), recorded(gravity, start, seed));
        writeln!(manifest, "[[observation]]\nfile = \"rec{seed}.csv\"\nstart.angle_rad = {start}").unwrap();
        writeln!(manifest, "constants.gravity = {gravity}\nheld_out = {}\n", seed == 4).unwrap();
    }
    folder.write("runs.toml", manifest);
    let poor = folder.run("tune --sim equations.toml --manifest runs.toml --json").ends(3).json();
    assert_eq!(poor["verdict"], "poor_fit");
    // A few brief fits and the curvature say as much of a poor fit as a full search.
    assert!(codes(&poor).contains(&"intervals.curvature"), "{poor:#}");
    assert!(poor["rollouts"].as_u64().unwrap() < 1000, "{poor:#}");
    let line = "diagnose --sim equations.toml --manifest runs.toml --out improved.toml --json";
    let json = folder.run(line).ends(0).json();
    assert_eq!((json["verdict"].as_str(), json["effects"][0]["name"].as_str()), (Some("named"), Some("dry_friction")));
    let found = json["effects"][0]["coefficients"]["c"]["value"].as_f64().unwrap();
    assert!((found - 0.35).abs() < 0.02, "{found}");
    let improved = folder.text("improved.toml");
    for wanted in ["[effects.dry_friction]\nc = 0.3", "adds.rate_rad_s", "[provenance"] {
        assert!(improved.contains(wanted), "no {wanted} in:\n{improved}");
    }
    let tuned = folder.run("tune --sim improved.toml --manifest runs.toml --json").ends(0).json();
    let length = tuned["parameters"]["length"]["value"].as_f64().unwrap();
    assert!(tuned["verdict"] == "tuned" && (length - 0.62).abs() < 2e-3, "{tuned:#}");
    folder.run("simulate --sim improved.toml --manifest runs.toml --out all").ends(0);
    assert!(folder.text("all/rec4.csv").lines().count() == 217);
}

#[test]
fn values_that_no_rollout_can_follow_are_refused_in_a_sentence() {
    let folder = Folder::new();
    folder.run("init equations").ends(0);
    let text = folder.text("equations.toml").replace("- damping*rate_rad_s", "+ damping*1000*rate_rad_s");
    folder.write("equations.toml", text);
    let ran = folder.run("simulate --sim equations.toml --out swing.csv").ends(1);
    assert!(
        ran.stderr.contains("the equations refused the file's own values") && ran.stderr.contains("_rad"),
        "{}",
        ran.stderr
    );
    folder.run("init equations --overwrite").ends(0);
    folder.run("simulate --sim equations.toml --out swing.csv").ends(0);
    let json = folder.run("tune --sim equations.toml swing.csv --json").ends(0).json();
    assert!(!codes(&json).iter().any(|code| code.contains("refused")), "{json:#}");
}

/// Two channels of different units: the gap is in standard deviations of their noise, so that it does not depend on the units.
#[test]
fn a_gap_over_several_units_is_in_noise() {
    let tuned = |scale: f64| {
        let folder = Folder::new();
        folder.write(
            "fall.toml",
            format!(
                "kind = \"equations\"\n[states]\n[states.v_m_s]\n[start.v_m_s]\nvalue = 0.0\n[derivatives]\nv_m_s = \"a\"\n\
                 [outputs]\nv_m_s = \"v_m_s\"\nspeed_v = \"k * v_m_s\"\n[constants]\nk = {scale}\n\
                 [parameters.a]\nvalue = 2.0\nmin = 0.0\nmax = 9.0\nunit = \"m/s²\"\n"
            ),
        );
        let (mut noise, mut text) = (Noise(3), String::from("t_s,v_m_s,speed_v\n"));
        for i in 0..200 {
            let t = f64::from(i) * 0.01;
            let (v, volts) = (3.0 * t + 0.01 * noise.normal(), scale * (3.0 * t + 0.02 * noise.normal()));
            writeln!(text, "{t},{v},{volts}").unwrap();
        }
        folder.write("fall.csv", text);
        folder.run("tune --sim fall.toml fall.csv --json").ends(0).json()["gap"].clone()
    };
    let (gap, other) = (tuned(100.0), tuned(0.01));
    let of = |gap: &serde_json::Value, key: &str| gap[key].as_f64().unwrap();
    assert_eq!((gap["unit"].as_str(), of(&gap, "noise_floor")), (Some("σ"), 1.0));
    assert!((of(&gap, "after") - 1.0).abs() < 0.15 && of(&gap, "before") > 20.0, "{gap}");
    assert!((of(&gap, "before") / of(&other, "before") - 1.0).abs() < 1e-3, "{gap} {other}");
}

/// One recording of three is in degrees under the name of radians: the poor fit says which.
#[test]
fn a_recording_in_another_unit_is_named() {
    let folder = Folder::new();
    folder.write(
        "turn.toml",
        "kind = \"equations\"\n[states]\n[states.q_rad]\n[start.q_rad]\nvalue = 0.0\n[derivatives]\nq_rad = \"w * cos(w*t_s)\"\n\
         [outputs]\nq_rad = \"q_rad\"\n[parameters.w]\nvalue = 2.0\nmin = 0.1\nmax = 9.0\nunit = \"rad/s\"\n",
    );
    let mut noise = Noise(5);
    for (name, scale) in [("a.csv", 1.0), ("b.csv", 180.0 / std::f64::consts::PI), ("c.csv", 1.0)] {
        let mut text = String::from("t_s,q_rad\n");
        for i in 0..200 {
            let t = f64::from(i) * 0.02;
            writeln!(text, "{t},{}", scale * ((3.0 * t).sin() + 0.002 * noise.normal())).unwrap();
        }
        folder.write(name, text);
    }
    let json = folder.run("tune --sim turn.toml a.csv b.csv c.csv --json").ends(3).json();
    let said: Vec<&str> = json["warnings"].as_array().unwrap().iter().filter_map(|w| w["text"].as_str()).collect();
    assert!(said.iter().any(|text| text.starts_with("b.csv: `q_rad` varies 57 times as much as")), "{json:#}");
    let alike = folder.run("tune --sim turn.toml a.csv c.csv --json").ends(0).json();
    assert!(!codes(&alike).contains(&"units.differ"), "{alike:#}");
}
