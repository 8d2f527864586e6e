//! Files that cannot be used: each is refused in one sentence that says where, what was expected, what was found and what
//! to try; nothing panics, hangs or is left half-written.

use crate::common::{DROP, Drop, Folder, Noise, SCENE, refused, table};

/// Refused as an observation.
#[track_caller]
fn observation(bytes: impl AsRef<[u8]>, name: &str, wanted: &[&str]) {
    let folder = Folder::with_scene();
    folder.write(name, bytes);
    let line = format!("tune --sim scene.toml --observation {name} --json --out tuned.toml");
    refused(&folder, &line, &[wanted, &[name]].concat());
}

/// Answered with a verdict other than `tuned`.
#[track_caller]
fn verdict(bytes: impl AsRef<[u8]>, wanted: &[&str]) {
    let folder = Folder::with_scene();
    folder.write("a.csv", bytes);
    let ran = folder.run("tune --sim scene.toml --observation a.csv --json --out tuned.toml").ends(3);
    let found = ran.json()["verdict"].as_str().unwrap().to_owned();
    assert!(wanted.contains(&found.as_str()), "{found}: {}", ran.stderr);
    assert!(ran.json()["warnings"].as_array().is_some_and(|w| !w.is_empty()));
}

/// A good record with line `number` (from 1, the header is 1) replaced.
fn with_line(number: usize, text: &str) -> String {
    let good = Drop::default().csv();
    let mut lines: Vec<&str> = good.lines().collect();
    lines[number - 1] = text;
    lines.join("\n")
}

#[test]
fn tables_that_are_none() {
    observation("", "a.csv", &["expected a table, found an empty file"]);
    observation("t_s,x_m,y_m,z_m\n", "a.csv", &["a.csv:1:1", "expected samples after the header, found none"]);
    observation("t_s,z_m\n0,1\n", "a.csv", &["expected at least 3 samples, found 1"]);
    observation("t_s,z_m\n0,1\n1,2\n", "a.csv", &["expected at least 3 samples, found 2"]);
    observation("bounce_time_s\n0.4\n1.1\n", "a.csv", &["expected at least 3 samples, found 2"]);
    observation([0u8, 255, 254, 1, 2, 3, 0, 0], "a.csv", &[]);
    observation("what,ever\n1,2\n2,3\n3,4\n", "a.csv", &["a.csv"]);
}

#[test]
fn cells_that_are_no_numbers() {
    observation(with_line(21, "0.15,0,0,NaN"), "a.csv", &["a.csv:21:10", "expected a finite number, found `NaN`"]);
    observation(with_line(21, "0.15,0,0,inf"), "a.csv", &["a.csv:21:10", "finite"]);
    observation(with_line(21, "0.15,0,0,0.6b31"), "a.csv", &["a.csv:21:10", "found `0.6b31`", "^^^^^^"]);
    observation(with_line(21, "0.15,0,0"), "a.csv", &["a.csv:21", "expected 4 cells, found 3"]);
    observation(with_line(21, "0.01,0,0,1"), "a.csv", &["a.csv:21:1", "the time falls", "found 0.01"]);
    observation(with_line(21, "0.15,0,0,1e300"), "a.csv", &["a.csv:21:10", "expected at most 1e10", "found `1e300`"]);
    observation(with_line(21, "1e300,0,0,1"), "a.csv", &["a.csv:21:1", "expected at most 1e10"]);
}

#[test]
fn impacts_that_are_none() {
    observation("bounce_time_s\n0.4e300\n1e300\n1.5e300\n", "a.csv", &["a.csv:2:1", "expected at most 1e10"]);
    observation("bounce_time_s\n0.4e-300\n1e-300\n1.5e-300\n", "a.csv", &["a.csv:3:1", "hardly rises"]);
    observation("bounce_time_s\n0.4\n1.0\n0.9\n", "a.csv", &["a.csv:4:1", "the bounce time falls"]);
}

