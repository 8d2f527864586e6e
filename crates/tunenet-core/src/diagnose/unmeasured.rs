//! Axes that nobody measured: what acts along them alone is neither free nor a candidate.

use super::columns::stack;
use super::joint::{Joint, Point, Which, dot};
use super::sets::Set;
use super::study::{Model, Study};
use crate::Result;

/// A coefficient that moves the recordings by less than this share of what another of its effect does is not seen.
const UNSEEN_SHARE: f64 = 1e-3;
/// An own unknown whose whole range moves nothing by more than this (in units of the noise) is held at its guess ...
const SILENT: f64 = 0.01;
/// ... by a pull of this share of its range.
const HELD_SHARE: f64 = 1e-6;

impl Study<'_> {
    /// Holds own unknowns along axes that were not measured, and frees no coefficient that acts along them alone. A start
    /// velocity across the picture would otherwise turn spin into any force within it.
    pub fn leave_out_unmeasured(&mut self, base: &Model, held_out: &mut [Set]) -> Result<()> {
        if self.sets.iter().chain(held_out.iter()).all(|set| set.unmeasured().is_empty()) {
            return Ok(());
        }
        let point = base.fit.point.clone();
        let structure = self.structure(&[])?;
        for (sets, own) in [(&mut self.sets[..], Some(&point.own)), (held_out, None)] {
            let own = own.cloned().unwrap_or_else(|| sets.iter().map(|s| s.prepared.own_values()).collect());
            let here = Point { globals: point.globals.clone(), own };
            let joint = Joint { structure: &structure, sets, rollouts: &self.rollouts };
            let residuals = joint.residuals(&here, 1.0)?;
            let columns = joint.columns(&here, &residuals, Which::ALL);
            for (set, one) in sets.iter_mut().zip(&columns) {
                set.hold_silent(&one.own);
            }
        }
        for entry in 0..self.catalogue.len() {
            if self.catalogue[entry].seen.len() > 1 {
                self.catalogue[entry].seen = self.seen(entry, base)?;
            }
        }
        Ok(())
    }

    /// Which coefficients of an effect the recordings depend on.
    fn seen(&self, entry: usize, base: &Model) -> Result<Vec<bool>> {
        let structure = self.structure(&[entry])?;
        let known = base.structure.globals.len();
        let globals = structure.carry(&base.structure, &base.fit.point.globals);
        let point = Point { globals, own: base.fit.point.own.clone() };
        let which = Which { first: known, own: false, ..Which::ALL };
        let columns = self.joint(&structure).columns(&point, &base.fit.residuals, which);
        let lengths: Vec<usize> = base.fit.residuals.iter().map(Vec::len).collect();
        let mut sizes = vec![0.0f64; self.catalogue[entry].seen.len()];
        for (place, global) in structure.globals.iter().enumerate().skip(known) {
            let column = stack(&columns, &lengths, place);
            if let Some((_, k)) = global.effect {
                sizes[k] = sizes[k].max(dot(&column, &column).sqrt());
            }
        }
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        Ok(sizes.into_iter().map(|size| largest <= 0.0 || size > UNSEEN_SHARE * largest).collect())
    }
}

impl Set {
    /// Channels of which nothing counts.
    fn unmeasured(&self) -> Vec<usize> {
        let width = self.width();
        (0..width).filter(|c| !self.keep.iter().skip(*c).step_by(width).any(|keep| *keep)).collect()
    }

    /// Holds the own unknowns with these derivatives of the white residuals where they move nothing.
    fn hold_silent(&mut self, columns: &[Vec<f64>]) {
        if self.unmeasured().is_empty() {
            return;
        }
        for ((pull, own), column) in self.pull.iter_mut().zip(&self.prepared.own).zip(columns) {
            if dot(column, column).sqrt() * own.span() < SILENT {
                *pull = HELD_SHARE * own.span();
            }
        }
    }
}
