//! Logs of robots, from the command line: what `inspect` says of a data set, and a tuning to its episodes.

use std::path::Path;

use serde_json::Value;

use crate::common::Folder;

/// A joint that follows its command with a lag.
const FOLLOWING: &str = r#"
kind = "equations"
[states.a_rad]
[start.a_rad]
value = "first"
[derivatives]
a_rad = "(goal_rad - a_rad) / lag"
[inputs.goal_rad]
column = "action.a"
[parameters.lag]
value = 0.1
min = 0.01
max = 1.0
unit = "s"
"#;

/// The data set that is a seed of the fuzz target: what describes it and, behind a NUL, its only file.
fn data_set(folder: &Folder) {
    let seed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/lerobot/v3_0");
    let bytes = std::fs::read(seed).unwrap();
    let split = bytes.iter().position(|byte| *byte == 0).unwrap();
    for part in ["set/meta", "set/data/chunk-000"] {
        std::fs::create_dir_all(folder.path(part)).unwrap();
    }
    folder.write("set/meta/info.json", &bytes[..split]);
    folder.write("set/data/chunk-000/file-000.parquet", &bytes[split + 1..]);
}

#[test]
fn a_data_set_is_listed_with_units_that_have_to_be_said() {
    let folder = Folder::new();
    data_set(&folder);
    folder.write("a.toml", FOLLOWING);
    let listed = folder.run("inspect set --json").ends(0).json();
    assert_eq!((&listed["kind"], &listed["format"]), (&Value::from("episodes"), &Value::from("LeRobot v3.0")));
    let columns = listed["columns"].as_array().unwrap();
    let names: Vec<&str> = columns.iter().map(|column| column["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["a", "b", "action.a", "action.b"]);
    let refused = folder.run("tune --sim a.toml set --json").ends(1);
    assert!(refused.stderr.contains("the unit of `a` is not stated"), "{}", refused.stderr);
    assert!(refused.stderr.contains("--units"), "{}", refused.stderr);
    let named = folder.run("inspect set/episode_0 --sim a.toml --units deg --json").ends(0).json();
    assert_eq!(named["usable"], true);
    let absent = folder.run("tune --sim a.toml set --episodes 3-4 --units deg").ends(1);
    assert!(absent.stderr.contains("found 3-4"), "{}", absent.stderr);
    // A command that differs from its joint by a constant has no lag that could be found; the recording is read.
    let tuned = folder.run("tune --sim a.toml set --episodes 0 --units deg --json");
    assert!(tuned.json()["verdict"].is_string(), "{}", tuned.stderr);
}

/// 2048 counts over 200 units are 0.9° for each.
#[test]
fn a_calibration_file_states_the_units_of_its_joints() {
    let folder = Folder::new();
    data_set(&folder);
    folder.write("a.toml", FOLLOWING);
    folder.write("robot.json", r#"{"a": {"id": 1, "range_min": 1000, "range_max": 3048}}"#);
    let listed = folder.run("inspect set --calibration robot.json --units b=rad --json").ends(0).json();
    let units: Vec<Value> = listed["columns"].as_array().unwrap().iter().map(|c| c["unit"].clone()).collect();
    assert_eq!(units, ["0.900000deg", "rad", "0.900000deg", "rad"]);
    let shown = folder.run("inspect set --calibration robot.json").ends(0).stdout;
    assert!(shown.contains("the calibration file: -100 to 100 are 2048 counts"), "{shown}");
    // What is typed counts more than the file.
    let both = folder.run("inspect set --calibration robot.json --units a=rad --json").ends(0).json();
    assert_eq!(both["columns"][0]["unit"], "rad");
    let stated = folder.run("tune --sim a.toml set --calibration robot.json --json");
    assert!(stated.json()["verdict"].is_string(), "{}", stated.stderr);
    folder.write("other.json", r#"{"wrist": {"range_min": 1000, "range_max": 3048}}"#);
    let refused = folder.run("tune --sim a.toml set --calibration other.json").ends(2).stderr;
    assert!(refused.contains("`--calibration`: expected one of the columns `a`, `b`"), "{refused}");
    folder.write("broken.json", r#"{"a": {"id": 1}}"#);
    let refused = folder.run("tune --sim a.toml set --calibration broken.json").ends(1).stderr;
    assert!(refused.contains("broken.json: expected a calibration file of LeRobot"), "{refused}");
    folder.write("drop.csv", "t_s,z_m\n0,1\n0.1,0.9\n0.2,0.8\n");
    let refused = folder.run("inspect drop.csv --calibration robot.json").stdout;
    assert!(refused.contains("unusable `--calibration`: expected a data set of LeRobot"), "{refused}");
}

#[test]
fn what_drives_a_simulation_is_read_as_recordings_are() {
    let folder = Folder::new();
    data_set(&folder);
    folder.write("a.toml", FOLLOWING);
    folder.write("m.toml", "[[observation]]\nfile = \"set/episode_0\"\n");
    for given in ["--manifest m.toml --out out", "--inputs set/episode_0 --out out.csv"] {
        let refused = folder.run(&format!("simulate --sim a.toml {given}")).ends(1);
        assert!(refused.stderr.contains("--units"), "{}", refused.stderr);
        folder.run(&format!("simulate --sim a.toml {given} --units deg")).ends(0);
    }
    let gen_few = "gen equations --sim a.toml --manifest m.toml --pairs 2 --out pairs.mcap";
    assert!(folder.run(gen_few).ends(1).stderr.contains("--units"));
    folder.run(&format!("{gen_few} --units deg")).ends(0);
    let refused = folder.run("gen equations --sim a.toml --units deg --pairs 2 --out other.mcap").ends(2);
    assert!(refused.stderr.contains("expected a recording that drives the simulation"), "{}", refused.stderr);
    let columns = folder.text("out/episode_0.csv");
    assert!(columns.starts_with("t_s,a_rad,action.a\n"), "{}", columns.lines().next().unwrap_or_default());
    folder.write("ball.toml", "kind = \"ball\"\n[ball]\nradius_m = 0.02\n[release]\nheight_m = 1.0\n");
    let refused = folder.run("simulate --sim ball.toml --units deg --out drop.csv").ends(2);
    assert!(
        refused.stderr.contains("`--units`: expected a recording that drives the simulation"),
        "{}",
        refused.stderr
    );
}

#[test]
fn a_folder_without_a_recording_says_what_it_may_be() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("set")).unwrap();
    let said = folder.run("inspect set").ends(1).stderr;
    assert!(said.contains("found a folder that holds none (ROS 2 bag, LeRobot data set)"), "{said}");
}
