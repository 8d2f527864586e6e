//! Bounce times: whether a ball can have made them.

use super::super::Observation;
use super::{Check, Expected};

/// Heights of a hop that bounce times may come from, m.
const PLAUSIBLE_HOP_M: std::ops::Range<f64> = 1e-5..200.0;
/// An interval longer than the one before by this share is no hop of the same ball.
const GROWS: f64 = 1.05;
/// ... and by this, s: late clicks are noisy.
const GROWS_S: f64 = 0.01;

pub(super) fn checks(seen: &Observation, expected: &Expected) -> Vec<Check> {
    let times = seen.values();
    let intervals: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    let first = intervals[0];
    // A hop that lasts T rises to g T²/8.
    let hop = expected.gravity_m_s2 * first * first / 8.0;
    let plausible = if PLAUSIBLE_HOP_M.contains(&hop) {
        Check::passed("bounces.implausible", format!("the first hop is {hop:.3} m high"))
    } else {
        let text = format!("the first interval of {first} s would need a hop of {hop:.3e} m");
        Check::failed(
            "bounces.implausible",
            text,
            "check the unit of the times: seconds; a column in milliseconds is called `bounce_time_ms`",
        )
    };
    // A missed impact is counted by the clock, so that a longer interval there is no wonder.
    let counted = |i: usize| seen.clock()[i + 1] - seen.clock()[i] < 1.5;
    let grown = (1..intervals.len()).find(|&i| {
        counted(i) && counted(i - 1) && intervals[i] > (GROWS * intervals[i - 1]).max(intervals[i - 1] + GROWS_S)
    });
    let grows = match grown {
        Some(i) => Check::noticed(
            "bounces.grow",
            format!(
                "the interval after {:.4} s is longer than the one before: a click was missed there, or is none",
                times[i]
            ),
            "delete false times, or number the impacts in a column `bounce_number`",
        ),
        None => Check::passed("bounces.grow", "every hop is shorter than the one before"),
    };
    vec![plausible, grows]
}
