//! The derivatives of all states, also where surfaces stick and events rest: unknown sides and supports follow from a small linear
//! system (equivalent control: Utkin, "Sliding Modes in Control and Optimization", 1992; it is Filippov's solution where sides
//! appear linearly).

use tunenet_formula::Program;

use super::law::LawTerm;
use super::rate::rate;
use super::signal::Piece;
use super::system::System;

/// Most surfaces and supports that hold the motion at a time; a further one is crossed.
pub(super) const MOST_CONSTRAINTS: usize = 8;
/// Half of a difference along the motion, s: of rates that are exact, so that rounding alone limits it.
const DIFFERENCE_S: f64 = 1e-6;
/// What is smaller than this share of its row balances nothing.
const SINGULAR: f64 = 1e-12;
/// A side beyond both sides, for what no side can balance.
const BEYOND: f64 = 2.0;
/// Corrections where sides do not appear linearly.
const CORRECTIONS: usize = 3;

type Unknowns = [f64; MOST_CONSTRAINTS];

/// Where a switching surface stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Side {
    /// Nothing uses it in this rollout.
    Off,
    /// On one side: −1 or 1; 0 before the start.
    On(f64),
    /// The motion stays on it.
    Stuck,
}

/// What holds the motion on a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Constraint {
    /// A switching surface that sticks; its unknown is the side.
    Stuck(usize),
    /// An event whose impacts have come to rest; its unknown is how strongly it presses.
    Rests(usize),
}

/// The right-hand side of one rollout.
pub(super) struct Motion<'a> {
    pub system: &'a System,
    /// The first instant on the recording's clock, s.
    pub start_s: f64,
    /// The array of values that programs read.
    pub values: Vec<f64>,
    /// How fast each of them changes.
    rates: Vec<f64>,
    /// What candidates that are there add.
    added: Vec<(usize, &'a Program)>,
    /// The numbers of terms of a law.
    law_numbers: Vec<f64>,
    /// An instant of the present piece between the ends of windows, s.
    pub window_s: f64,
    /// Positions and pieces of inputs and delayed inputs.
    pub pieces: Vec<(usize, Piece)>,
    pub sides: Vec<Side>,
    /// The greatest magnitude of each surface's argument so far.
    pub greatest: Vec<f64>,
    /// The direction in which the support of a resting event acts.
    pub supports: Vec<Vec<f64>>,
    /// Whether an event can happen: its formula has been above zero since.
    pub armed: Vec<bool>,
    /// What an event gave a state that no state can be, for a message.
    pub unusable: Option<String>,
    pub constraints: Vec<Constraint>,
    /// The value of every constraint's unknown where derivatives were evaluated last.
    pub unknown: Unknowns,
    shifted: Vec<f64>,
    slopes: Vec<f64>,
    /// How often derivatives were evaluated.
    pub evaluations: usize,
}

/// Sets the clock, which starts at `start_s`, and what the pieces of inputs are at `t`.
#[inline]
fn drive(values: &mut [f64], (clock, start_s): (usize, f64), pieces: &[(usize, Piece)], t: f64) {
    values[clock] = start_s + t;
    for (slot, piece) in pieces {
        values[*slot] = piece.at(t);
    }
}

impl<'a> Motion<'a> {
    /// With these parameters and coefficients; inputs have no pieces yet.
    pub fn new(system: &'a System, parameters: &[f64], coefficients: &[f64], start_s: f64) -> Self {
        let (slots, n) = (&system.slots, system.states.len());
        let mut values = vec![0.0; slots.count];
        values[slots.parameters.clone()].copy_from_slice(parameters);
        values[slots.constants.clone()].copy_from_slice(&system.constants);
        let (coefficients, law_numbers) = coefficients.split_at(slots.coefficients.len());
        values[slots.coefficients.clone()].copy_from_slice(coefficients);
        system.fix(&mut values);
        let mut acting: Vec<bool> = system.candidates.iter().map(|adds| adds.acts(&values)).collect();
        let terms = system.candidates.iter().zip(&acting).filter(|(_, acts)| **acts).flat_map(|(adds, _)| &adds.terms);
        let added = terms.map(|term| (term.state, &term.program)).collect();
        acting.extend(system.laws.iter().map(|_| true));
        let used = |owner: &Option<usize>| owner.is_none_or(|number| acting[number]);
        let sides = system
            .surfaces
            .iter()
            .map(|surface| if surface.owners.iter().any(used) { Side::On(0.0) } else { Side::Off });
        Self {
            system,
            start_s,
            rates: vec![0.0; slots.count],
            added,
            law_numbers: law_numbers.to_vec(),
            window_s: start_s,
            pieces: Vec::new(),
            sides: sides.collect(),
            greatest: vec![0.0; system.surfaces.len()],
            supports: vec![Vec::new(); system.events.len()],
            unusable: None,
            armed: vec![false; system.events.len()],
            constraints: Vec::new(),
            unknown: Unknowns::default(),
            shifted: vec![0.0; n],
            slopes: vec![0.0; n],
            values,
            evaluations: 0,
        }
    }

