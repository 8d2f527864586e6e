//! Where within a step something first falls below zero: checks along the dense output, then regula falsi with halved ends (Illinois;
//! Dowell & Jarratt, BIT 11, 1971) and bisection. What falls below zero and is back before the next check is seen by the polynomial through
//! the checks, which a further check confirms: where it does not, the step is too long for what is watched (Shampine and Thompson 2000,
//! section 4).

use super::motion::{Motion, Side};
use super::runge_kutta::Stepper;

/// Shares of a step at which it is checked whether something has crossed zero.
const CHECKED: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Where the polynomial through these and the beginning is confirmed: no multiple of them.
const CONFIRMED: f64 = 0.381_966;
/// How well, as a share of the greatest magnitude within the step.
const WELL: f64 = 0.05;
/// The polynomial may fall below zero where a check is below this share of that, and is looked at in so many places.
const LOW: f64 = 0.5;
const PLACES: u32 = 24;
const CLOSER: usize = 3;
/// How exactly a crossing is located, s.
const EXACT_S: f64 = 1e-13;
const MOST_ROUNDS: usize = 80;
/// What is below this share of the greatest is zero.
const ZERO: f64 = 1e-13;
/// A formula that is above this share of its greatest where it changes its sign has a pole or a jump there.
const NOT_SMALL: f64 = 1e-3;
/// An event is armed where its formula is above this share of the greatest.
pub(super) const ARMED: f64 = 1e-9;

/// What is watched during a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Watch {
    /// A surface on one side.
    Surface(usize),
    /// A constraint, by its position.
    Hold(usize),
    /// An event that is armed.
    Event(usize),
    /// An event that is not: it will be where its formula is above zero at the end of a step.
    Unarmed(usize),
}

/// What was found in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Found {
    /// Nothing crosses zero.
    Nothing,
    /// Something does, at this share of the step.
    Crossing(Watch, f64),
    /// The formula of an event changes its sign at this share of the step without being zero there.
    Pole(usize, f64),
    /// What leaves zero at the beginning of the step is back before the first check, or what is watched changes too much within it: the step is
    /// too long.
    TooLong,
}

/// Everything that has to be watched.
pub(super) fn watched(motion: &Motion, all: &mut Vec<Watch>) {
    all.clear();
    let surfaces = motion.sides.iter().enumerate();
    all.extend(surfaces.filter(|(_, side)| matches!(side, Side::On(_))).map(|(s, _)| Watch::Surface(s)));
    all.extend((0..motion.constraints.len()).map(Watch::Hold));
    let events = (0..motion.armed.len()).filter(|event| !motion.rests_on(*event));
    all.extend(events.map(|event| if motion.armed[event] { Watch::Event(event) } else { Watch::Unarmed(event) }));
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
        Watch::Event(event) | Watch::Unarmed(event) => {
            motion.load(t, state);
            motion.system.events[event].when.program.value(&motion.values)
        }
    }
}

/// The greatest magnitude that what is watched had.
fn size(motion: &Motion, heights: &[f64], watch: Watch) -> f64 {
    match watch {
        Watch::Surface(s) => motion.greatest[s],
        Watch::Event(event) | Watch::Unarmed(event) => heights[event],
        Watch::Hold(_) => 0.0,
    }
}

/// The first crossing within a step whose interpolant is ready. `heights` are the greatest magnitudes of the events' formulas; the step is
/// only too long for what changes within it where it `may_shorten`.
pub(super) fn first(
    motion: &mut Motion,
    stepper: &Stepper,
    (watches, may_shorten): (&[Watch], bool),
    heights: &mut [f64],
    scratch: &mut (Vec<f64>, Vec<f64>),
) -> Found {
    let (state, field) = (&mut scratch.0, &mut scratch.1);
    let mut found: Option<(Found, f64)> = None;
    for watch in watches {
        let mut checks = [at(motion, stepper, *watch, 0.0, state, field), 0.0, 0.0, 0.0, 0.0];
        for (check, share) in checks[1..].iter_mut().zip(CHECKED) {
            *check = at(motion, stepper, *watch, share, state, field);
        }
        let greatest = checks.iter().fold(0.0_f64, |most, check| most.max(check.abs()));
        // The motion does not go on as the step has it behind a crossing.
        let until = checks.iter().position(|check| *check < 0.0).unwrap_or(CHECKED.len());
        let reached = checks[..=until].iter().fold(0.0_f64, |most, check| most.max(check.abs()));
        match watch {
            Watch::Surface(s) => motion.greatest[*s] = motion.greatest[*s].max(reached),
            Watch::Event(event) => heights[*event] = heights[*event].max(reached),
            Watch::Unarmed(event) => heights[*event] = heights[*event].max(greatest),
            Watch::Hold(_) => {}
        }
        let size = size(motion, heights, *watch);
        let zero = ZERO * size;
        let below = (1..checks.len()).find(|i| checks[*i] < -zero);
        let is_finite = checks.iter().all(|check| check.is_finite());
        let mut look = |share: f64| at(motion, stepper, *watch, share, state, field);
        if may_shorten && is_finite && (look(CONFIRMED) - quartic(&checks, CONFIRMED)).abs() > WELL * greatest {
            return Found::TooLong;
        }
        if let Watch::Unarmed(_) = watch {
            if stepper.h > EXACT_S && falls_again(&checks, ARMED * size) {
                return Found::TooLong;
            }
            continue;
        }
        if below == Some(1) && checks[0] <= zero && stepper.h > EXACT_S {
            return Found::TooLong;
        }
        // Up to the first check below zero, or over the whole step.
        let until = below.map_or(1.0, |i| CHECKED[i - 1]);
        let dip = if is_finite { dip(&checks, until).filter(|share| look(*share) < -zero) } else { None };
        let Some(high) = dip.or_else(|| below.map(|i| CHECKED[i - 1])) else { continue };
        let low = CHECKED.into_iter().filter(|share| *share < high).fold(0.0, f64::max);
        let share = located(motion, stepper, *watch, (low, high), (state, field));
        if found.as_ref().is_some_and(|(_, earlier)| *earlier <= share) {
            continue;
        }
        let here = at(motion, stepper, *watch, share, state, field).abs();
        let crossing = match watch {
            // At the beginning of a step an input or a side may have jumped.
            Watch::Event(event) if share > 0.0 && here > NOT_SMALL * size => Found::Pole(*event, share),
            _ => Found::Crossing(*watch, share),
        };
        found = Some((crossing, share));
    }
    found.map_or(Found::Nothing, |(crossing, _)| crossing)
}

