//! Files that no reader should trust: too large, not files at all, written to meanwhile, in other encodings and of other
//! kinds. Each is answered at once, in one sentence with a remedy, and with little memory.

use std::io::Write as _;
use std::time::{Duration, Instant};

use crate::common::{Drop, Folder, SCENE, refused};

/// Longest that a refusal may take here, beside other tests.
const AT_ONCE: Duration = Duration::from_secs(5);

/// Refused at once by `tune` and by `inspect`.
#[track_caller]
fn observation(folder: &Folder, name: &str, wanted: &[&str]) {
    let began = Instant::now();
    refused(folder, &format!("tune --sim scene.toml --observation {name} --json --out tuned.toml"), wanted);
    refused(folder, &format!("inspect {name} --json"), wanted);
    assert!(began.elapsed() < 2 * AT_ONCE, "{name} took {:?}", began.elapsed());
}

/// In which order the two bytes of a sign come.
type Bytes = fn(u16) -> [u8; 2];

fn wide(text: &str, mark: bool, bytes: Bytes) -> Vec<u8> {
    mark.then_some('\u{feff}')
        .into_iter()
        .chain(text.chars())
        .collect::<String>()
        .encode_utf16()
        .flat_map(bytes)
        .collect()
}

/// Ten gigabytes cost nothing on a disk that knows holes.
fn sparse(folder: &Folder, name: &str, start: &str) {
    let mut file = std::fs::File::create(folder.path(name)).unwrap();
    file.write_all(start.as_bytes()).unwrap();
    file.set_len(10 << 30).unwrap();
}

#[test]
fn ten_gigabytes_are_refused_with_their_size() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    sparse(&folder, "a.csv", "t_s,z_m\n0,1\n");
    observation(&folder, "a.csv", &["a.csv: expected at most", "found 10737418240", "cut"]);
    sparse(&folder, "b.toml", SCENE);
    refused(&folder, "tune --sim b.toml --observation drop.csv", &["b.toml", "found 10737418240"]);
    sparse(&folder, "c.safetensors", "");
    refused(
        &folder,
        "tune --sim scene.toml --observation drop.csv --model c.safetensors",
        &["c.safetensors", "found 10737418240"],
    );
    sparse(&folder, "d.mcap", "\u{89}");
    observation(&folder, "d.mcap", &["d.mcap", "expected the mark of an MCAP file"]);
}

#[test]
fn lines_without_an_end_are_refused_early() {
    let folder = Folder::with_scene();
    // Below the limit of a text, so that the line itself is what is wrong.
    let file = std::fs::File::create(folder.path("a.csv")).unwrap();
    file.set_len(1000 << 20).unwrap();
    observation(&folder, "a.csv", &["a.csv", "a zero byte in line 1"]);
    folder.write("b.csv", "1,".repeat(2 << 20));
    observation(&folder, "b.csv", &["b.csv", "line 1 is longer than 1048576 bytes"]);
}

/// A header as long as a line may be is told in a few words.
#[test]
fn messages_stay_short() {
    let folder = Folder::with_scene();
    folder.write("a.csv", format!("{},b\n1,2\n", "x".repeat(900_000)));
    let ran = folder.run("tune --sim scene.toml --observation a.csv").ends(1);
    assert!(ran.stderr.len() < 2000, "{} bytes", ran.stderr.len());
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_and_not_waited_for() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    folder.shell("mkfifo a.csv a.toml a.mcap a.safetensors a.xml").ends(0);
    observation(&folder, "a.csv", &["a.csv: expected a file, found a pipe", "> recording.csv"]);
    observation(&folder, "a.mcap", &["a.mcap: expected a file, found a pipe"]);
    for line in [
        "tune --sim a.toml --observation drop.csv",
        "tune --sim scene.toml --observation drop.csv --model a.safetensors",
        "train --data a.mcap --out m.safetensors",
    ] {
        refused(&folder, line, &["expected a file, found a pipe"]);
    }
    refused(&folder, "inspect a.xml", &["a.xml: expected a file, found a pipe"]);
    refused(&folder, "inspect /dev/zero", &["/dev/zero: expected a file, found a device"]);
    let piped = folder.shell("cat drop.csv | $TUNENET inspect /dev/stdin").ends(1);
    assert!(piped.stderr.contains("/dev/stdin: expected a file, found a pipe"), "{}", piped.stderr);
    // A file behind standard input is a file.
    folder.shell("$TUNENET tune --sim scene.toml --observation /dev/stdin < drop.csv").ends(0);
}

