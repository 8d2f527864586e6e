//! A table whose columns have names of their own: those of a robot's joints, or of channels of a simulation of one's own.

use std::path::Path;

use tunenet_core::observation::{Kind, Note};
use tunenet_formats::{Described, Table};
use tunenet_sim::robot::rare_samples;

use super::{Found, Standing};
use crate::args::Inspect;
use crate::commands::load;
use crate::failure::{hint, sentence};
use crate::view::answer::Printout;
use crate::view::inspect::{described, table};

/// What is in it, where it is read by its clock as any of its columns is.
pub fn look(found: &Table, columns: &Described, path: &Path, options: &Inspect, shown: &mut Printout) -> Found {
    let noticed = load::reading(&options.reading.numbers).and_then(|reading| Ok(columns.noticed(path, &reading)?));
    let mut notes = found.notes.clone();
    notes.extend(noticed.iter().flatten().filter(|note| !found.notes.contains(note)).cloned().collect::<Vec<Note>>());
    notes.extend(rare(found));
    table::contents(found, shown);
    shown.warn_all(&notes);
    let refused = noticed.as_ref().err().map(sentence);
    let usable = refused.as_deref().map_or(Ok(Kind::Other), Err);
    let remedy = noticed.as_ref().err().and_then(|error| hint(error)).unwrap_or_default();
    table::verdict(usable, None, remedy, shown);
    if usable.is_ok() {
        described::next(columns, path, shown);
    }
    let object = table::object(found, usable, None, None, &notes, remedy);
    Found { object, standing: if usable.is_ok() { Standing::Usable } else { Standing::Refused }, motion: None }
}

/// That its samples are too rare for the motion of a joint.
pub fn rare(found: &Table) -> Option<Note> {
    rare_samples(found.median_rate_hz?.recip())
}
