//! From files to objects with their simulators, and recordings.

use anyhow::{Context, Result};
use tunenet_core::observation::{Kind, Note};
use tunenet_core::simulator::Simulator;
use tunenet_formats::{Error, kind_name};
use tunenet_sim::SimulationFile;
use tunenet_sim::replayed_arm::replays;

use crate::answers::diagnose::{Loaded, Object, Recorded};
use crate::args::Diagnose;
use crate::commands::load::{self, Setups};
use crate::files::manifest::Source;
use crate::files::{hash, names};

/// Most samples of one recording that are used; more would not sharpen the answer by as much as they cost.
const MOST_SAMPLES: usize = 4_000;

pub fn load(options: &Diagnose, sources: &[Source]) -> Result<Loaded> {
    let (mut recorded, mut notes): (Vec<Recorded>, Vec<Note>) = (Vec::new(), Vec::new());
    let (file, _) = load::simulation_with(&options.simulation, options.permission)?;
    let objects = grouped(options, sources, &file)?;
    for (i, source) in sources.iter().enumerate() {
        let name = names::file_name(&source.path);
        let (object, place) = place(&objects, i);
        let setups = &objects[object].setups;
        // A video's scale goes by what its own entry says of the ball.
        let scene = setups.file(place);
        let recording = load::recording_of(scene, setups.number(place), &source.path, &options.reading, MOST_SAMPLES)?;
        if let (Some(manifest), Some(_), false) = (&options.manifest, &source.reference, replays(scene)) {
            let message =
                "expected no `reference`, which only an arm's logs have (`motion.kind = \"replay\"`), found one";
            return Err(Error::file(manifest, message, "leave it out").into());
        }
        let recording =
            load::attach_reference(scene, recording, source.reference.as_deref(), &options.reading.numbers)?;
        let recording = setups.placed(place, recording);
        let several = sources.len() > 1;
        let named = |note: Note| if several { Note { text: format!("{name}: {}", note.text), ..note } } else { note };
        notes.extend(recording.notes.into_iter().map(named));
        let (hash, held_out, seen) = (hash::sha256(&source.path)?, source.held_out, recording.observation);
        let reference = source.reference.as_deref().map(hash::fingerprint).transpose()?;
        let inputs = hash::fingerprints(&load::own_files(scene, &source.path))?;
        let own = setups.differences().scene(place);
        recorded.push(Recorded { name, hash, object, held_out, seen, reference, inputs, own });
    }
    if options.out.is_some() {
        notes.extend(objects.iter().filter_map(|group| group.note(sources, objects.len())));
    }
    notes.extend(load::lacks(&file)?);
    let kind = one_kind(sources, &recorded)?;
    let objects = objects.iter().map(|group| object(options, sources, group, kind)).collect::<Result<_>>()?;
    Ok(Loaded { objects, recorded, notes })
}

/// The recordings of one object, by their positions among all, and their setups.
struct Group {
    recordings: Vec<usize>,
    setups: Setups,
}

impl Group {
    /// In what its recordings differ, with its name where there are several.
    fn note(&self, sources: &[Source], objects: usize) -> Option<Note> {
        let note = self.setups.differences().note()?;
        let object = &sources[self.recordings[0]].object;
        Some(if objects > 1 { Note { text: format!("{object}: {}", note.text), ..note } } else { note })
    }
}

/// The objects in the order in which they are met.
fn grouped(options: &Diagnose, sources: &[Source], file: &SimulationFile) -> Result<Vec<Group>> {
    let mut all: Vec<Vec<usize>> = Vec::new();
    for (i, source) in sources.iter().enumerate() {
        match all.iter_mut().find(|known| sources[known[0]].object == source.object) {
            Some(known) => known.push(i),
            None => all.push(vec![i]),
        }
    }
    let one = |recordings: Vec<usize>| {
        let entries: Vec<&Source> = recordings.iter().map(|i| &sources[*i]).collect();
        let setups = Setups::of(options.manifest.as_deref(), file, &entries)?;
        Ok(Group { recordings, setups })
    };
    all.into_iter().map(one).collect()
}

/// The object of a recording, and which of its recordings it is.
fn place(objects: &[Group], recording: usize) -> (usize, usize) {
    let within = |group: &Group| group.recordings.iter().position(|i| *i == recording);
    objects.iter().enumerate().find_map(|(o, group)| Some((o, within(group)?))).unwrap_or((0, 0))
}

/// All recordings have to be of one kind.
fn one_kind(sources: &[Source], recorded: &[Recorded]) -> Result<Kind> {
    let (first, kind) = (&recorded[0].name, recorded[0].seen.kind());
    let Some(other) = recorded.iter().position(|r| r.seen.kind() != kind) else { return Ok(kind) };
    let found = kind_name(recorded[other].seen.kind());
    let message = format!("expected {} as in {first}, found {found}", kind_name(kind));
    Err(Error::file(&sources[other].path, message, "diagnose recordings of each kind separately").into())
}

fn object(options: &Diagnose, sources: &[Source], group: &Group, kind: Kind) -> Result<Object> {
    let first = &sources[group.recordings[0]];
    let session = load::session(options.permission);
    let file = group.setups.common().clone();
    let mut simulator = group.setups.simulator(kind, &session).with_context(|| names::file_name(&first.path))?;
    // A coefficient that stands there may be wrong, and is tuned with the parameters; else it looks like something missing.
    let present = file.effects();
    let names = present.iter().map(|e| e.name.as_str());
    let shown: Vec<&str> = names.filter(|name| simulator.with_effects(&[*name]).is_ok()).collect();
    if !shown.is_empty() {
        simulator = simulator.with_effects(&shown)?;
    }
    let setups = group.setups.files().into_iter().cloned().collect();
    Ok(Object { name: first.object.clone(), file, session, simulator, setups })
}
