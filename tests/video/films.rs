//! Films of other kinds, and what they may show beside a ball that bounces.

use crate::common::{Folder, Ran};
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

fn rows(folder: &Folder, name: &str) -> Vec<Vec<f64>> {
    let text = String::from_utf8(folder.read(name)).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

/// The same bounces, up to what a clock is rounded to.
fn alike(a: &Value, b: &Value) -> bool {
    let bounces = |v: &Value| v["bounces_s"].as_array().unwrap().iter().filter_map(Value::as_f64).collect::<Vec<_>>();
    let (first, second) = (bounces(a), bounces(b));
    let value = |v: &Value| v["restitution"]["value"].as_f64().unwrap();
    first.len() == second.len()
        && first.iter().zip(&second).all(|(a, b)| (a - b).abs() < 1e-6)
        && (value(a) - value(b)).abs() < 1e-6
}

#[test]
fn a_rate_and_a_count_clip_and_resample_from_the_release_on() {
    let film = Film { held_s: 0.5, ..Film::default() };
    let folder = with(&film);
    folder.run("track drop.avi --pixels --rate 45 --frames 150 --out even.csv").ends(0);
    let even = rows(&folder, "even.csv");
    assert_eq!(even.len(), 150);
    let begin = even[0][0];
    assert!((begin - film.held_s).abs() < 0.1, "{begin}");
    let last = 119.0 / 60.0;
    for (k, row) in even.iter().enumerate() {
        assert!((row[0] - begin - k as f64 / 45.0).abs() < 1e-6);
        let (_, v) = film.place_px(row[0].min(last));
        // A straight line between two frames misses a bounce by what the ball moves in half of one.
        assert!((row[2] - v).abs() < 7.0, "{row:?} for {v}");
    }
    // The film has ended by then, and the ball stays where it was.
    assert_eq!(even[149][1..], even[140][1..]);
}

#[test]
fn a_folder_of_frames_is_a_film() {
    let film = Film { frames: 110, ..Film::default() };
    let folder = with(&film);
    std::fs::create_dir(folder.path("frames")).unwrap();
    for (i, png) in film.pngs().into_iter().enumerate() {
        folder.write(&format!("frames/f{}.png", i + 1), png);
    }
    let ran = folder.run("track frames").ends(1);
    assert!(ran.stderr.contains("--camera-rate 60"), "{}", ran.stderr);
    let pictures = folder.run("track frames --camera-rate 60 --json").ends(0).json();
    let film = folder.run("track drop.avi --json").ends(0).json();
    assert_eq!((&pictures["seen"], &pictures["fps"]), (&film["seen"], &60.0.into()));
    assert!(alike(&pictures, &film), "{pictures}");
    let line = "tune --sim scene.toml --set ball.radius_m=0.04 --no-cache --json --observation";
    let tuned = folder.run(&format!("{line} frames --camera-rate 60")).json();
    let found = tuned["parameters"]["restitution"]["value"].as_f64().unwrap();
    assert!((found - 0.75).abs() < 0.004, "{found}");
    folder.write("frames/f7.png", "no picture");
    let cut = folder.run("track frames --camera-rate 60 --frames 100 --json").json();
    assert_eq!(cut["frames"], 6, "{cut}");
}

#[test]
fn logs_with_pictures_give_what_the_film_gives() {
    let film = Film { frames: 100, ..Film::default() };
    let folder = with(&film);
    let plain = folder.run("track drop.avi --json").ends(0).json();
    for (name, compressed) in [("raw.mcap", false), ("png.mcap", true)] {
        folder.write(name, film.mcap(compressed));
        let json = folder.run(&format!("track {name} --topic /camera/image --json --out {name}.csv")).ends(0).json();
        assert_eq!((&json["frames"], &json["seen"]), (&plain["frames"], &plain["seen"]));
        assert!(alike(&json, &plain), "{name}: {json}");
        assert_eq!(rows(&folder, &format!("{name}.csv")).len(), 100);
    }
    let ran = folder.run("track raw.mcap --topic /other").ends(1);
    assert!(ran.stderr.contains("/camera/image"), "{}", ran.stderr);
}

fn refused(film: &Film, verdict: &str, words: &str) -> (Folder, Ran) {
    let folder = with(film);
    let ran = folder.run("track drop.avi --report page.html --json").ends(3);
    assert_eq!(ran.json()["verdict"], verdict, "{}", ran.stderr);
    let text = folder.run("track drop.avi").ends(3);
    assert!(text.stdout.contains(words), "{}", text.stdout);
    (folder, ran)
}

#[test]
fn a_film_without_a_ball_gets_its_page_too() {
    let green = [40, 210, 40];
    for (film, verdict, words) in [
        (Film { balls: Vec::new(), ..Film::default() }, "no_ball", "NO BALL"),
        (Film { balls: vec![green, green], ..Film::default() }, "two_balls", "TWO BALLS"),
        (Film { pan_px: 1.5, ..Film::default() }, "camera_moves", "CAMERA MOVES"),
        (Film { square: true, radius_m: 0.06, ..Film::default() }, "not_round", "NOT ROUND"),
    ] {
        let (folder, _) = refused(&film, verdict, words);
        let page = String::from_utf8(folder.read("page.html")).unwrap();
        assert!(page.contains(words) && page.contains("data:image/jpeg;base64,"), "{verdict}");
    }
}

#[test]
fn a_ball_that_rolls_is_told_from_one_in_the_wrong_unit() {
    let film = Film { height_m: 0.0, held_s: 0.0, speed_m_s: 0.4, ..Film::default() };
    let folder = with(&film);
    let json = folder.run("track drop.avi --json").ends(0).json();
    assert!(codes(&json).contains(&"ball.rolls"), "{json}");
    let ran = folder.run("tune --sim scene.toml --observation drop.avi --json").ends(3);
    assert_eq!(ran.json()["verdict"], "rejected");
    assert!(ran.stdout.contains("it rolls") && !ran.stdout.contains("unit"), "{}", ran.stdout);
    folder.run("inspect drop.avi").ends(3);
}

#[test]
fn a_manifest_says_how_large_each_ball_is() {
    let film = Film { height_m: 0.0, held_s: 0.0, speed_m_s: 0.4, ..Film::default() };
    let folder = with(&film);
    folder.write("other.avi", Film { restitution: 0.6, ..Film::default() }.avi());
    folder.write("drop.avi", Film::default().avi());
    let entry = |file: &str, radius: f64| {
        format!("[[observation]]\nfile = \"{file}\"\nobject = \"{file}\"\nball.radius_m = {radius}\n")
    };
    let told = |radius: f64| {
        folder.write("all.toml", entry("drop.avi", radius) + &entry("other.avi", radius));
        let json = folder.run("diagnose --sim scene.toml --manifest all.toml --json").json();
        codes(&json).contains(&"scale.disagrees")
    };
    assert!(!told(0.04) && told(0.02));
}

#[test]
fn a_film_that_is_cut_off_says_where() {
    let folder = with(&Film::default());
    let whole = folder.read("drop.avi");
    folder.write("cut.avi", &whole[..whole.len() * 3 / 4]);
    let ran = folder.run("track cut.avi --json").ends(0);
    let json = ran.json();
    let note = json["warnings"].as_array().unwrap().iter().find(|w| w["code"] == "film.truncated").unwrap();
    let text = note["text"].as_str().unwrap();
    assert!(text.contains("of 120 frames can be decoded, until 1.4"), "{text}");
    let film = Film { frames: 60, ..Film::default() };
    let log = film.mcap(false);
    folder.write("cut.mcap", &log[..log.len() / 2]);
    let json = folder.run("track cut.mcap --json").ends(0).json();
    assert!(codes(&json).contains(&"film.truncated") && json["frames"].as_u64().unwrap() >= 20, "{json}");
}

/// Cameras that look down, from near and far; nothing says how high the ball fell, or how large a pixel is.
#[test]
fn restitution_is_right_whatever_camera_saw_it_and_wherever_it_fell_from() {
    for (eye, restitution, height_m) in [
        ([2.5, 1.0, 1.8], 0.75, 1.2),
        ([-1.5, 4.0, 3.0], 0.62, 1.6),
        ([3.0, -3.0, 0.6], 0.7, 0.9),
        ([0.5, 3.0, 2.4], 0.8, 1.1),
    ] {
        let film = Film {
            eye_m: Some(eye),
            restitution,
            height_m,
            speed_m_s: 0.0,
            radius_m: 0.08,
            rates_hz: (120.0, 120),
            frames: 240,
            ..Film::default()
        };
        let folder = with(&film);
        let seen = folder.run("track drop.avi --json").ends(0).json();
        let found = seen["restitution"]["value"].as_f64().unwrap();
        assert!((found - restitution).abs() < 0.01, "{eye:?}: {found} for {restitution}");
        let line = "tune --sim scene.toml --set ball.radius_m=0.08 --observation drop.avi --no-cache --json";
        let json = folder.run(line).json();
        let found = json["parameters"]["restitution"]["value"].as_f64().unwrap();
        assert!((found - restitution).abs() < 0.005, "{eye:?}: {found} for {restitution}: {json}");
    }
}

#[test]
fn a_ball_without_a_hue_is_found_by_its_brightness() {
    for shade in [[245; 3], [15; 3]] {
        let folder = with(&Film { balls: vec![shade], ..Film::default() });
        let json = folder.run("track drop.avi --json").ends(0).json();
        assert!(json["seen"].as_u64().unwrap() > 115, "{json}");
        let restitution = json["restitution"]["value"].as_f64().unwrap();
        assert!((restitution - 0.75).abs() < 0.02, "{shade:?}: {restitution}");
    }
}

/// The camera is bumped by 9 px for an eighth of a second, or half way through for good.
#[test]
fn a_bumped_camera_is_told_and_what_it_saw_meanwhile_is_left_out() {
    for (bump, left_out) in [(50..58, 8..24), (70..120, 48..64)] {
        let film = Film { bump: Some((bump.clone(), 9.0)), ..Film::default() };
        let folder = with(&film);
        let json = folder.run("track drop.avi --out track.csv --pixels --json").ends(0).json();
        assert!(codes(&json).contains(&"camera.bumped"), "{json}");
        let kept = rows(&folder, "track.csv");
        let gone = film.frames - kept.len();
        assert!(left_out.contains(&gone), "{bump:?}: {gone} left out");
        for row in kept {
            let (u, v) = film.place_px(row[0]);
            assert!((row[1] - u).hypot(row[2] - v) < 0.3, "{bump:?}: {row:?} for {u} {v}");
        }
    }
}

/// Balls thrown across the view lose more than half of their speed along the floor at the first bounce.
#[test]
fn films_of_throws_show_that_the_floor_rubs() {
    let Some(root) = std::env::var_os("TUNENET_MEASURED").map(std::path::PathBuf::from) else {
        eprintln!("skipped: TUNENET_MEASURED does not name a folder of measured files");
        return;
    };
    let folder = Folder::with_scene();
    for name in ["PV_1.mp4", "PV_2.mp4"] {
        let path = root.join("video-throws").join(name);
        if !path.exists() {
            eprintln!("skipped: {} is not there", path.display());
            continue;
        }
        let line = format!("diagnose --sim scene.toml --observation {} --json", path.display());
        let json = folder.run(&line).ends(3).json();
        let names: Vec<&str> = json["candidates"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        assert_eq!(json["verdict"], "one_of", "{name}");
        assert!(names.contains(&"tangential_restitution") && names.contains(&"bounce_friction"), "{name}: {names:?}");
        assert_eq!(names.len(), 2, "{name}: {names:?}");
    }
}
