//! What scripts rely on: JSON keys, one object on standard output, exit codes, and the same bytes for the same seed.

use crate::common::{DROP, Drop, Folder, SCENE};
use serde_json::Value;

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

#[track_caller]
fn has(value: &Value, wanted: &[&str]) {
    let found = keys(value);
    for key in wanted {
        assert!(found.contains(key), "no `{key}` in {found:?}");
    }
}

fn restitution(json: &Value) -> f64 {
    json["parameters"]["restitution"]["value"].as_f64().unwrap()
}

/// What people read goes to standard error, with `--json` and without: nothing else is ever on standard output.
/// Without `--json` the answer is on standard output, with it the object is and nothing else.
#[test]
fn the_answer_is_on_standard_output() {
    let folder = with_drop();
    folder.write("drop.toml", DROP);
    folder.run("gen ball --sim drop.toml --pairs 8 --out p.mcap --shard 0/1").ends(0);
    for line in [
        "tune --sim scene.toml --observation drop.csv",
        "tune --sim scene.toml --observation drop.csv --each",
        "diagnose --sim scene.toml --observation drop.csv",
        "simulate --sim drop.toml --out a.csv",
        "inspect drop.csv",
        "gen ball --sim drop.toml --pairs 2 --out a.mcap",
        "merge p.shard-0-of-1.mcap --out p.mcap",
        "init ball --out new.toml",
        "bench preflight --records 2",
        "bench intervals --drops 1 --quick",
        "bench regions --draws 1 --quick",
    ] {
        let ran = folder.run(line);
        assert!(matches!(ran.code, Some(0 | 3)), "{line}: {}", ran.stderr);
        // What only writes a file answers by it, and says on standard error where it is.
        let writes = ["simulate", "gen", "merge", "init"].iter().any(|command| line.starts_with(command));
        assert!(ran.stdout.is_empty() == writes && !ran.stdout.starts_with('{'), "{line}: {}", ran.stdout);
        assert!(!writes || ran.stderr.lines().any(|note| note.starts_with("wrote ")), "{line}: {}", ran.stderr);
        assert!(
            ["warning[", "error:", "wrote ", "next "].iter().all(|word| !ran.stdout.contains(word)),
            "{line}: {}",
            ran.stdout
        );
        let more = if line.contains("--out") { " --overwrite" } else { "" };
        if !line.starts_with("bench") {
            let quiet = folder.run(&format!("{line}{more} --quiet"));
            assert!(quiet.code == ran.code && quiet.stderr.is_empty(), "{line}: {}", quiet.stderr);
            assert!(quiet.stdout.is_empty() == writes, "{line}: {}", quiet.stdout);
        }
        let json = folder.run(&format!("{line}{more} --json"));
        json.json();
    }
}

#[test]
fn recordings_can_be_given_without_a_flag() {
    let folder = with_drop();
    let answers = |line: &str| {
        let ran = folder.run(line);
        (ran.code, ran.stdout)
    };
    for tool in ["tune", "diagnose"] {
        let flag = answers(&format!("{tool} --sim scene.toml --observation drop.csv -q"));
        assert_eq!(flag, answers(&format!("{tool} --sim scene.toml drop.csv -q")), "{tool}");
        assert_eq!(flag, answers(&format!("{tool} drop.csv --sim scene.toml -q")), "{tool}");
        let none = folder.run(&format!("{tool} --sim scene.toml")).ends(2);
        assert!(none.stderr.contains("RECORDING"), "{}", none.stderr);
    }
    folder.run("tune --sim scene.toml drop.csv -o short.toml").ends(0);
    assert!(folder.path("short.toml").exists());
    let details = folder.run("tune --sim scene.toml drop.csv -v").ends(0);
    assert!(details.stdout.contains("iteration"), "{}", details.stdout);
    folder.run("tune --sim scene.toml drop.csv -v -q").ends(2);
}

fn with_drop() -> Folder {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    folder
}

