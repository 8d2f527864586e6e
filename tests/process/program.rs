//! Programs of one's own as simulators: tuned, diagnosed and learned from like ours.

use std::fmt::Write as _;
use std::path::Path;

use crate::common::{Folder, Ran};
use crate::process::programs::{DRIVEN, MUJOCO, MUJOCO_CART, MUJOCO_SCENE, PENDULUM_SCENE, Swing, pendulum, python};

#[track_caller]
fn holds(json: &serde_json::Value, name: &str, truth: f64, near: f64) {
    let one = &json["parameters"][name];
    let [value, low, high] =
        [&one["value"], &one["interval95"][0], &one["interval95"][1]].map(|v| v.as_f64().unwrap_or(f64::NAN));
    assert!((value - truth).abs() < near, "{name}: {one}");
    // The seed was not chosen: an interval of 95 % may miss the truth, but not by its own width again.
    let slack = 0.5 * (high - low);
    assert!((low - slack..=high + slack).contains(&truth) && low < high, "{name}: {one}");
}

#[test]
fn a_program_is_tuned_to_what_another_integrator_made() {
    if !python("json") {
        return;
    }
    let folder = pendulum();
    let line = "tune --sim pendulum.toml --allow-process --observation swing.csv --json --out tuned.toml";
    let first = folder.run(line).ends(0);
    let json = first.json();
    assert_eq!(json["verdict"], "tuned");
    assert_eq!(json["parameters"]["length"]["unit"], "m");
    holds(&json, "length", 0.62, 2e-3);
    holds(&json, "damping", 0.24, 2e-2);
    let gap = json["gap"]["after"].as_f64().unwrap();
    assert!((gap / 2e-3 - 1.0).abs() < 0.2, "{}", json["gap"]);

    // The same seed gives the same bytes, whatever the number of threads and of copies.
    let tuned = folder.read("tuned.toml");
    for workers in ["1", "3"] {
        let mut command = folder.command();
        command.env("RAYON_NUM_THREADS", workers).args(line.split_whitespace());
        Ran::from(command.output().unwrap()).ends(0);
        assert!(folder.read("tuned.toml") == tuned, "{workers} workers");
    }
    // What was written is run with leave alone, too.
    let refused = folder.run("simulate --sim tuned.toml --out again.csv").ends(2);
    assert!(refused.stderr.contains("`--allow-process`: expected permission to run"), "{}", refused.stderr);
    folder.run("simulate --sim tuned.toml --allow-process --out again.csv").ends(0);
    assert!(folder.text("again.csv").starts_with("t_s,angle_rad\n0.0,0.5\n"));

    // A file that is written elsewhere still finds its program.
    std::fs::create_dir(folder.path("elsewhere")).unwrap();
    folder.run("tune --sim pendulum.toml --allow-process --observation swing.csv --out elsewhere/tuned.toml").ends(0);
    let text = folder.text("elsewhere/tuned.toml");
    assert!(text.contains("kind = \"process\"") && text.contains("folder = \"..\""), "{text}");
    folder.run("simulate --sim elsewhere/tuned.toml --allow-process --out elsewhere/again.csv").ends(0);
    assert!(folder.read("elsewhere/again.csv") == folder.read("again.csv"));
}

#[test]
fn mujoco_is_tuned_to_what_another_integrator_made() {
    if !python("mujoco") {
        return;
    }
    let folder = Folder::new();
    folder.write("mujoco_pendulum.py", MUJOCO);
    folder.write("scene.toml", MUJOCO_SCENE);
    // A ball of .05 m: I = m l² + 2/5 m r², so that it swings like a point on a longer rod.
    let (length_m, radius_m, mass_kg, damping) = (0.7, 0.05, 0.5, 0.04);
    let stretch = 1.0 + 0.4 * radius_m * radius_m / (length_m * length_m);
    let inertia = mass_kg * length_m * length_m * stretch;
    let swing = Swing { length_m, stretch, damping_1_s: damping / inertia, ..Swing::default() };
    folder.write("swing.csv", swing.csv("t_s,angle_rad"));
    let json = folder.run("tune --sim scene.toml --allow-process --observation swing.csv --json").ends(0).json();
    holds(&json, "length", length_m, 2e-3);
    holds(&json, "damping", damping, 4e-3);
}

