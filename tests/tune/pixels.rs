//! A drop in the pixels of a camera that nobody knows: the data set, a network that learned from it, and the tuned ball.

use crate::common::{Drop, Folder};
use std::fmt::Write;

/// The scene of the drops below.
const SCENE: &str = include_str!("../../assets/ball_easy.toml");

/// Any camera makes `(a z + b) / (c z + 1)` of a vertical line.
fn pixels(restitution: f64) -> String {
    let drop = Drop {
        restitution,
        height_m: 4.0,
        radius_m: 0.5,
        floor_m: 0.0,
        rate_hz: 60.0,
        frames: 400,
        held_s: 0.0,
        noise_m: 0.0,
        seed: 1,
    };
    let mut noise = crate::common::Noise(77);
    let mut csv = "t_s,u_px,v_px\n".to_owned();
    for (t, [_, _, z]) in drop.frames() {
        let v = (-13.0 * z + 96.0) / (-0.045 * z + 1.0) + 0.3 * noise.normal();
        writeln!(csv, "{t},{},{v}", 79.5 + 0.3 * noise.normal()).unwrap();
    }
    csv
}

#[test]
fn restitution_comes_out_of_pixels() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    for truth in [0.42, 0.66] {
        folder.write("drop.csv", pixels(truth));
        let ran = folder.run("tune --sim scene.toml --observation drop.csv --json").ends(0);
        let json = ran.json();
        assert_eq!(json["verdict"], "tuned", "{json}");
        let found = &json["parameters"]["restitution"];
        let value = found["value"].as_f64().unwrap();
        let end = |i: usize| found["interval95"][i].as_f64().unwrap();
        assert!((value - truth).abs() < 0.003, "{found}");
        assert!(end(0) < truth + 0.001 && truth - 0.001 < end(1) && end(1) - end(0) < 0.01, "{found}");
    }
}

#[test]
fn pixels_without_a_known_height_say_what_is_missing() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE.replace("height_m = 4.0 ", "# "));
    folder.write("drop.csv", pixels(0.5));
    let ran = folder.run("tune --sim scene.toml --observation drop.csv").ends(1);
    assert!(ran.stderr.contains("release.height_m"), "{}", ran.stderr);
}

#[test]
fn a_network_learns_from_pixels_and_is_used() {
    let folder = Folder::new();
    for name in ["pairs", "again"] {
        folder.run(&format!("gen ball-video --pairs 60 --seed 4 --out {name}.mcap")).ends(0);
    }
    assert!(folder.read("pairs.mcap") == folder.read("again.mcap"));
    folder.run("train --data pairs.mcap --preset paper --out pixels.safetensors").ends(0);
    folder.write("scene.toml", SCENE);
    folder.write("drop.csv", pixels(0.6));
    let line = "tune --sim scene.toml --observation drop.csv --model pixels.safetensors --json";
    let json = folder.run(line).json();
    // The paper's loop: one iterate for each of five rollouts, and the start.
    assert_eq!(json["iterations"].as_array().unwrap().len(), 6, "{json}");
    folder.run("gen ball-video --preset general --pairs 4 --out no.mcap").ends(2);
}
