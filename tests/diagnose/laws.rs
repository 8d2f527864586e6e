//! Laws of a ball that no catalogue holds: found, written, simulated and tuned with again, or refused.
//!
//! Every recording is integrated here, by the midpoint rule in small steps.

use std::fmt::Write as _;

use crate::common::{Folder, Noise};

const BALL: &str =
    "kind = \"ball\"\nball.radius_m = 0.02\nparameters.restitution = { value = 0.7, min = 0.0, max = 1.0 }\n";
const LINE: &str = "diagnose --sim ball.toml 0.csv 1.csv 2.csv --held-out 3.csv 4.csv --law --out improved.toml --json";

/// A throw of 1.5 s at 100 Hz under this acceleration, which bounces at a restitution of 0.8, with noise of 2 mm.
fn throw(number: u64, acceleration: impl Fn(f64, [f64; 3], [f64; 3]) -> [f64; 3]) -> String {
    let mut noise = Noise(number);
    let mut x: [f64; 3] = [noise.between(-0.2, 0.2), noise.between(-0.2, 0.2), noise.between(0.8, 1.5)];
    let mut v: [f64; 3] = [noise.between(1.0, 3.0), noise.between(-2.0, 2.0), noise.between(0.0, 3.0)];
    let mut text = String::from("t_s,x_m,y_m,z_m\n");
    let h = 2e-5;
    for i in 0..150 {
        let seen = x.map(|x| x + 0.002 * noise.normal());
        writeln!(text, "{},{:.6},{:.6},{:.6}", f64::from(i) * 0.01, seen[0], seen[1], seen[2]).unwrap();
        for k in 0..500 {
            let t = f64::from(i) * 0.01 + f64::from(k) * h;
            let a = acceleration(t, x, v);
            let at: [f64; 3] = std::array::from_fn(|k| x[k] + 0.5 * h * v[k]);
            let middle: [f64; 3] = std::array::from_fn(|k| v[k] + 0.5 * h * a[k]);
            let a = acceleration(t + 0.5 * h, at, middle);
            (0..3).for_each(|k| x[k] += h * (v[k] + 0.5 * h * a[k]));
            (0..3).for_each(|k| v[k] += h * a[k]);
            if x[2] < 0.02 && v[2] < 0.0 {
                v[2] *= -0.8;
                x[2] = 0.02 + 0.8 * (0.02 - x[2]);
            }
        }
    }
    text
}

fn recorded(acceleration: impl Fn(usize, f64, [f64; 3], [f64; 3]) -> [f64; 3]) -> Folder {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    for i in 0..5 {
        folder.write(&format!("{i}.csv"), throw(i as u64 + 1, |t, x, v| acceleration(i, t, x, v)));
    }
    folder
}

/// Drag with the third power of the speed.
fn cubic_drag() -> Folder {
    recorded(|_, _, _, v| {
        let square: f64 = v.iter().map(|v| v * v).sum();
        [-0.006 * square * v[0], -0.006 * square * v[1], -0.006 * square * v[2] - 9.81]
    })
}

#[test]
fn drag_with_another_exponent_is_a_law_and_its_file_simulates_and_tunes() {
    let folder = cubic_drag();
    let output = folder.run(&format!("{LINE} --out-ranges ranges.json"));
    let json = output.json();
    let members = json["law"]["members"].as_array().unwrap_or_else(|| panic!("{json:#}"));
    assert!(["law", "one_of"].contains(&json["verdict"].as_str().unwrap()), "{json:#}");
    let power = |member: &serde_json::Value| {
        let term = &member["terms"][0];
        let factor = &term["factors"][0];
        let interval = &factor["constants"][0]["interval95"];
        term["directions"] == serde_json::json!(["v"])
            && factor["kind"] == "power"
            && interval[0].as_f64().unwrap() <= 3.0
            && interval[1].as_f64().unwrap() >= 3.0
    };
    assert!(members.iter().any(power), "{json:#}");
    assert!(json["law"]["rollouts"].as_u64().unwrap() <= 10_000, "{json:#}");
    // What stands next to the verdict is the law's, and what the catalogue says without it has its own place.
    assert_eq!((json["effects"].as_array().map(Vec::len), json["next_experiment"].is_null()), (Some(0), true));
    assert!(json["law"]["catalogue"]["gap"]["after"].as_f64() > json["gap"]["after"].as_f64(), "{json:#}");
    let floor = json["gap"]["noise_floor"].as_f64().unwrap();
    assert!(json["gap"]["after"].as_f64().unwrap() < 1.1 * floor, "{json:#}");
    let ranges: serde_json::Value = serde_json::from_str(&folder.text("ranges.json")).unwrap();
    let all: Vec<&str> = ranges["ranges"].as_array().unwrap().iter().filter_map(|r| r["name"].as_str()).collect();
    assert!(ranges["verdict"] == json["verdict"] && all.contains(&"effects.law.a"), "{ranges:#}");
    let improved = folder.text("improved.toml");
    assert!(improved.contains("[candidates.law]") && improved.contains("[effects.law]"), "{improved}");
    let line =
        "simulate --sim improved.toml --set release.position_m=[0,0,1] --set release.velocity_m_s=[2,0,1] --out s.csv";
    folder.run(line).ends(0);
    let tuned = folder.run("tune --sim improved.toml --set effects.law.tune=true 0.csv 1.csv 2.csv --json").json();
    assert!(["tuned", "not_identifiable"].contains(&tuned["verdict"].as_str().unwrap()), "{tuned:#}");
}

