//! `tunenet plan` as a process: the answer, its files, and everything that it refuses.

use std::path::Path;

use crate::common::{Folder, refused};
use serde_json::Value;

const TUNED: &str = "\
kind = \"ball\"

[ball]
radius_m = 0.03

[parameters.restitution]
value = 0.72
min = 0.0
max = 1.0

[provenance]
tool = \"tunenet 0\"
verdict = \"tuned\"
interval95 = { restitution = [0.70, 0.74] }
";
const LINE: &str = "plan --sim tuned.toml --task shot.toml";

/// The ready task, its robot, and a tuned ball.
fn folder() -> Folder {
    let (folder, assets) = (Folder::new(), Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets"));
    for name in ["shot.toml", "jaco_robotiq.urdf"] {
        folder.write(name, std::fs::read(assets.join(name)).unwrap());
    }
    folder.write("tuned.toml", TUNED);
    folder
}

fn with(folder: &Folder, from: &str, to: &str) {
    let task = folder.text("shot.toml");
    assert!(task.contains(from), "{from}");
    folder.write("shot.toml", task.replace(from, to));
}

/// From a drop to a shot: what is tuned here is let go from the height that the formula asks for.
#[test]
fn a_tuned_file_is_planned_with() {
    let folder = folder();
    let drop = crate::common::Drop { restitution: 0.72, ..crate::common::Drop::default() };
    folder.write("drop.csv", drop.csv());
    folder.write("ball.toml", TUNED.split("\n[provenance]").next().unwrap().replace("0.72", "0.5"));
    folder.run("tune --sim ball.toml --observation drop.csv --out found.toml").ends(0);
    let found = folder.run("plan --sim found.toml --task shot.toml --rule nearest --heights 71 --json").ends(0).json();
    // v = √(2gh); the normal part comes back e times as fast; the parabola then falls .3 m.
    let lands = |height: f64| {
        let (speed, tilt) = ((2.0 * 9.81 * height).sqrt(), std::f64::consts::FRAC_PI_6);
        let push = 1.72 * speed * tilt.cos();
        let (vx, vz) = (push * tilt.sin(), push * tilt.cos() - speed);
        vx * (vz + (vz * vz + 2.0 * 9.81 * 0.3).sqrt()) / 9.81
    };
    let height = found["height_m"].as_f64().unwrap();
    let miss = found["miss_distance_m"].as_f64().unwrap();
    assert!((miss - (lands(height) - 0.8).abs()).abs() < 3e-3, "{miss} {}", lands(height));
    let best = (0..=70).map(|i| (lands(0.3 + 0.01 * f64::from(i)) - 0.8).abs()).fold(f64::INFINITY, f64::min);
    assert!((miss - best).abs() < 3e-3, "{miss} {best}");
    assert_eq!(found["candidates"].as_array().unwrap().len(), 71);
    assert_eq!(found["joint_positions_rad"].as_array().unwrap().len(), 7);
    assert!(found["warnings"].as_array().unwrap().is_empty(), "{}", found["warnings"]);
}

#[test]
fn the_surest_height_is_as_sure_as_any() {
    let folder = folder();
    let found = folder.run(&format!("{LINE} --json")).ends(0).json();
    let chance = |value: &Value| value["success_probability"].as_f64().unwrap();
    let most = found["candidates"].as_array().unwrap().iter().map(chance).fold(0.0, f64::max);
    assert!(chance(&found) >= most && most > 0.9 && found["reachable"] == true);
    assert_eq!(found["schema"], "tunenet.plan/1");
    // The same seed gives the same plan, whatever the number of threads.
    let mut again = folder.command();
    again.env("RAYON_NUM_THREADS", "1").args(LINE.split_whitespace()).arg("--json");
    let again = crate::common::Ran::from(again.output().unwrap()).ends(0).json();
    assert_eq!((&again["height_m"], &again["candidates"]), (&found["height_m"], &found["candidates"]));
}

#[test]
fn the_approach_and_the_page_are_written() {
    let folder = folder();
    folder.run(&format!("{LINE} --out approach.mcap --report shot.html")).ends(0);
    let seen = folder.run("inspect approach.mcap --json").json();
    let text = seen.to_string();
    assert!(text.contains("trajectory_msgs") && text.contains("sensor_msgs"), "{text}");
    let found = folder.run(&format!("{LINE} --json")).json();
    let way = trajectory(&folder.read("approach.mcap"));
    assert_eq!((way.frame.as_str(), way.joints.len()), ("base", 7));
    assert!(way.points.len() > 20 && way.states == way.points.len());
    let last = way.points.last().unwrap();
    let told = found["joint_positions_rad"].as_array().unwrap().iter().map(|q| q.as_f64().unwrap());
    assert!(last.columns[0].iter().zip(told).all(|(q, told)| (q - told).abs() < 1e-12), "it ends at the release");
    moves_as_stated(&way);
    let page = folder.text("shot.html");
    assert!(page.contains("Planned") && page.matches("<svg").count() == 4 && !page.contains("NaN"), "{page}");
    // Asked again, the page may be replaced, and the log may not.
    refused(&folder, &format!("{LINE} --out approach.mcap"), &["approach.mcap", "--overwrite"]);
    folder.run(&format!("{LINE} --report shot.html")).ends(0);
}

/// Rates by differences of positions, accelerations by differences of rates; from rest to rest, within the URDF's speeds.
fn moves_as_stated(way: &Trajectory) {
    let (first, last) = (&way.points[0], &way.points[way.points.len() - 1]);
    assert_eq!(first.time_ns, 0);
    for end in [first, last] {
        assert!(end.columns[1..].iter().flatten().all(|v| v.abs() < 1e-9), "{:?}", end.columns);
    }
    // Of a way of least jerk the third derivative is at most 60 times the way over T³, the fourth 360 times over T⁴;
    // differences over two steps of h are off by h²/6 of what follows.
    let (whole_s, step_s) = (1e-9 * last.time_ns as f64, 1e-9 * way.points[1].time_ns as f64);
    for joint in 0..way.joints.len() {
        // Half of what the URDF allows: the four large joints, and the wrist's three.
        let fastest = 0.5 * if joint < 4 { 0.628_319 } else { 0.837_758 };
        let turned = (last.columns[0][joint] - first.columns[0][joint]).abs();
        let off = |most: f64| turned * most * step_s * step_s / 6.0 + 1e-6;
        for three in way.points.windows(3) {
            let seconds = 1e-9 * (three[2].time_ns - three[0].time_ns) as f64;
            assert!(three[1].time_ns > three[0].time_ns);
            let slope = |column: usize| (three[2].columns[column][joint] - three[0].columns[column][joint]) / seconds;
            let stated = |column: usize| three[1].columns[column][joint];
            assert!((slope(0) - stated(1)).abs() <= off(60.0 / whole_s.powi(3)), "joint {joint}");
            assert!((slope(1) - stated(2)).abs() <= off(360.0 / whole_s.powi(4)), "joint {joint}");
            assert!(stated(1).abs() <= fastest, "joint {joint}: {}", stated(1));
        }
    }
}

/// What the log holds of the way: time from the start, then positions, velocities and accelerations.
struct Point {
    time_ns: i64,
    columns: [Vec<f64>; 3],
}

struct Trajectory {
    frame: String,
    joints: Vec<String>,
    points: Vec<Point>,
    states: usize,
}

fn trajectory(bytes: &[u8]) -> Trajectory {
    let messages: Vec<_> = mcap::MessageStream::new(bytes).unwrap().map(Result::unwrap).collect();
    let on = |topic: &str| messages.iter().filter(|m| m.channel.topic == topic).collect::<Vec<_>>();
    let whole = on("/joint_trajectory");
    assert_eq!((whole.len(), whole[0].channel.message_encoding.as_str()), (1, "cdr"));
    // Four bytes say that what follows is little-endian; numbers stand at multiples of their size from there.
    let mut cdr = Cdr { bytes: &whole[0].data[4..], at: 0 };
    assert_eq!((cdr.word(), cdr.word()), (0, 0), "the stamp");
    let frame = cdr.text();
    let joints = (0..cdr.word()).map(|_| cdr.text()).collect();
    let points = (0..cdr.word()).map(|_| {
        let columns = [cdr.numbers(), cdr.numbers(), cdr.numbers()];
        assert!(cdr.numbers().is_empty(), "no effort is asked for");
        Point { time_ns: i64::from(cdr.word()) * 1_000_000_000 + i64::from(cdr.word()), columns }
    });
    let points = points.collect();
    assert_eq!(cdr.at, cdr.bytes.len(), "all of it is read");
    Trajectory { frame, joints, points, states: on("/joint_states").len() }
}

struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Cdr<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.at = self.at.next_multiple_of(N);
        self.at += N;
        self.bytes[self.at - N..self.at].try_into().unwrap()
    }

    fn word(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn text(&mut self) -> String {
        let length = self.word() as usize;
        self.at += length;
        String::from_utf8(self.bytes[self.at - length..self.at - 1].to_vec()).unwrap()
    }

    fn numbers(&mut self) -> Vec<f64> {
        (0..self.word()).map(|_| f64::from_le_bytes(self.take())).collect()
    }
}

