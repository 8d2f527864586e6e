//! The program that sees, which alone is linked to OpenCV.

use std::process::Command;

use anyhow::{Context, Result};

/// `tunenet-video`, beside this program.
pub fn command() -> Result<Command> {
    let here = std::env::current_exe().context("this program's own path")?;
    Ok(Command::new(here.with_file_name(format!("tunenet-video{}", std::env::consts::EXE_SUFFIX))))
}
