//! `tunenet inspect`.

mod log;
mod settings;
mod several;
mod table;
mod video;

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_formats::dataset::DatasetReader;
use tunenet_formats::load_model;
use tunenet_formats::{Contents, ReadOptions, Recording, contents_with};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{SimulationFile, process};

use super::load;
use crate::answers::motion::Motion;
use crate::args::Inspect;
use crate::failure::Exit;
use crate::files::names;
use crate::files::videos::is_video;
use crate::view::answer::Printout;
use crate::view::inspect::learned;

pub fn run(options: &Inspect) -> Result<Exit> {
    if let [path] = options.files.as_slice() {
        let mut shown = Printout::default();
        let found = look(path, options, &mut shown)?;
        shown.show(options.common.json, || found.object)?;
        return Ok(if found.usable { Exit::Done } else { Exit::Inconclusive });
    }
    several::run(options)
}

/// What was found in one file.
struct Found {
    object: Value,
    usable: bool,
    motion: Option<Motion>,
}

fn look(path: &Path, options: &Inspect, shown: &mut Printout) -> Result<Found> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let plain = |object: Value, usable: bool| Found { object, usable, motion: None };
    let mut found = match extension.as_str() {
        "toml" => plain(settings::look(path, shown)?, true),
        "safetensors" => plain(learned::model(&load_model(path)?, shown), true),
        _ if is_video(path) => {
            let (object, usable) = video::look(path, options.reading.camera_rate, shown)?;
            plain(object, usable)
        }
        _ => match contents_with(path, &reading(options)?)? {
            Contents::Table(found) => table::look(&found, path, options, shown),
            // What `gen` writes is a log too, though none of measurements.
            Contents::Log(found) => match DatasetReader::open(path).or_else(|_| DatasetReader::open_shard(path)) {
                Ok(reader) => {
                    let (header, shard) = (reader.header().clone(), reader.shard());
                    // Whether it is whole shows only at its end.
                    let broken = reader.into_iter().find_map(Result::err);
                    plain(learned::dataset(&header, shard, broken.as_ref(), shown), broken.is_none() && shard.is_none())
                }
                Err(_) => log::look(&found, path, options, shown),
            },
        },
    };
    found.object["schema"] = json!("tunenet.inspect/1");
    found.object["file"] = json!(names::file_name(path));
    found.object["usable"] = json!(found.usable);
    Ok(found)
}

/// How files are read; where a program simulates, by its channels.
fn reading(options: &Inspect) -> Result<ReadOptions> {
    let mut reading = load::reading(&options.reading);
    if let Some(sim) = &options.sim {
        let file = SimulationFile::read(sim)?;
        load::of_kind(&file, Domain::Process)?;
        reading.channels = process::channels(&file)?;
    }
    Ok(reading)
}

/// The recording in a file, as `tune` looks at it.
fn recording(path: &Path, options: &Inspect) -> Result<Recording> {
    match &options.sim {
        Some(sim) => load::of_channels(&SimulationFile::read(sim)?, path, &options.reading, load::MOST_SAMPLES),
        None => load::recording(path, &options.reading),
    }
}
