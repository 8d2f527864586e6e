//! From a film to an answer, as a person meets it: tracks against the truth that was drawn, tuning to a film, and what no
//! ball can be seen in.

use std::path::{Path, PathBuf};

use crate::common::Folder;
use crate::video::film::Film;
use serde_json::Value;

fn with(film: &Film) -> Folder {
    let folder = Folder::with_scene();
    folder.write("drop.avi", film.avi());
    folder
}

fn codes(json: &Value) -> Vec<&str> {
    json["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect()
}

/// Columns of a CSV by name.
fn columns(folder: &Folder, name: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = String::from_utf8(folder.read(name)).unwrap();
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|c| c.parse().unwrap()).collect()).collect();
    let columns = (0..names.len()).map(|c| rows.iter().map(|row| row[c]).collect()).collect();
    (names, columns)
}

#[test]
fn a_drawn_drop_is_tracked_to_a_tenth_of_a_pixel() {
    let film = Film::default();
    let folder = with(&film);
    let json = folder.run("track drop.avi --pixels --out track.csv --json").ends(0).json();
    assert_eq!((json["schema"].as_str(), json["verdict"].as_str()), (Some("tunenet.track/1"), Some("tracked")));
    assert_eq!((&json["frames"], &json["seen"], &json["duplicates"]), (&120.into(), &120.into(), &0.into()));
    assert!((json["fps"].as_f64().unwrap() - 60.0).abs() < 0.01, "{}", json["fps"]);
    let (names, columns) = columns(&folder, "track.csv");
    assert_eq!(names, ["t_s", "u_px", "v_px", "radius_px", "confidence"]);
    assert_eq!(columns[0].len(), 120);
    let places = columns[1].iter().zip(&columns[2]);
    for (i, ((time, radius), (found_u, found_v))) in columns[0].iter().zip(&columns[3]).zip(places).enumerate() {
        let (u, v) = film.place_px(i as f64 / 60.0);
        assert!((found_u - u).hypot(found_v - v) < 0.1, "frame {i}: {found_u} {found_v} for {u} {v}");
        assert!((radius - 8.0).abs() < 0.15, "frame {i}: radius {radius}");
        assert!((time - i as f64 / 60.0).abs() < 1e-3);
    }
    // Restitution needs no length, and is there before any simulation.
    let found = json["restitution"]["value"].as_f64().unwrap();
    assert!((found - film.restitution).abs() < 0.01, "{found}");
    assert!(codes(&json).is_empty(), "{json}");
}

#[test]
fn metres_come_from_the_fall_from_the_radius_or_from_a_length() {
    let film = Film::default();
    let folder = with(&film);
    for (flags, by, share) in
        [("", "gravity", 0.02), ("--radius 0.04", "radius", 0.02), ("--length 0.5=100", "length", 1e-9)]
    {
        let json = folder.run(&format!("track drop.avi {flags} --out track.csv --overwrite --json")).ends(0).json();
        assert_eq!(json["scale"]["by"], by);
        let found = json["scale"]["m_per_px"].as_f64().unwrap();
        assert!((found / film.m_per_px - 1.0).abs() < share, "{by}: {found}");
        let (names, columns) = columns(&folder, "track.csv");
        assert_eq!(names[..3], ["t_s", "x_m", "z_m"]);
        let (_, z) = film.place_m(0.0);
        assert!((columns[2][0] - z).abs() < 0.02, "{by}: {} for {z}", columns[2][0]);
    }
}

#[test]
fn tune_takes_a_film_as_it_is() {
    // Without noise, a thousandth of a pixel would be more than chance explains.
    let film = Film { noise: 8.0, ..Film::default() };
    let folder = with(&film);
    let line =
        "tune --sim scene.toml --set ball.radius_m=0.04 --observation drop.avi --no-cache --json --out tuned.toml";
    let json = folder.run(line).ends(0).json();
    let found = &json["parameters"]["restitution"];
    assert_eq!(json["verdict"], "tuned");
    assert!((found["value"].as_f64().unwrap() - film.restitution).abs() < 0.004, "{found}");
    assert!(json["gap"]["after"].as_f64().unwrap() < 2e-3, "{}", json["gap"]);
    assert!(codes(&json).contains(&"release.late"), "{json}");
    let text = String::from_utf8(folder.read("tuned.toml")).unwrap();
    assert!(text.contains("drop.avi"), "{text}");
}

