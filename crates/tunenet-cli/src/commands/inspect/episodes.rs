//! A recording in several episodes: what is in it, and whether an episode that is named can be read.

use std::path::Path;

use tunenet_formats::Episodes;
use tunenet_sim::SimulationFile;

use super::reading::recording;
use super::{Found, Standing};
use crate::args::Inspect;
use crate::failure::refusal;
use crate::view::answer::Printout;
use crate::view::inspect::episodes;

pub fn look(
    found: &Episodes,
    path: &Path,
    options: &Inspect,
    sim: Option<&SimulationFile>,
    shown: &mut Printout,
) -> Found {
    episodes::contents(found, shown);
    shown.warn_all(&found.notes);
    // One that is named, or the only one, is read as a simulation asks for it.
    let single = !path.exists() || found.episodes.len() == 1;
    let asked = sim.is_some() || !options.reading.numbers.columns.is_empty();
    let read = (single && asked).then(|| recording(path, options, sim));
    let refused = read.as_ref().and_then(|read| read.as_ref().err()).map(refusal);
    let notes = read.and_then(Result::ok).map_or_else(Vec::new, |recording| recording.notes);
    shown.warn_all(&notes);
    episodes::verdict(found, path, refused.as_deref(), shown);
    let standing = if refused.is_some() { Standing::Refused } else { Standing::Usable };
    let object = episodes::object(found, &notes, refused.as_deref());
    Found { object, standing, motion: None }
}
