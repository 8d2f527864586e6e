//! From a file of equations to a simulator that core can tune and diagnose.

use tunenet_core::simulator::Declared;
use tunenet_formats::{Error, Result};

use crate::equations::{EquationsModel, System};
use crate::simulation_file::Domain;
use crate::{SimulationFile, declared};

/// Equations as a simulator, with the inputs, states and candidates that their file declares.
pub type EquationsSimulator = Declared<EquationsModel>;

/// The equations of `files`, a file for each setup of the recordings
/// ([`Circumstances::setup`](tunenet_core::observation::Circumstances::setup) is a position among them): they differ in constants and
/// initial states.
///
/// # Errors
/// [`Error::File`] where a file holds no equations, or they differ in what they predict or in their parameters.
///
/// # Panics
/// Where `files` is empty.
pub fn equations(files: &[&SimulationFile]) -> Result<EquationsSimulator> {
    equations_of(files, &|_, system| system)
}

/// As [`equations`], the system of each file changed by `change` before it simulates.
pub(crate) fn equations_of(
    files: &[&SimulationFile],
    change: &dyn Fn(&SimulationFile, System) -> System,
) -> Result<EquationsSimulator> {
    let file = files[0];
    let (parameters, channels) = (file.parameters()?, declared::channels(file)?);
    declared::refuse_scale_without_lengths(file, &channels)?;
    let mut systems = Vec::with_capacity(files.len());
    for other in files {
        if other.headers() != file.headers()
            || other.starts().map(|(name, _)| name).ne(file.starts().map(|(name, _)| name))
        {
            let message = "recordings of one object: expected the same outputs and states in every setup, found others";
            return Err(Error::file(file.path(), message, "give recordings that differ in them another `object`"));
        }
        systems.push(change(other, system(other)?));
    }
    let states = files.iter().map(|file| declared::states(file)).collect::<Result<Vec<_>>>()?;
    declared::with_candidates(Declared::new(EquationsModel::new(systems), parameters, channels).setups(states), file)
}

/// The compiled equations of a file.
fn system(file: &SimulationFile) -> Result<System> {
    let parameters = file.parameters()?;
    let units: Vec<(&str, Option<&str>)> =
        parameters.iter().map(|p| (p.name.as_str(), file.written_unit(&p.name))).collect();
    System::new(file.equations()?, &units).map_err(|misfit| {
        let message = format!("`{}`: expected {}, found {}", misfit.path, misfit.expected, misfit.found);
        Error::file(
            file.path(),
            message,
            format!("`tunenet init {}` writes one to start from", Domain::Equations.name()),
        )
    })
}
