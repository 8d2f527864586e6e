//! Inputs in files of their own: what they decide, where they are named, and that they are not lost.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::time::Duration;

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::common::{Folder, codes, refused};
use crate::process::driven::Driven;
use crate::process::programs::{DRIVEN, DRIVEN_SCENE, python};

const SWING: Driven = Driven { length_m: 0.62, damping_1_s: 0.24, friction_rad_s2: 0.0, start_rad: 0.5, seed: 1 };

/// Rows of numbers without their header.
fn rows(text: &str) -> Vec<Vec<f64>> {
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

/// The driven pendulum with this table of its input, and a recording whose torque stands in `torque.csv`.
fn folder(driven: &Driven, input: &str) -> Folder {
    let folder = Folder::new();
    folder.write("driven_pendulum.py", DRIVEN);
    folder.write("scene.toml", DRIVEN_SCENE.replace("default = 0.0", input));
    let whole = rows(&driven.csv("t_s,angle_rad,torque_nm"));
    let columns = |header: &str, column: usize| {
        let lines = whole.iter().map(|row| format!("{},{}\n", row[0], row[column]));
        format!("{header}\n{}", lines.collect::<String>())
    };
    folder.write("swing.csv", columns("t_s,angle_rad", 1));
    folder.write("torque.csv", columns("t_s,torque_nm", 2));
    folder
}

const FILE: &str = "file = \"torque.csv\"";

#[test]
fn a_file_that_holds_an_input_is_named_with_its_hash() {
    if !python("json") {
        return;
    }
    let folder = folder(&Driven { friction_rad_s2: 0.35, ..SWING }, FILE);
    let hash = hex::encode(Sha256::digest(folder.read("torque.csv")));
    let named = format!("inputs = [{{ file = \"torque.csv\", sha256 = \"{hash}\" }}]");
    for command in ["tune", "diagnose"] {
        let line =
            format!("{command} --sim scene.toml --allow-process swing.csv --out {command}.toml --report page.html");
        folder.run(&format!("{line} --overwrite"));
        let written = folder.text(&format!("{command}.toml"));
        assert!(written.contains(&named), "{command}: no {named} in:\n{written}");
        assert!(folder.text("page.html").contains(&hash), "{command}");
    }
    // One that stands in the recording has no file of its own.
    let alone = "tune --sim scene.toml --allow-process both.csv --set inputs.torque_nm.file=both.csv --out both.toml";
    folder.write("both.csv", SWING.csv("t_s,angle_rad,torque_nm"));
    folder.write("scene.toml", DRIVEN_SCENE);
    folder.run(alone).ends(0);
    folder.run("tune --sim scene.toml --allow-process both.csv --out own.toml").ends(0);
    assert!(folder.text("both.toml").contains("inputs = [") && !folder.text("own.toml").contains("inputs = ["));
}

#[test]
fn a_file_that_holds_an_input_is_never_written_over() {
    let folder = folder(&SWING, FILE);
    folder.write("bare.toml", DRIVEN_SCENE);
    let entry = "[[observation]]\nfile = \"swing.csv\"\ninputs.torque_nm.file = \"torque.csv\"\n";
    folder.write("runs.toml", entry);
    let set = "--sim bare.toml --set inputs.torque_nm.file=torque.csv";
    let before = folder.read("torque.csv");
    for line in [
        "tune --sim scene.toml swing.csv --out torque.csv",
        "tune --sim scene.toml swing.csv --report ./torque.csv",
        "tune --sim scene.toml swing.csv --checkpoint torque.csv",
        &format!("tune {set} swing.csv --report torque.csv"),
        "tune --sim bare.toml --manifest runs.toml --report torque.csv",
        "diagnose --sim scene.toml swing.csv --out torque.csv",
        &format!("diagnose {set} swing.csv --report torque.csv"),
        "diagnose --sim bare.toml --manifest runs.toml --report torque.csv",
        "simulate --sim scene.toml --out torque.csv",
        "simulate --sim scene.toml --inputs swing.csv --out torque.csv",
    ] {
        let wanted = ["torque.csv", "read as an input", "choose another name for --"];
        refused(&folder, &format!("{line} --allow-process --overwrite"), &wanted);
        assert!(folder.read("torque.csv") == before, "{line}");
    }
    folder.write("torque.mcap", "a log");
    let line = "gen process --sim bare.toml --set inputs.torque_nm.file=torque.mcap --out torque.mcap --overwrite";
    refused(&folder, line, &["torque.mcap", "read as an input"]);
    assert_eq!(folder.read("torque.mcap"), b"a log");
}

/// What was answered before another input was recorded is no answer any more.
#[test]
fn answers_one_by_one_are_given_anew_for_another_input() {
    if !python("json") {
        return;
    }
    let folder = folder(&SWING, FILE);
    for command in ["tune", "diagnose"] {
        let line = format!("{command} --sim scene.toml --allow-process swing.csv --each --out-dir {command}");
        let kept = |folder: &Folder| folder.run(&line).stdout.contains("swing.csv: kept");
        assert_eq!([kept(&folder), kept(&folder)], [false, true], "{command}");
        let torque = folder.text("torque.csv");
        folder.write("torque.csv", torque.replace("t_s,torque_nm\n", "t_s,torque_nm\n-0.1,0\n"));
        assert!(!kept(&folder), "{command}");
        folder.write("torque.csv", torque);
    }
}

/// A log of JSON messages about the joint `motor`, each topic with its own clock in s, angle and torque.
fn log(topics: &[(&str, Vec<[f64; 3]>)]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut bytes).unwrap();
    for (topic, rows) in topics {
        let channel_id = writer.add_channel(0, topic, "json", &BTreeMap::new()).unwrap();
        for (sequence, [time_s, angle_rad, torque_nm]) in (0..).zip(rows) {
            let at = Duration::from_secs_f64(*time_s);
            let log_time = u64::try_from(at.as_nanos()).unwrap();
            let message = json!({
                "header": { "stamp": { "sec": at.as_secs(), "nanosec": at.subsec_nanos() } },
                "name": ["motor"], "position": [angle_rad], "effort": [torque_nm],
            });
            let header = mcap::records::MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, message.to_string().as_bytes()).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

#[test]
fn an_input_is_read_from_a_topic_of_a_log() {
    if !python("json") {
        return;
    }
    let input = "file = \"motor.mcap\"\ntopic = \"/motor\"\ncolumn = \"tau1_nm\"";
    let folder = folder(&SWING, input);
    let table = rows(&SWING.csv("t_s,angle_rad,torque_nm"));
    let seen: Vec<[f64; 3]> = table.iter().map(|row| [row[0], row[1], 0.0]).collect();
    let driving: Vec<[f64; 3]> = table.iter().map(|row| [row[0], 0.0, row[2]]).collect();
    folder.write("motor.mcap", log(&[("/other", seen.clone()), ("/motor", driving.clone())]));
    let length = |json: &Value| json["parameters"]["length"]["value"].as_f64().unwrap();
    let tune = |rest: &str| format!("tune --sim scene.toml --allow-process {rest} --json");
    let json = folder.run(&tune("swing.csv --report page.html")).ends(0).json();
    assert!((length(&json) - SWING.length_m).abs() < 2e-3, "{json}");
    assert!(!codes(&json).contains(&"joints.absent"), "{json}");
    assert!(folder.text("page.html").contains(">torque, N\u{b7}m</text>"));
    let found = folder.run("inspect swing.csv --sim scene.toml --json").ends(0).json();
    assert_eq!(found["inputs"][0]["name"], "torque_nm");
    refused(
        &folder,
        &tune("swing.csv --set inputs.torque_nm.topic=/none"),
        &["motor.mcap", "topic `/none` is not there", "/motor"],
    );
    refused(
        &folder,
        &tune("swing.csv --set inputs.torque_nm.column=dq1"),
        &["motor.mcap", "`torque_nm` of the simulation, found", "`tau1_nm`"],
    );

    // The recording and its input may be two topics of one log, or a log and a table.
    let joint = DRIVEN_SCENE.replace("channels = [\"angle_rad\"]", "channels = [\"q1_rad\"]");
    let scene = |input: &str| joint.replace("default = 0.0", input);
    folder.write("scene.toml", scene("topic = \"/motor\"\ncolumn = \"tau1\""));
    folder.write("whole.mcap", log(&[("/swing", seen.clone()), ("/motor", driving)]));
    let whole = tune("whole.mcap --topic /swing");
    let same = folder.run(&whole).ends(0).json();
    assert!((length(&same) - length(&json)).abs() < 1e-4, "{same}");
    folder.write("scene.toml", scene(FILE));
    let same = folder.run(&whole).ends(0).json();
    assert!((length(&same) - length(&json)).abs() < 1e-4, "{same}");
    folder.write("scene.toml", scene("file = \"motor.mcap\""));
    refused(
        &folder,
        &tune("swing.csv --columns q1_rad=angle_rad"),
        &["motor.mcap: several topics", "`topic = \"/motor\"` into the input's table"],
    );

    // Where a log has no such topic, or none of its channels is the input, a default takes its place.
    folder.write("swing.mcap", log(&[("/swing", seen)]));
    let other = whole.replace("whole.mcap", "swing.mcap");
    folder.write("scene.toml", scene("topic = \"/motor\"\ncolumn = \"tau1\""));
    refused(&folder, &other, &["swing.mcap", "topic `/motor` is not there"]);
    for input in ["default = 0.0\ntopic = \"/motor\"", "default = 0.0"] {
        folder.write("scene.toml", scene(input));
        let json = folder.run(&other).json();
        assert!(codes(&json).contains(&"inputs.default"), "{json}");
    }
}