/// The instants of the bounces alone, as `tune` reads them.
#[test]
fn bounces_are_a_recording_of_their_own() {
    let film = Film { noise: 4.0, ..Film::default() };
    let folder = with(&film);
    let json = folder.run("track drop.avi --bounces --out bounces.csv --json").ends(0).json();
    let (names, columns) = columns(&folder, "bounces.csv");
    let told: Vec<f64> = json["bounces_s"].as_array().unwrap().iter().map(|t| t.as_f64().unwrap()).collect();
    assert_eq!((names.len(), names[0].as_str()), (1, "bounce_time_s"));
    assert!(told.len() >= 3 && columns[0].len() == told.len(), "{told:?}");
    assert!(columns[0].iter().zip(&told).all(|(a, b)| (a - b).abs() < 1e-9), "{told:?}");
    let json = folder.run("tune --sim scene.toml --observation bounces.csv --no-cache --json").json();
    let found = json["parameters"]["restitution"]["value"].as_f64().unwrap();
    assert!((found - film.restitution).abs() < 0.005, "{found}");
    assert!(folder.run("track drop.avi --bounces").ends(2).stderr.contains("--out"));
}

#[test]
fn slow_motion_and_repeated_frames_are_noticed_and_mended() {
    // 240 frames a second, played at 60.
    let slow = Film { rates_hz: (240.0, 60), frames: 360, ..Film::default() };
    let folder = with(&slow);
    let json = folder.run("track drop.avi --radius 0.04 --json").ends(0).json();
    assert!(codes(&json).contains(&"scale.disagrees"), "{json}");
    let json = folder.run("track drop.avi --radius 0.04 --camera-rate 240 --json").ends(0).json();
    assert!(!codes(&json).contains(&"scale.disagrees"), "{json}");
    assert!((json["fps"].as_f64().unwrap() - 240.0).abs() < 0.1);
    let twice = with(&Film { repeat: vec![20, 50], ..Film::default() });
    let json = twice.run("track drop.avi --json").ends(0).json();
    assert_eq!((&json["duplicates"], codes(&json)), (&2.into(), vec!["film.repeated"]));
}

#[test]
fn what_shows_no_single_ball_is_a_plain_no() {
    let green = [40, 210, 40];
    let cases = [
        (Film { balls: Vec::new(), ..Film::default() }, "", "no_ball", "NO BALL"),
        (Film { balls: vec![green, green], ..Film::default() }, "", "two_balls", "TWO BALLS"),
        (Film { shake_px: 8.0, ..Film::default() }, "", "camera_moves", "CAMERA MOVES"),
        (Film::default(), "--color green", "no_ball", "omit `--color`"),
    ];
    for (film, flags, verdict, wanted) in cases {
        let folder = with(&film);
        let ran = folder.run(&format!("track drop.avi {flags} --out track.csv --json")).ends(3);
        assert_eq!(ran.json()["verdict"], verdict);
        let text = folder.run(&format!("track drop.avi {flags}")).ends(3);
        assert!(text.stdout.contains(wanted), "{}", text.stdout);
        assert!(!folder.names().iter().any(|n| n == "track.csv"));
    }
    let folder = with(&Film { balls: Vec::new(), ..Film::default() });
    let ran = folder.run("tune --sim scene.toml --observation drop.avi --json").ends(3);
    assert_eq!(ran.json()["verdict"], "rejected");
    let text = folder.run("tune --sim scene.toml --observation drop.avi").ends(3);
    assert!(text.stdout.contains("REJECTED") && text.stdout.contains("nothing round"), "{}", text.stdout);
}

#[test]
fn files_that_are_no_films_say_so() {
    let folder = with(&Film { frames: 60, ..Film::default() });
    let whole = folder.read("drop.avi");
    folder.write("words.mp4", "t_s,z_m\n0,1\n");
    folder.write("noise.mp4", vec![0x42u8; 5000]);
    folder.write("empty.avi", "");
    for (name, wanted) in [("words.mp4", "found a text"), ("noise.mp4", "expected a video"), ("empty.avi", "empty")] {
        for line in [format!("track {name}"), format!("tune --sim scene.toml --observation {name}")] {
            let ran = folder.run(&line).ends(1);
            assert!(ran.stderr.contains(name) && ran.stderr.contains(wanted), "{line}: {}", ran.stderr);
        }
    }
    let ran = folder.run("track absent.mp4").ends(1);
    assert!(ran.stderr.contains("absent.mp4"), "{}", ran.stderr);
    // What decodes of a film that is cut off is used, and it is said.
    folder.write("cut.avi", &whole[..whole.len() * 3 / 4]);
    let json = folder.run("track cut.avi --json").ends(0).json();
    assert!(codes(&json).contains(&"film.truncated"), "{json}");
    assert!(json["frames"].as_u64().unwrap() < 60);
}

