//! From files to objects with their simulators, and recordings.

use anyhow::{Context, Result};
use tunenet_core::observation::{Kind, Note};
use tunenet_core::simulator::Simulator;
use tunenet_formats::{Error, kind_name};
use tunenet_sim::replayed_arm::replays;
use tunenet_sim::simulator;

use super::scene::{in_scene, same_scene};
use crate::answers::diagnose::{Loaded, Object, Recorded};
use crate::args::Diagnose;
use crate::commands::load;
use crate::files::manifest::Source;
use crate::files::{hash, names};

/// Most samples of one recording that are used; more would not sharpen the answer by as much as they cost.
const MOST_SAMPLES: usize = 4_000;

pub fn load(options: &Diagnose, sources: &[Source]) -> Result<Loaded> {
    let (mut recorded, mut notes): (Vec<Recorded>, Vec<Note>) = (Vec::new(), Vec::new());
    let (file, _) = load::simulation_with(&options.simulation, options.permission)?;
    for source in sources {
        let name = names::file_name(&source.path);
        // A video's scale goes by what its own entry says of the ball.
        let scene = in_scene(options, source, &file)?;
        let recording = load::recording_of(&scene, &source.path, &options.reading, MOST_SAMPLES)?;
        if let (Some(manifest), Some(_), false) = (&options.manifest, &source.reference, replays(&scene)) {
            let message =
                "expected no `reference`, which only an arm's logs have (`motion.kind = \"replay\"`), found one";
            return Err(Error::file(manifest, message, "leave it out").into());
        }
        let recording = load::attach_reference(&scene, recording, source.reference.as_deref(), &options.reading)?;
        let several = sources.len() > 1;
        let named = |note: Note| if several { Note { text: format!("{name}: {}", note.text), ..note } } else { note };
        notes.extend(recording.notes.into_iter().map(named));
        let (hash, held_out, seen) = (hash::sha256(&source.path)?, source.held_out, recording.observation);
        let reference = source.reference.as_deref().map(hash::fingerprint).transpose()?;
        recorded.push(Recorded { name, hash, object: 0, held_out, seen, reference });
    }
    notes.extend(load::lacks(&file)?);
    let kind = one_kind(sources, &recorded)?;
    let mut objects: Vec<Object> = Vec::new();
    for (source, recorded) in sources.iter().zip(&mut recorded) {
        let known = objects.iter().position(|o| o.name == source.object);
        if let Some(at) = known {
            same_scene(options, source, &objects[at])?;
        } else {
            objects.push(object(options, source, kind)?);
        }
        recorded.object = known.unwrap_or(objects.len() - 1);
    }
    Ok(Loaded { objects, recorded, notes })
}

/// All recordings have to be of one kind.
fn one_kind(sources: &[Source], recorded: &[Recorded]) -> Result<Kind> {
    let (first, kind) = (&recorded[0].name, recorded[0].seen.kind());
    let Some(other) = recorded.iter().position(|r| r.seen.kind() != kind) else { return Ok(kind) };
    let found = kind_name(recorded[other].seen.kind());
    let message = format!("expected {} as in {first}, found {found}", kind_name(kind));
    Err(Error::file(&sources[other].path, message, "diagnose recordings of each kind separately").into())
}

fn object(options: &Diagnose, source: &Source, kind: Kind) -> Result<Object> {
    let (file, session) = load::simulation_with(&options.simulation, options.permission)?;
    let file = in_scene(options, source, &file)?;
    let mut simulator = simulator(&file, kind, &session).with_context(|| names::file_name(&source.path))?;
    // A coefficient that stands there may be wrong, and is tuned with the parameters; else it looks like something missing.
    let present = file.effects();
    let names = present.iter().map(|e| e.name.as_str());
    let shown: Vec<&str> = names.filter(|name| simulator.with_effects(&[*name]).is_ok()).collect();
    if !shown.is_empty() {
        simulator = simulator.with_effects(&shown)?;
    }
    Ok(Object { name: source.object.clone(), file, session, simulator, scene: source.scene.clone() })
}
