//! Drops from two other engines, where `TUNENET_PEERS` names a folder that holds them.

use super::{digest, each, pinned};
use crate::common::recorded::{peers, peers_diagnosed};
use crate::common::{Folder, PEERS_BALL};

/// Of each set; all 20 would take minutes.
const TUNED: usize = 5;
const COLUMNS: &str = "--columns t_s=t,x_m=x,y_m=y,z_m=z";

#[test]
fn regress_other_engines_tuned() {
    let mut found = Vec::new();
    for engine in ["mujoco", "pybullet"] {
        for what in ["easy", "hard", "drag", "tilt", "eslope", "wind"] {
            let set = format!("{engine}_{what}");
            let Some(drops) = peers(&set) else { return };
            let here = Folder::new();
            here.write("ball.toml", PEERS_BALL);
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
        let Some(ran) = peers_diagnosed(&set, count) else { return };
        found.push((set, digest::answered(&ran)));
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
