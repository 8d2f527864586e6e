//! Figure 3: the bounce shot, ball by ball (experiment 3 of the paper), as `bench shot` plays it.

use std::path::Path;

use anyhow::Result;

use super::super::resume::Store;
use super::super::shot::{self, Extent, ShotResults};
use crate::output::{file_of, write_all};

/// `None` where only a shard of it was made.
pub fn run(store: &Store, seed: u64, quick: bool) -> Result<Option<ShotResults>> {
    let results = shot::measure(store, Extent::plain(quick), seed)?;
    Ok((!store.sharded()).then_some(results))
}

/// The figure as a table for users.
pub fn markdown(results: &ShotResults) -> String {
    let quick = if results.quick { " --quick" } else { "" };
    format!(
        "# Figure 3: how often a ball recorded on video goes through the hoop\n\n    \
         tunenet bench paper --only figure3{quick} --seed {}\n\n\
         {} shots with each ball, in hidden worlds; ± the standard error. The paper reports 0.62 of all shots of a real robot, \
         and 0.87 without those after drops that went off the table (arXiv 1907.11200). The same shots as `tunenet bench shot`'s, \
         which says more of them.\n\n{}\n![Share of shots that go in, ball by ball](figure3.svg)\n",
        results.seed,
        results.trials,
        results.by_ball()
    )
}

/// Writes `figure3.md`, `figure3.json` and `figure3.svg`; none is ever half written.
pub fn write(folder: &Path, results: &ShotResults) -> Result<()> {
    write_all(
        folder,
        [
            ("figure3.md", markdown(results)),
            ("figure3.json", file_of(&results.as_json())),
            ("figure3.svg", results.figure()),
        ],
    )
}
