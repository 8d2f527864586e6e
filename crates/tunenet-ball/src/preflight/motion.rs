//! The motion as a whole: is it that of a ball, who else touches it, when is it released and when does it rest.

use super::flights::{Flight, Flights};
use super::{Expected, share};
use crate::findings;
use crate::segmentation::span;
use crate::segmentation::{Arcs, Blows};
use tunenet_core::finding::FindingKind;
use tunenet_core::observation::Check;
use tunenet_core::observation::{FEWEST_SAMPLES, Observation, noise_sd};

/// A record that spans less than this along every axis, m, shows no motion.
const LEAST_MOTION_M: f64 = 1e-6;
/// What passes for gravity where there is no bounce, as a share of what is expected.
const PLAUSIBLE_GRAVITY: std::ops::Range<f64> = 0.25..2.0;
/// A flight strays from a parabola by less than this share of its range, air included.
const WORST_MISFIT_SHARE: f64 = 0.05;
/// Most blows whose times a sentence lists.
const BLOWS_SHOWN: usize = 4;

/// Whether anything moves.
pub(crate) fn moves(seen: &Observation) -> Check {
    const KIND: FindingKind = findings::MOTION_NONE;
    let still = (0..seen.channels().len()).all(|c| span(&seen.column(c).collect::<Vec<_>>()) < LEAST_MOTION_M);
    if still {
        let text = format!("the ball does not move in any of the {} samples", seen.len());
        return Check::failed(KIND, text, "check the columns and their units");
    }
    Check::passed(KIND, "the ball moves")
}

/// Whether a motion without a bounce is a flight at all.
pub(crate) fn like(seen: &Observation, arcs: &Arcs, flights: &Flights, expected: &Expected) -> Check {
    const KIND: FindingKind = findings::MOTION_UNLIKE;
    let remedy = "check the units and the sign of z, the unit of the time, and which column is which";
    if !arcs.contacts.is_empty() {
        return Check::passed(KIND, "it flies and bounces");
    }
    // A fall that ends in rest without a rebound that is seen, say.
    if falls(flights, expected) {
        return Check::passed(KIND, "it flies");
    }
    let (Some(apparent), Some(misfit)) = (arcs.apparent_gravity_m_s2, arcs.misfit_share) else {
        return Check::not_run(KIND, "too few samples without a bounce");
    };
    let gravity = expected.gravity_m_s2;
    // Five standard deviations: a short noisy flight is not rejected.
    let slack = 5.0 * apparent.sd;
    let plausible = PLAUSIBLE_GRAVITY.start * gravity - slack..PLAUSIBLE_GRAVITY.end * gravity + slack;
    if plausible.contains(&apparent.value) && misfit < WORST_MISFIT_SHARE {
        return Check::passed(KIND, "it flies");
    }
    if is_upside_down(seen, expected) {
        let text = "the height rises as that of a ball falls, so z points down";
        let remedy = "reverse the sign of its column with a minus: `--columns z_m=-NAME`";
        return Check::failed(KIND, text, remedy);
    }
    let text = if misfit > 1.0 {
        "the height does not change".to_string()
    } else if misfit < WORST_MISFIT_SHARE {
        format!("not a ball in flight: it falls at {:.3e} m/s², expected near {gravity}", apparent.value)
    } else {
        let percent = 100.0 * misfit;
        format!("neither a bounce nor a flight: the best parabola deviates by {percent:.0} % of the motion")
    };
    Check::failed(KIND, text, remedy)
}

/// Whether any flight falls as by gravity.
fn falls(flights: &Flights, expected: &Expected) -> bool {
    flights.flights.iter().any(|f: &Flight| PLAUSIBLE_GRAVITY.contains(&(f.acceleration() / expected.gravity_m_s2)))
}

/// Whether the motion is that of a ball once the sign of the height is reversed.
fn is_upside_down(seen: &Observation, expected: &Expected) -> bool {
    let mut values = seen.values().to_vec();
    values.iter_mut().skip(2).step_by(seen.channels().len()).for_each(|z| *z = -*z);
    let turned = Observation::new(seen.kind(), seen.channels().to_vec(), seen.clock().to_vec(), values).ok();
    turned.is_some_and(|turned| {
        let arcs = Arcs::cut(&turned, expected.gravity_m_s2);
        arcs.is_some_and(|arcs| {
            let one_flight = arcs.misfit_share.is_some_and(|misfit| misfit < WORST_MISFIT_SHARE);
            (one_flight || !arcs.contacts.is_empty())
                && falls(&Flights::find(&turned, &arcs, expected.gravity_m_s2), expected)
        })
    })
}

/// Whether samples before the release are excluded.
pub(crate) fn release(arcs: &Arcs, samples: usize) -> Check {
    const KIND: FindingKind = findings::RELEASE_LATE;
    match arcs.held_s {
        Some(held) => {
            let share = share(arcs.held_samples, samples);
            Check::noticed(KIND, format!("the first {held:.3} s before the release were excluded ({share})"), "")
        }
        None => Check::passed(KIND, "the record begins in flight or at the release"),
    }
}

/// Whether samples are excluded because something other than the surface touches the ball.
pub(crate) fn blows(arcs: &Arcs, given: usize) -> Check {
    const KIND: FindingKind = findings::MOTION_BLOW;
    let Some(Blows { times_s, used, samples }) = &arcs.blows else {
        return Check::passed(KIND, "nothing but the surface touches the ball");
    };
    let times: Vec<String> = times_s.iter().take(BLOWS_SHOWN).map(|t| format!("{t:.3} s")).collect();
    let text = format!(
        "something other than the surface changes the velocity at {}{}: samples {} to {} of {samples} are used, {} are excluded",
        times.join(", "),
        if times_s.len() > BLOWS_SHOWN { " and later" } else { "" },
        used.start + 1,
        used.end,
        share(samples - used.len(), given),
    );
    Check::noticed(KIND, text, "record without touching the ball; a hand, a racket or a second surface does this")
}

/// Whether enough undisturbed motion is left.
pub(crate) fn undisturbed(usable: usize, samples: usize) -> Check {
    const KIND: FindingKind = findings::MOTION_DISTURBED;
    if usable < FEWEST_SAMPLES {
        let text = format!("only {usable} of {samples} samples are undisturbed free motion");
        return Check::failed(KIND, text, "record a drop that touches nothing but the surface");
    }
    let share = share(samples - usable.min(samples), samples);
    Check::passed(KIND, format!("{usable} of {samples} samples are undisturbed; {share} are excluded"))
}

/// How much of the end the ball lies still.
pub(crate) fn rest(seen: &Observation) -> Check {
    const KIND: FindingKind = findings::MOTION_REST;
    let heights: Vec<f64> = seen.column(2).collect();
    let last = heights.len() - 1;
    let noise = noise_sd(&heights).max(1e-4 * span(&heights));
    let still = heights.iter().rev().take_while(|z| (**z - heights[last]).abs() < 6.0 * noise).count();
    let since = seen.clock()[last + 1 - still.max(1)];
    let lies = seen.clock()[last] - since;
    if still > seen.len() / 10 && still > 8 {
        let share = share(still, seen.len());
        return Check::passed(KIND, format!("the ball lies still for the last {lies:.2} s ({share})"));
    }
    Check::passed(KIND, "the record ends in motion")
}