#[test]
fn nothing_is_found_where_nothing_is_missing() {
    let folder = recorded(|_, _, _, _| [0.0, 0.0, -9.81]);
    let json = folder.run(LINE).ends(0).json();
    assert_eq!((json["verdict"].as_str(), json["law"]["verdict"].as_str()), (Some("none"), Some("none")), "{json:#}");
}

/// A spin that nobody measured and that decays from another value in each recording.
#[test]
fn hidden_state_is_never_a_law_alone() {
    let folder = recorded(|i, t, _, v| {
        let s = [0.25, -0.4, 0.5, -0.2, 0.35][i] * (-t / 0.8).exp();
        [-s * v[1], s * v[0], -9.81]
    });
    let json = folder.run(LINE).json();
    assert_ne!(json["verdict"], "law", "{json:#}");
    assert!(json["law"]["rollouts"].as_u64().unwrap() <= 11_000, "{json:#}");
}

#[test]
fn a_limit_on_rollouts_and_a_search_for_a_law_exclude_each_other() {
    let folder = cubic_drag();
    for other in ["--quick", "--max-rollouts 100"] {
        let line = format!("diagnose --sim ball.toml 0.csv 1.csv --law {other}");
        let said = folder.run(&line).ends(2).stderr;
        assert!(said.contains("--law"), "{said}");
    }
}

/// A jet of air in a band of heights, declared in the file: a fit of it from typical values ends in another minimum, and the law that
/// is found is this candidate.
#[test]
fn a_law_that_is_a_declared_jet_bears_its_name() {
    let jet = |x: [f64; 3]| 1.2 * (-((x[2] - 1.1) / 0.22).powi(2)).exp();
    let folder = recorded(|_, _, x, _| [jet(x), 0.0, -9.81]);
    let candidate = "[candidates.jet]\nsentence = \"a jet of air blows along x\"\nacts = \"flight\"\nalong = [\"x\"]\n\
                     formula = \"a * exp(-((z_m - h)/w)^2)\"\n\
                     coefficients.a = { unit = \"m/s²\", absent = 0.0, min = -5.0, max = 5.0 }\n\
                     coefficients.h = { unit = \"m\", min = 0.0, max = 3.0 }\n\
                     coefficients.w = { unit = \"m\", min = 0.02, max = 3.0 }\n";
    folder.write("ball.toml", format!("{BALL}{candidate}"));
    let json = folder.run(LINE).ends(0).json();
    assert_eq!(
        (json["verdict"].as_str(), json["effects"][0]["name"].as_str()),
        (Some("named"), Some("jet")),
        "{json:#}"
    );
    assert!(folder.text("improved.toml").contains("[effects.jet]"), "{json:#}");
}

/// A step of a flight looks through the surface, below which a broken power of the height has no value.
#[test]
fn a_broken_power_of_the_height_is_a_law() {
    let folder = recorded(|_, _, x, _| [0.0, 1.2 * x[2].max(0.0).powf(1.5), -9.81]);
    let json = folder.run(LINE).json();
    assert!(["law", "one_of"].contains(&json["verdict"].as_str().unwrap()), "{json:#}");
    let is = |member: &serde_json::Value| {
        let term = &member["terms"][0];
        let interval = &term["factors"][0]["constants"][0]["interval95"];
        term["directions"] == serde_json::json!(["y"])
            && term["factors"].as_array().unwrap().len() == 1
            && interval[0].as_f64().is_some_and(|low| low <= 1.5)
            && interval[1].as_f64().is_some_and(|high| high >= 1.5)
    };
    assert!(json["law"]["members"].as_array().unwrap().iter().any(is), "{json:#}");
    let simulated = "simulate --sim improved.toml --set release.position_m=[0,0,1] --out again.csv";
    folder.run(simulated).ends(0);
}
