//! What can be wrong with an arm's files: the URDF, the log, its columns, its clock, a manifest, and other commands' files.

use crate::arm::pendulum::{self, Beside, HEADER, URDF, log, plain};
use crate::common::Folder;

fn folder() -> Folder {
    let folder = pendulum::folder();
    folder.write("log.csv", log(Beside::default(), plain));
    folder
}

const TUNE: &str = "tune --sim arm.toml --observation log.csv";

/// What is replaced in the URDF, and what the message has to hold: never the name of the log.
#[test]
fn faults_of_a_urdf_are_its_own() {
    let inertial = "<inertial><origin xyz=\"0 0 -0.2\"/><mass value=\"0.5\"/>\n    \
                    <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.001\"/></inertial>";
    let cycle = "<joint name=\"back\" type=\"revolute\"><parent link=\"rod\"/><child link=\"base\"/><axis xyz=\"1 0 0\"/></joint></robot>";
    let cases: [(&str, &str, &[&str]); 9] = [
        (inertial, "", &["pendulum.urdf", "<inertial> of link `rod`"]),
        (
            "mass value=\"0.5\"",
            "mass value=\"-0.5\"",
            &["pendulum.urdf:3:3", "link `rod`", "mass of 0 kg or more", "-0.5"],
        ),
        ("ixx=\"0.01\"", "ixx=\"-0.01\"", &["pendulum.urdf:3:3", "inertia above 0 about every axis"]),
        ("izz=\"0.001\"", "izz=\"0.1\"", &["pendulum.urdf:3:3", "at most the sum of the others"]),
        ("lower=\"-2\"", "lower=\"-2,0\"", &["pendulum.urdf:6:19", "<limit lower=…>: expected a number, found `-2,0`"]),
        ("xyz=\"0 0 -0.2\"", "xyz=\"0 0\"", &["pendulum.urdf:3:43", "expected 3 numbers, found `0 0`"]),
        ("<axis xyz=\"1 0 0\"/>", "<axis xyz=\"1 0 0\">", &["pendulum.urdf:6:", "</axis>", "mend the XML"]),
        ("</robot>", "", &["pendulum.urdf:1:1", "`<robot>` is not closed"]),
        ("</robot>", cycle, &["pendulum.urdf", "expected a tree, found a cycle"]),
    ];
    for (from, to, said) in cases {
        let folder = folder();
        assert!(URDF.contains(from), "{from}");
        folder.write("pendulum.urdf", URDF.replace(from, to));
        let ran = folder.run(TUNE).ends(1);
        for part in said {
            assert!(ran.stderr.contains(part), "{to}: no `{part}` in\n{}", ran.stderr);
        }
        assert!(!ran.stderr.contains("log.csv") && ran.stdout.is_empty(), "{}", ran.stderr);
    }
}