    /// Whether the derivatives bend sharply somewhere.
    pub fn bends(&self) -> bool {
        let mut numbers = self.law_numbers.as_slice();
        let by_law = |law: &LawTerm| {
            let (own, rest) = numbers.split_at(law.numbers());
            numbers = rest;
            law.bends(own)
        };
        let system = self.system;
        system.bends
            || system.candidates.iter().any(|adds| adds.bends && adds.acts(&self.values))
            || system.laws.iter().any(by_law)
    }

    /// Lets programs read the state at an instant.
    pub fn load(&mut self, t: f64, state: &[f64]) {
        match state {
            // A copy of few numbers is shorter than the call that copies many.
            &[a, b] => (self.values[0], self.values[1]) = (a, b),
            _ => self.values[..state.len()].copy_from_slice(state),
        }
        drive(&mut self.values, (self.system.slots.clock, self.start_s), &self.pieces, t);
    }

    /// What programs read of a state at an instant.
    pub fn loaded(&self, t: f64, state: &[f64]) -> Vec<f64> {
        let mut values = self.values.clone();
        values[..state.len()].copy_from_slice(state);
        drive(&mut values, (self.system.slots.clock, self.start_s), &self.pieces, t);
        values
    }

    /// The derivatives of all states.
    pub fn field(&mut self, t: f64, state: &[f64], out: &mut [f64]) {
        if self.constraints.is_empty() { self.free(t, state, out) } else { self.held(t, state, out) }
    }

    /// Those with the present sides and without supports.
    fn free(&mut self, t: f64, state: &[f64], out: &mut [f64]) {
        self.load(t, state);
        self.evaluations += 1;
        for (value, program) in out.iter_mut().zip(&self.system.derivatives) {
            *value = program.value(&self.values);
        }
        for (state, program) in &self.added {
            out[*state] += program.value(&self.values);
        }
        let mut numbers = self.law_numbers.as_slice();
        for law in &self.system.laws {
            let (own, rest) = numbers.split_at(law.numbers());
            law.add(own, &self.values, self.window_s, out);
            numbers = rest;
        }
    }

    /// The instants at which windows of a law's terms begin and end, s since the start, rising.
    pub fn window_ends(&self) -> Vec<f64> {
        let (mut numbers, mut ends) = (self.law_numbers.as_slice(), Vec::new());
        for law in &self.system.laws {
            let (own, rest) = numbers.split_at(law.numbers());
            ends.extend(law.window(own).into_iter().flatten().map(|t| t - self.start_s));
            numbers = rest;
        }
        ends.retain(|t| *t > 0.0);
        ends.sort_by(f64::total_cmp);
        ends
    }

    /// Those that hold all constraints.
    fn held(&mut self, t: f64, state: &[f64], out: &mut [f64]) {
        let count = self.constraints.len();
        let mut x = Unknowns::default();
        let mut residual = self.departures(t, state, &x, out);
        let mut columns = [Unknowns::default(); MOST_CONSTRAINTS];
        for (j, column) in columns.iter_mut().enumerate().take(count) {
            let mut one = Unknowns::default();
            one[j] = 1.0;
            let moved = self.departures(t, state, &one, out);
            for i in 0..count {
                column[i] = moved[i] - residual[i];
            }
        }
        let scale = residual[..count].iter().fold(0.0_f64, |most, r| most.max(r.abs()));
        for _ in 0..CORRECTIONS {
            let step = solved(&columns, &residual, count);
            for j in 0..count {
                x[j] += step[j];
            }
            residual = self.departures(t, state, &x, out);
            let left = residual[..count].iter().fold(0.0_f64, |most, r| most.max(r.abs()));
            if left <= 1e-9 * scale || step[..count].iter().any(|s| s.abs() >= BEYOND) {
                break;
            }
        }
        self.unknown = x;
    }

    /// How fast the motion leaves every constraint, with these unknowns; the derivatives go to `out`.
    fn departures(&mut self, t: f64, state: &[f64], x: &Unknowns, out: &mut [f64]) -> Unknowns {
        for (constraint, x) in self.constraints.iter().zip(x) {
            if let Constraint::Stuck(surface) = constraint {
                self.values[self.system.surfaces[*surface].side] = *x;
            }
        }
        self.free(t, state, out);
        for (k, constraint) in self.constraints.iter().enumerate() {
            if let Constraint::Rests(event) = constraint {
                out.iter_mut().zip(&self.supports[*event]).for_each(|(value, support)| *value += x[k] * support);
            }
        }
        let mut leaving = Unknowns::default();
        for (k, leaves) in leaving.iter_mut().enumerate().take(self.constraints.len()) {
            *leaves = match self.constraints[k] {
                Constraint::Stuck(surface) => self.drift(surface, out),
                Constraint::Rests(event) => self.lift(event, t, state, out),
            };
        }
        self.load(t, state);
        leaving
    }

