//! `tunenet inspect`.

mod episodes;
mod listing;
mod log;
mod manifest;
mod own_names;
mod reading;
mod robot_model;
mod settings;
mod several;
mod table;
mod video;

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_formats::dataset::DatasetReader;
use tunenet_formats::load_model;
use tunenet_formats::{Contents, contents_with};
use tunenet_sim::SimulationFile;

use crate::answers::motion::Motion;
use crate::args::Inspect;
use crate::exit_status::Exit;
use crate::files::names;
use crate::files::videos::is_video;
use crate::view::answer::Printout;
use crate::view::inspect::{declared, learned};

pub fn run(options: &Inspect) -> Result<Exit> {
    if let Some(manifest) = &options.manifest {
        return manifest::run(options, manifest);
    }
    if let [path] = options.files.as_slice() {
        let mut shown = Printout::default();
        let found = look(path, options, &mut shown)?;
        shown.show(options.common.json, || found.object)?;
        return Ok(found.standing.exit());
    }
    several::run(options)
}

/// What was found in one file.
struct Found {
    object: Value,
    standing: Standing,
    motion: Option<Motion>,
}

/// Whether a file can be used, and where not, what the other commands do with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Standing {
    Usable,
    /// It is read, and its contents are of no use: an answer of the checks.
    Unusable,
    /// It is refused as an error.
    Refused,
}

impl Standing {
    fn exit(self) -> Exit {
        match self {
            Self::Usable => Exit::Done,
            Self::Unusable => Exit::Inconclusive,
            Self::Refused => Exit::Refused,
        }
    }
}

fn look(path: &Path, options: &Inspect, shown: &mut Printout) -> Result<Found> {
    let sim = options.sim.as_deref().map(SimulationFile::read).transpose()?;
    look_in(path, options, sim.as_ref(), shown)
}

/// The same, with the channels and inputs of a simulation file.
fn look_in(path: &Path, options: &Inspect, sim: Option<&SimulationFile>, shown: &mut Printout) -> Result<Found> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let model = robot_model::format(path, &extension);
    let plain = |object: Value, standing: Standing| Found { object, standing, motion: None };
    let mut found = match (extension.as_str(), model) {
        (_, Some(format)) => plain(robot_model::look(path, format, shown)?, Standing::Usable),
        ("toml", _) => plain(settings::look(path, shown)?, Standing::Usable),
        ("safetensors", _) => plain(learned::model(&load_model(path)?, shown), Standing::Usable),
        _ if is_video(path) => {
            let (object, standing) = video::look(path, options.reading.camera_rate, shown)?;
            plain(object, standing)
        }
        _ => match contents_with(path, &reading::options(options, sim)?)? {
            Contents::Episodes(found) => episodes::look(&found, path, options, sim, shown),
            Contents::Table(found) => table::look(&found, path, options, sim, shown),
            // What `gen` writes is a log too, though none of measurements.
            Contents::Log(found) => match DatasetReader::open(path).or_else(|_| DatasetReader::open_shard(path)) {
                Ok(reader) => {
                    let (header, shard) = (reader.header().clone(), reader.shard());
                    // Whether it is whole shows only at its end.
                    let broken = reader.into_iter().find_map(Result::err);
                    let whole = broken.is_none() && shard.is_none();
                    let standing = if whole { Standing::Usable } else { Standing::Refused };
                    plain(learned::dataset(&header, shard, broken.as_ref(), shown), standing)
                }
                Err(_) => log::look(&found, path, options, sim, shown),
            },
        },
    };
    if let Some(sim) = sim {
        declared::show(sim, shown);
        declared::add_to(sim, &mut found.object)?;
    }
    found.object["schema"] = json!("tunenet.inspect/1");
    found.object["file"] = json!(names::file_name(path));
    found.object["usable"] = json!(found.standing == Standing::Usable);
    Ok(found)
}