#[test]
fn odd_numbers_still_get_an_answer() {
    // Tiny numbers and a ball that lies still.
    verdict("t_s,z_m\n0,1e-300\n1,2e-300\n2,1e-300\n3,3e-300\n4,1e-300\n", &["rejected"]);
    let still: Vec<_> = (0..200).map(|i| (f64::from(i) / 100.0, [0.0, 0.0, 0.5])).collect();
    verdict(table(&still), &["rejected"]);
    let quick: Vec<_> = Drop::default().frames().iter().map(|(t, p)| (t * 1e-300, *p)).collect();
    verdict(table(&quick), &["not_identifiable", "rejected", "poor_fit"]);
    verdict("t_s,z_m\n0,1\n0.01,0.999\n0.02,0.998\n", &["not_identifiable"]);
    let wild: Vec<_> =
        Drop::default().frames().iter().map(|(t, [x, y, z])| (*t, [x * 1e9, y * 1e9, z * 1e9])).collect();
    let folder = Folder::with_scene();
    folder.write("a.csv", table(&wild));
    let ran = folder.run("tune --sim scene.toml --observation a.csv --json");
    assert!(matches!(ran.code, Some(1 | 3)), "{:?}", ran.code);
}

/// Good records in unusual shapes are tuned to.
#[test]
fn unusual_records_are_tuned_to() {
    let good = Drop::default().frames();
    let before: Vec<_> = good.iter().map(|(t, p)| (t - 100.0, *p)).collect();
    let mut twice = good.clone();
    twice.insert(50, good[49]);
    let gap: Vec<_> = good.iter().enumerate().map(|(i, (t, p))| (if i < 60 { *t } else { t + 1000.0 }, *p)).collect();
    let only_z = good.iter().fold("t_s,z_m\n".to_owned(), |text, (t, p)| format!("{text}{t},{}\n", p[2]));
    for (what, text) in [
        ("negative times", table(&before)),
        ("two identical rows", table(&twice)),
        ("a gap of 1000 s", table(&gap)),
        ("only z", only_z),
    ] {
        let folder = Folder::with_scene();
        folder.write("a.csv", text);
        let json = folder.run("tune --sim scene.toml --observation a.csv --json").ends(0).json();
        let found = json["parameters"]["restitution"]["value"].as_f64().unwrap();
        assert!((found - 0.7).abs() < 0.002, "{what}: {found}");
    }
}

