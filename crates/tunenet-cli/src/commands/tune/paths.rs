//! What a `tune` reads and writes.

use std::path::Path;

use crate::args::Tune;
use crate::files::destination::{Output, Product};
use crate::view::html;

/// What is read, and must not be lost.
pub fn inputs(options: &Tune) -> impl Iterator<Item = &Path> {
    let scene = std::iter::once(options.simulation.sim.as_path());
    scene
        .chain(options.observation.iter().map(AsRef::as_ref))
        .chain(options.manifest.as_deref())
        .chain(options.model.as_deref())
        .chain(options.reference.as_deref())
}

/// What is written.
pub fn outputs(options: &Tune) -> Vec<Output> {
    let out = options.out.iter().map(|out| Output::new(out, "--out", Product::Simulation));
    let report = options.report.iter().map(|report| Output::new(report, "--report", Product::Page));
    let kept = options.checkpoint.iter().map(|kept| Output::new(kept, "--checkpoint", Product::Rollouts));
    out.chain(report).chain(kept).collect()
}

/// What a report says of its origin.
pub fn provenance(options: &Tune) -> html::Provenance {
    html::Provenance::new(options.common.seed, &inputs(options).collect::<Vec<_>>())
}
