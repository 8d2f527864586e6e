//! `tunenet bench`: every figure that is claimed, measured here.

mod diagnose;
mod film_speed;
mod grow;
mod intervals;
mod paper;
mod preflight;
mod process;
mod regions;
mod rehearsal;
mod resume;
mod search;
mod shot;
mod speed;
mod tuning;

use std::path::Path;

use anyhow::Result;

pub use self::resume::own;
use crate::cli::{Bench, Measured};
use crate::failure::Exit;

pub fn run(options: &Bench) -> Result<Exit> {
    measure(&options.what)
}

/// The whole answer from the pieces that shards have brought to `out`.
pub fn merged(mut bench: Measured, out: &Path, as_json: bool) -> Result<Exit> {
    let (folder, common) = match &mut bench {
        Measured::Tuning(options) => (&mut options.out, &mut options.common),
        Measured::Diagnose(options) => (&mut options.out, &mut options.common),
        Measured::Intervals(options) => (&mut options.out, &mut options.common),
        Measured::Regions(options) => (&mut options.out, &mut options.common),
        Measured::Preflight(options) => (&mut options.out, &mut options.common),
        Measured::Paper(options) => (&mut options.out, &mut options.common),
        Measured::Shot(options) => (&mut options.out, &mut options.common),
        Measured::Speed(_) | Measured::Grow(_) => anyhow::bail!("this bench has no shards"),
    };
    *folder = out.into();
    common.json = as_json;
    measure(&bench)
}

fn measure(bench: &Measured) -> Result<Exit> {
    match bench {
        Measured::Speed(options) => speed::run(options),
        Measured::Tuning(options) => tuning::run(options),
        Measured::Diagnose(options) => diagnose::run(options),
        Measured::Intervals(options) => intervals::run(options),
        Measured::Regions(options) => regions::run(options),
        Measured::Preflight(options) => preflight::run(options),
        Measured::Paper(options) => paper::run(options),
        Measured::Shot(options) => shot::run(options),
        Measured::Grow(options) => grow::run(options),
    }
}
