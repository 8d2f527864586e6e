//! A log: which of its topics can be used.

use std::path::Path;

use tunenet_formats::Log;
use tunenet_sim::SimulationFile;

use super::reading::{expected, recording};
use super::{Found, Standing};
use crate::answers::motion::Motion;
use crate::args::Inspect;
use crate::failure::refusal;
use crate::view::answer::Printout;
use crate::view::inspect::{joints, log, motion as render};

pub fn look(found: &Log, path: &Path, options: &Inspect, sim: Option<&SimulationFile>, shown: &mut Printout) -> Found {
    log::contents(found, shown);
    let usable = found.topics.iter().filter(|t| t.usable.is_ok()).count();
    let chosen = usable == 1 || options.reading.numbers.topic.is_some();
    let read = (chosen && found.ended.is_none()).then(|| recording(path, options, sim));
    let refused = read.as_ref().and_then(|read| read.as_ref().err()).map(refusal);
    let read = read.and_then(Result::ok);
    let notes = read.as_ref().map_or_else(|| found.notes.clone(), |r| r.notes.clone());
    shown.warn_all(&notes);
    let named = options.reading.numbers.topic.as_deref().filter(|_| read.is_some());
    let units = read.as_ref().and_then(|r| joints::units(&r.observation, shown));
    let motion = read.and_then(|r| Motion::of(&r.observation, expected(sim)));
    let rejected = refused.as_deref().or_else(|| motion.as_ref().and_then(Motion::rejected));
    if let Some(motion) = &motion {
        render::render(motion, shown);
    }
    log::verdict(found, path, rejected, named, shown);
    let joints = log::of_joints(found).is_some();
    let standing = match rejected {
        _ if usable == 0 && !joints && named.is_none() || found.ended.is_some() || refused.is_some() => {
            Standing::Refused
        }
        Some(_) => Standing::Unusable,
        None => Standing::Usable,
    };
    let object = log::object(found, motion.as_ref(), units.as_ref(), &notes, refused.as_deref());
    Found { object, standing, motion }
}
