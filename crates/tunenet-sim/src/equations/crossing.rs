//! Where within a step something first falls below zero: checks along the dense output, then regula falsi with halved ends (Illinois;
//! Dowell & Jarratt, BIT 11, 1971) and bisection.

use super::motion::{Motion, Side};
use super::runge_kutta::Stepper;

/// Shares of a step at which it is checked whether something has crossed zero.
const CHECKED: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// How exactly a crossing is located, s.
const EXACT_S: f64 = 1e-13;
const MOST_ROUNDS: usize = 80;
/// What is below this share of the greatest is zero.
const ZERO: f64 = 1e-13;

/// What is watched during a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Watch {
    /// A surface on one side.
    Surface(usize),
    /// A constraint, by its position.
    Hold(usize),
    /// An event that is armed.
    Event(usize),
}

/// What was found in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Found {
    /// Nothing crosses zero.
    Nothing,
    /// Something does, at this share of the step.
    Crossing(Watch, f64),
    /// What leaves zero at the beginning of the step is back before the first check: the step is too long.
    TooLong,
}

/// Everything that has to be watched.
pub(super) fn watched(motion: &Motion, all: &mut Vec<Watch>) {
    all.clear();
    let surfaces = motion.sides.iter().enumerate();
    all.extend(surfaces.filter(|(_, side)| matches!(side, Side::On(_))).map(|(s, _)| Watch::Surface(s)));
    all.extend((0..motion.constraints.len()).map(Watch::Hold));
    all.extend((0..motion.armed.len()).filter(|event| motion.armed[*event]).map(Watch::Event));
}

/// What is watched, where the state is this: above 0 as long as nothing happens.
fn value(motion: &mut Motion, watch: Watch, t: f64, state: &[f64], scratch: &mut [f64]) -> f64 {
    match watch {
        Watch::Surface(s) => {
            if !motion.constraints.is_empty() {
                // Arguments may use sides that stick.
                motion.field(t, state, scratch);
            }
            motion.load(t, state);
            let Side::On(side) = motion.sides[s] else { return 1.0 };
            side * motion.surface(s)
        }
        Watch::Hold(k) => {
            motion.field(t, state, scratch);
            motion.hold(k)
        }
        Watch::Event(event) => {
            motion.load(t, state);
            motion.system.events[event].when.program.value(&motion.values)
        }
    }
}

/// The greatest magnitude that what is watched had.
fn size(motion: &Motion, heights: &[f64], watch: Watch) -> f64 {
    match watch {
        Watch::Surface(s) => motion.greatest[s],
        Watch::Event(event) => heights[event],
        Watch::Hold(_) => 0.0,
    }
}

/// The first crossing within a step whose interpolant is ready. `heights` are the greatest magnitudes of the events' formulas.
pub(super) fn first(
    motion: &mut Motion,
    stepper: &Stepper,
    watches: &[Watch],
    heights: &mut [f64],
    scratch: &mut (Vec<f64>, Vec<f64>),
) -> Found {
    let (state, field) = (&mut scratch.0, &mut scratch.1);
    let mut found: Option<(Watch, f64)> = None;
    for watch in watches {
        let mut before = 0.0;
        for (i, share) in CHECKED.into_iter().enumerate() {
            if found.is_some_and(|(_, earlier)| before >= earlier) {
                break;
            }
            let here = at(motion, stepper, *watch, share, state, field);
            match watch {
                Watch::Surface(s) => motion.greatest[*s] = motion.greatest[*s].max(here.abs()),
                Watch::Event(event) => heights[*event] = heights[*event].max(here.abs()),
                Watch::Hold(_) => {}
            }
            let zero = ZERO * size(motion, heights, *watch);
            if here < -zero {
                if i == 0 && at(motion, stepper, *watch, 0.0, state, field) <= zero && stepper.h > EXACT_S {
                    return Found::TooLong;
                }
                let share = located(motion, stepper, *watch, (before, share), (state, field));
                if found.is_none_or(|(_, earlier)| share < earlier) {
                    found = Some((*watch, share));
                }
                break;
            }
            before = share;
        }
    }
    found.map_or(Found::Nothing, |(watch, share)| Found::Crossing(watch, share))
}

fn at(motion: &mut Motion, stepper: &Stepper, watch: Watch, share: f64, state: &mut [f64], field: &mut [f64]) -> f64 {
    if share == 1.0 {
        state.copy_from_slice(&stepper.end);
    } else {
        stepper.within(share, state);
    }
    value(motion, watch, stepper.t + share * stepper.h, state, field)
}

/// The share of the step at which what is watched is 0, just behind it.
fn located(
    motion: &mut Motion,
    stepper: &Stepper,
    watch: Watch,
    (mut low, mut high): (f64, f64),
    (state, field): (&mut [f64], &mut [f64]),
) -> f64 {
    let mut above = at(motion, stepper, watch, low, state, field);
    let mut below = at(motion, stepper, watch, high, state, field);
    if above <= 0.0 {
        return low;
    }
    for round in 0..MOST_ROUNDS {
        if (high - low) * stepper.h <= EXACT_S {
            break;
        }
        let secant = (low * below - high * above) / (below - above);
        let inside = secant > low && secant < high;
        let middle = if round % 4 == 3 || !inside { 0.5 * (low + high) } else { secant };
        if middle <= low || middle >= high {
            break;
        }
        let here = at(motion, stepper, watch, middle, state, field);
        if here > 0.0 {
            (low, above) = (middle, here);
            below *= 0.5;
        } else {
            (high, below) = (middle, here);
            above *= 0.5;
            if here == 0.0 {
                break;
            }
        }
    }
    high
}
