//! Drops that other engines made: `NN.csv` with `t,x,y,z` and the restitution that the engine was given.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use tunenet_formats::ReadOptions;

use super::targets::{DropTarget, Simulation};
use crate::scene::{EASY, HARD, PAPER_RADIUS_M};
use tunenet_cli::files::names;

/// The environment variable that names the folder with `cross/<engine>_<set>`.
pub const FOLDER: &str = "TUNENET_PEERS";

/// A folder, the range its restitutions come from, and the best that another tuner reached there at 5 rollouts: mean
/// distance in height, cm.
pub const SETS: [(&str, (f64, f64), f64); 4] = [
    ("mujoco_easy", EASY, 1.90),
    ("mujoco_hard", HARD, 9.40),
    ("pybullet_easy", EASY, 0.02),
    ("pybullet_hard", HARD, 0.04),
];

/// Why a goal there is out of reach.
pub const OTHER_LAWS: &str = "These drops were made by PyBullet, with air damping and contacts in steps of 1/60 s, and the \
     goal was reached by tuning PyBullet itself. A ball without air cannot follow them nearer than its likeliest \
     restitution does with any tuner: that is where all columns end.";

/// The folder, where the environment names one.
pub fn folder() -> Option<PathBuf> {
    std::env::var_os(FOLDER).filter(|v| !v.is_empty()).map(|v| Path::new(&v).join("cross"))
}

/// The drops of one set, each started at 0.5.
pub fn targets(simulation: &Simulation, folder: &Path, range: (f64, f64)) -> Result<Vec<DropTarget>> {
    let listed = std::fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))?;
    let mut files: Vec<PathBuf> = listed.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    files.retain(|path| path.extension().is_some_and(|e| e == "csv") && names::file_name(path) != "truth.csv");
    files.sort();
    ensure!(!files.is_empty(), "{} holds no drops", folder.display());
    files.iter().map(|path| read(simulation, path, range).with_context(|| path.display().to_string())).collect()
}

fn read(simulation: &Simulation, path: &Path, range: (f64, f64)) -> Result<DropTarget> {
    let ours = [("t_s", "t"), ("x_m", "x"), ("y_m", "y"), ("z_m", "z")];
    let columns = ours.map(|(ours, theirs)| (ours.to_owned(), theirs.to_owned())).to_vec();
    let seen = tunenet_formats::read(path, &ReadOptions { columns, ..ReadOptions::default() })?.observation;
    let frames = simulation.clock.len();
    ensure!(seen.len() == frames, "expected {frames} samples, found {}", seen.len());
    let heights: Vec<f64> = seen.column(2).map(|z| z - PAPER_RADIUS_M).collect();
    // Nobody knows the true restitution: the engines disagree on what the number means.
    simulation.seen(heights[0], heights, (f64::NAN, 0.5), range)
}
