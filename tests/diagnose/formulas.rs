//! Effects that a user wrote as formulas: named, written, tuned with again; and what is wrong with them said in one sentence.
//!
//! Every recording is integrated here, by the midpoint rule in small steps.

use std::fmt::Write as _;

use crate::common::{Folder, Noise, codes, refused};

const BALL: &str =
    "kind = \"ball\"\nball.radius_m = 0.02\nparameters.restitution = { value = 0.7, min = 0.0, max = 1.0 }\n";
const THREAD: &str = "[candidates.thread]\nsentence = \"a thread pulls the ball back\"\nacts = \"flight\"\nalong = [\"x\"]\n\
                      formula = \"-k * x_m\"\ncoefficients.k = { unit = \"1/s²\", absent = 0.0, min = 0.0, max = 50.0 }\n";
const FAN: &str = "[candidates.fan]\nsentence = \"a fan blows within a band of heights\"\nacts = \"flight\"\nalong = [\"x\", \"y\"]\n\
                   formula = \"a * exp(-((z_m - h) / w)^2)\"\nper_direction = [\"a\"]\nvalid = { z_m = [0.0, 1.6] }\n\
                   coefficients.a = { unit = \"m/s²\", absent = 0.0, min = -5.0, max = 5.0 }\n\
                   coefficients.h = { unit = \"m\", min = 0.0, max = 3.0 }\ncoefficients.w = { unit = \"m\", min = 0.02, max = 3.0 }\n";

