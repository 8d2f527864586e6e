//! Formulas of a user at robot joints: named where they are missing, written, and used again.

use super::folder;
use super::truth::{NONE, Truth, recorded, simulation};

const COGGING: &str = "[candidates.cogging]
sentence = \"magnets draw the rotor to several places of a turn\"
acts = \"joint\"
formula = \"c * sin(n * q_rad)\"
[candidates.cogging.coefficients.c]
unit = \"N·m\"
absent = 0.0
min = -1.0
max = 1.0
[candidates.cogging.coefficients.n]
unit = \"1/rad\"
min = 2.0
max = 12.0
";

#[test]
fn a_formula_competes_with_the_catalogue_and_is_written() {
    let folder = folder();
    recorded(&folder, &Truth { cogging: 0.15, ..NONE }, |_, mass| mass);
    simulation(&folder, [6.0, 1.2, 0.02, 0.12, 0.022, 0.0]);
    let file = String::from_utf8(folder.read("servo.toml")).unwrap();
    folder.write("servo.toml", format!("{file}{COGGING}"));
    let answer = folder.run("diagnose --sim servo.toml --manifest runs.toml --out improved.toml --json").ends(0).json();
    let [effect] = answer["effects"].as_array().unwrap().as_slice() else { panic!("{answer:#}") };
    assert_eq!(effect["name"], "cogging", "{answer:#}");
    assert!(effect["alternatives"].as_array().unwrap().is_empty(), "{effect:#}");
    let value = |key: &str| effect["coefficients"][key]["value"].as_f64().unwrap();
    // The file asks what the motion needs more.
    assert!((value("c").abs() - 0.15).abs() < 0.01 && (value("n") - 8.0).abs() < 0.1, "{effect:#}");
    assert!(answer["gap"]["held_out"]["after"].as_f64().unwrap() < 0.003, "{answer:#}");

    let again = folder.run("diagnose --sim improved.toml --manifest runs.toml --json").json();
    assert_eq!(again["verdict"], "none", "{again:#}");
    folder.run("simulate --sim improved.toml --inputs run_0.csv --out again.csv").ends(0);
    let written = String::from_utf8(folder.read("improved.toml"))
        .unwrap()
        .replace("[effects.cogging]", "[effects.cogging]\ntune = true");
    folder.write("free.toml", written);
    let tuned = folder.run("tune --sim free.toml --manifest runs.toml --json").ends(0).json();
    let names = tuned["parameters"].to_string();
    assert!(names.contains("cogging.c") && names.contains("cogging.n"), "{names}");
}

#[test]
fn a_formula_that_fits_no_joint_is_refused_with_its_place() {
    let folder = folder();
    let file = String::from_utf8(folder.read("robot.toml")).unwrap();
    for (from, to, wanted) in [
        ("c * sin(n * q_rad)", "c * sin(n * q_m)", "expected one of q_rad, dq_rad_s, t_s, command, c, n, found `q_m`"),
        ("acts = \"joint\"", "acts = \"flight\"", "`candidates.cogging.acts`: expected \"joint\" for a robot"),
        (
            "acts = \"joint\"",
            "acts = \"joint\"\njoints = [\"elbow\"]",
            "expected joints that turn (\"hinge\"), found \"elbow\"",
        ),
        (
            "acts = \"joint\"",
            "acts = \"joint\"\ngives = \"n\"",
            "expected one of q_m, dq_m_s, t_s, command, c, n, found `q_rad`",
        ),
    ] {
        folder.write("own.toml", format!("{file}{}", COGGING.replace(from, to)));
        let refused = folder.run("simulate --sim own.toml --out swing.csv").ends(1);
        assert!(refused.stderr.contains(wanted), "{to}: {}", refused.stderr);
    }
}

#[test]
fn a_formula_without_a_value_is_refused_with_its_part_and_instant() {
    let folder = folder();
    recorded(&folder, &NONE, |_, mass| mass);
    simulation(&folder, [6.0, 1.2, 0.02, 0.12, 0.022, 0.0]);
    let file = String::from_utf8(folder.read("servo.toml")).unwrap();
    let own = COGGING.replace("c * sin(n * q_rad)", "c * n / dq_rad_s") + "[effects.cogging]\nc = 0.1\nn = 3.0\n";
    folder.write("own.toml", format!("{file}{}", own.replace("unit = \"1/rad\"", "unit = \"rad/s\"")));
    let refused = folder.run("simulate --sim own.toml --inputs run_0.csv --out swing.csv").ends(1);
    let wanted = "`c * n / dq_rad_s` in `candidates.cogging.formula` grows beyond all bounds at 0.000000 s";
    assert!(refused.stderr.contains(wanted), "{}", refused.stderr);
}
