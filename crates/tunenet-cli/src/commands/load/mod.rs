//! Loading what several commands need.

mod clock;
mod differences;
mod driven;
mod input_files;
pub mod inputs;
mod interfaces;
mod joints;
mod options;
mod read_inputs;
mod record_end;
mod recording;
mod scene;
mod setups;
mod stated;
mod thinned;
mod video;

use anyhow::Result;
use tunenet_formats::Error;
use tunenet_sim::process::Permission;
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{Session, SimulationFile};

use crate::args::{self, Simulation};
use crate::files::destination::neighbouring_urdf;
use crate::files::hash;
pub use driven::Driven;
pub use input_files::{own_files, own_files_of};
pub use joints::{attach_reference, lacks, left_out};
pub use options::{definitions, reading};
pub use recording::{of_channels, recording, recording_of};
pub use setups::Setups;
pub use stated::{Stated, stated};
pub use thinned::{MOST_SAMPLES, thinned};

/// A simulation file with its overrides.
pub fn simulation(options: &Simulation) -> Result<SimulationFile> {
    let mut file = SimulationFile::read(&options.sim)?;
    for assignment in &options.set {
        file.set(assignment)?;
    }
    Ok(file)
}

/// The same, and the session in which the program that it names runs; without permission such a file is refused before anything
/// else is done.
pub fn simulation_with(options: &Simulation, given: args::Permission) -> Result<(SimulationFile, Session)> {
    let (file, session) = (simulation(options)?, session(given));
    if file.domain() == Domain::Process {
        session.require_permission(&file)?;
    }
    Ok((file, session))
}

/// A session with the permission that the command line gives.
pub fn session(given: args::Permission) -> Session {
    Session::new(if given.allow_process { Permission::Granted } else { Permission::Denied })
}

/// Refuses a simulation file of another kind than a command needs.
pub fn of_kind(file: &SimulationFile, needed: Domain) -> Result<()> {
    if file.domain() == needed {
        return Ok(());
    }
    let message = format!("expected `kind = \"{}\"` here, found \"{}\"", needed.name(), file.domain().name());
    Err(Error::file(file.path(), message, format!("`tunenet init {}` writes one to start from", needed.name())).into())
}

/// The SHA-256 of the URDF that a simulation names, where it names one that is there.
pub fn urdf_hash(options: &Simulation) -> Result<Option<String>> {
    let named = options.urdf_set().or_else(|| neighbouring_urdf(&options.sim));
    named.filter(|path| path.is_file()).map(|path| hash::sha256(&path)).transpose()
}
