//! A law of an oscillator in equations: found, written as what it adds to a derivative, and tuned with again.

use std::fmt::Write as _;

use crate::common::{Folder, Noise};

const FILE: &str = "kind = \"equations\"\n[states]\n[states.q_rad]\n[states.dq_rad_s]\n[start.q_rad]\nvalue = \"first\"\nsd = 0.01\n\
[start.dq_rad_s]\nvalue = 0.0\nmin = -20.0\nmax = 20.0\n[derivatives]\nq_rad = \"dq_rad_s\"\n\
dq_rad_s = \"-stiffness*q_rad - damping*dq_rad_s\"\n[outputs]\nq_rad = \"q_rad\"\n\
[parameters.stiffness]\nvalue = 8.0\nmin = 0.0\nmax = 30.0\nunit = \"1/s²\"\n\
[parameters.damping]\nvalue = 0.2\nmin = 0.0\nmax = 5.0\nunit = \"1/s\"\n";

/// A swing of 4 s at 50 Hz with noise of 2 mrad, by the midpoint rule in short steps.
fn swing(number: u64, force: impl Fn(f64, f64) -> f64) -> String {
    let mut noise = Noise(number);
    let (mut q, mut v) = (noise.between(-1.5, 1.5), noise.between(-3.0, 3.0));
    let mut text = String::from("t_s,q_rad\n");
    let h = 1e-5;
    for i in 0..200 {
        writeln!(text, "{},{:.7}", f64::from(i) * 0.02, q + 0.002 * noise.normal()).unwrap();
        for _ in 0..2000 {
            let a = -9.0 * q - 0.3 * v + force(q, v);
            let (at, middle) = (q + 0.5 * h * v, v + 0.5 * h * a);
            let a = -9.0 * at - 0.3 * middle + force(at, middle);
            q += h * (v + 0.5 * h * a);
            v += h * a;
        }
    }
    text
}

fn recorded(force: impl Fn(f64, f64) -> f64) -> Folder {
    let folder = Folder::new();
    folder.write("swing.toml", FILE);
    for i in 0..5 {
        folder.write(&format!("{i}.csv"), swing(3 + i, &force));
    }
    folder
}

