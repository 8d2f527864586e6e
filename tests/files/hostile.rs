//! Files, names and surroundings that mean harm, or are an accident: stray stamps, chunks that unpack to gigabytes, names that a
//! shell would run, a full disk behind standard error.

use std::fmt::Write as _;

use crate::common::{Drop, Folder, SCENE, codes, refused};

fn tuned(folder: &Folder, name: &str) -> serde_json::Value {
    folder.run(&format!("tune --sim scene.toml {name} --json")).ends(0).json()
}

/// Bounce times whose intervals shrink by `ratio`.
fn bounces(count: usize, ratio: f64) -> String {
    let (mut time_s, mut interval_s) = (0.5, 1.0);
    let mut text = String::from("bounce_time_s\n");
    for _ in 0..count {
        writeln!(text, "{time_s:.9}").unwrap();
        (time_s, interval_s) = (time_s + interval_s, interval_s * ratio);
    }
    text
}

#[cfg(target_os = "linux")]
#[test]
fn standard_error_that_cannot_be_written_changes_nothing() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    for (line, out) in [
        ("tune --sim scene.toml drop.csv -o NAME.toml --report NAME.html", &["toml", "html"][..]),
        ("simulate --sim scene.toml --set release.height_m=1 --out NAME.csv", &["csv"]),
        ("inspect drop.csv", &[]),
    ] {
        let plain = folder.shell(&format!("$TUNENET {}", line.replace("NAME", "a"))).ends(0);
        let full = folder.shell(&format!("$TUNENET {} 2>/dev/full", line.replace("NAME", "b"))).ends(0);
        assert_eq!(plain.stdout, full.stdout);
        for ending in out {
            assert!(!folder.read(&format!("b.{ending}")).is_empty());
        }
    }
    // A refusal keeps its status where nobody can read why.
    folder.shell("$TUNENET tune --sim scene.toml none.csv 2>/dev/full").ends(1);
}

#[test]
fn a_stray_stamp_is_set_aside_and_said() {
    let folder = Folder::with_scene();
    let good = Drop::default().csv();
    folder.write("good.csv", &good);
    let restitution = |json: &serde_json::Value| json["parameters"]["restitution"]["value"].as_f64().unwrap();
    let expected = restitution(&tuned(&folder, "good.csv"));
    let (header, rows) = good.split_once('\n').unwrap();
    let first = rows.lines().next().unwrap();
    let columns = first.split_once(',').unwrap().1;
    folder.write("stray.csv", format!("{header}\n-1e9,{columns}\n{rows}"));
    let json = tuned(&folder, "stray.csv");
    assert!(codes(&json).contains(&"clock.jump"), "{json}");
    assert!((restitution(&json) - expected).abs() < 1e-9);
    // The clock is set after the first frame: the others keep their digits.
    let mut late = format!("{header}\n");
    for (i, row) in rows.lines().enumerate() {
        let (time, rest) = row.split_once(',').unwrap();
        let time_s: f64 = time.parse().unwrap();
        writeln!(late, "{:.6},{rest}", if i == 0 { 0.0 } else { time_s + 1.7e9 }).unwrap();
    }
    folder.write("late.csv", late);
    let json = tuned(&folder, "late.csv");
    assert!(codes(&json).contains(&"clock.jump"));
    assert!((restitution(&json) - expected).abs() < 1e-3);
}

#[test]
fn an_offset_of_a_planet_is_refused() {
    let folder = Folder::with_scene();
    let mut far = String::from("t_s,z_m\n");
    for row in Drop::default().csv().lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let height_m: f64 = cells[cells.len() - 1].parse().unwrap();
        writeln!(far, "{},{}", cells[0], height_m + 1e9).unwrap();
    }
    folder.write("far.csv", far);
    refused(
        &folder,
        "tune --sim scene.toml far.csv",
        &["far.csv: expected positions within 1e8 m", "subtract the offset"],
    );
}

#[test]
fn impacts_are_counted_in_whole_numbers_and_not_without_end() {
    let folder = Folder::with_scene();
    folder.write("half.csv", "bounce_number,bounce_time_s\n0.5,0\n1.5,1\n2.5,1.8\n3.5,2.44\n");
    refused(
        &folder,
        "tune --sim scene.toml half.csv",
        &["half.csv:2:1", "expected a whole bounce number", "found 0.5"],
    );
    folder.write("far.csv", "bounce_number,bounce_time_s\n0,0\n1,1\n1000000000,1.8\n");
    refused(
        &folder,
        "tune --sim scene.toml far.csv",
        &["far.csv:4:1", "expected a whole bounce number from 0 to 9999"],
    );
    folder.write("long.csv", bounces(200_000, 1.0));
    let json = tuned(&folder, "long.csv");
    assert!(codes(&json).contains(&"bounces.many"));
    // A metronome.
    assert!(codes(&json).contains(&"bounces.even"));
    folder.write("ball.csv", bounces(40, 0.9));
    assert!(!codes(&tuned(&folder, "ball.csv")).contains(&"bounces.even"));
}

#[test]
fn texts_of_settings_have_a_size() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    folder.write("big.toml", format!("{SCENE}x = [{}1]\n", "1,".repeat(5_000_000)));
    refused(&folder, "tune --sim big.toml drop.csv", &["big.toml: expected a text of at most 8388608 bytes"]);
    refused(&folder, "diagnose --sim scene.toml --manifest big.toml", &["big.toml: expected a text of at most"]);
}

#[cfg(unix)]
#[test]
fn names_are_quoted_in_suggested_commands_and_shown_in_one_line() {
    let folder = Folder::with_scene();
    let good = Drop::default().csv();
    let wide: Vec<u8> = good.encode_utf16().flat_map(u16::to_le_bytes).collect();
    folder.write("a b;touch pwned.csv", [&[0xff, 0xfe][..], &wide].concat());
    let ran = folder.shell("$TUNENET tune --sim scene.toml 'a b;touch pwned.csv'").ends(1);
    assert!(
        ran.stderr.contains("iconv -f UTF-16 -t UTF-8 'a b;touch pwned.csv' > 'utf8_a b;touch pwned.csv'"),
        "{}",
        ran.stderr
    );
    // A name with an end of line and an escape sequence forges no line, on no stream and in no page.
    folder.write("a\nTUNED\u{1b}[31m\u{202e}.csv", &good);
    let name = "\"$(printf 'a\\nTUNED\\033[31m\\342\\200\\256.csv')\"";
    let ran = folder.shell(&format!("$TUNENET tune --sim scene.toml {name} -o a.toml --report a.html")).ends(0);
    assert!(ran.stderr.contains("a\u{fffd}TUNED\u{fffd}[31m\u{fffd}.csv"), "{}", ran.stderr);
    for text in [ran.stdout, ran.stderr, folder.text("a.html"), folder.text("a.toml")] {
        assert!(!text.contains('\u{1b}') && !text.contains('\u{202e}') && !text.contains("\nTUNED\u{fffd}"), "{text}");
    }
}

#[test]
fn threads_without_number_are_refused() {
    let folder = Folder::with_scene();
    folder.write("drop.csv", Drop::default().csv());
    let ran = folder.shell("RAYON_NUM_THREADS=1000000 $TUNENET tune --sim scene.toml drop.csv").ends(2);
    assert!(ran.stderr.contains("`RAYON_NUM_THREADS`: expected at most 1024 threads, found 1000000"), "{}", ran.stderr);
}