#[test]
fn a_program_is_diagnosed() {
    if !python("json") {
        return;
    }
    let folder = pendulum();
    let mut manifest = String::new();
    for (seed, start_rad) in [(1, 0.5), (2, 0.9), (3, 0.25)] {
        let late = Swing { seed, late_s: 0.04, start_rad, ..Swing::default() };
        folder.write(&format!("late_{seed}.csv"), late.csv("t_s,angle_rad"));
        let entry = format!("file = \"late_{seed}.csv\"\nobject = \"{seed}\"\nsettings.start_rad = {start_rad}\n");
        writeln!(manifest, "[[observation]]\n{entry}").unwrap();
        let shaken = Swing { seed, shaken: 2.0, ..Swing::default() };
        folder.write(&format!("shaken_{seed}.csv"), shaken.csv("t_s,angle_rad"));
    }
    folder.write("late.toml", manifest);
    let diagnose =
        |what: &str| folder.run(&format!("diagnose --sim pendulum.toml --allow-process --json --out {what}"));
    let none = diagnose("improved.toml --observation swing.csv").ends(0).json();
    assert_eq!(none["verdict"], "none");
    std::fs::remove_file(folder.path("improved.toml")).unwrap();

    // Swings that begin otherwise are objects with settings of their own; the clock that is late is common to all.
    let named = diagnose("improved --manifest late.toml").ends(0).json();
    assert_eq!((named["verdict"].as_str(), named["effects"][0]["name"].as_str()), (Some("named"), Some("time_offset")));
    let offset = &named["effects"][0]["coefficients"]["offset_s"]["value"];
    assert!((offset.as_f64().unwrap() - 0.04).abs() < 2e-3, "{offset}");
    let improved = folder.text("improved/2.toml");
    for wanted in ["kind = \"process\"", "[effects.time_offset]", "start_rad = 0.9", "folder = \"..\""] {
        assert!(improved.contains(wanted), "no {wanted} in:\n{improved}");
    }
    let refused = folder.run("tune --sim improved/2.toml --observation late_2.csv").ends(2);
    assert!(refused.stderr.contains("--allow-process"));
    let again = folder.run("tune --sim improved/2.toml --allow-process --observation late_2.csv --json").ends(0).json();
    holds(&again, "length", 0.62, 2e-3);
    std::fs::remove_dir_all(folder.path("improved")).unwrap();

    // What shakes the hinge is in no catalogue of a measurement.
    let unknown = diagnose("improved.toml --observation shaken_1.csv shaken_2.csv shaken_3.csv").ends(3).json();
    assert_eq!(unknown["verdict"], "unknown");
}

