//! Switching surfaces (Filippov, "Differential Equations with Discontinuous Righthand Sides", 1988): where both one-sided motions
//! point at a surface, the motion stays on it until the side that holds it there is beyond −1 or 1.

use super::motion::{Constraint, MOST_CONSTRAINTS, Motion, Side};

/// A surface is reached where its argument is below this share of the greatest that it was.
const REACHED: f64 = 1e-10;
/// How far beyond −1 or 1 a side may be that is one of them but for rounding.
pub(super) const BEYOND_A_SIDE: f64 = 1e-9;
/// A support that presses less than this (unit of the event over s²) does not hold.
pub(super) const LIFTED: f64 = 1e-12;

impl Motion<'_> {
    /// Finds the side of every surface at a state that was reached by a jump, or on the surface `reached`.
    pub fn settle(&mut self, t: f64, state: &[f64], reached: Option<usize>) {
        self.load(t, state);
        // Arguments within arguments come first.
        for surface in 0..self.sides.len() {
            let Side::On(_) = self.sides[surface] else { continue };
            let value = self.surface(surface);
            self.greatest[surface] = self.greatest[surface].max(value.abs());
            if reached == Some(surface) || value.abs() <= REACHED * self.greatest[surface] {
                self.decide(surface, t, state);
                self.load(t, state);
            } else {
                self.set_side(surface, value.signum());
            }
        }
        self.release(t, state);
    }

    /// Crosses a surface that is reached, or stays on it.
    fn decide(&mut self, surface: usize, t: f64, state: &[f64]) {
        let before = self.sides[surface];
        let mut field = vec![0.0; state.len()];
        let mut leaving = |motion: &mut Self, side: f64| {
            motion.set_side(surface, side);
            motion.field(t, state, &mut field);
            motion.drift(surface, &field)
        };
        let (above, below) = (leaving(self, 1.0), leaving(self, -1.0));
        match (above > 0.0, below < 0.0) {
            // It leaves on both sides: it stays where it is.
            (true, true) => self.set_side(surface, if before == Side::On(-1.0) { -1.0 } else { 1.0 }),
            (true, false) => self.set_side(surface, 1.0),
            (false, true) => self.set_side(surface, -1.0),
            (false, false) if self.constraints.len() < MOST_CONSTRAINTS => {
                self.sides[surface] = Side::Stuck;
                self.constraints.push(Constraint::Stuck(surface));
            }
            (false, false) => self.set_side(surface, if above.abs() < below.abs() { 1.0 } else { -1.0 }),
        }
    }

    /// Lets go, one after the other, of what cannot hold.
    fn release(&mut self, t: f64, state: &[f64]) {
        let mut field = vec![0.0; state.len()];
        while !self.constraints.is_empty() {
            self.field(t, state, &mut field);
            let worst = (0..self.constraints.len()).map(|k| (k, self.hold(k))).min_by(|a, b| a.1.total_cmp(&b.1));
            match worst {
                Some((k, hold)) if hold < 0.0 => self.let_go(k),
                _ => break,
            }
        }
    }

    /// How far a constraint is from letting go; below 0 it does.
    pub fn hold(&self, k: usize) -> f64 {
        match self.constraints[k] {
            Constraint::Stuck(_) => 1.0 + BEYOND_A_SIDE - self.unknown[k].abs(),
            Constraint::Rests(_) => self.unknown[k] + LIFTED,
        }
    }

    /// Lets go of a constraint to the side on which it does not hold.
    pub fn let_go(&mut self, k: usize) {
        let side = self.unknown[k].signum();
        match self.constraints.remove(k) {
            Constraint::Stuck(surface) => self.set_side(surface, side),
            Constraint::Rests(event) => self.armed[event] = true,
        }
    }
}