#[test]
fn flags_are_blamed_for_what_they_say() {
    let folder = with(&Film { frames: 20, ..Film::default() });
    for (flags, wanted) in [
        ("--color pinkish", "--color"),
        ("--length 5", "0.5=240"),
        ("--radius=-1", "--radius"),
        ("--rate 0", "--rate"),
        ("--camera-rate 0", "--camera-rate"),
        ("--frames 1", "at least 2"),
        ("--topic /camera", "--topic"),
        ("--out track.txt", "--out"),
        ("--radius 0.04 --length 0.5=240", "cannot be used with"),
    ] {
        let ran = folder.run(&format!("track drop.avi {flags}")).ends(2);
        assert!(ran.stderr.contains(wanted), "{flags}: {}", ran.stderr);
    }
    folder.run("track drop.avi --out none/track.csv").ends(1);
    folder.run("track drop.avi --overlay drop.avi").ends(1);
}

#[test]
fn a_report_is_complete_in_itself_and_equal_runs_write_equal_bytes() {
    let folder = with(&Film::default());
    for name in ["a", "b"] {
        folder.run(&format!("track drop.avi --out {name}.csv --report {name}.html --overlay {name}.mp4")).ends(0);
    }
    assert_eq!(folder.read("a.csv"), folder.read("b.csv"));
    assert_eq!(folder.read("a.html"), folder.read("b.html"));
    let page = String::from_utf8(folder.read("a.html")).unwrap();
    assert_eq!(page.matches("data:image/jpeg;base64,").count(), 12);
    for foreign in ["<script", "http:", "https:", "<link"] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    // The film with the track drawn in is a film of as many frames.
    let json = folder.run("track a.mp4 --json --color 0,60,60:12,255,255").json();
    assert_eq!(json["frames"], 120);
    assert!(folder.names().iter().all(|n| !n.starts_with('.')), "{:?}", folder.names());
}

#[test]
fn without_the_part_that_reads_films_it_is_said() {
    let folder = with(&Film { frames: 20, ..Film::default() });
    let alone = folder.path("tunenet");
    std::fs::copy(env!("CARGO_BIN_EXE_tunenet"), &alone).unwrap();
    for line in [&["track", "drop.avi"][..], &["tune", "--sim", "scene.toml", "--observation", "drop.avi"]] {
        let output =
            std::process::Command::new(&alone).args(line).current_dir(alone.parent().unwrap()).output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(
            text.contains("expected `tunenet-video` in the folder of tunenet") && text.contains("make build"),
            "{text}"
        );
    }
}

/// Films of others, with what was counted by eye and told beside them: frames with a ball, and restitution (centre, slack).
#[test]
fn real_films_give_what_was_counted_in_them() {
    let Some(root) = std::env::var_os("TUNENET_MEASURED").map(PathBuf::from) else {
        eprintln!("skipped: TUNENET_MEASURED does not name a folder of measured files");
        return;
    };
    let folder = Folder::with_scene();
    let (none, throw) = (None, Some((0.725, 0.04)));
    let films = [
        ("video-redball/RedBall.mp4", 57..=60, Some((0.72, 0.03))),
        ("video-throws/PV_1.mp4", 51..=53, throw),
        ("video-throws/PV_2.mp4", 37..=39, throw),
        ("video-tennis-throw/ball.mp4", 27..=27, none),
    ];
    for (name, frames, restitution) in films {
        let path: &Path = &root.join(name);
        if !path.exists() {
            eprintln!("skipped: {} is not there", path.display());
            continue;
        }
        let json = folder.run(&format!("track {} --json", path.display())).ends(0).json();
        assert!(frames.contains(&json["seen"].as_u64().unwrap()), "{name}: {}", json["seen"]);
        if name.ends_with("RedBall.mp4") {
            assert_eq!(json["duplicates"], 1);
            assert!(codes(&json).contains(&"flight.odd"), "{json}");
        }
        let line = format!("tune --sim scene.toml --observation {} --no-cache --json", path.display());
        let tuned = folder.run(&line).ends(3).json();
        match restitution {
            Some((centre, slack)) => {
                let found = tuned["parameters"]["restitution"]["value"].as_f64().unwrap();
                assert!((found - centre).abs() < slack, "{name}: {found}");
            }
            None => assert_eq!(tuned["verdict"], "not_identifiable", "{name}"),
        }
    }
}
