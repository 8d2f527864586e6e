//! What `diagnose` is asked to write, refused before anything is spent on it where it cannot be written.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_core::Origin;
use tunenet_formats::{Action, Error};

use crate::args::Diagnose;
use crate::commands::{load, models};
use crate::files::destination::{self, Output, Product};
use crate::files::manifest::Source;
use crate::files::names;
use crate::view::html;

/// Refuses outputs that cannot be written, or would replace what is read, before anything is spent on them. For several
/// objects `--out` is a folder, which is made.
pub fn writable(options: &Diagnose, sources: &[Source]) -> Result<()> {
    let several = several(sources.iter().map(|s| s.object.as_str()));
    let mut outputs: Vec<Output> = Vec::new();
    match &options.out {
        Some(out) if several => outputs.extend(of_objects(options, out, sources)?),
        Some(out) => outputs.push(Output::new(out, "--out", Product::Simulation)),
        None => {}
    }
    outputs.extend(models::outputs(&options.models)?);
    outputs.extend(options.out_ranges.iter().map(|out| Output::new(out, "--out-ranges", Product::Answer)));
    outputs.extend(options.report.iter().map(|report| Output::new(report, "--report", Product::Page)));
    let inputs = sources.iter().map(|s| s.path.as_path()).chain([options.simulation.sim.as_path()]);
    let references = sources.iter().filter_map(|s| s.reference.as_deref());
    let urdf = options.simulation.urdf_set();
    let own = input_files(options, sources);
    let named = inputs.chain(options.manifest.as_deref()).chain(references);
    let inputs: Vec<&Path> = named.chain(own.iter().map(PathBuf::as_path)).chain(urdf.as_deref()).collect();
    destination::check(&outputs, &inputs, options.writing.overwrite)?;
    if let (Some(out), true) = (&options.out, several) {
        // The page may not be the folder itself either.
        if options.report.as_deref() == Some(out) {
            let (expected, found) = ("another file than `--out`".into(), names::file_name(out));
            return Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: "--report", expected, found }.into());
        }
        std::fs::create_dir_all(out).map_err(|e| Error::io(out, Action::Creating, e))?;
    }
    Ok(())
}

/// The files of their own in which inputs of `sources` stand, each once.
pub fn input_files(options: &Diagnose, sources: &[Source]) -> Vec<PathBuf> {
    let all = load::own_files_of(&options.simulation, options.manifest.as_deref(), sources).concat();
    all.into_iter().collect::<BTreeSet<PathBuf>>().into_iter().collect()
}

/// What a report says of its origin.
pub fn provenance(options: &Diagnose, sources: &[Source]) -> html::Provenance {
    let scene = [options.simulation.sim.as_path()].into_iter().chain(options.manifest.as_deref());
    let own = input_files(options, sources);
    let named = sources.iter().flat_map(|s| [s.path.as_path()].into_iter().chain(s.reference.as_deref()));
    let read: Vec<&Path> = scene.chain(named).chain(own.iter().map(PathBuf::as_path)).collect();
    html::Provenance::new(options.common.seed, &read)
}

/// A file for each object in the folder `out`.
fn of_objects(options: &Diagnose, out: &Path, sources: &[Source]) -> Result<Vec<Output>> {
    if out.is_file() {
        let message = "expected a folder, since each object gets its own file, found a file";
        return Err(Error::file(out, message, "name a folder with --out").into());
    }
    let objects: BTreeSet<&str> = sources.iter().map(|s| s.object.as_str()).collect();
    let one = |object: &str| {
        let plain = object.chars().all(|c| c.is_alphanumeric() || "-_. ".contains(c));
        if !plain || object.starts_with('.') {
            let message = format!("`{object}` makes no file name for --out");
            let path = options.manifest.clone().unwrap_or_default();
            return Err(Error::file(path, message, "use letters, digits, -, _ and spaces in `object`").into());
        }
        let path = out.join(format!("{object}.toml"));
        Ok(Output { makes_folder: true, ..Output::new(&path, "--out", Product::Simulation) })
    };
    objects.into_iter().map(one).collect()
}

fn several<'a>(mut objects: impl Iterator<Item = &'a str>) -> bool {
    let first = objects.next();
    objects.any(|object| Some(object) != first)
}
