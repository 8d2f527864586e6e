//! Inputs as they were read, before it is known which instants they drive.

use std::path::Path;

use anyhow::Result;
use tunenet_formats::{Error, InputSource, NotedInput, ReadOptions, Recording, read_input, under_inputs};
use tunenet_sim::SimulationFile;

use super::input_files::own_file;
use super::inputs::sources;

/// Inputs as they were read, each with where it stands; `None` where its default replaces it.
pub struct ReadInputs(Vec<(InputSource, Option<NotedInput>)>);

impl ReadInputs {
    /// The inputs of `file` that drove the recording at `path`.
    ///
    /// # Errors
    /// Where an input cannot be read.
    pub fn of(file: &SimulationFile, path: &Path, options: &ReadOptions) -> Result<Self> {
        let mut found = Vec::new();
        for (source, input) in sources(file) {
            let own = own_file(input, path);
            if let Some(missing) = own.as_deref().filter(|own| !own.exists()) {
                let hint = format!("`file` of `[inputs.{}]` names it, from the folder of the recording", source.name);
                return Err(Error::file(missing, "no such file", hint).into());
            }
            let read = read_input(own.as_deref().unwrap_or(path), options, &source)?;
            found.push((source, read));
        }
        Ok(Self(found))
    }

    /// The first and the last stamp of all inputs that were read, s; `None` where defaults replace all of them.
    pub fn extent_s(&self) -> Option<(f64, f64)> {
        let clocks = self.0.iter().filter_map(|(_, read)| read.as_ref().map(|(input, _)| input.series().clock()));
        let ends = clocks.filter_map(|clock| Some((*clock.first()?, *clock.last()?)));
        ends.reduce(|(first, last), (begin, end)| (first.min(begin), last.max(end)))
    }

    /// `recording`, which was read from `path`, under these inputs and in this setup.
    ///
    /// # Errors
    /// Where an input does not overlap the recording.
    pub fn drive(self, path: &Path, recording: Recording, setup: usize) -> Result<Recording> {
        let (sources, found): (Vec<_>, Vec<_>) = self.0.into_iter().unzip();
        Ok(under_inputs(path, recording, setup, sources.iter().zip(found).collect())?)
    }
}

/// `recording`, which was read from `path`, with the inputs of `file` and in this setup.
///
/// # Errors
/// As [`ReadInputs::of`] and [`ReadInputs::drive`].
pub fn attach(
    file: &SimulationFile,
    path: &Path,
    recording: Recording,
    setup: usize,
    options: &ReadOptions,
) -> Result<Recording> {
    ReadInputs::of(file, path, options)?.drive(path, recording, setup)
}
