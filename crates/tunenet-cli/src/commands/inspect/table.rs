//! A table of numbers: whether it can be read as a recording, and used.

use std::path::Path;

use tunenet_core::observation::{Channel, Kind};
use tunenet_formats::Table;
use tunenet_sim::SimulationFile;

use super::reading::{expected, on_channels, recording};
use super::{Found, Standing, own_names};
use crate::answers::motion::Motion;
use crate::args::Inspect;
use crate::failure::{hint, sentence};
use crate::view::answer::Printout;
use crate::view::inspect::{described, joints, motion as render, table};

pub fn look(
    found: &Table,
    path: &Path,
    options: &Inspect,
    sim: Option<&SimulationFile>,
    shown: &mut Printout,
) -> Found {
    if let Some(columns) = described::of(found).filter(|_| found.channels.is_empty() && sim.is_none()) {
        return own_names::look(found, columns, path, options, shown);
    }
    // With `--columns` the file is what the mapping makes of it.
    let mapped = !options.reading.numbers.columns.is_empty();
    let readable = if mapped { Ok(()) } else { found.usable.clone().map(|_| ()).map_err(|reason| (reason, None)) };
    let refused = |error: anyhow::Error| (sentence(&error), hint(&error).map(str::to_owned));
    let recorded = || match found.channels.as_slice() {
        [] => recording(path, options, sim),
        channels => on_channels(path, options, channels.to_vec()),
    };
    let read = readable.and_then(|()| recorded().map_err(refused));
    // What reading it as a recording says goes further than what the table alone shows.
    let mut notes = read.as_ref().map_or_else(|_| found.notes.clone(), |r| r.notes.clone());
    let other = read.as_ref().is_ok_and(|read| read.observation.kind() == Kind::Other);
    notes.extend(own_names::rare(found).filter(|_| other));
    let motion = read.as_ref().ok().and_then(|r| Motion::of(&r.observation, expected(sim)));
    table::contents(found, shown);
    shown.warn_all(&notes);
    let units = read.as_ref().ok().and_then(|r| joints::units(&r.observation, shown));
    if let Some(motion) = &motion {
        render::render(motion, shown);
    }
    let usable = match (&read, motion.as_ref().and_then(Motion::rejected)) {
        (Err((reason, _)), _) => Err(reason.as_str()),
        (Ok(_), Some(reason)) => Err(reason),
        (Ok(recording), None) => Ok(recording.observation.kind()),
    };
    let tried = read.as_ref().err().and_then(|(_, hint)| hint.clone());
    let remedy = tried.unwrap_or_else(|| remedy(found, options));
    table::verdict(usable, motion.as_ref(), &remedy, shown);
    if let Some(columns) = described::of(found).filter(|_| usable.is_ok()) {
        described::next(columns, path, shown);
    }
    let object = table::object(found, usable, motion.as_ref(), units.as_ref(), &notes, &remedy);
    let standing = match (&read, usable) {
        (Err(_), _) => Standing::Refused,
        (Ok(_), Err(_)) => Standing::Unusable,
        (Ok(_), Ok(_)) => Standing::Usable,
    };
    Found { object, standing, motion }
}

/// What to type; where columns could be the channels or inputs of a program, that as well.
fn remedy(found: &Table, options: &Inspect) -> String {
    let timed = found.columns.iter().any(|c| c.read_as.as_deref() == Some("t_s"));
    let named = found.columns.iter().filter(|c| c.read_as.is_none() && Channel::from_header(&c.name).is_some());
    let channels: Vec<String> = named.map(|c| format!("`{}`", c.name)).collect();
    if options.sim.is_some() || !timed || channels.is_empty() {
        return found.remedy.clone();
    }
    let program =
        format!("{} may be of your own simulator: pass its simulation file with `--sim`", channels.join(", "));
    if found.remedy.is_empty() { program } else { format!("{}; {program}", found.remedy) }
}