#[test]
fn a_hardening_spring_is_a_law_that_its_file_holds() {
    let folder = recorded(|q, _| -0.5 * q * q * q);
    // A parameter has the name that the law's coefficient would have.
    folder.write("swing.toml", FILE.replace("damping", "a"));
    // Starts that differ from recording to recording are no hindrance.
    let entry = |i: i32| {
        let held_out = if i > 2 { "held_out = true\n" } else { "" };
        format!("[[observation]]\nfile = \"{i}.csv\"\n{held_out}start.dq_rad_s = 0.{i}\n")
    };
    folder.write("runs.toml", (0..5).map(entry).collect::<String>());
    let line = "diagnose --sim swing.toml --manifest runs.toml --law --out improved.toml --report law.html --json";
    let json = folder.run(line).json();
    assert!(["law", "one_of"].contains(&json["verdict"].as_str().unwrap()), "{json:#}");
    let cubic = |member: &serde_json::Value| {
        let factor = &member["terms"][0]["factors"][0];
        let interval = &factor["constants"][0]["interval95"];
        factor["kind"] == "odd_power"
            && factor["variable"] == "q_rad"
            && interval[0].as_f64().unwrap() <= 3.0
            && interval[1].as_f64().unwrap() >= 3.0
    };
    assert!(json["law"]["members"].as_array().unwrap().iter().any(cubic), "{json:#}");
    // What the recordings ask for along the angle is the true force: of at most 10 intervals of 95 % one may miss it.
    let course = &json["law"]["members"][0]["courses"][0];
    let bins = course["bins"].as_array().unwrap();
    let misses = |bin: &&serde_json::Value| {
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let (at, ends) = (number(&bin["estimate"]["at"]), &bin["estimate"]["interval95"]);
        let true_force = -0.5 * at * at * at;
        true_force < number(&ends[0]) || number(&ends[1]) < true_force
    };
    assert!(bins.len() >= 4 && bins.iter().filter(misses).count() <= 1, "{course:#}");
    let report = folder.text("law.html");
    assert!(report.contains("Along dq_rad_s over q_rad") && report.contains("the solid line has the law"), "{line}");
    let improved = folder.text("improved.toml");
    assert!(improved.contains("adds.dq_rad_s = \"") && improved.contains("[effects.law]\na_law = "), "{improved}");
    // Seen between some angles alone: within them nothing is said, beyond them the instant that is farthest outside.
    assert!(improved.contains("valid = { q_rad = ["), "{improved}");
    let within = folder.run("simulate --sim improved.toml --set start.q_rad=0.5 --out again.csv").ends(0);
    assert!(!within.stderr.contains("effect.outside"), "{}", within.stderr);
    let beyond = folder.run("simulate --sim improved.toml --set start.q_rad=4.0 --out beyond.csv").ends(0);
    assert!(beyond.stderr.contains("`q_rad` reaches 4.000 at 0.000 s"), "{}", beyond.stderr);
    // The numbers of the law stay as they are, which is said, unless its table asks for their estimate.
    let held =
        |json: &serde_json::Value| json["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "effects.held");
    let tuned = folder.run("tune --sim improved.toml 0.csv 1.csv 2.csv --json").ends(0).json();
    assert!(tuned["verdict"] == "tuned" && held(&tuned), "{tuned:#}");
    folder.write("open.toml", improved.replace("[effects.law]\n", "[effects.law]\ntune = true\n"));
    let open = folder.run("tune --sim open.toml 0.csv 1.csv 2.csv --json").ends(0).json();
    assert!(open["verdict"] == "tuned" && !held(&open), "{open:#}");
    let width = |json: &serde_json::Value| {
        let interval = &json["parameters"]["stiffness"]["interval95"];
        interval[1].as_f64().unwrap() - interval[0].as_f64().unwrap()
    };
    assert!(width(&open) > 1.2 * width(&tuned), "{open:#}");
}

/// Where nothing moves, nothing shows the noise that a law is measured by.
#[test]
fn recordings_that_stand_still_have_no_law() {
    let folder = recorded(|q, _| -0.5 * q * q * q);
    let still = |folder: &Folder, i: u32| {
        let lines = (0..200).map(|k| format!("{},0.5\n", f64::from(k) * 0.02));
        folder.write(&format!("{i}.csv"), std::iter::once("t_s,q_rad\n".into()).chain(lines).collect::<String>());
    };
    still(&folder, 0);
    for recordings in ["0.csv", "0.csv 1.csv 2.csv --held-out 3.csv", "1.csv 2.csv --held-out 0.csv"] {
        let ran = folder.run(&format!("diagnose --sim swing.toml --law --json {recordings}"));
        assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
        let law = &ran.json()["law"];
        let why = law["why"].as_str().unwrap_or_default();
        assert!(law["verdict"] == "unknown" && why.starts_with("no channel of a recording changes"), "{law:#}");
    }
}

#[test]
fn a_linear_oscillator_has_no_law() {
    let folder = recorded(|_, _| 0.0);
    let json = folder.run("diagnose --sim swing.toml 0.csv 1.csv 2.csv --held-out 3.csv --law --json").ends(0).json();
    assert_eq!((json["verdict"].as_str(), json["law"]["verdict"].as_str()), (Some("none"), Some("none")), "{json:#}");
}

/// Friction by the square of the rate, which the file declares: the law that is found is that candidate in another notation.
#[test]
fn a_law_that_is_a_declared_candidate_bears_its_name() {
    let folder = recorded(|_, v| -0.3 * v * v.abs());
    let candidate = "[candidates.quadratic]\nsentence = \"air drags the pendulum\"\nacts = \"body\"\n\
                     adds.dq_rad_s = \"-c*dq_rad_s*abs(dq_rad_s)\"\n\
                     coefficients.c = { unit = \"1/rad\", absent = 0.0, min = 0.0, max = 10.0, typical = 0.1 }\n";
    folder.write("swing.toml", format!("{FILE}{candidate}"));
    let line = "diagnose --sim swing.toml 0.csv 1.csv 2.csv --held-out 3.csv 4.csv --law --out improved.toml --json";
    let json = folder.run(line).ends(0).json();
    assert_eq!((json["verdict"].as_str(), json["effects"][0]["name"].as_str()), (Some("named"), Some("quadratic")));
    assert!(folder.text("improved.toml").contains("[effects.quadratic]"), "{json:#}");
}

/// A plane body on which the origin pulls with 1.2/r², from 2 to 3 m away, followed by the midpoint rule, with noise of 10 mm.
fn orbit(number: u64) -> String {
    let mut noise = Noise(number);
    let mut x = [noise.between(1.5, 2.0), noise.between(-1.0, 1.0)];
    let mut v = [noise.between(-0.3, 0.3), noise.between(0.4, 0.9)];
    let pull = |x: [f64; 2]| x.map(|one| -1.2 * one / x[0].hypot(x[1]).powi(3));
    let mut text = String::from("t_s,x_m,y_m\n");
    let h = 2e-5;
    for i in 0..120 {
        let seen = x.map(|one| one + 0.01 * noise.normal());
        writeln!(text, "{},{:.7},{:.7}", f64::from(i) * 0.025, seen[0], seen[1]).unwrap();
        for _ in 0..1250 {
            let at = std::array::from_fn(|k| x[k] + 0.5 * h * v[k]);
            let a = pull(at);
            (0..2).for_each(|k| x[k] += h * (v[k] + 0.5 * h * a[k]));
            (0..2).for_each(|k| v[k] += h * a[k]);
        }
    }
    text
}

const BODY: &str = "kind = \"equations\"\nstates.x_m = {}\nstates.y_m = {}\nstates.vx_m_s = {}\nstates.vy_m_s = {}\n\
[derivatives]\nx_m = \"vx_m_s\"\ny_m = \"vy_m_s\"\nvx_m_s = \"-drag*vx_m_s\"\nvy_m_s = \"-drag*vy_m_s\"\n\
[outputs]\nx_m = \"x_m\"\ny_m = \"y_m\"\n\
[start]\nx_m = { value = \"first\", sd = 0.1 }\ny_m = { value = \"first\", sd = 0.1 }\n\
vx_m_s = { value = 0.0, min = -5.0, max = 5.0 }\nvy_m_s = { value = 0.0, min = -5.0, max = 5.0 }\n\
[parameters]\ndrag = { value = 0.05, min = 0.0, max = 1.0, unit = \"1/s\" }\n";

/// At rest, as the file says that it starts, it would fall into the centre: its estimate begins at the slope of what was recorded.
#[test]
fn an_attraction_is_a_law_that_tunes_again_and_a_candidate_that_is_named() {
    let folder = Folder::new();
    folder.write("body.toml", BODY);
    for i in 0..5 {
        folder.write(&format!("{i}.csv"), orbit(31 + i));
    }
    let line = "diagnose --sim body.toml 0.csv 1.csv 2.csv --held-out 3.csv 4.csv --law --out improved.toml --json";
    let json = folder.run(line).json();
    assert!(["law", "one_of"].contains(&json["verdict"].as_str().unwrap()), "{json:#}");
    let inverse_square = |member: &serde_json::Value| {
        let interval = &member["terms"][0]["factors"][0]["constants"][0]["interval95"];
        member["terms"][0]["factors"].as_array().unwrap().len() == 1
            && interval[0].as_f64().is_some_and(|low| low <= -2.0)
            && interval[1].as_f64().is_some_and(|high| high >= -2.0)
    };
    assert!(json["law"]["members"].as_array().unwrap().iter().any(inverse_square), "{json:#}");
    let tuned = folder.run("tune --sim improved.toml 0.csv 1.csv 2.csv --json").ends(0).json();
    assert_eq!(tuned["verdict"], "tuned", "{tuned:#}");

    let candidate = "[candidates.pull]\nsentence = \"the origin pulls\"\nacts = \"body\"\n\
                     adds.vx_m_s = \"-k*x_m/sqrt(x_m^2 + y_m^2)^3\"\nadds.vy_m_s = \"-k*y_m/sqrt(x_m^2 + y_m^2)^3\"\n\
                     coefficients.k = { unit = \"m³/s²\", absent = 0.0, min = -10.0, max = 10.0, typical = 0.1 }\n";
    folder.write("body.toml", format!("{BODY}{candidate}"));
    let json = folder.run(line.replace("improved", "pulled").as_str()).ends(0).json();
    assert_eq!(
        (json["verdict"].as_str(), json["effects"][0]["name"].as_str()),
        (Some("named"), Some("pull")),
        "{json:#}"
    );
}

/// A body in a room of 293 K that radiates, heated to 500 K or 600 K, each degree read to 1.5 K: in K the exponent and its coefficient go
/// together over decades.
#[test]
fn a_radiating_body_has_an_exponent_whose_interval_holds_four() {
    let cooling = |number: u64| {
        let mut noise = Noise(number);
        let mut temperature: f64 = noise.between(480.0, 620.0);
        let mut text = String::from("t_s,temperature_k\n");
        for i in 0..200 {
            writeln!(text, "{i},{:.5}", temperature + 1.5 * noise.normal()).unwrap();
            for _ in 0..100 {
                let rate = |t: f64| -0.004 * (t - 293.0) - 2e-11 * t.powi(4);
                temperature += 0.01 * rate(temperature + 0.005 * rate(temperature));
            }
        }
        text
    };
    let folder = Folder::new();
    folder.write(
        "body.toml",
        "kind = \"equations\"\nstates.temperature_k = {}\nderivatives.temperature_k = \"-loss*(temperature_k - 293.0)\"\n\
         start.temperature_k = { value = \"first\", sd = 1.0 }\n\
         parameters.loss = { value = 0.01, min = 0.0, max = 0.5, unit = \"1/s\" }\n",
    );
    for i in 0..5 {
        folder.write(&format!("{i}.csv"), cooling(51 + i));
    }
    let line = "diagnose --sim body.toml 0.csv 1.csv 2.csv --held-out 3.csv 4.csv --law --out improved.toml --json";
    let json = folder.run(line).json();
    // A law alone is the power with an interval that holds 4; where others are as good, it is among them.
    let holds = |member: &serde_json::Value| {
        let constant = &member["terms"][0]["factors"][0]["constants"][0];
        constant["interval95"][0].as_f64().is_some_and(|low| low <= 4.0)
            && constant["interval95"][1].as_f64().is_some_and(|high| high >= 4.0)
    };
    let members = json["law"]["members"].as_array().unwrap();
    assert!(members.is_empty() || members.iter().any(holds), "{json:#}");
    assert!(json["verdict"] != "law" || holds(&members[0]), "{json:#}");
}

/// Where a state is estimated, a simulation starts at its value, unless it replays a recording or the command line says where.
#[test]
fn a_simulation_starts_at_the_value_or_as_its_recording_shows() {
    let folder = Folder::new();
    let file = FILE.replace("value = 0.0\nmin = -20.0", "value = 0.8\nmin = -20.0");
    folder.write("swing.toml", format!("{file}[record]\nrate_hz = 50.0\nframes = 200\n"));
    let first_step = |line: &str| {
        let said = folder.run(&format!("simulate --sim swing.toml {line} --out out.csv --overwrite")).ends(0).stderr;
        let rows: Vec<f64> =
            folder.text("out.csv").lines().skip(1).map(|row| row.split(',').nth(1).unwrap().parse().unwrap()).collect();
        ((rows[1] - rows[0]) / 0.02, said)
    };
    let (stated, said) = first_step("--set start.q_rad.value=0.5");
    assert!((stated - 0.8).abs() < 0.15 && !said.contains("start.estimated"), "{stated} {said}");
    folder.write("seen.csv", swing(4, |_, _| 0.0));
    let seen: Vec<f64> =
        folder.text("seen.csv").lines().skip(1).map(|row| row.split(',').nth(1).unwrap().parse().unwrap()).collect();
    let slope = (seen[4] - seen[0]) / 0.08;
    assert!((slope - 0.8).abs() > 1.0, "another swing than the file's: {slope}");
    let (shown, said) = first_step("--inputs seen.csv");
    assert!((shown - slope).abs() < 0.5 && said.contains("start.estimated"), "{shown} for {slope}: {said}");
    let (stated, said) = first_step("--inputs seen.csv --set start.dq_rad_s.value=0.8");
    assert!((stated - 0.8).abs() < 0.6 && !said.contains("start.estimated"), "{stated} {said}");
}

/// Clean swings: the fit of the base model without a law ends where that of the diagnosis does, and nothing is left for a law.
#[test]
fn gaps_of_a_law_are_those_of_its_own_rollouts() {
    let folder = recorded(|q, _| -0.5 * q * q * q);
    let line = "diagnose --sim swing.toml 0.csv 1.csv 2.csv --held-out 3.csv 4.csv --law --out improved.toml --json";
    let json = folder.run(line).json();
    let (after, held_out) = (&json["gap"]["after"], &json["gap"]["held_out"]["after"]);
    for gap in [after, held_out] {
        let ratio = gap.as_f64().unwrap() / 0.002;
        assert!((0.85..1.15).contains(&ratio), "{ratio} times the noise: {json:#}");
    }
}