/// What is no ball is not spoken of as one; and what one motion alone shows is told as that, since its evidence is clear.
#[test]
fn a_diagnosis_of_a_program_speaks_of_no_ball() {
    if !python("json") {
        return;
    }
    let folder = pendulum();
    for seed in [1, 2, 3] {
        let late = Swing { seed, late_s: 0.04, ..Swing::default() };
        folder.write(&format!("late_{seed}.csv"), late.csv("t_s,angle_rad"));
        let shaken = Swing { seed, shaken: 2.0, ..Swing::default() };
        folder.write(&format!("shaken_{seed}.csv"), shaken.csv("t_s,angle_rad"));
    }
    let diagnose = |what: &str| {
        let line = "diagnose --sim pendulum.toml --allow-process --report page.html";
        let text = folder.run(&format!("{line} {what}")).ends(3);
        let ran = folder.run(&format!("{line} {what} --json")).ends(3);
        let page = folder.text("page.html");
        // The key of a flight stands in every object.
        let object = ran.stdout.replace("\"flight\": null", "");
        for text in [&text.stdout, &text.stderr, &object, &page] {
            let words = text.split(|c: char| !c.is_ascii_alphabetic()).map(str::to_lowercase);
            let balls = [
                "drop", "drops", "release", "ball", "throw", "throws", "bounces", "contact", "contacts", "flight",
                "flights", "camera",
            ];
            let found: Vec<String> = words.filter(|word| balls.contains(&word.as_str())).collect();
            // Styles have heights of their own.
            assert!(!text.contains("the height") && found.is_empty(), "{what}: {found:?} in\n{text}");
            // Nothing of a recording is fitted: it starts as the file says.
            for fitted in ["start of each recording is fitted", "only the start is fitted", "start states"] {
                assert!(!text.contains(fitted), "{what}: `{fitted}` in\n{text}");
            }
        }
        (text.stdout, ran.json())
    };
    let (_, unknown) = diagnose("shaken_1.csv shaken_2.csv shaken_3.csv");
    assert_eq!(unknown["verdict"], "unknown");
    assert!(unknown["next_experiment"]["text"].as_str().unwrap().contains("(start, inputs, parameters, sensor)"));
    assert!(unknown["description"].as_str().unwrap().contains("over the whole of each record"), "{unknown:#}");

    let (text, one_of) = diagnose("late_1.csv late_2.csv late_3.csv");
    assert_eq!((one_of["verdict"].as_str(), one_of["candidates"][0].as_str()), (Some("one_of"), Some("time_offset")));
    let ahead = one_of["scores"][1]["behind_best"].as_f64().unwrap();
    assert!(ahead > 10.0 * one_of["margin"].as_f64().unwrap(), "{ahead}");
    assert_eq!(one_of["doubt"], "a single motion does not identify one effect");
    assert!(text.contains("time_offset fits best by far, but a single motion does not identify one effect"), "{text}");
    let next = one_of["next_experiment"]["text"].as_str().unwrap();
    assert!(next.contains("start otherwise") && next.contains("the instant at which the motion starts"), "{next}");
    // Only what gains anything at all may stand beside it.
    let gain = |name: &serde_json::Value| {
        let score = one_of["scores"].as_array().unwrap().iter().find(|score| score["name"] == *name).unwrap();
        score["bic_gain"].as_f64().unwrap()
    };
    let candidates = one_of["candidates"].as_array().unwrap();
    assert!(candidates.iter().all(|name| gain(name) > 0.0), "{candidates:?} of {}", one_of["scores"]);
}