/// A throw of 1.2 s at 100 Hz under this acceleration, which bounces at a restitution of 0.8, with noise of 1 mm.
fn throw(number: u64, acceleration: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let mut noise = Noise(number);
    let mut x: [f64; 3] = [noise.between(-0.5, 0.5), noise.between(-0.5, 0.5), noise.between(1.0, 1.5)];
    let mut v: [f64; 3] = [noise.between(-1.0, 1.0), noise.between(-1.0, 1.0), noise.between(0.0, 2.0)];
    let mut text = String::from("t_s,x_m,y_m,z_m\n");
    let h = 1e-5;
    for i in 0..120 {
        let seen = x.map(|x| x + 0.001 * noise.normal());
        writeln!(text, "{},{:.6},{:.6},{:.6}", f64::from(i) * 0.01, seen[0], seen[1], seen[2]).unwrap();
        for _ in 0..1000 {
            let middle: [f64; 3] = std::array::from_fn(|k| x[k] + 0.5 * h * v[k]);
            let a = acceleration(middle);
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

fn recorded(acceleration: impl Fn([f64; 3]) -> [f64; 3]) -> Folder {
    let folder = Folder::new();
    folder.write("ball.toml", format!("{BALL}{THREAD}{FAN}"));
    for i in 0..5 {
        folder.write(&format!("{i}.csv"), throw(i + 1, &acceleration));
    }
    folder
}

const LINE: &str = "diagnose --sim ball.toml 0.csv 1.csv 2.csv 3.csv --held-out 4.csv --out improved.toml --json";

#[test]
fn a_formula_is_named_written_and_tuned_with_again() {
    let folder = recorded(|x| [-6.0 * x[0], 0.0, -9.81]);
    let json = folder.run(LINE).ends(0).json();
    assert_eq!((json["verdict"].as_str(), json["effects"][0]["name"].as_str()), (Some("named"), Some("thread")));
    let found = json["effects"][0]["coefficients"]["k"]["value"].as_f64().unwrap();
    assert!((found - 6.0).abs() < 0.05, "{found}");
    let improved = folder.text("improved.toml");
    assert!(improved.contains("[candidates.thread]") && improved.contains("\n[effects.thread]\nk = "), "{improved}");
    folder.run("diagnose --sim improved.toml 0.csv 1.csv 2.csv 3.csv --held-out 4.csv --json").ends(0);
    let line = "tune --sim improved.toml --set effects.thread.tune=true 0.csv 1.csv 2.csv --json";
    let tuned = folder.run(line).ends(0).json();
    let again = tuned["parameters"]["thread.k"]["value"].as_f64().unwrap();
    assert!((again - 6.0).abs() < 0.05 && tuned["verdict"] == "tuned", "{tuned:#}");
    let line = "simulate --sim improved.toml --set release.position_m=[0.5,0,1] --set release.velocity_m_s=[0,0,0] --out s.csv";
    folder.run(line).ends(0);
}

#[test]
fn several_directions_share_a_formula_and_its_range_is_known() {
    let folder = recorded(|x| {
        let blown = (-((x[2] - 1.0) / 0.3_f64).powi(2)).exp();
        [1.2 * blown, -0.6 * blown, -9.81]
    });
    let json = folder.run(LINE).ends(0).json();
    let names: Vec<&str> = json["effects"].as_array().unwrap().iter().map(|e| e["name"].as_str().unwrap()).collect();
    assert_eq!((json["verdict"].as_str(), names.as_slice()), (Some("named"), &["fan"][..]), "{json:#}");
    let improved = folder.text("improved.toml");
    let written = improved.split("[effects.fan]\na = [").nth(1).expect("a list").split(']').next().unwrap();
    let numbers: Vec<f64> = written.split(',').map(|number| number.trim().parse().unwrap()).collect();
    assert!((numbers[0] - 1.2).abs() < 0.05 && (numbers[1] + 0.6).abs() < 0.05, "{numbers:?}");
    let line = "simulate --sim improved.toml --set release.height_m=3 --set release.velocity_m_s=[1,0,0] --out s.csv";
    let said = folder.run(line).ends(0).stderr;
    assert!(said.contains("effect.outside") && said.contains("was seen to hold from 0 to 1.6"), "{said}");
}

#[test]
fn a_formula_of_the_time_is_bound_to_its_clock_and_a_free_power_is_explained() {
    let folder = recorded(|_| [0.0, 0.0, -9.81]);
    let wave = "[candidates.wave]\nsentence = \"something shakes\"\nacts = \"flight\"\nalong = [\"x\"]\nformula = \"a*sin(w*t_s)\"\n\
                coefficients.a = { unit = \"m/s²\", absent = 0, min = -9, max = 9 }\n\
                coefficients.w = { unit = \"1/s\", min = 1, max = 20 }\n[effects.wave]\na = 0.001\nw = 5\n";
    folder.write("wave.toml", format!("{BALL}{wave}"));
    let json = folder.run("tune --sim wave.toml 0.csv 1.csv --json").ends(0).json();
    assert!(codes(&json).contains(&"effect.clock"), "{json:#}");
    let drag = wave.replace("a*sin(w*t_s)", "-a*speed_m_s^w").replace("\"1/s\"", "\"1\"").replace("[\"x\"]", "[\"v\"]");
    folder.write("drag.toml", format!("{BALL}{}", drag.replace("w = 5", "w = 2")));
    let json = folder.run("tune --sim drag.toml 0.csv 1.csv --json").ends(0).json();
    let said = json["warnings"].as_array().unwrap().iter().find(|w| w["code"] == "effect.power").expect("a note");
    assert!(said["text"].as_str().unwrap().contains("`speed_m_s^w` in the formula of `wave`"), "{said}");
}

#[test]
fn what_is_wrong_with_a_formula_is_said_with_its_place() {
    let folder = Folder::new();
    for (from, to, wanted) in [
        (
            "-k * x_m",
            "-k * y",
            &["ball.toml:8:17", "`candidates.thread.formula`: expected one of x_m,", "found `y`"][..],
        ),
        ("-k * x_m", "-k * (x_m", &["ball.toml:8:21", "expected an operator or `)`, found the end"]),
        ("-k * x_m", "-k * vx_m_s", &["ball.toml:8:12", "expected a formula in m/s², found one in m/s³"]),
        ("formula = \"-k * x_m\"\n", "", &["expected `formula`", "found none"]),
        ("along = [\"x\"]", "along = [\"up\"]", &["`candidates.thread.along`", "found \"up\""]),
        ("coefficients.k", "coefficients.pi", &["no constant of mathematics", "found `pi`"]),
        (
            "[candidates.thread]",
            "[candidates.wind]",
            &["`candidates.wind`: expected a name that no built-in effect has"],
        ),
    ] {
        assert!(THREAD.contains(from), "{from}");
        let text = format!("{BALL}{}", THREAD.replace(from, to));
        folder.write("ball.toml", text);
        folder.write("0.csv", throw(1, |_| [0.0, 0.0, -9.81]));
        refused(&folder, "tune --sim ball.toml 0.csv", wanted);
    }
    let given = |effects: &str| folder.write("ball.toml", format!("{BALL}{FAN}{effects}"));
    given("[effects.fan]\na = 1.0\nh = 1.0\nw = 0.3\n");
    refused(
        &folder,
        "tune --sim ball.toml 0.csv",
        &["`effects.fan.a`", "[2 numbers], one for each direction or joint"],
    );
    given("[effects.fan]\na = [1.0, 7.0]\nh = 1.0\nw = 0.3\n");
    refused(&folder, "tune --sim ball.toml 0.csv", &["`effects.fan.a`: expected -5 to 5, found 7"]);
}

/// A formula that no recording can be simulated with is no candidate without influence: the answer says which part fails.
#[test]
fn a_candidate_that_cannot_be_simulated_is_excluded_with_its_reason() {
    let folder = recorded(|x| [-3.0 * x[0], 0.0, -9.81]);
    for (formula, wanted) in [
        ("k / (z_m - z_m)", "grows beyond all bounds"),
        ("k * 1e300", "accelerates the ball"),
        ("k * sqrt(-1 - x_m^2)", "no real value"),
    ] {
        let broken = THREAD.replace("thread", "broken").replace("-k * x_m", formula).replace("\"1/s²\"", "\"?\"");
        folder.write("ball.toml", format!("{BALL}{THREAD}{broken}"));
        let json = folder.run("diagnose --sim ball.toml 0.csv 1.csv 2.csv --held-out 3.csv --json").json();
        let all = json["scores"].as_array().unwrap();
        let one = all.iter().find(|c| c["name"] == "broken").unwrap_or_else(|| panic!("{json:#}"));
        let why = one["excluded"].as_str().unwrap_or_default();
        assert!(why.contains(wanted) && why.contains("candidates.broken.formula"), "{formula}: {one}");
    }
}
