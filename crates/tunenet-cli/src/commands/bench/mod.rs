//! `tunenet bench`: every figure that is claimed, measured here.

mod process;
mod speed;

use anyhow::Result;

use crate::cli::{Bench, Measured};
use crate::failure::Exit;

pub fn run(options: &Bench) -> Result<Exit> {
    match options.what {
        Measured::Speed => speed::run(options),
    }
}