#[test]
fn absent_limits_are_not_called_passed() {
    let folder = folder();
    folder.write("pendulum.urdf", URDF.replace("lower=\"-2\" upper=\"2\"", "lower=\"0\" upper=\"0\""));
    let answer = folder.run(&format!("{TUNE} --json")).json();
    let checks = answer["preflight"][0].as_array().unwrap();
    let limits = checks.iter().find(|c| c["code"] == "joints.limits").unwrap();
    assert_eq!(limits["state"], "not_run");
    assert!(limits["text"].as_str().unwrap().contains("no limits of `hinge`"), "{limits}");
    assert!(answer["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "urdf.limits"), "{answer}");
}

#[test]
fn a_log_that_is_mostly_gaps_is_rejected() {
    let folder = folder();
    let good = log(Beside::default(), plain);
    // Samples of the first second and of the last, with 18 s of nothing between them.
    let kept = good.split_inclusive('\n').enumerate().filter(|(i, _)| *i <= 100 || *i > 1900).map(|(_, line)| line);
    folder.write("log.csv", kept.collect::<String>());
    let ran = folder.run(&format!("{TUNE} --json")).ends(3);
    let clock = ran.json()["preflight"][0][1].clone();
    assert_eq!((clock["code"].as_str(), clock["state"].as_str()), (Some("joints.clock"), Some("failed")), "{clock}");
    assert!(clock["remedy"].as_str().unwrap().contains("cut the log where its gaps are"), "{clock}");
}

#[test]
fn foreign_columns_are_proposed_as_joints() {
    let folder = folder();
    let foreign = log(Beside::default(), plain).replace(HEADER, "time,hinge_pos,hinge_vel,hinge_effort\n");
    folder.write("log.csv", foreign);
    let ran = folder.run(TUNE).ends(1);
    insta::assert_snapshot!("arm_columns", ran.stderr);
    // What is proposed works, and so does one pattern for each quantity; a range that does not fit is refused.
    let proposed = "--columns t_s=time,q1_rad=hinge_pos,dq1_rad_s=hinge_vel,tau1_nm=hinge_effort";
    assert!(ran.stderr.contains(proposed), "{}", ran.stderr);
    folder.run(&format!("{TUNE} {proposed}")).ends(0);
    folder.run(&format!("{TUNE} --columns t_s=1,q1..1_rad=2..2,tau1..1_nm=4..4")).ends(0);
    let range = folder.run(&format!("{TUNE} --columns t_s=1,q1..2_rad=2..2")).ends(2);
    assert!(range.stderr.contains("expected 2 columns, one for each joint"), "{}", range.stderr);
    let pattern = log(Beside::default(), plain).replace(HEADER, "t_s,actual_q_0,actual_qd_0,torque_0\n");
    folder.write("log.csv", pattern);
    folder.run(&format!("{TUNE} --columns q1..1_rad=actual_q_*,tau1..1_nm=torque_*")).ends(0);
    let seen = folder.run("inspect log.csv --json").ends(1).json();
    assert!(seen["remedy"].as_str().unwrap().contains("q1_rad=actual_q_0"), "{seen}");
}

#[test]
fn inspect_suspects_units_and_names_other_files() {
    let folder = folder();
    folder.write(
        "deg.csv",
        log(Beside::default(), |t, [q, dq, c]| format!("{t:.3},{},{},{c}", q.to_degrees(), dq.to_degrees())),
    );
    folder.write("ms.csv", log(Beside::default(), |t, [q, dq, c]| format!("{:.3},{q:.9},{dq:.9},{c}", 1000.0 * t)));
    for (name, said) in [("deg.csv", "degrees?"), ("ms.csv", "times the slope of its positions")] {
        let seen = folder.run(&format!("inspect {name} --json")).ends(0).json();
        let warning = &seen["warnings"][0];
        assert_eq!(warning["code"], "joints.units", "{seen}");
        assert!(warning["text"].as_str().unwrap().contains(said), "{seen}");
    }
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    folder.write("shot.toml", std::fs::read(assets.join("shot.toml")).unwrap());
    folder.write("all.toml", "[[observation]]\nfile = \"log.csv\"\n");
    assert_eq!(folder.run("inspect shot.toml --json").ends(0).json()["kind"], "task");
    assert_eq!(folder.run("inspect all.toml --json").ends(0).json()["kind"], "manifest");
    insta::assert_snapshot!("arm_plan", folder.run("plan --sim arm.toml --task shot.toml").ends(1).stderr);
}

/// Two objects of one arm: one that holds a payload which is known, and one whose bare run lies beside it.
#[test]
fn a_manifest_says_what_an_arm_holds() {
    let folder = folder();
    let wrong = Beside { viscous: 0.4, ..Beside::default() };
    folder.write("held.csv", log(Beside { payload_kg: 0.8, ..wrong }, plain));
    folder.write("other.csv", log(Beside { payload_kg: 0.5, ..wrong }, plain));
    folder.write("bare.csv", log(Beside { late_s: 0.37, ..wrong }, plain));
    folder.write("all.toml", "[[observation]]\nfile = \"held.csv\"\npayload_mass_kg = 0.8\n");
    let answer = folder.run("diagnose --sim arm.toml --manifest all.toml --json --out improved.toml").ends(0).json();
    assert_eq!(
        (answer["verdict"].as_str(), answer["effects"][0]["name"].as_str()),
        (Some("named"), Some("viscous_friction"))
    );
    assert!(answer["parameters"].as_array().unwrap().is_empty(), "the payload is known: {answer}");
    let improved = folder.text("improved.toml");
    assert!(improved.contains("value = 0.8"), "{improved}");
    folder.write("pair.toml", "[[observation]]\nfile = \"other.csv\"\nreference = \"bare.csv\"\n");
    let answer = folder.run("diagnose --sim arm.toml --manifest pair.toml --json --out pair_improved.toml").json();
    let mass = &answer["parameters"][0];
    assert!((mass["value"].as_f64().unwrap() - 0.5).abs() < 0.01, "friction cancels: {answer}");
    let unknown = "[[observation]]\nfile = \"held.csv\"\npayload = 0.8\n";
    folder.write("wrong.toml", unknown);
    let ran = folder.run("diagnose --sim arm.toml --manifest wrong.toml").ends(1);
    assert!(ran.stderr.contains("`reference`, `payload_mass_kg`"), "{}", ran.stderr);
}

/// One result for each file, in order, whatever is wrong with one of them.
#[test]
fn each_finishes_the_others() {
    let folder = folder();
    let good = log(Beside { payload_kg: 0.8, ..Beside::default() }, plain);
    folder.write("a.csv", &good);
    folder.write("nan.csv", good.replacen("0.500,", "NaN,", 1));
    folder.write("b.csv", good.replace("0.000000000,", "0.0,"));
    let ran = folder.run("tune --sim arm.toml --each --json --observation a.csv nan.csv b.csv").ends(1);
    let all = ran.json()["observations"].clone();
    let names: Vec<_> = all.as_array().unwrap().iter().map(|o| o["file"].as_str().unwrap()).collect();
    assert_eq!(names, ["a.csv", "nan.csv", "b.csv"]);
    assert!(all[1]["error"].as_str().unwrap().contains("nan.csv:52") && all[2]["verdict"] == "tuned", "{all}");
}

#[test]
fn logs_that_are_broken_get_one_sentence() {
    let folder = folder();
    let good = log(Beside::default(), plain);
    folder.write("empty.csv", "");
    folder.write("cut.csv", &good[..HEADER.len() + 70]);
    folder.write("nan.csv", good.replacen("0.500,", "NaN,", 1));
    let cases = [
        ("empty.csv", "found an empty file"),
        ("cut.csv", "expected 4 cells, found 3"),
        ("nan.csv", "expected a finite number"),
        ("none.csv", "check the path"),
    ];
    for (name, said) in cases {
        let ran = folder.run(&format!("tune --sim arm.toml --observation {name}"));
        assert!(matches!(ran.code, Some(1 | 3)) && ran.stderr.contains(said), "{name}: {:?}\n{}", ran.code, ran.stderr);
    }
}

/// An arm that draws a circle has rigid bodies alone: an effect or candidate that it would ignore is refused.
#[test]
fn effects_of_a_circle_are_refused() {
    let effect = "[effects.viscous_friction]\nnms_rad = [0.1]\n";
    let candidate = "[candidates.cable]\nsentence = \"a cable pulls at twice the angle\"\nacts = \"joint\"\njoints = [\"hinge\"]\n\
                     formula = \"k * sin(2*q_rad)\"\ncoefficients.k = { unit = \"N·m\", absent = 0.0, min = -9.0, max = 9.0 }\n";
    for (more, name) in [(effect, "`effects.viscous_friction`"), (candidate, "`candidates.cable`")] {
        let folder = folder();
        let scene = folder.text("arm.toml");
        assert!(scene.contains("kind = \"replay\""), "{scene}");
        folder.write("arm.toml", format!("{}\n{more}", scene.replace("kind = \"replay\"", "kind = \"circle\"")));
        let ran = folder.run("simulate --sim arm.toml --out run.csv").ends(1);
        assert!(ran.stderr.contains(name) && ran.stderr.contains("motion.kind"), "{}", ran.stderr);
    }
}
