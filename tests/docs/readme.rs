//! The tables of docs/, held against the tool and the sources. Commands are those of `documented.rs`, links of `links.rs`.

use std::fmt::Write as _;
use std::process::Command;

use super::page::{root, text};
use tunenet_sim::shot::task::TASK_KEYS;
use tunenet_sim::simulation_file::schema::{BALL_KEYS, EFFECT_KEYS, Key, PARAMETER_KEYS};
use tunenet_sim::simulation_file::{
    ARM_EFFECT_KEYS, ARM_KEYS, CANDIDATE_KEYS, COEFFICIENT_KEYS, EQUATIONS_KEYS, EQUATIONS_TABLES, FORMULA_KEYS,
    INPUT_KEYS, PROCESS_EFFECT_KEYS, PROCESS_KEYS, ROBOT_EFFECT_KEYS, ROBOT_KEYS, ROBOT_TABLES, START_KEYS,
};

/// The rows that docs/files.md must hold for these keys.
fn rows(keys: &[Key]) -> String {
    let mut table = String::from("| key | value | needed | meaning |\n|---|---|---|---|\n");
    for key in keys {
        let needed = if key.required { "yes" } else { "no" };
        let meaning = key.meaning.replace('|', "\\|");
        writeln!(table, "| `{}` | {} | {needed} | {meaning} |", key.path, key.shape.expected()).unwrap();
    }
    table
}

#[test]
fn the_keys_of_a_simulation_file_are_those_of_the_schema() {
    let mut page = text("docs/files.md");
    let write = std::env::var_os("TUNENET_DOCS_WRITE").is_some();
    let equations = [EQUATIONS_KEYS, EQUATIONS_TABLES].concat();
    let robot = [ROBOT_KEYS, &ROBOT_TABLES[..]].concat();
    let all: [(&str, &[Key]); 16] = [
        ("keys", BALL_KEYS),
        ("arm", ARM_KEYS),
        ("effects", &EFFECT_KEYS),
        ("arm effects", &ARM_EFFECT_KEYS),
        ("process", PROCESS_KEYS),
        ("equations", &equations),
        ("robot", &robot),
        ("robot effects", &ROBOT_EFFECT_KEYS),
        ("process effects", &PROCESS_EFFECT_KEYS),
        ("inputs", INPUT_KEYS),
        ("start", START_KEYS),
        ("candidates", CANDIDATE_KEYS),
        ("formulas", FORMULA_KEYS),
        ("coefficients", COEFFICIENT_KEYS),
        ("parameters", PARAMETER_KEYS),
        ("task", TASK_KEYS),
    ];
    for (name, keys) in all {
        let (begin, end) = (format!("<!-- {name}: begin -->\n"), format!("<!-- {name}: end -->"));
        let found = page.split_once(&begin).and_then(|(_, rest)| rest.split_once(&end));
        let found = found.unwrap_or_else(|| panic!("docs/files.md lacks its mark `{name}`")).0.to_owned();
        let expected = rows(keys);
        if write {
            page = page.replace(&format!("{begin}{found}{end}"), &format!("{begin}{expected}{end}"));
            std::fs::write(root().join("docs/files.md"), &page).unwrap();
            continue;
        }
        assert!(found == expected, "docs/files.md should hold between its marks `{name}`:\n{expected}");
    }
}

#[test]
fn every_key_of_the_json_is_in_the_docs() {
    let (page, folder) = (text("docs/json.md"), tempfile::tempdir().unwrap());
    let assets = root().join("assets");
    let at = |name: &str| assets.join(name).display().to_string();
    let out = folder.path().join("drop.mcap").display().to_string();
    let (scene, drop, throw) = (at("ball.toml"), at("observations/drop.csv"), at("observations/throw.csv"));
    let light: Vec<String> = (1..=5).map(|i| at(&format!("observations/light_{i}.csv"))).collect();
    let shot = at("shot.toml");
    let runs: [&[&str]; 10] = [
        &["plan", "--sim", &scene, "--task", &shot],
        &["diagnose", "--sim", &scene, "--observation", &light[0], &light[1], &light[2], "--held-out", &light[4]],
        &["tune", "--sim", &scene, "--observation", &drop],
        &["tune", "--sim", &scene, "--set", "parameters.friction.tune=true", "--observation", &throw],
        &["tune", "--sim", &scene, "--observation", &drop, "--each"],
        &["simulate", "--sim", &scene, "--set", "release.height_m=1", "--out", &out],
        &["inspect", &out],
        &["inspect", &scene],
        &["inspect", &drop],
        &["inspect", &drop, &throw],
    ];
    for arguments in runs {
        let output = Command::new(env!("CARGO_BIN_EXE_tunenet"))
            .args(arguments)
            .arg("--json")
            .env("TUNENET_CACHE", folder.path().join("cache"))
            .output()
            .unwrap();
        let object: serde_json::Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{arguments:?}: {e}"));
        listed(&object, &page, arguments);
    }
}

/// Every key below `value` stands in `page`; the names of parameters are data, not keys.
fn listed(value: &serde_json::Value, page: &str, arguments: &[&str]) {
    match value {
        serde_json::Value::Object(object) => {
            for (key, inner) in object {
                let data = ["restitution", "friction", "c_1_m"].contains(&key.as_str());
                let word = |text: &str| text.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == key);
                assert!(data || word(page), "docs/json.md does not list `{key}` of {arguments:?}");
                listed(inner, page, arguments);
            }
        }
        serde_json::Value::Array(all) => all.iter().for_each(|inner| listed(inner, page, arguments)),
        _ => {}
    }
}

/// The picture at the head of the README is what its script draws with this tool.
#[test]
fn the_picture_is_drawn_by_its_script() {
    let folder = tempfile::tempdir().unwrap();
    let drawn = folder.path().join("drop.svg");
    let script = root().join("docs/make_picture.py");
    let run = Command::new("python3").arg(script).arg(env!("CARGO_BIN_EXE_tunenet")).arg(&drawn).output();
    let Ok(run) = run else {
        println!("skipped: no python3");
        return;
    };
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    assert_eq!(std::fs::read_to_string(drawn).unwrap(), text("docs/drop.svg"), "docs/drop.svg is older");
}