    /// The argument of a surface where the state is loaded.
    pub fn surface(&self, surface: usize) -> f64 {
        self.system.surfaces[surface].of.program.value(&self.values)
    }

    /// How fast the argument of a surface changes where the state is loaded and moves so.
    pub fn drift(&mut self, surface: usize, field: &[f64]) -> f64 {
        self.moving(field);
        rate(&self.system.surfaces[surface].of.tree, &self.values, &self.rates).1
    }

    fn moving(&mut self, field: &[f64]) {
        self.rates[..field.len()].copy_from_slice(field);
        self.rates[self.system.slots.clock] = 1.0;
        for (slot, piece) in &self.pieces {
            self.rates[*slot] = piece.slope;
        }
    }

    /// The formula of an event and how fast it changes, without supports.
    pub fn height(&mut self, event: usize, t: f64, state: &[f64]) -> (f64, f64) {
        let mut slopes = std::mem::take(&mut self.slopes);
        self.free(t, state, &mut slopes);
        self.moving(&slopes);
        self.slopes = slopes;
        rate(&self.system.events[event].when.tree, &self.values, &self.rates)
    }

    /// The second derivative of an event's formula where the state moves so.
    pub fn lift(&mut self, event: usize, t: f64, state: &[f64], field: &[f64]) -> f64 {
        let mut shifted = std::mem::take(&mut self.shifted);
        let mut at = |motion: &mut Self, by: f64| {
            for (value, (now, rate)) in shifted.iter_mut().zip(state.iter().zip(field)) {
                *value = now + by * rate;
            }
            motion.height(event, t + by, &shifted).1
        };
        let (after, before) = (at(self, DIFFERENCE_S), at(self, -DIFFERENCE_S));
        self.shifted = shifted;
        (after - before) / (2.0 * DIFFERENCE_S)
    }

    /// Writes the side of a surface.
    pub fn set_side(&mut self, surface: usize, side: f64) {
        self.sides[surface] = Side::On(side);
        self.values[self.system.surfaces[surface].side] = side;
    }
}

/// The solution of `columns x = −residual` by elimination with pivots (Gauss–Jordan). What has no influence stays 0; a row that
/// nothing can balance gets an unknown beyond what is possible.
fn solved(columns: &[Unknowns; MOST_CONSTRAINTS], residual: &Unknowns, count: usize) -> Unknowns {
    let mut rows = [[0.0; MOST_CONSTRAINTS + 1]; MOST_CONSTRAINTS];
    let mut scale = Unknowns::default();
    for i in 0..count {
        for j in 0..count {
            rows[i][j] = columns[j][i];
            scale[i] = scale[i].max(rows[i][j].abs());
        }
        rows[i][MOST_CONSTRAINTS] = -residual[i];
    }
    let (mut x, mut used) = (Unknowns::default(), [false; MOST_CONSTRAINTS]);
    let mut pivots = [usize::MAX; MOST_CONSTRAINTS];
    for j in 0..count {
        let share = |i: usize| rows[i][j].abs() / scale[i].max(f64::MIN_POSITIVE);
        let left = (0..count).filter(|i| !used[*i]);
        let Some(best) = left.max_by(|a, b| share(*a).total_cmp(&share(*b))) else { break };
        if share(best) <= SINGULAR {
            continue;
        }
        (used[best], pivots[j]) = (true, best);
        let pivot = rows[best];
        for (_, row) in rows.iter_mut().enumerate().take(count).filter(|(i, _)| *i != best) {
            let factor = row[j] / pivot[j];
            row.iter_mut().zip(&pivot).for_each(|(value, p)| *value -= factor * p);
        }
    }
    for j in 0..count {
        if pivots[j] != usize::MAX {
            x[j] = rows[pivots[j]][MOST_CONSTRAINTS] / rows[pivots[j]][j];
        }
    }
    for i in (0..count).filter(|i| !used[*i]) {
        if rows[i][MOST_CONSTRAINTS].abs() > 1e-9 * residual[i].abs() {
            x[i] = BEYOND * residual[i].signum();
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_redundant_is_balanced_once() {
        let mut columns = [Unknowns::default(); MOST_CONSTRAINTS];
        // Two rows of which one is twice the other, and a third that nothing balances.
        (columns[0][0], columns[0][1]) = (1.0, 2.0);
        (columns[1][0], columns[1][1]) = (1.0, 2.0);
        let mut residual = Unknowns::default();
        (residual[0], residual[1], residual[2]) = (0.5, 1.0, -3.0);
        let x = solved(&columns, &residual, 3);
        assert_eq!((x[0] + x[1], x[2]), (-0.5, -BEYOND));
    }
}
