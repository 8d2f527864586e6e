//! Robots whose joints are looked for in a recording: a table in its own words, and a log whose commands have a topic of their own.

use std::collections::BTreeMap;
use std::io::Cursor;

use serde_json::{Value, json};

use super::models;
use crate::common::Folder;

/// Times, both positions and both commands, of a rollout of the two hinges.
fn rolled_out(folder: &Folder) -> Vec<[f64; 5]> {
    folder.run("simulate --sim robot.toml --inputs commands.csv --set record.frames=300 --set parameters.elbow__viscous.value=0.5 \
                --out seen.csv").ends(0);
    let numbers = |text: String| -> Vec<Vec<f64>> {
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
    };
    let (seen, given) = (numbers(folder.text("seen.csv")), numbers(folder.text("commands.csv")));
    seen.iter().zip(&given).map(|(seen, given)| [seen[0], seen[1], seen[2], given[1], given[2]]).collect()
}

/// Times in s, and a number for each joint.
type Rows = Vec<(f64, Vec<f64>)>;

/// A log of joint states in JSON: topic, names of the joints, and their positions at each time.
fn log(topics: &[(&str, &[&str], Rows)]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut bytes).unwrap();
    let mut channels = BTreeMap::new();
    let mut messages = Vec::new();
    for (topic, names, rows) in topics {
        let channel =
            *channels.entry(*topic).or_insert_with(|| writer.add_channel(0, topic, "json", &BTreeMap::new()).unwrap());
        messages.extend(rows.iter().map(|(time_s, position)| (*time_s, channel, *names, position)));
    }
    messages.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (sequence, (time_s, channel_id, names, position)) in (0..).zip(messages) {
        let message = json!({ "timestamp": time_s, "name": names, "position": position });
        let log_time = std::time::Duration::from_secs_f64(time_s).as_nanos().try_into().unwrap();
        let header = mcap::records::MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, message.to_string().as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

fn tuned(json: &Value) -> f64 {
    json["parameters"]["elbow__viscous"]["value"].as_f64().unwrap_or_else(|| panic!("{json}"))
}

#[test]
fn a_table_in_its_own_words_and_in_degrees_is_read_as_one_of_ours() {
    let folder = models::folder();
    let rows = rolled_out(&folder);
    let row = |row: &[f64; 5]| {
        let [t, q1, q2, u1, u2] = *row;
        let [q1, q2, u1, u2] = [q1, q2, u1, u2].map(f64::to_degrees);
        format!("{t},{q1},{u1},{q2},{u2},25\n")
    };
    let header = "time,shoulder.pos_deg,cmd_shoulder_deg,q_elbow,elbow_target,elbow_temperature\n".to_owned();
    folder.write("own.csv", std::iter::once(header).chain(rows.iter().map(row)).collect::<String>());
    let ran = folder.run("init robot --model two.xml --from own.csv --out own.toml").ends(0);
    for part in ["shoulder: shoulder.pos_deg, commands cmd_shoulder_deg", "elbow: q_elbow, commands elbow_target"] {
        assert!(ran.stderr.contains(part), "{}", ran.stderr);
    }
    let columns = "--columns t_s=time,elbow_UNIT=q_elbow,elbow_goal_UNIT=elbow_target";
    assert!(ran.stderr.contains(&format!("own.csv {columns} --out")), "{}", ran.stderr);
    let own = |columns: &str| folder.run(&format!("tune --sim own.toml own.csv {columns} --quick --json"));
    let found = own(&columns.replace("UNIT", "deg")).ends(0).json();
    folder.run("init robot --model two.xml --from seen.csv --out ours.toml").ends(0);
    let expected = folder.run("tune --sim ours.toml seen.csv --quick --json").ends(0).json();
    assert!((tuned(&found) - tuned(&expected)).abs() < 1e-6, "{found}");
    assert!((tuned(&found) - 0.5).abs() < 0.05, "{found}");
}

#[test]
fn a_column_of_switches_releases_the_motors() {
    let folder = models::folder();
    let row =
        |[t, q1, q2, u1, u2]: [f64; 5]| format!("{t},{q1},{q2},{u1},{u2},{}\n", if t < 2.0 { "True" } else { "False" });
    let header = "t_s,shoulder_rad,elbow_rad,shoulder_goal_rad,elbow_goal_rad,Torque Enable\n".to_owned();
    folder
        .write("own.csv", std::iter::once(header).chain(rolled_out(&folder).into_iter().map(row)).collect::<String>());
    let ran = folder.run("init robot --model two.xml --from own.csv --out own.toml --json").ends(0);
    assert!(ran.stderr.contains("motors   released where Torque Enable is 0"), "{}", ran.stderr);
    assert_eq!(ran.json()["switch"], json!({ "column": "Torque Enable", "topic": null }));
    let text = folder.text("own.toml");
    assert!(text.contains("column = \"Torque Enable\"\ndefault = 1.0"), "{text}");
    assert_eq!(text.matches("enable = \"torque_on\"").count(), 2, "{text}");
    let read = folder.run("tune --sim own.toml own.csv --quick --max-rollouts 40 --json").json();
    assert!(read["verdict"].is_string() && !read.to_string().contains("columns.ignored"), "{read}");
}

/// A gripper's driver publishes on the topic of the arm as well, and its message may come first.
#[test]
fn commands_are_found_in_their_own_topic_by_the_names_of_joints() {
    let folder = models::folder();
    let rows = rolled_out(&folder);
    let at = |from: usize| rows.iter().map(|row| (1.0 + row[0], row[from..from + 2].to_vec())).collect::<Vec<_>>();
    let grip = rows.iter().map(|row| (0.9995 + row[0], vec![0.01])).collect::<Vec<_>>();
    let joints = ["shoulder", "elbow"];
    let topics: [(&str, &[&str], _); 3] =
        [("/joint_states", &["grip"], grip), ("/joint_states", &joints, at(1)), ("/arm/commands", &joints, at(3))];
    folder.write("arm.mcap", log(&topics));
    let ran = folder.run("init robot --model two.xml --from arm.mcap --out arm.toml").ends(0);
    let said = "shoulder: position.shoulder of /joint_states, commands position.shoulder of /arm/commands";
    assert!(ran.stderr.contains(said) && ran.stderr.contains("arm.mcap --topic /joint_states --out"), "{}", ran.stderr);
    let text = folder.text("arm.toml");
    assert!(text.contains("topic = \"/arm/commands\"\ncolumn = \"position.elbow\""), "{text}");
    let read = |sim: &str| {
        folder.run(&format!("tune --sim {sim} arm.mcap --topic /joint_states --quick --json")).ends(0).json()
    };
    assert!((tuned(&read("arm.toml")) - 0.5).abs() < 0.05);
    // A file that says nothing of topics finds the commands by the joints' names.
    let named = read("robot.toml");
    assert!((tuned(&named) - 0.5).abs() < 0.05, "{named}");
    let refused = folder.run("init robot --model two.xml --from arm.mcap --topic /nothing --out other.toml").ends(2);
    assert!(refused.stderr.contains("`--topic`: expected a topic with numbers"), "{}", refused.stderr);
}

/// Drivers that publish one joint each on one topic: those of one message are taken, and the others named.
#[test]
fn joints_in_messages_of_their_own_are_held_and_named() {
    let folder = models::folder();
    let rows = rolled_out(&folder);
    let at =
        |after: f64, from: usize| rows.iter().map(|row| (1.0 + after + row[0], vec![row[from]])).collect::<Vec<_>>();
    let commands = rows.iter().map(|row| (1.0 + row[0], row[3..5].to_vec())).collect::<Vec<_>>();
    let topics: [(&str, &[&str], _); 3] = [
        ("/joint_states", &["elbow"], at(0.0, 2)),
        ("/joint_states", &["shoulder"], at(0.0003, 1)),
        ("/arm/commands", &["shoulder", "elbow"], commands),
    ];
    folder.write("two.mcap", log(&topics));
    let ran = folder.run("init robot --model two.xml --from two.mcap --out arm.toml").ends(0);
    let text = "joints that stand in other messages of /joint_states than most are held at 0: `shoulder`";
    assert!(ran.stderr.contains(text), "{}", ran.stderr);
    assert!(!folder.text("arm.toml").contains("[joints.shoulder]"));
    let read = folder.run("tune --sim arm.toml two.mcap --topic /joint_states --quick --max-rollouts 40");
    assert!(read.stderr.contains("read     two.mcap, 300 samples"), "{}", read.stderr);
}

#[test]
fn a_column_that_stands_twice_is_refused() {
    let folder = models::folder();
    let text = "t_s,shoulder_rad,elbow_rad,shoulder_goal_rad,elbow_goal_rad,elbow_rad\n";
    let rows = (0..9).map(|i| format!("{},0,0,0,0,1\n", f64::from(i) / 10.0));
    folder.write("twice.csv", std::iter::once(text.to_owned()).chain(rows).collect::<String>());
    let refused = folder.run("tune --sim robot.toml twice.csv").ends(1).stderr;
    assert!(refused.contains("expected one column `elbow_rad`, found two: columns 3 and 6"), "{refused}");
}
