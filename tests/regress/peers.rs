//! Drops from two other engines, where `TUNENET_PEERS` names a folder that holds them.

use std::path::PathBuf;

use super::{answer, each, files, folder, line, pinned};
use crate::common::Folder;

/// The other engines put the ball's radius at 0.5 m.
const BALL: &str = "\
kind = \"ball\"
ball.radius_m = 0.5
surface.height_m = 0.0

[parameters.restitution]
value = 0.5
min = 0.0
max = 1.0
";
/// Of each set; all 20 would take minutes.
const TUNED: usize = 5;
const COLUMNS: &str = "--columns t_s=t,x_m=x,y_m=y,z_m=z";

/// The drops of a set.
fn drops(set: &str) -> Option<Vec<PathBuf>> {
    let mut drops = files(&folder("TUNENET_PEERS", "cross")?.join(set), "", ".csv");
    drops.retain(|path| !path.ends_with("truth.csv"));
    Some(drops)
}

#[test]
fn regress_other_engines_tuned() {
    let mut found = Vec::new();
    for engine in ["mujoco", "pybullet"] {
        for what in ["easy", "hard", "drag", "tilt", "eslope", "wind"] {
            let set = format!("{engine}_{what}");
            let Some(drops) = drops(&set) else { return };
            let here = Folder::new();
            here.write("ball.toml", BALL);
            let words = format!("tune --sim ball.toml --each {COLUMNS} --observation");
            found.extend(
                each(&here, &words, &drops[..TUNED.min(drops.len())])
                    .into_iter()
                    .map(|(name, one)| (format!("{set}/{name}"), one)),
            );
        }
    }
    pinned::check("engines-tuned", &found);
}

/// The first drops of each set, every one of a ball of its own.
fn diagnosed(engine: &str) {
    let mut found = Vec::new();
    for (what, count) in [("easy", 5), ("hard", 5), ("drag", 5), ("tilt", 2), ("eslope", 5), ("wind", 3)] {
        let set = format!("{engine}_{what}");
        let Some(drops) = drops(&set) else { return };
        let here = Folder::new();
        here.write("ball.toml", BALL);
        let one = |(i, path): (usize, &PathBuf)| {
            format!("[[observation]]\nfile = '{}'\nobject = \"ball {i}\"\n", path.display())
        };
        here.write("m.toml", drops.iter().take(count).enumerate().map(one).collect::<String>());
        let words = format!("diagnose --sim ball.toml --manifest m.toml {COLUMNS}");
        found.push((set, answer(&here, &line(&words, &[]))));
    }
    pinned::check(&format!("engines-diagnosed-{engine}"), &found);
}

#[test]
fn regress_other_engine_diagnosed() {
    diagnosed("mujoco");
}

#[test]
fn regress_other_engine_with_late_contacts_diagnosed() {
    diagnosed("pybullet");
}
