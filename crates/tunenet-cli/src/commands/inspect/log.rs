//! An MCAP log: which of its topics can be used.

use std::path::Path;

use tunenet_formats::Log;

use super::{Found, Standing, recording};
use crate::answers::motion::Motion;
use crate::args::Inspect;
use crate::view::answer::Printout;
use crate::view::inspect::{joints, log, motion as render};

pub fn look(found: &Log, path: &Path, options: &Inspect, shown: &mut Printout) -> Found {
    log::contents(found, shown);
    let usable = found.topics.iter().filter(|t| t.usable.is_ok()).count();
    let chosen = usable == 1 || options.reading.topic.is_some();
    let read = (chosen && found.ended.is_none()).then(|| recording(path, options).ok()).flatten();
    let notes = read.as_ref().map_or_else(Vec::new, |r| r.notes.clone());
    shown.warn_all(&notes);
    let units = read.as_ref().and_then(|r| joints::units(&r.observation, shown));
    let motion = read.and_then(|r| Motion::of(&r.observation));
    let rejected = motion.as_ref().and_then(Motion::rejected);
    if let Some(motion) = &motion {
        render::render(motion, shown);
    }
    log::verdict(found, rejected, shown);
    let standing = match rejected {
        _ if usable == 0 || found.ended.is_some() => Standing::Refused,
        Some(_) => Standing::Unusable,
        None => Standing::Usable,
    };
    Found { object: log::object(found, motion.as_ref(), units.as_ref(), &notes), standing, motion }
}