#[test]
fn tune_has_its_keys() {
    let folder = Folder::with_scene();
    let csv = Drop::default().csv();
    let wider: Vec<String> =
        csv.lines().enumerate().map(|(i, line)| format!("{line},{}", if i == 0 { "warmth_c" } else { "20" })).collect();
    folder.write("drop.csv", wider.join("\n"));
    let ran = folder.run("tune --sim scene.toml --observation drop.csv --json").ends(0);
    let json = ran.json();
    has(&json, &["schema", "verdict", "parameters", "iterations", "gap", "rollouts", "seconds", "warnings"]);
    assert_eq!(json["verdict"], "tuned");
    assert!(json["schema"].is_string() && json["rollouts"].is_u64() && json["seconds"].is_f64());
    assert_eq!(keys(&json["parameters"]), ["restitution"]);
    let found = &json["parameters"]["restitution"];
    has(found, &["value", "unit", "interval95"]);
    assert_eq!(found["unit"], "1");
    let (low, high) = (found["interval95"][0].as_f64().unwrap(), found["interval95"][1].as_f64().unwrap());
    assert!(low < restitution(&json) && restitution(&json) < high);
    assert!((restitution(&json) - 0.7).abs() < 0.001);
    let iterations = json["iterations"].as_array().unwrap();
    for (k, iteration) in iterations.iter().enumerate() {
        assert_eq!(keys(iteration), ["k", "parameters", "rmse"]);
        assert_eq!(iteration["k"], k);
        assert_eq!(keys(&iteration["parameters"]), ["restitution"]);
        assert!(iteration["rmse"].is_f64());
    }
    assert_eq!(keys(&json["gap"]), ["after", "before", "noise_floor", "unit"]);
    assert_eq!(json["gap"]["unit"], "m");
    assert!(json["gap"]["after"].as_f64() < json["gap"]["before"].as_f64());
    // A column was ignored, which is a warning: it stands in the object, and its text on standard error alone.
    let warnings = json["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|w| w["code"] == "columns.ignored" && w["text"].is_string()), "{warnings:?}");
    assert!(ran.stderr.contains("columns.ignored"));
}

#[test]
fn a_model_iterates_as_often_as_asked() {
    let folder = with_drop();
    folder.write("drop.toml", DROP);
    folder.run("gen ball --preset wide --sim drop.toml --pairs 40 --out pairs.mcap").ends(0);
    folder.run("train --data pairs.mcap --preset paper --out model.safetensors").ends(0);
    folder.run("simulate --sim drop.toml --out seen.csv").ends(0);
    let line = "tune --sim drop.toml --observation seen.csv --model model.safetensors --initial restitution=0.2 --json";
    let seven = folder.run(&format!("{line} --iterations 7")).json();
    let iterations = seven["iterations"].as_array().unwrap();
    assert_eq!(iterations.len(), 8, "{iterations:?}");
    assert_eq!(iterations[0]["parameters"]["restitution"], 0.2);
    let clamped = folder.run(&format!("{line} --iterations 7 --clamp")).json();
    for iteration in clamped["iterations"].as_array().unwrap() {
        assert!((0.0..=1.0).contains(&iteration["parameters"]["restitution"].as_f64().unwrap()), "{iteration}");
    }
    let inspected = folder.run("inspect model.safetensors --json").ends(0).json();
    has(&inspected, &["schema", "kind", "preset", "seed", "parameters", "file", "usable", "warnings"]);
}

#[test]
fn the_other_commands_have_theirs() {
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    let simulated = folder.run("simulate --sim drop.toml --out drop.csv --json").ends(0).json();
    has(&simulated, &["schema", "file", "kind", "samples", "warnings"]);
    assert_eq!(simulated["samples"], 200);
    let pairs = folder.run("gen ball --sim drop.toml --pairs 30 --out pairs.mcap --json").ends(0).json();
    has(&pairs, &["schema", "file", "preset", "pairs", "seed", "frames", "warnings"]);
    let trained = folder.run("train --data pairs.mcap --preset paper --out m.safetensors --json").ends(0).json();
    has(
        &trained,
        &["schema", "file", "preset", "seed", "steps", "loss", "validation", "seconds", "device", "warnings"],
    );
    assert_eq!(trained["device"], "cpu");
    let table = folder.run("inspect drop.csv --json").ends(0).json();
    has(&table, &["schema", "file", "usable", "kind", "columns", "rows", "samples", "broken_lines", "warnings"]);
    assert_eq!(table["kind"], "positions");
    let scene = folder.run("inspect drop.toml --json").ends(0).json();
    has(&scene, &["schema", "file", "usable", "kind", "parameters", "warnings"]);
    folder.run("simulate --sim drop.toml --out drop.mcap").ends(0);
    let log = folder.run("inspect drop.mcap --json").ends(0).json();
    has(&log, &["schema", "file", "usable", "kind", "topics", "warnings"]);
    assert_eq!(log["topics"][0]["name"], "/ball/point");
}

#[test]
fn exit_codes_tell_the_four_ends_apart() {
    let folder = with_drop();
    folder.run("tune --sim scene.toml --observation drop.csv").ends(0);
    folder.run("tune --sim scene.toml --observation none.csv --json").ends(1);
    for usage in [
        "tune --sim scene.toml",
        "tune --sim scene.toml --observation drop.csv --set ball.radius=1",
        "tune --sim scene.toml --observation drop.csv --set ball.radius_m=-1",
        "tune --sim scene.toml --observation drop.csv --initial bounce=1",
        "tune --sim scene.toml --observation drop.csv --initial restitution=7",
        "tune --sim scene.toml --observation drop.csv --iterations 0",
        "tune --sim scene.toml --observation drop.csv --columns z_m",
        "tune --sim scene.toml --observation drop.csv --topic /ball",
        "tune --sim scene.toml --observation drop.csv --each --out tuned.toml",
        "simulate --sim scene.toml --out drop.txt",
        "gen ball --pairs 0 --out pairs.mcap",
        "gen ball --preset none --out pairs.mcap",
        "fly",
    ] {
        let ran = folder.run(usage).ends(2);
        assert!(ran.stdout.is_empty() && !ran.stderr.is_empty(), "{usage}");
    }
    folder.write("short.csv", Drop { frames: 30, ..Drop::default() }.csv());
    let short = folder.run("tune --sim scene.toml --observation short.csv --json --out tuned.toml").ends(3);
    assert_eq!(short.json()["verdict"], "not_identifiable");
    assert!(!folder.path("tuned.toml").exists());
}

#[test]
fn each_answers_for_every_file() {
    let folder = with_drop();
    folder.write("bad.csv", "t_s,z_m\n0,1\n");
    folder.write("other.csv", Drop { restitution: 0.4, seed: 2, ..Drop::default() }.csv());
    let ran = folder.run("tune --sim scene.toml --observation drop.csv bad.csv other.csv --each --json").ends(1);
    let json = ran.json();
    let all = json["observations"].as_array().unwrap();
    let files: Vec<&str> = all.iter().map(|o| o["file"].as_str().unwrap()).collect();
    assert_eq!(files, ["drop.csv", "bad.csv", "other.csv"]);
    assert!((restitution(&all[0]) - 0.7).abs() < 0.001 && (restitution(&all[2]) - 0.4).abs() < 0.001);
    assert_eq!(all[1]["error"], "bad.csv: expected at least 3 samples, found 1");
    assert_eq!(ran.stderr.matches("bad.csv").count(), 1, "{}", ran.stderr);
}

#[test]
fn what_simulate_wrote_tunes_back() {
    let folder = Folder::with_scene();
    folder.write("drop.toml", DROP);
    for (name, option) in [("a.csv", ""), ("a.mcap", ""), ("b.csv", "--bounces"), ("b.mcap", "--bounces")] {
        folder.run(&format!("simulate --sim drop.toml --out {name} {option}")).ends(0);
        let line = format!("tune --sim scene.toml --observation {name} --json --out tuned.toml");
        let json = folder.run(&line).ends(0).json();
        assert!((restitution(&json) - 0.7).abs() < 1e-5, "{name}: {json}");
    }
    // The tuned file is a simulation file again.
    folder.run("simulate --sim tuned.toml --set release.height_m=1 --out again.csv").ends(0);
}

#[test]
fn options_reach_the_reader_and_the_scene() {
    let folder = with_drop();
    let foreign = Drop::default().csv().replace("t_s,x_m,y_m,z_m", "time,a,b,height");
    folder.write("foreign.csv", &foreign);
    let mapped = "tune --sim scene.toml --observation foreign.csv --columns t_s=time,z_m=height --json";
    assert!((restitution(&folder.run(mapped).ends(0).json()) - 0.7).abs() < 0.001);
    folder.write("bare.csv", foreign.split_once('\n').unwrap().1);
    let numbered = "tune --sim scene.toml --observation bare.csv --columns t_s=1,z_m=4 --json";
    assert!((restitution(&folder.run(numbered).ends(0).json()) - 0.7).abs() < 0.001);
    // A start far away ends at the same place, and stands in the first iteration.
    let far =
        folder.run("tune --sim scene.toml --observation drop.csv --initial restitution=0.05 --json").ends(0).json();
    assert_eq!(far["iterations"][0]["parameters"]["restitution"], 0.05);
    assert!((restitution(&far) - 0.7).abs() < 0.001);
    // Gravity of the moon does not fit a drop on earth.
    let moon = "tune --sim scene.toml --observation drop.csv --set world.gravity_m_s2=1.62 --json";
    assert_ne!(folder.run(moon).json()["verdict"], "tuned");
}

/// Runs `line` with one and with two threads in two folders; output and files have to agree, `seconds` apart.
fn same_bytes(prepare: impl Fn(&Folder), line: &str, written: &[&str]) {
    let [one, two] = ["1", "2"].map(|threads| {
        let folder = Folder::new();
        prepare(&folder);
        let output = folder.command().env("RAYON_NUM_THREADS", threads).args(line.split_whitespace()).output();
        let mut json = crate::common::Ran::from(output.unwrap()).ends(0).json();
        json.as_object_mut().unwrap().remove("seconds");
        (json.to_string(), written.iter().map(|name| folder.read(name)).collect::<Vec<_>>())
    });
    assert_eq!(one.0, two.0);
    assert!(one.1 == two.1, "{line}: other bytes");
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let scenes = |folder: &Folder| {
        folder.write("drop.toml", DROP);
        folder.write("scene.toml", SCENE);
        folder.write("drop.csv", Drop::default().csv());
    };
    let pairs = |folder: &Folder| {
        scenes(folder);
        folder.run("gen ball --sim drop.toml --pairs 60 --seed 5 --out pairs.mcap").ends(0);
    };
    same_bytes(scenes, "gen ball --sim drop.toml --pairs 300 --seed 4 --out pairs.mcap --json", &["pairs.mcap"]);
    let train = "train --data pairs.mcap --preset paper --seed 6 --out m.safetensors --json";
    same_bytes(pairs, train, &["m.safetensors"]);
    same_bytes(scenes, "tune --sim scene.toml --observation drop.csv --out tuned.toml --json", &["tuned.toml"]);
    same_bytes(scenes, "simulate --sim drop.toml --out a.csv --json", &["a.csv"]);
    same_bytes(scenes, "simulate --sim drop.toml --out a.mcap --json", &["a.mcap"]);
}

/// A build that can use GPUs, on a machine that has one, is free to choose one where it may.
#[test]
fn train_says_where_it_ran() {
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    folder.run("gen ball --sim drop.toml --pairs 30 --out pairs.mcap").ends(0);
    let train = |flags: &str| folder.run(&format!("train --data pairs.mcap --preset paper --json {flags}"));
    assert_eq!(train("--device cpu --out cpu.safetensors").ends(0).json()["device"], "cpu");
    let auto = train("--device auto --out auto.safetensors").ends(0).json();
    if auto["device"] == "cuda" {
        return println!("skipped: a GPU is at hand");
    }
    assert_eq!(auto["device"], "cpu");
    assert_eq!(folder.read("auto.safetensors"), folder.read("cpu.safetensors"));
    let told = "train --data pairs.mcap --preset paper --device auto --out told.safetensors";
    let told = folder.run(told).ends(0).stdout;
    assert!(told.contains(" for restitution on the CPU, loss "), "{told}");
    // Before anything else is looked at, and with the way out.
    let refused = folder.run("train --data none.mcap --device cuda --out cuda.safetensors");
    if refused.stderr.contains("expected a GPU") {
        refused.ends(1);
        return println!("skipped: this build can use GPUs, and none is at hand");
    }
    let refused = refused.ends(2);
    for words in ["`device`: expected `cpu` or `auto`", "found `cuda`", "--features cuda`"] {
        assert!(refused.stderr.contains(words), "{}", refused.stderr);
    }
    assert_eq!(refused.stderr.lines().count(), 2, "{}", refused.stderr);
}

#[test]
fn another_seed_gives_another_dataset() {
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    for seed in [1, 2] {
        folder.run(&format!("gen ball --sim drop.toml --pairs 5 --seed {seed} --out {seed}.mcap")).ends(0);
    }
    assert_ne!(folder.read("1.mcap"), folder.read("2.mcap"));
}
