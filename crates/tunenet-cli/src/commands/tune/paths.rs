//! What a `tune` reads and writes.

use std::path::{Path, PathBuf};

use anyhow::Result;

use super::manifest::entries;
use crate::args::Tune;
use crate::commands::{load, models};
use crate::files::destination::{Output, Product};
use crate::files::manifest::Source;
use crate::view::html;

/// What is read, and must not be lost.
pub fn inputs(options: &Tune) -> Vec<PathBuf> {
    let scene = std::iter::once(&options.simulation.sim).chain(&options.observation);
    let named = scene.chain(&options.manifest).chain(&options.model).chain(&options.reference);
    let mut read: Vec<PathBuf> = named.cloned().collect();
    for own in input_files(options).concat() {
        if !read.contains(&own) {
            read.push(own);
        }
    }
    read
}

/// The files of their own in which the inputs of each recording stand.
pub fn input_files(options: &Tune) -> Vec<Vec<PathBuf>> {
    let sources: Vec<Source> = if options.manifest.is_some() {
        // What is wrong with it is said where it is read.
        entries(options).unwrap_or_default()
    } else {
        options.observation.iter().map(|path| Source::alone(path, "", None)).collect()
    };
    load::own_files_of(&options.simulation, options.manifest.as_deref(), &sources)
}

/// What is written.
pub fn outputs(options: &Tune) -> Result<Vec<Output>> {
    let out = options.out.iter().map(|out| Output::new(out, "--out", Product::Simulation));
    let report = options.report.iter().map(|report| Output::new(report, "--report", Product::Page));
    let kept = options.checkpoint.iter().map(|kept| Output::new(kept, "--checkpoint", Product::Rollouts));
    let ranges = options.out_ranges.iter().map(|ranges| Output::new(ranges, "--out-ranges", Product::Answer));
    let models = models::outputs(&options.models)?;
    Ok(out.chain(report).chain(kept).chain(ranges).chain(models).collect())
}

/// What a report says of its origin.
pub fn provenance(options: &Tune) -> html::Provenance {
    let read = inputs(options);
    html::Provenance::new(options.common.seed, &read.iter().map(PathBuf::as_path).collect::<Vec<&Path>>())
}
