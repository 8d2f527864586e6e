//! Free flights of a record: the stretches in which only gravity and air act, in any unit.

use std::ops::Range;

use crate::segmentation::Arcs;
use crate::segmentation::parabolas::{MOST_SAMPLES, parabolas};
use crate::segmentation::polynomial::Polynomial;
use crate::segmentation::span;
use tunenet_core::observation::{Observation, noise_sd};
use tunenet_core::statistics::median;

/// Fewest samples of a flight whose acceleration is asked for.
const FEWEST: usize = 5;
/// A flight is used where noise leaves its acceleration unsure by less than this share of it.
const MOST_UNSURE: f64 = 0.3;
/// Flights of one record fall alike to this share, air included, in addition to the uncertainty from noise.
const ALIKE: f64 = 0.25;
/// A flight strays from its parabola by less than this many times the noise ...
const MISFIT_NOISE: f64 = 2.5;
/// ... and this share of its range of heights, air included.
const MISFIT_SHARE: f64 = 0.02;
/// A flight covers at least this share of all heights: what drifts while it rests bends too.
const LEAST_RANGE_SHARE: f64 = 0.02;
/// Flights that fall as expected speak for the record where they last for this share of those that agree otherwise.
const EXPECTED_SHARE: f64 = 0.2;
/// Without noise, a record is known to this share of its range.
const LEAST_NOISE_SHARE: f64 = 1e-9;

/// One stretch of free flight.
#[derive(Debug, Clone)]
pub(crate) struct Flight {
    pub samples: Range<usize>,
    pub fit: Polynomial,
}

impl Flight {
    /// How fast it falls, in the units of the record.
    pub fn acceleration(&self) -> f64 {
        -2.0 * self.fit.coefficients[2]
    }
}

/// All flights of a record.
#[derive(Debug, Clone)]
pub(crate) struct Flights {
    pub flights: Vec<Flight>,
    /// Standard deviation of the noise on the height.
    pub noise: f64,
}

impl Flights {
    /// The flights of `seen`. Where it has few samples enough, it is cut with no gravity assumed; else where `arcs` found
    /// kinks.
    pub fn find(seen: &Observation, arcs: &Arcs, expected: f64) -> Self {
        let heights: Vec<f64> = seen.column(2).collect();
        if seen.len() <= MOST_SAMPLES {
            return Self::within(seen.clock(), &heights, parabolas(seen.clock(), &heights), expected);
        }
        let bounds = [0].into_iter().chain(arcs.kinks.iter().map(|k| k + 1)).chain([seen.len()]).collect::<Vec<_>>();
        let mut pieces: Vec<Range<usize>> = bounds.windows(2).map(|w| w[0]..w[1]).collect();
        // What comes before the release is no flight.
        for piece in &mut pieces {
            if piece.contains(&arcs.usable.start) {
                piece.start = arcs.usable.start;
            }
        }
        let near = Self::within(seen.clock(), &heights, pieces, expected);
        if !near.flights.is_empty() {
            return near;
        }
        let Some(fewer) = seen.thinned(MOST_SAMPLES).ok().flatten() else { return near };
        let heights: Vec<f64> = fewer.column(2).collect();
        let found = Self::within(fewer.clock(), &heights, parabolas(fewer.clock(), &heights), expected);
        // The places of samples are those of the whole record.
        let every = seen.len().div_ceil(MOST_SAMPLES);
        let whole = |f: Flight| Flight { samples: f.samples.start * every..(f.samples.end - 1) * every + 1, ..f };
        Self { flights: found.flights.into_iter().map(whole).collect(), ..found }
    }

    fn within(clock: &[f64], heights: &[f64], pieces: Vec<Range<usize>>, expected: f64) -> Self {
        let range = span(heights);
        let noise = noise_sd(heights).max(LEAST_NOISE_SHARE * range);
        let flight = |samples: Range<usize>| -> Option<Flight> {
            if samples.len() < FEWEST {
                return None;
            }
            let (time, height) = (&clock[samples.clone()], &heights[samples.clone()]);
            let fit = Polynomial::fit(time, height, time[0].midpoint(time[time.len() - 1]), None)?;
            let flight = Flight { samples, fit };
            let strays = MISFIT_NOISE * noise + MISFIT_SHARE * span(height);
            let sure = 2.0 * flight.fit.curvature_gain() * noise < MOST_UNSURE * flight.acceleration();
            (sure && flight.fit.residual_sd < strays && span(height) > LEAST_RANGE_SHARE * range).then_some(flight)
        };
        let inner = |piece: Range<usize>| {
            // The sample next to a cut may belong to the other side.
            let start = piece.start + usize::from(piece.start > 0);
            start..(piece.end - usize::from(piece.end < clock.len())).max(start)
        };
        let mut flights: Vec<Flight> = pieces.into_iter().filter_map(|piece| flight(inner(piece))).collect();
        meet(clock, &mut flights, &flight);
        agree(clock, &mut flights, noise, expected);
        Self { flights, noise }
    }
}

/// Keeps the flights that fall alike: those that fall as expected, or else those that fill most of the time.
fn agree(clock: &[f64], flights: &mut Vec<Flight>, noise: f64, expected: f64) {
    let lasts = |f: &Flight| clock[f.samples.end - 1] - clock[f.samples.start];
    let alike = |f: &Flight, to: f64| {
        let unsure = 3.0 * 2.0 * f.fit.curvature_gain() * noise;
        (f.acceleration() - to).abs() < ALIKE * to + unsure
    };
    let supports = |to: f64| flights.iter().filter(|f| alike(f, to)).map(lasts).sum::<f64>();
    let best = flights.iter().map(|f| (f.acceleration(), supports(f.acceleration())));
    let Some((leader, most)) = best.max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let leader = if supports(expected) > EXPECTED_SHARE * most { expected } else { leader };
    let middle = median(flights.iter().filter(|f| alike(f, leader)).map(Flight::acceleration)).unwrap_or(0.0);
    flights.retain(|f| alike(f, middle));
}

/// Cuts neighbouring flights where their parabolas cross, which is sharper than a cut between samples: a sample from beyond
/// the impact would bend the parabola.
fn meet(clock: &[f64], flights: &mut [Flight], again: &dyn Fn(Range<usize>) -> Option<Flight>) {
    for i in 1..flights.len() {
        let (before, after) = (&flights[i - 1], &flights[i]);
        if after.samples.start - before.samples.end > 3 {
            continue;
        }
        let (low, high) = (before.samples.end.saturating_sub(3), (after.samples.start + 3).min(clock.len() - 1));
        let sinks = |i: usize| before.fit.at(clock[i]) < after.fit.at(clock[i]);
        // The first sample at which the ball would have fallen on below where it is.
        let Some(first) = (low..=high).find(|&i| sinks(i)) else { continue };
        let (end, start) = (first.saturating_sub(1).min(before.samples.end), (first + 1).max(after.samples.start));
        if end <= before.samples.start || start >= after.samples.end {
            continue;
        }
        let (old, new) = (before.samples.start..end, start..after.samples.end);
        if let (Some(old), Some(new)) = (again(old), again(new)) {
            (flights[i - 1], flights[i]) = (old, new);
        }
    }
}
