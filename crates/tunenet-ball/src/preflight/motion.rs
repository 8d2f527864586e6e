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
    // The bounces of a record with z upside down look like strokes from above.
    if arcs.blows.is_some()
        && is_upside_down(seen, expected, |turned| turned.blows.is_none() && !turned.contacts.is_empty())
    {
        return upside_down();
    }
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
    let one_flight = |turned: &Arcs| turned.misfit_share.is_some_and(|misfit| misfit < WORST_MISFIT_SHARE);
    if is_upside_down(seen, expected, |turned| one_flight(turned) || !turned.contacts.is_empty()) {
        return upside_down();
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

fn upside_down() -> Check {
    let text = "the height rises as that of a ball falls, so z points down";
    let remedy = "reverse the sign of its column with a minus: `--columns z_m=-NAME`";
    Check::failed(findings::MOTION_UNLIKE, text, remedy)
}

/// Whether the motion is that of a ball once the sign of the height is reversed: it falls by gravity, and is as `like` says.
fn is_upside_down(seen: &Observation, expected: &Expected, like: impl Fn(&Arcs) -> bool) -> bool {
    let mut values = seen.values().to_vec();
    values.iter_mut().skip(2).step_by(seen.channels().len()).for_each(|z| *z = -*z);
    let turned = Observation::new(seen.kind(), seen.channels().to_vec(), seen.clock().to_vec(), values).ok();
    turned.is_some_and(|turned| {
        let arcs = Arcs::cut(&turned, expected.gravity_m_s2);
        arcs.is_some_and(|arcs| like(&arcs) && falls(&Flights::find(&turned, &arcs, expected.gravity_m_s2), expected))
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

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use tunenet_core::observation::State;

    use super::*;
    use crate::preflight::of;

    const GRAVITY_M_S2: f64 = 9.81;

    /// A ball let go 0.8 m above the surface with restitution `e`, seen for 2.5 s at 50 Hz with 8 mm of noise; times `sign`.
    fn bouncing(e: f64, sign: f64, seed: u64) -> Observation {
        let clock: Vec<f64> = (0..125).map(|i| 0.02 * f64::from(i)).collect();
        let noise = Normal::new(0.0, 0.008).unwrap().sample_iter(rand_chacha::ChaCha8Rng::seed_from_u64(seed));
        let height = |t: f64| {
            let (mut begin, mut speed) = ((1.6 / GRAVITY_M_S2).sqrt(), e * (1.6 * GRAVITY_M_S2).sqrt());
            if t < begin {
                return 0.8 - 0.5 * GRAVITY_M_S2 * t * t;
            }
            while speed > 0.01 && t > begin + 2.0 * speed / GRAVITY_M_S2 {
                (begin, speed) = (begin + 2.0 * speed / GRAVITY_M_S2, e * speed);
            }
            (speed * (t - begin) - 0.5 * GRAVITY_M_S2 * (t - begin).powi(2)).max(0.0)
        };
        let positions: Vec<[f64; 3]> =
            clock.iter().zip(noise).map(|(t, noise)| [0.0, 0.0, sign * height(*t) + noise]).collect();
        Observation::positions(clock, &positions).unwrap()
    }

    /// Seen with z upside down, bounces look like strokes from above: without another hypothesis most of the record is cut off.
    #[test]
    fn bounces_upside_down_are_no_strokes() {
        for (seed, e) in [0.3, 0.5, 0.7].into_iter().enumerate() {
            let unlike = |sign: f64| {
                let checks = of(&bouncing(e, sign, seed as u64), &Expected::default());
                checks.iter().any(|c| c.kind == findings::MOTION_UNLIKE && c.state == State::Failed)
            };
            assert_eq!((unlike(1.0), unlike(-1.0)), (false, true), "{e}");
        }
    }
}
