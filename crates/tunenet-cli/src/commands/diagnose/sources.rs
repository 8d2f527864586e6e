//! Which files to diagnose: from the command line, or from a manifest that groups them into objects.

use anyhow::Result;
use tunenet_formats::Error;
use tunenet_sim::SimulationFile;

use crate::args::Diagnose;
use crate::files::hash;
use crate::files::manifest::{ONLY, Source, read};

/// Everything that is to be read, in the order given. A recording that is given twice is refused, be it for training, held
/// out or as both.
pub fn sources(options: &Diagnose) -> Result<Vec<Source>> {
    let mut sources = Vec::new();
    if let Some(path) = &options.manifest {
        sources = read(path)?;
    }
    let given = options.observation.iter().map(|path| (path, false));
    for (path, held_out) in given.chain(options.held_out.iter().map(|path| (path, true))) {
        let (object, scene, reference) = (ONLY.to_owned(), vec![], options.reference.clone());
        sources.push(Source { path: path.clone(), object, held_out, reference, scene });
    }
    // What cannot be read is refused by whoever reads it.
    let kind = SimulationFile::read(&options.simulation.sim).map_or("ball", |file| file.domain().name());
    for source in sources.iter_mut().filter(|source| source.object == ONLY) {
        kind.clone_into(&mut source.object);
    }
    hash::refuse_copies(sources.iter().map(|s| s.path.as_path()))?;
    if let Some(first) = sources.first().filter(|_| sources.iter().all(|s| s.held_out)) {
        let message = "expected at least one recording to fit to, found only held-out ones";
        let (place, hint) = match &options.manifest {
            Some(manifest) => (manifest, "leave `held_out = true` out of those that are to be fitted"),
            None => (&first.path, "give one with --observation"),
        };
        return Err(Error::file(place, message, hint).into());
    }
    Ok(sources)
}