/// Whether what is above zero within a step is not afterwards, beyond what counts as zero.
fn falls_again(checks: &[f64; 5], zero: f64) -> bool {
    let top = dip(&checks.map(|check| -check), 1.0).map(|share| (share, quartic(checks, share)));
    let at = [0.0, 0.25, 0.5, 0.75, 1.0];
    let known = at.into_iter().zip(*checks).chain(top);
    let rises = known.clone().filter(|(_, value)| *value > zero).map(|(share, _)| share).fold(f64::INFINITY, f64::min);
    known.into_iter().any(|(share, value)| share > rises && value <= zero)
}

/// The polynomial of degree 4 through values at 0, 1/4, 1/2, 3/4 and 1 (Newton's forward differences).
fn quartic(values: &[f64; 5], share: f64) -> f64 {
    let x = 4.0 * share;
    let mut differences = *values;
    let (mut sum, mut factor) = (values[0], 1.0);
    for order in 1..5 {
        for i in (order..5).rev() {
            differences[i] -= differences[i - 1];
        }
        factor *= (x - (order - 1) as f64) / order as f64;
        sum += factor * differences[order];
    }
    sum
}

/// Where that polynomial is lowest before `until`, where that is between two of the values, and one of these is low.
fn dip(values: &[f64; 5], until: f64) -> Option<f64> {
    let greatest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    if values.iter().all(|value| *value >= LOW * greatest) {
        return None;
    }
    let places = (1..PLACES).map(|i| f64::from(i) / f64::from(PLACES)).filter(|share| *share < until);
    let lowest = places.map(|share| (share, quartic(values, share))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    if lowest.1 >= least {
        return None;
    }
    // The vertex of the parabola through three places, ever closer.
    let (mut share, mut by) = (lowest.0, 1.0 / f64::from(PLACES));
    for _ in 0..CLOSER {
        let [before, here, after] = [share - by, share, share + by].map(|place| quartic(values, place));
        let bend = before - 2.0 * here + after;
        if bend > 0.0 {
            share += (0.5 * by * (before - after) / bend).clamp(-by, by);
        }
        by *= 0.1;
    }
    Some(share.min(until))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn checks(f: impl Fn(f64) -> f64) -> [f64; 5] {
        [0.0, 0.25, 0.5, 0.75, 1.0].map(f)
    }

    #[test]
    fn the_quartic_through_five_values_is_a_quartic() {
        let f = |x: f64| 0.3 - 2.0 * x + 7.0 * x.powi(2) - 5.0 * x.powi(3) + 1.5 * x.powi(4);
        let values = checks(f);
        for share in [0.0, 0.1, CONFIRMED, 0.75, 0.9, 1.0] {
            assert!((quartic(&values, share) - f(share)).abs() < 1e-14, "{share}");
        }
        // |x − 0.4| is none: it is seen at the place that confirms.
        let bent = |x: f64| (x - 0.4).abs();
        assert!((quartic(&checks(bent), CONFIRMED) - bent(CONFIRMED)).abs() > WELL * 0.6);
    }

    /// A parabola whose top is 0.01 below zero between two checks, and one whose top is 0.01 above it.
    #[test]
    fn what_falls_and_rises_between_two_checks_is_seen() {
        let parabola = |least: f64| checks(|x| least + 3.0 * (x - 0.61).powi(2));
        let found = dip(&parabola(-0.01), 1.0).unwrap();
        assert!((found - 0.61).abs() < 0.03, "{found}");
        assert!(dip(&parabola(-0.01), 0.5).is_none());
        assert!(dip(&checks(|x| 1.0 + x), 1.0).is_none());
        let hump = parabola(-0.01).map(|value| -value);
        assert!(falls_again(&hump, 1e-9) && !falls_again(&parabola(-0.01), 1e-9));
        assert!(!falls_again(&checks(|x| -0.01 - x), 1e-9) && falls_again(&checks(|x| (7.0 * x).sin() - 0.8), 1e-9));
    }
}