/// A sensor that adds the same to every reading leaves a constant, and that is what it is called, with its size.
#[test]
fn a_constant_bias_is_told_as_one() {
    if !python("json") {
        return;
    }
    let folder = pendulum();
    for seed in [1, 2, 3] {
        let swing = Swing { bias_rad: 0.05, seed, ..Swing::default() };
        folder.write(&format!("biased_{seed}.csv"), swing.csv("t_s,angle_rad"));
    }
    let line =
        "diagnose --sim pendulum.toml --allow-process --json --observation biased_1.csv biased_2.csv biased_3.csv";
    let told = folder.run(line).ends(3).json();
    assert_eq!(told["verdict"], "unknown");
    let text = told["description"].as_str().unwrap();
    assert!(
        text.contains("as a constant offset of about ") && text.contains("rad of angle, measured above simulated"),
        "{text}"
    );
    let size: f64 = text.split("of about ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    // Length and damping take a little of it away.
    assert!((size / 0.05 - 1.0).abs() < 0.2 && !text.contains("bend"), "{text}");
}

#[test]
fn pairs_are_generated_and_a_network_learns_from_them() {
    if !python("json") {
        return;
    }
    let folder = pendulum();
    let refused = folder.run("gen process --sim pendulum.toml --pairs 4 --out pairs.mcap").ends(2);
    assert!(refused.stderr.contains("--allow-process"));
    let few = "--set record.frames=40 --set record.rate_hz=20";
    folder.run(&format!("gen process --sim pendulum.toml --allow-process {few} --pairs 40 --out pairs.mcap")).ends(0);
    folder.run("inspect pairs.mcap").ends(0);
    folder.run("train --data pairs.mcap --preset paper --out model.safetensors").ends(0);
    let line = "tune --sim pendulum.toml --allow-process --observation swing.csv --model model.safetensors --json";
    let json = folder.run(line);
    assert!(matches!(json.code, Some(0 | 3)), "{}", json.stderr);
    assert_eq!(json.json()["model"]["source"], "given");
}

#[test]
fn what_is_not_a_programs_is_refused() {
    let folder = pendulum();
    folder.write("task.toml", include_str!("../../assets/shot.toml"));
    folder.write("a.mp4", b"\0\0\0\x18ftypisom");
    for (line, code, wanted) in [
        ("plan --sim pendulum.toml --task task.toml", 1, "found that of a program"),
        ("simulate --sim pendulum.toml --allow-process --bounces --out a.csv", 2, "`--bounces`"),
        ("simulate --sim pendulum.toml --allow-process --out a.mcap", 2, "ends in .csv"),
        ("gen ball --sim pendulum.toml --out a.mcap", 1, "expected `kind = \"ball\"` here, found \"process\""),
        ("tune --sim pendulum.toml --observation a.mp4 --allow-process", 1, "found a video"),
        ("tune --sim pendulum.toml --observation swing.csv --set parameters.weight.value=1", 2, "(length, damping)"),
        (
            "tune --sim pendulum.toml --observation swing.csv --set process.channels=[\"<b>\"]",
            2,
            "names with their units",
        ),
        ("tune --sim pendulum.toml --observation swing.csv --set kind=ball", 2, "\"process\" for `kind`"),
    ] {
        let ran = folder.run(line).ends(code);
        assert!(ran.stderr.contains(wanted), "{line}: {}", ran.stderr);
        assert!(!folder.path("a.csv").exists() && !folder.path("a.mcap").exists(), "{line}");
    }
    folder.write("other.csv", "t_s,theta\n0,1\n1,2\n2,3\n");
    crate::common::refused(
        &folder,
        "tune --sim pendulum.toml --observation other.csv --allow-process",
        &["expected a column `angle_rad`", "found `t_s`, `theta`", "`--columns angle_rad=theta`"],
    );
}

#[test]
fn inspect_knows_the_channels_and_runs_nothing() {
    let folder = pendulum();
    folder.write("pendulum.toml", PENDULUM_SCENE.replace("\"pendulum.py\"", "\"-c\", \"open('ran', 'w')\""));
    let ran = folder.run("inspect swing.csv").ends(0);
    assert!(ran.stdout.contains("a time series: tune robot joints, equations or your own simulator"), "{}", ran.stdout);
    assert!(
        ran.stdout.contains("try: check its columns against a simulation file: `--sim FILE.toml`"),
        "{}",
        ran.stdout
    );
    let json = folder.run("inspect swing.csv --sim pendulum.toml --json").ends(0).json();
    assert_eq!((json["usable"].as_bool(), json["columns"][1]["read_as"].as_str()), (Some(true), Some("angle_rad")));
    let json = folder.run("inspect pendulum.toml --json").ends(0).json();
    assert_eq!((json["command"][0].as_str(), json["channels"][0].as_str()), (Some("python3"), Some("angle_rad")));
    assert!(!folder.path("ran").exists());
}

/// What `init process` writes works as it stands.
#[test]
fn what_init_writes_can_be_tuned_with() {
    let folder = Folder::new();
    let json = folder.run("init process --json").ends(0).json();
    assert_eq!((json["file"].as_str(), json["program"].as_str()), (Some("process.toml"), Some("pendulum.py")));
    assert_eq!(folder.read("pendulum.py"), DRIVEN.as_bytes());
    folder.run("inspect process.toml").ends(0);
    crate::common::refused(&folder, "init process", &["process.toml: expected a new name"]);
    folder.run("init process --out other.toml").ends(0);
    folder.write("pendulum.py", "# mine\n");
    crate::common::refused(&folder, "init process --out third.toml", &["pendulum.py: expected a new name"]);
    if !python("json") {
        return;
    }
    folder.run("init process --overwrite").ends(0);
    folder.write("swing.csv", Swing::default().csv("t_s,angle_rad"));
    let json = folder.run("tune --sim process.toml --allow-process --observation swing.csv --json").ends(0).json();
    holds(&json, "length", 0.62, 2e-3);
}

/// Pages of the documentation show the programs as they are.
#[test]
fn the_documentation_shows_the_programs_that_are_tested() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/process.md");
    let page = std::fs::read_to_string(page).unwrap();
    for program in [DRIVEN, MUJOCO_CART] {
        assert!(page.contains(program), "docs/process.md differs from assets/process:\n{program}");
        assert!(program.lines().count() <= 40);
    }
}
