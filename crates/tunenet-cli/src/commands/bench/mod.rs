//! `tunenet bench`: every figure that is claimed, measured here.

mod diagnose;
mod film_speed;
mod intervals;
mod paper;
mod preflight;
mod process;
mod regions;
mod resume;
mod speed;
mod tuning;

use anyhow::Result;

use crate::cli::{Bench, Measured};
use crate::failure::Exit;

pub fn run(options: &Bench) -> Result<Exit> {
    match &options.what {
        Measured::Speed(options) => speed::run(options),
        Measured::Tuning(options) => tuning::run(options),
        Measured::Diagnose(options) => diagnose::run(options),
        Measured::Intervals(options) => intervals::run(options),
        Measured::Regions(options) => regions::run(options),
        Measured::Preflight(options) => preflight::run(options),
        Measured::Paper(options) => paper::run(options),
    }
}