/// Two balls explain what was measured: the height is chosen for both, by turns as often as each is believed.
#[test]
fn every_explanation_of_a_set_is_planned_for() {
    let folder = folder();
    let found = |alternatives: &str| {
        let verdict = "verdict = \"tuned\"\ninterval95 = { restitution = [0.70, 0.74] }";
        folder.write("tuned.toml", TUNED.replace(verdict, &format!("verdict = \"one_of\"\n{alternatives}")));
        folder.run(&format!("{LINE} --json")).ends(0).json()
    };
    let chance = |json: &Value| json["success_probability"].as_f64().unwrap();
    let code = |json: &Value| json["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "plan.one_explanation");
    // So far apart that no height serves both.
    let far = found(
        "alternatives = [{ name = \"quadratic_drag\", c_1_m = 0.02, restitution = 0.74 }, \
         { name = \"linear_drag\", b_1_s = 0.05, restitution = 0.55 }]",
    );
    assert!((chance(&far) - 0.5).abs() < 1e-9 && !code(&far), "{}", far["success_probability"]);
    // So near that one does, which neither would choose alone.
    let near = found(
        "alternatives = [{ name = \"quadratic_drag\", c_1_m = 0.0, restitution = 0.74 }, \
         { name = \"linear_drag\", b_1_s = 0.0, restitution = 0.64 }]",
    );
    let height = |json: &Value| json["height_m"].as_f64().unwrap();
    let (one, other) = ("{ name = \"wind\", ax_m_s2 = 0.0, ay_m_s2 = 0.0, restitution = 0.74 }", "0.64");
    let first = found(&format!("alternatives = [{one}]"));
    let second = found(&format!("alternatives = [{}]", one.replace("0.74", other)));
    assert_eq!((chance(&near), chance(&first), chance(&second)), (1.0, 1.0, 1.0));
    assert!(
        height(&first) < height(&near) && height(&near) < height(&second),
        "{} {}",
        height(&first),
        height(&second)
    );
    // Without their numbers only the file's own is planned for, and that is said.
    assert!(code(&found("")));
}

/// One throw never settles which effect is missing; what is left of it is planned for without more ado.
#[test]
fn a_diagnosis_that_cannot_choose_is_planned_with() {
    let folder = folder();
    let throw = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/observations/light_1.csv");
    folder.write("throw.csv", std::fs::read(throw).unwrap());
    folder.write("ball.toml", "kind = \"ball\"\nball.radius_m = 0.02\nsurface.height_m = 0.0\n");
    let json = folder.run("diagnose --sim ball.toml --observation throw.csv --out left.toml --json").ends(3).json();
    assert_eq!(json["verdict"], "one_of", "{json:#}");
    let text = folder.text("left.toml");
    let listed = text.lines().find(|line| line.starts_with("alternatives")).expect(&text);
    for name in json["candidates"].as_array().unwrap() {
        assert!(listed.contains(name.as_str().unwrap()), "{listed}");
    }
    let line = "plan --sim left.toml --task shot.toml --json";
    let found = folder.run(line).ends(0).json();
    assert!(!found["warnings"].to_string().contains("plan."), "{}", found["warnings"]);
    // Whoever writes another value into the file means it: no explanation of the recording is drawn in its place.
    for (edit, other) in [("parameters.restitution.value", "0.6"), ("effects.quadratic_drag.c_1_m", "0.4")] {
        let edited = folder.run(&format!("{line} --set {edit}={other}")).ends(0).json();
        let told = &edited["warnings"][0];
        assert_eq!(told["code"], "plan.changed", "{edit}: {}", edited["warnings"]);
        assert!(told["text"].as_str().is_some_and(|m| m.contains(&format!("is {other}, which is outside"))), "{told}");
        let moved = edited["height_m"].as_f64().unwrap() - found["height_m"].as_f64().unwrap();
        assert!(moved.abs() > 0.02, "{edit}: {moved}");
    }
    // The nearest path is that of the file's own numbers, whatever else is possible.
    folder.write("alone.toml", text.replace(listed, ""));
    let nearest = |sim: &str| {
        folder.run(&format!("plan --sim {sim} --task shot.toml --rule nearest --json")).ends(0).json()["height_m"]
            .clone()
    };
    assert_eq!(nearest("left.toml"), nearest("alone.toml"));
}

#[test]
fn a_hoop_out_of_reach_is_an_honest_no() {
    let folder = folder();
    with(&folder, "[0.8, 0.0, -0.3]", "[4.0, 0.0, -0.3]");
    let ran = folder.run(&format!("{LINE} --json")).ends(3);
    let found = ran.json();
    assert_eq!((&found["reachable"], &found["success_probability"]), (&false.into(), &0.0.into()));
    assert!(found["miss_distance_m"].as_f64().unwrap() > 1.0);
    let ran = folder.run(LINE).ends(3);
    assert!(ran.stdout.contains("OUT OF REACH  no height brings the ball through the hoop"), "{}", ran.stdout);
    assert!(ran.stdout.contains("try: higher releases") && !ran.stdout.contains("joints"), "{}", ran.stdout);
    with(&folder, "[4.0, 0.0, -0.3]", "[0.8, 0.0, 2.0]");
    let above = folder.run(LINE).ends(3);
    assert!(above.stdout.contains("no height brings the ball up to the hoop"), "{}", above.stdout);
}

#[test]
fn what_cannot_be_planned_is_refused() {
    let plane = ("tilt_about_y_rad = 0.5235987755982988", "tilt_about_y_rad = -0.5");
    for (from, to, wanted) in [
        (plane.0, plane.1, &["shot.toml: the plane faces away from the hoop", "help: turn `plane.tilt"][..]),
        (
            plane.0,
            "tilt_about_y_deg = 30",
            &["expected a key of a task file, found `plane.tilt_about_y_deg`", "shot.toml:10"],
        ),
        ("radius_m = 0.11", "radius_m = \"wide\"", &["`hoop.radius_m`: expected a number", "\"wide\""]),
        ("radius_m = 0.11", "", &["expected `hoop.radius_m`", "found none"]),
        ("[0.3, 1.0]", "[1.0, 0.3]", &["`release.heights_m`: expected the lowest before the highest"]),
        ("[0.3, 1.0]", "[nan, 1.0]", &["`release.heights_m`"]),
        ("[0.3, 1.0]", "[2.5, 3.0]", &["the arm reaches none of the heights from 2.5 to 3 m", "help: move `arm.base"]),
        ("jaco_robotiq.urdf", "none.urdf", &["none.urdf"]),
        ("\"grip\"", "\"claw\"", &["`arm.link`: expected a link of the URDF", "`claw`"]),
        ("kind = \"shot\"", "kind = \"ball\"", &["`kind`: expected \"shot\""]),
    ] {
        let folder = folder();
        with(&folder, from, to);
        refused(&folder, LINE, wanted);
    }
    let folder = folder();
    folder.write("tuned.toml", "kind = \"ball\"\nball.radius_m = 0.03\n");
    refused(&folder, LINE, &["tuned.toml: expected a restitution above 0, found none", "tune the simulation first"]);
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/arm.toml");
    folder.write("arm.toml", std::fs::read(arm).unwrap());
    let of_an_arm = "plan --sim arm.toml --task shot.toml";
    refused(&folder, of_an_arm, &["arm.toml: expected the tuned simulation of a ball", "found that of an arm"]);
    folder.write("tuned.toml", &TUNED.as_bytes()[..40]);
    refused(&folder, LINE, &["tuned.toml"]);
    assert!(folder.run(&format!("{LINE} --heights 1")).ends(2).stderr.contains("--heights"));
    assert!(folder.run(&format!("{LINE} --out way.csv")).ends(2).stderr.contains(".mcap"));
}

#[test]
fn what_nobody_tuned_is_allowed_with_a_warning() {
    let folder = folder();
    folder.write("tuned.toml", TUNED.split("\n[provenance]").next().unwrap());
    let found = folder.run(&format!("{LINE} --json")).ends(0).json();
    assert_eq!(found["warnings"][0]["code"], "plan.untuned");
}

/// A base so far off that the arm reaches the lower heights alone.
#[test]
fn heights_beyond_the_arm_are_left_out() {
    let folder = folder();
    with(&folder, "[-0.55, 0.0, 0.25]", "[-0.55, 0.0, -0.35]");
    let found = folder.run(&format!("{LINE} --json")).ends(0).json();
    let reached = found["candidates"].as_array().unwrap().iter().filter(|c| c["arm_reaches"] == true).count();
    assert!((5..95).contains(&reached), "{reached}");
    assert!(found["warnings"].to_string().contains("plan.arm_reach"), "{}", found["warnings"]);
}