#[cfg(unix)]
#[test]
fn a_file_that_may_not_be_read() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with_scene();
    let path = folder.write("a.csv", Drop::default().csv());
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o000)).unwrap();
    if std::fs::File::open(&path).is_ok() {
        eprintln!("skipped: this user may read everything");
        return;
    }
    observation(&folder, "a.csv", &["a.csv: opening failed", "check who may use the file"]);
}

/// Written to from before the first byte is read until after the last.
#[test]
fn a_file_that_grows_while_it_is_read() {
    let folder = Folder::with_scene();
    let path = folder.write("a.csv", "t_s,z_m\n");
    let mut file = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
    let lines: Vec<String> = (0..300_000).map(|i| format!("{i},1\n")).collect();
    file.write_all(lines.concat().as_bytes()).unwrap();
    let mut child = folder
        .command()
        .args(["tune", "--sim", "scene.toml", "--observation", "a.csv", "--json"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut next = 300_000;
    while child.try_wait().unwrap().is_none() {
        writeln!(file, "{next},1").unwrap();
        next += 1;
        std::thread::sleep(Duration::from_millis(1));
    }
    let ran = crate::common::Ran::from(child.wait_with_output().unwrap()).ends(1);
    assert!(ran.stdout.is_empty(), "{}", ran.stdout);
    assert!(ran.stderr.contains("a.csv: the file changed while it was read"), "{}", ran.stderr);
    assert!(ran.stderr.contains("help: wait until the recording has ended"), "{}", ran.stderr);
}

#[test]
fn wide_texts_are_refused_with_the_command_that_converts_them() {
    let folder = Folder::with_scene();
    let table = Drop::default().csv();
    folder.write("drop.csv", &table);
    let cases: [(bool, Bytes, &str); 4] = [
        (true, u16::to_le_bytes, "UTF-16"),
        (true, u16::to_be_bytes, "UTF-16"),
        (false, u16::to_le_bytes, "UTF-16LE"),
        (false, u16::to_be_bytes, "UTF-16BE"),
    ];
    for (mark, bytes, name) in cases {
        let iconv = format!("`iconv -f {name} -t UTF-8 a.csv > utf8_a.csv`");
        folder.write("a.csv", wide(&table, mark, bytes));
        observation(&folder, "a.csv", &["a.csv: expected UTF-8 text, found UTF-16", &iconv]);
        folder.write("a.toml", wide(SCENE, mark, bytes));
        let iconv = format!("`iconv -f {name} -t UTF-8 a.toml > utf8_a.toml`");
        refused(&folder, "tune --sim a.toml --observation drop.csv", &["a.toml: expected UTF-8 text", &iconv]);
        refused(&folder, "inspect a.toml", &["a.toml: expected UTF-8 text", &iconv]);
    }
    folder.write("a.toml", SCENE.replace("[ball]", "# H\u{f6}he\n[ball]").chars().map(|c| c as u8).collect::<Vec<_>>());
    refused(&folder, "inspect a.toml", &["a.toml", "other bytes in line 3", "`iconv -f LATIN1 -t UTF-8"]);
}

/// Every way of writing the same table gives the same answer.
#[test]
fn foreign_ways_of_writing_are_read() {
    let good = Drop::default().csv();
    let semicolons = good.replace(',', ";").replace('.', ",");
    let milliseconds = good.lines().enumerate().fold(String::new(), |text, (i, line)| {
        let (time, rest) = line.split_once(',').unwrap();
        let time = if i == 0 { "t_µs".into() } else { format!("{}", time.parse::<f64>().unwrap() * 1e6) };
        format!("{text}{time},{rest}\n")
    });
    let latin: Vec<u8> = milliseconds.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let folder = Folder::with_scene();
    let answer = |bytes: Vec<u8>| {
        folder.write("a.csv", bytes);
        let json = folder.run("tune --sim scene.toml --observation a.csv --json").ends(0).json();
        json["parameters"]["restitution"]["value"].as_f64().unwrap()
    };
    let expected = answer(good.clone().into_bytes());
    assert!((expected - 0.7).abs() < 1e-3, "{expected}");
    for (what, bytes) in [
        ("Windows line ends", good.replace('\n', "\r\n").into_bytes()),
        ("a mark (BOM)", format!("\u{feff}{good}").into_bytes()),
        ("semicolons and decimal commas", semicolons.clone().into_bytes()),
        ("all three", format!("\u{feff}{}", semicolons.replace('\n', "\r\n")).into_bytes()),
        ("microseconds in UTF-8", milliseconds.into_bytes()),
        ("microseconds in Latin-1", latin),
    ] {
        let found = answer(bytes);
        assert!((found - expected).abs() < 1e-9, "{what}: {found} instead of {expected}");
    }
    let scene = SCENE.replace('\n', "\r\n");
    folder.write("a.csv", good);
    folder.write("scene.toml", format!("\u{feff}{scene}"));
    folder.run("tune --sim scene.toml --observation a.csv").ends(0);
    folder.write("old_mac.csv", Drop::default().csv().replace('\n', "\r"));
    observation(&folder, "old_mac.csv", &["old_mac.csv", "only carriage returns", "tr '\\r' '\\n'"]);
}

#[test]
fn other_kinds_of_files_under_the_name_of_a_table() {
    let folder = Folder::with_scene();
    for (start, wanted) in [
        (&b"PK\x03\x04\x14\0\x08\0"[..], "found a zip archive or a spreadsheet"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "found a picture"),
        (b"\xff\xd8\xff\xe0\0\x10JFIF", "found a picture"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "found an old spreadsheet"),
        (b"\x1f\x8b\x08\0\0\0\0\0", "found a gzip archive"),
        (b"%PDF-1.7\n", "found a PDF document"),
        (b"\0\0\0\x20ftypisom\0\0\x02\0", "found a video"),
        (b"MATLAB 7.3 MAT-file, Platform: GLNXA64", "found a MATLAB file (version 7.3)"),
        (b"\x7fELF\x02\x01\x01\0\0", "found a zero byte in line 1"),
        (b"t_s,z_m\n0,1\n0.1,\0\n", "found a zero byte in line 3"),
    ] {
        folder.write("a.csv", start);
        observation(&folder, "a.csv", &["a.csv: expected", wanted]);
    }
    folder.write("a.csv", "");
    refused(&folder, "tune --sim scene.toml --observation a.csv", &["a.csv: expected a table, found an empty file"]);
    folder.run("inspect a.csv").ends(1);
    folder.write("a.csv", "t_s,z_m\n");
    folder.run("inspect a.csv").ends(1);
}

/// What is no table is named, and where it belongs.
#[test]
fn documents_are_named_instead_of_their_columns() {
    let folder = Folder::with_scene();
    for (name, start, found, remedy) in [
        (
            "a.csv",
            "<?xml version=\"1.0\"?>\n<!-- a, b -->\n<robot name=\"arm\">\n</robot>\n",
            "a URDF",
            "`tunenet init robot --model FILE`",
        ),
        ("a.xml", "<mujoco model=\"arm\">\n</mujoco>\n", "a MuJoCo model", "`tunenet init robot --model FILE`"),
        ("a.json", "{\n  \"fps\": 30,\n  \"rows\": 2\n}\n", "a JSON document", "export the series as CSV"),
        ("a.html", "<!DOCTYPE html>\n<html></html>\n", "an HTML page", "download the file itself"),
        ("README.md", "# Drops\n\nRecorded in May, at 120 Hz.\n", "a Markdown document", "give the recording"),
        ("scene.toml", SCENE, "a TOML file", "--sim"),
    ] {
        folder.write(name, start);
        let wanted = [&format!("{name}: expected a recording, found {found}"), remedy];
        refused(&folder, &format!("tune --sim scene.toml --observation {name}"), &wanted);
        // `inspect` describes a simulation file and a robot's model.
        let described = name.ends_with("toml") || remedy.contains("--model");
        if !described {
            refused(&folder, &format!("inspect {name}"), &wanted);
        }
    }
}

/// A robot's description is no simulation file, and says where it belongs.
#[test]
fn a_urdf_in_place_of_a_simulation_file_is_named() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    folder.write("arm.urdf", "<?xml version=\"1.0\"?>\n<robot name=\"arm\">\n</robot>\n");
    let wanted = ["arm.urdf: expected a simulation file (TOML), found a URDF", "`tunenet init robot --model FILE`"];
    refused(&folder, "tune --sim arm.urdf drop.csv", &wanted);
}

/// A clone without Git LFS leaves a few lines in place of every large file, whatever it is.
#[test]
fn a_git_lfs_pointer_is_named_wherever_it_stands() {
    const POINTER: &str = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2146\nsize 12345\n";
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    for name in ["a.csv", "a.parquet", "a.mcap", "a.toml", "a.safetensors"] {
        folder.write(name, POINTER);
    }
    let wanted = ["a Git LFS pointer", "run `git lfs pull`"];
    observation(&folder, "a.csv", &wanted);
    observation(&folder, "a.parquet", &wanted);
    observation(&folder, "a.mcap", &wanted);
    refused(&folder, "tune --sim a.toml drop.csv", &wanted);
    refused(&folder, "tune --sim scene.toml drop.csv --model a.safetensors", &wanted);
}

/// Where a file grows too large for the disk's rules and nobody listens, the system ends the process.
#[cfg(target_os = "linux")]
#[test]
fn a_kill_in_the_middle_of_writing_leaves_no_temporary_file() {
    use std::os::unix::fs::OpenOptionsExt;
    const O_TMPFILE: i32 = 0o20_200_000;
    let folder = Folder::with_scene();
    let nameless = std::fs::OpenOptions::new().write(true).custom_flags(O_TMPFILE).open(folder.path("."));
    if nameless.is_err() {
        eprintln!("skipped: this disk has no files without a name");
        return;
    }
    folder.write("drop.csv", Drop::default().csv());
    folder.write("long.toml", format!("{SCENE}# {}\n", "a comment that is kept ".repeat(300)));
    folder.write("out.toml", "old");
    let before = folder.names();
    let line = "tune --sim long.toml --observation drop.csv --out out.toml --overwrite";
    let ran = folder.shell(&format!("ulimit -c 0; ulimit -f 4; exec $TUNENET {line}"));
    assert_eq!(ran.code, None, "{}", ran.stderr);
    assert_eq!((folder.names(), folder.read("out.toml")), (before, b"old".to_vec()));
}

/// A log without its end: what there is of it, and that `tune` refuses it, in one voice.
#[test]
fn a_log_that_is_cut_off_is_told_precisely() {
    let folder = Folder::with_scene();
    folder.run("simulate --sim scene.toml --set release.height_m=1 --out whole.mcap").ends(0);
    let whole = folder.read("whole.mcap");
    folder.write("cut.mcap", &whole[..whole.len() * 9 / 10]);
    let ran = folder.run("inspect cut.mcap").ends(1);
    assert!(ran.stdout.contains("unusable ") && !ran.stdout.contains("\nusable "), "{}", ran.stdout);
    for text in
        ["the recording is cut off: ", " messages could be read before", "`tune` refuses", "mcap recover cut.mcap"]
    {
        assert!(ran.stdout.contains(text), "no `{text}` in {}", ran.stdout);
    }
    refused(&folder, "tune --sim scene.toml --observation cut.mcap", &["cut.mcap: the recording is cut off"]);
}

/// The lines that are proposed can be used as they are cut out.
#[test]
fn the_whole_lines_keep_their_header() {
    let folder = Folder::with_scene();
    let mut lines: Vec<String> = Drop::default().csv().lines().map(str::to_owned).collect();
    lines[30] = "x,y,z,w".into();
    folder.write("a.csv", lines.join("\n"));
    let ran = folder.run("inspect a.csv").ends(1);
    let command = ran.stdout.split('`').find(|text| text.starts_with("sed ")).unwrap().to_owned();
    folder.shell(&format!("{command} a.csv > b.csv")).ends(0);
    folder.run("tune --sim scene.toml --observation b.csv").ends(0);
}
