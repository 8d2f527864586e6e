//! How many sets, recordings or draws of each kind a benchmark takes.

use crate::args::{BenchIntervals, BenchJoints, BenchLaw, BenchPreflight, BenchRegions};

/// How many are drawn of each kind by default: enough for shares of a percent, or to see that it works.
fn drawn(asked: Option<u32>, quick: bool) -> u32 {
    asked.unwrap_or(if quick { 100 } else { 1000 })
}

impl BenchPreflight {
    /// Records of each kind.
    pub fn count(&self) -> u32 {
        drawn(self.records, self.quick)
    }
}

impl BenchLaw {
    /// Sets of each law.
    pub fn count(&self) -> u64 {
        self.sets.unwrap_or(if self.quick { 1 } else { 20 })
    }
}

impl BenchJoints {
    /// Sets of each effect at each ratio.
    pub fn count(&self) -> u64 {
        self.sets.unwrap_or(if self.quick { 1 } else { 20 })
    }
}

impl BenchIntervals {
    /// Drops in each cell.
    pub fn count(&self) -> u32 {
        drawn(self.drops, self.quick)
    }
}

impl BenchRegions {
    /// Recordings in each cell.
    pub fn count(&self) -> u32 {
        drawn(self.draws, self.quick)
    }
}