#[test]
fn two_million_rows_are_thinned() {
    let folder = Folder::with_scene();
    let drop = Drop { rate_hz: 1e6, frames: 2_000_000, ..Drop::default() };
    folder.write("a.csv", drop.csv());
    let line = "ulimit -v 4000000; exec $TUNENET tune --sim scene.toml --observation a.csv --json";
    let began = std::time::Instant::now();
    let json = folder.shell(line).ends(0).json();
    assert!(began.elapsed().as_secs() < 60, "{:?}", began.elapsed());
    assert!((json["parameters"]["restitution"]["value"].as_f64().unwrap() - 0.7).abs() < 0.001);
    assert!(json["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "samples.thinned"));
}

/// A log with these topics: name, schema, message encoding; each holds 50 messages of JSON or of CDR positions.
fn log(topics: &[(&str, &str, &str)]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut bytes).unwrap();
    for (topic, schema, encoding) in topics {
        let schema = writer.add_schema(schema, "ros2msg", b"text").unwrap();
        let channel_id = writer.add_channel(schema, topic, encoding, &std::collections::BTreeMap::new()).unwrap();
        for i in 0..200u32 {
            let (time, drop) = (f64::from(i) / 100.0, Drop { noise_m: 0.0, ..Drop::default() });
            let nanoseconds = i * 10_000_000;
            let mut data = vec![0, 1, 0, 0];
            data.extend((nanoseconds / 1_000_000_000).to_le_bytes());
            data.extend((nanoseconds % 1_000_000_000).to_le_bytes());
            // An empty frame name with its end mark, then padding to 8 bytes.
            data.extend([1, 0, 0, 0, 0, 0, 0, 0]);
            for value in [0.0, 0.0, drop.height_at(time)] {
                data.extend(f64::to_le_bytes(value));
            }
            let log_time = u64::from(nanoseconds);
            let header = mcap::records::MessageHeader { channel_id, sequence: i, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, &data).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

const POINT: &str = "geometry_msgs/msg/PointStamped";

#[test]
fn logs_that_cannot_be_used() {
    let good = log(&[("/ball", POINT, "cdr")]);
    observation(&good[..good.len() / 2], "a.mcap", &["a.mcap"]);
    observation(&good[..5], "a.mcap", &["a.mcap"]);
    observation("t_s,z_m\n0,1\n", "a.mcap", &["expected the mark of an MCAP file"]);
    observation(log(&[("/chatter", "std_msgs/msg/String", "cdr")]), "a.mcap", &["a.mcap", "/chatter"]);
    observation(log(&[("/ball", POINT, "protobuf")]), "a.mcap", &["/ball", "protobuf"]);
    observation(log(&[("/ball", POINT, "cdr"), ("/other", POINT, "cdr")]), "a.mcap", &["/ball", "/other", "--topic"]);
}

#[test]
fn a_topic_chooses() {
    let folder = Folder::with_scene();
    folder.write("a.mcap", log(&[("/ball", POINT, "cdr"), ("/other", POINT, "cdr")]));
    let line = "tune --sim scene.toml --observation a.mcap --topic";
    let json = folder.run(&format!("{line} /other --json")).ends(0).json();
    assert!((json["parameters"]["restitution"]["value"].as_f64().unwrap() - 0.7).abs() < 1e-4);
    refused(&folder, &format!("{line} /none --json"), &["/none", "/ball", "a.mcap"]);
}

#[test]
fn simulation_files_that_contradict_the_schema() {
    let folder = Folder::new();
    folder.write("drop.csv", Drop::default().csv());
    for (text, wanted) in [
        (SCENE.replace("radius_m", "radius_mm"), &["scene.toml:4:1", "found `ball.radius_mm`", "ball.radius_m,"][..]),
        (SCENE.replace("value = 0.5", "value = 1.7"), &["scene.toml:7:9", "expected 0 to 1, found 1.7", "^^^"]),
        (SCENE.replace("min = 0.0", "min = 2.0"), &["scene.toml:9:7", "expected more than min = 2, found 1"]),
        (SCENE.replace("radius_m = 0.02", "radius_m = -1"), &["scene.toml:4:12", "found -1"]),
        (SCENE.replace("radius_m = 0.02", ""), &["scene.toml", "expected `ball.radius_m`", "found none"]),
        (SCENE.replace("min = 0.0\n", ""), &["scene.toml", "expected `min`", "found none"]),
        (SCENE.replace("kind = \"ball\"", ""), &["scene.toml", "found no `kind`"]),
        (SCENE.replace("\"ball\"", "\"box\""), &["scene.toml:1:8", "found \"box\""]),
        (SCENE.replace('[', "<"), &["scene.toml:3"]),
        (String::new(), &["scene.toml", "found no `kind`"]),
    ] {
        folder.write("scene.toml", text);
        refused(&folder, "tune --sim scene.toml --observation drop.csv --json --out tuned.toml", wanted);
    }
    folder.write("scene.toml", [0xff, 0xfe, 0x00]);
    refused(&folder, "tune --sim scene.toml --observation drop.csv", &["scene.toml"]);
    refused(&folder, "tune --sim none.toml --observation drop.csv", &["none.toml: no such file", "check the path"]);
}

#[test]
fn models_that_do_not_fit() {
    let folder = Folder::with_scene();
    folder.write("drop.toml", DROP);
    folder.write("drop.csv", Drop::default().csv());
    folder.write("bounces.csv", "bounce_time_s\n0.4515\n1.0836\n1.526\n1.836\n2.053\n");
    folder.run("gen ball --preset easy --sim drop.toml --pairs 20 --out pairs.mcap").ends(0);
    folder.run("train --data pairs.mcap --preset paper --out m.safetensors").ends(0);
    let line = "tune --sim drop.toml --observation drop.csv --json --model";
    refused(&folder, &format!("{line} none.safetensors"), &["none.safetensors: no such file", "check the path"]);
    folder.write("text.safetensors", "a text");
    refused(
        &folder,
        &format!("{line} text.safetensors"),
        &["text.safetensors", "found a file that is not safetensors"],
    );
    let whole = folder.read("m.safetensors");
    folder.write("half.safetensors", &whole[..whole.len() / 2]);
    refused(&folder, &format!("{line} half.safetensors"), &["half.safetensors"]);
    refused(&folder, &format!("{line} pairs.mcap"), &["pairs.mcap"]);
    // Trained for the restitution alone, asked for the friction as well, and the other way round.
    let other = ["the model tunes other parameters", "found restitution"];
    refused(&folder, &format!("{line} m.safetensors --set parameters.friction.tune=true"), &other);
    let fixed = "--set parameters.friction.tune=true --set parameters.restitution.tune=false";
    refused(&folder, &format!("{line} m.safetensors {fixed}"), &other);
    // Trained on positions, asked about bounce times.
    let bounces = "tune --sim drop.toml --observation bounces.csv --json --model m.safetensors";
    refused(&folder, bounces, &["the model", "expected", "found"]);
}

#[test]
fn datasets_that_are_none() {
    let folder = Folder::new();
    folder.write("drop.toml", DROP);
    folder.run("gen ball --sim drop.toml --pairs 40 --out pairs.mcap").ends(0);
    refused(&folder, "train --data none.mcap --out m.safetensors", &["none.mcap: no such file", "check the path"]);
    folder.write("text.mcap", "t_s,z_m\n");
    refused(&folder, "train --data text.mcap --out m.safetensors", &["text.mcap", "expected an MCAP file"]);
    folder.write("log.mcap", log(&[("/ball", POINT, "cdr")]));
    refused(&folder, "train --data log.mcap --out m.safetensors", &["log.mcap", "expected a dataset"]);
    let whole = folder.read("pairs.mcap");
    folder.write("half.mcap", &whole[..whole.len() / 2]);
    refused(&folder, "train --data half.mcap --out m.safetensors", &["half.mcap"]);
    refused(&folder, "train --data . --out m.safetensors", &["folder"]);
}

#[test]
fn kinds_that_do_not_go_together() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    folder.write("bounces.csv", "bounce_time_s\n0.4\n1.0\n1.4\n1.7\n");
    folder.write("joints.csv", "t_s,q1_rad,tau1_nm\n0,0,0\n0.1,0.1,1\n0.2,0.2,0\n0.3,0.1,1\n");
    let line = "tune --sim scene.toml --json --observation";
    refused(&folder, &format!("{line} drop.csv bounces.csv"), &["bounces.csv", "expected positions", "drop.csv"]);
    let ran = folder.run(&format!("{line} joints.csv")).ends(1);
    assert!(ran.stderr.contains("joints.csv: ") && ran.stderr.contains("found joint series"), "{}", ran.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_a_broken_pipe_is_none() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    for line in [
        "completions bash",
        "man",
        "init ball --overwrite --json",
        "inspect drop.csv --json",
        "inspect drop.csv",
        "tune --sim scene.toml drop.csv",
        "tune --sim scene.toml drop.csv --each",
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut command = folder.command();
        let ran = crate::common::Ran::from(command.args(line.split(' ')).stdout(full).output().unwrap()).ends(1);
        assert!(ran.stderr.contains("error: standard output: writing failed: "), "{line}: {}", ran.stderr);
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = folder.command();
        let ran = crate::common::Ran::from(command.args(line.split(' ')).stdout(writer).output().unwrap()).ends(0);
        assert!(!ran.stderr.contains("error"), "{line}: {}", ran.stderr);
    }
}

/// A manifest where a recording is asked for is called one.
#[test]
fn a_manifest_is_no_recording() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    folder.write("all.toml", "[[observation]]\nfile = \"drop.csv\"\n");
    refused(
        &folder,
        "tune --sim a.toml --observation all.toml",
        &["found a manifest of 1", "give it with `--manifest`"],
    );
}

#[test]
fn outputs_that_cannot_be_written() {
    let folder = Folder::with_scene();
    folder.write("drop.toml", DROP);
    folder.write("drop.csv", Drop::default().csv());
    folder.run("gen ball --sim drop.toml --pairs 20 --out pairs.mcap").ends(0);
    for line in [
        "tune --sim scene.toml --observation drop.csv --out",
        "gen ball --sim drop.toml --pairs 20 --out",
        "train --data pairs.mcap --preset paper --out",
        "simulate --sim drop.toml --out",
    ] {
        let ending = match line.split(' ').next() {
            Some("tune") => "toml",
            Some("gen") => "mcap",
            Some("train") => "safetensors",
            _ => "csv",
        };
        std::fs::create_dir_all(folder.path(&format!("folder.{ending}"))).unwrap();
        let beyond = format!("none/../../a.{ending}: expected a folder at none before `..`, found none");
        refused(&folder, &format!("{line} none/../../a.{ending}"), &[&beyond]);
        refused(&folder, &format!("{line} none/a.{ending}"), &[&format!("none/a.{ending}"), "make the folder first"]);
        refused(&folder, &format!("{line} folder.{ending}"), &[&format!("folder.{ending}"), "name a file"]);
    }
    for (out, wanted) in
        [("none/../../a", "a folder at none before `..`"), ("drop.csv/a", "a folder at drop.csv, found a file")]
    {
        refused(&folder, &format!("bench preflight --records 1 --out {out}"), &[wanted]);
    }
    refused(
        &folder,
        "tune --sim scene.toml --observation folder.csv",
        &["folder.csv", "found a folder that holds none"],
    );
    refused(&folder, "inspect folder.csv", &["folder.csv"]);
    refused(&folder, "tune --sim folder.csv --observation drop.csv", &["folder.csv"]);
}

/// Files may grow to 2 KiB and no further, which is how a full disk looks to a process.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_what_was_there() {
    let folder = Folder::with_scene();
    folder.write("drop.toml", DROP);
    folder.write("drop.csv", Drop::default().csv());
    folder.write("long.toml", format!("{SCENE}# {}\n", "a comment that is kept ".repeat(300)));
    folder.run("gen ball --sim drop.toml --pairs 20 --out pairs.mcap").ends(0);
    for (line, kept) in [
        ("tune --sim long.toml --observation drop.csv --json --out out.toml", "out.toml"),
        ("gen ball --sim drop.toml --pairs 400 --json --out out.mcap", "out.mcap"),
        ("train --data pairs.mcap --preset paper --json --out out.safetensors", "out.safetensors"),
        ("simulate --sim drop.toml --json --out out.csv", "out.csv"),
        ("simulate --sim drop.toml --json --out other.mcap", "other.mcap"),
    ] {
        folder.write(kept, "old");
        let before = folder.names();
        let ran = folder.shell(&format!("trap '' XFSZ; ulimit -f 4; exec $TUNENET {line} --overwrite")).ends(1);
        assert!(ran.stdout.is_empty(), "{line}: {}", ran.stdout);
        assert!(ran.stderr.contains("too large") && ran.stderr.contains(kept), "{line}: {}", ran.stderr);
        assert_eq!(folder.read(kept), b"old", "{line}");
        // Only what a second run goes on from may be new.
        let documented = [".partial", ".checkpoint"];
        let new: Vec<String> = folder.names().into_iter().filter(|n| !before.contains(n)).collect();
        assert!(new.iter().all(|n| documented.iter().any(|d| n.ends_with(d))), "{line}: {new:?}");
    }
    // With room again the same command succeeds.
    folder.run("gen ball --sim drop.toml --pairs 400 --out out.mcap --overwrite").ends(0);
    assert!(!folder.path("out.mcap.partial").exists());
}

/// Bytes changed, cut, doubled and dropped at random: the answer may be anything but a panic or a hang.
#[test]
fn random_damage_never_panics() {
    let folder = Folder::with_scene();
    folder.write("drop.toml", DROP);
    folder.run("simulate --sim drop.toml --out good.mcap").ends(0);
    let files = [
        ("a.csv", Drop { frames: 60, ..Drop::default() }.csv().into_bytes()),
        ("a.mcap", folder.read("good.mcap")),
        ("a.toml", DROP.as_bytes().to_vec()),
    ];
    let mut draw = Noise(9);
    for round in 0..240 {
        let (name, whole) = &files[round % files.len()];
        let mut bytes = whole.clone();
        for _ in 0..=draw.next() % 4 {
            damage(&mut bytes, &mut draw);
        }
        folder.write(name, &bytes);
        let line = match *name {
            "a.toml" => "tune --sim a.toml --observation good.mcap --json".to_owned(),
            name => format!("tune --sim scene.toml --observation {name} --json"),
        };
        let began = std::time::Instant::now();
        let ran = folder.run(&line);
        assert!(matches!(ran.code, Some(0 | 1 | 3)), "round {round}: {:?} {}", ran.code, ran.stderr);
        assert!(began.elapsed().as_secs() < 10, "round {round} took {:?}", began.elapsed());
    }
}

fn damage(bytes: &mut Vec<u8>, draw: &mut Noise) {
    let mut index = |limit: usize| usize::try_from(draw.next() % limit.max(1) as u64).unwrap();
    if bytes.is_empty() {
        return;
    }
    let at = index(bytes.len());
    let until = (at + 1 + index(40)).min(bytes.len());
    match index(6) {
        0 => bytes[at] ^= 1 << index(8),
        1 => bytes.truncate(at),
        2 => drop(bytes.drain(at..until)),
        3 => {
            let piece = bytes[at..until].to_vec();
            bytes.splice(at..at, piece);
        }
        4 => bytes[at] = b"0123456789.,-eE\n\"[]= "[index(21)],
        _ => {
            let other = index(bytes.len());
            bytes.swap(at, other);
        }
    }
}
