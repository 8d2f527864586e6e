//! Bounce times: whether a ball can have made them.

use super::Expected;
use crate::findings;
use tunenet_core::finding::FindingKind;
use tunenet_core::observation::Check;
use tunenet_core::observation::{Observation, event_time_sd};
use tunenet_core::statistics::median;

/// Heights of a hop that bounce times may come from, m.
const PLAUSIBLE_HOP_M: std::ops::Range<f64> = 1e-5..200.0;
/// An interval longer than the one before by this share is no hop of the same ball ...
const GROWS: f64 = 1.03;
/// ... where it exceeds the interval that the usual shrinking would leave by this many standard deviations, more where few
/// intervals determine the noise: `SIGNIFICANT · (1 + FEW / (n − 3))` of n intervals.
const SIGNIFICANT: f64 = 3.7;
const FEW: f64 = 7.0;
/// Fewer intervals hardly know their noise: a hop that is longer by this share and by this, s, counts there.
const FEWEST_FOR_NOISE: usize = 11;
const GROWS_UNKNOWN: f64 = 1.05;
const GROWS_UNKNOWN_S: f64 = 0.01;

/// So many intervals are judged for shrinking, and a mean ratio of each to the one before above this is taken for that of no
/// ball: a judgement, which leaves room above the liveliest balls.
const FEWEST_EVEN: usize = 10;
const MOST_LIVELY: f64 = 0.995;

pub(crate) fn checks(seen: &Observation, expected: &Expected) -> Vec<Check> {
    let times = seen.values();
    let intervals: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    let first = intervals[0];
    // A hop that lasts T rises to g T²/8.
    let hop = expected.gravity_m_s2 * first * first / 8.0;
    let plausible = if PLAUSIBLE_HOP_M.contains(&hop) {
        Check::passed(findings::BOUNCES_IMPLAUSIBLE, format!("the first hop is {hop:.3} m high"))
    } else {
        let text = format!("the first interval of {first} s would need a hop of {hop:.3e} m");
        Check::failed(
            findings::BOUNCES_IMPLAUSIBLE,
            text,
            "check the unit of the times: seconds; a column in milliseconds is called `bounce_time_ms`",
        )
    };
    let grows = match grown(seen.clock(), times) {
        Some(at) => {
            let text = format!(
                "the hop after bounce {} lasts {:.4} s, the one before it {:.4} s: a bounce cannot gain energy",
                at + 1,
                intervals[at],
                intervals[at - 1]
            );
            let remedy = format!(
                "a hand, a second impact or a missed click does this: give the first {} bounces only, or number the impacts in \
                 a column `bounce_number` where clicks were missed",
                at + 1
            );
            Check::noticed(findings::BOUNCES_GROW, text, remedy)
        }
        None => Check::passed(
            findings::BOUNCES_GROW,
            "no hop is longer than the previous one, within the noise of the clock",
        ),
    };
    vec![plausible, grows, shrinks(&intervals)]
}

/// Whether the intervals shrink as those of a ball do.
fn shrinks(intervals: &[f64]) -> Check {
    const KIND: FindingKind = findings::BOUNCES_EVEN;
    if intervals.len() < FEWEST_EVEN {
        return Check::not_run(KIND, format!("fewer than {FEWEST_EVEN} intervals"));
    }
    let steps = (intervals.len() - 1) as f64;
    let ratio = (intervals[intervals.len() - 1] / intervals[0]).powf(1.0 / steps);
    if ratio < MOST_LIVELY {
        return Check::passed(KIND, format!("an interval is {ratio:.4} times the one before, on average"));
    }
    let text = format!(
        "{} intervals in a row hardly shrink: each is {ratio:.5} times the one before, and no ball is expected to \
         exceed {MOST_LIVELY}",
        intervals.len()
    );
    let remedy = "check that a free ball made these times: a clock, a machine or a driven ball gives even ones";
    Check::noticed(KIND, text, remedy)
}

/// The first interval (from 0) that is longer than the one before, beyond what the noise of the times makes of a ball that
/// loses next to nothing.
fn grown(clock: &[f64], times: &[f64]) -> Option<usize> {
    let intervals: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    // A missed impact is counted by the clock, so that a longer interval there is no wonder.
    let counted = |i: usize| clock[i + 1] - clock[i] < 1.5;
    let pairs: Vec<usize> = (1..intervals.len()).filter(|&i| counted(i) && counted(i - 1)).collect();
    let usual = median(pairs.iter().map(|&i| intervals[i] / intervals[i - 1])).unwrap_or(0.0).min(1.0);
    let known = intervals.len() >= FEWEST_FOR_NOISE;
    // The difference of two intervals that share a time: noise on three times, the middle one twice.
    let unsure = SIGNIFICANT * (1.0 + FEW / (intervals.len() as f64 - 3.0)) * 6f64.sqrt() * event_time_sd(clock, times);
    pairs.into_iter().find(|&i| {
        let (before, after) = (intervals[i - 1], intervals[i]);
        if known {
            after > GROWS * before && after - usual * before > unsure
        } else {
            after > (GROWS_UNKNOWN * before).max(before + GROWS_UNKNOWN_S)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use tunenet_core::observation::State;

    /// Bounce times whose intervals shrink by `restitution`, with normal noise.
    fn bounce_times(count: usize, restitution: f64, sd_s: f64, draw: &mut rand_chacha::ChaCha8Rng) -> Vec<f64> {
        let (mut time, mut interval) = (0.3, 0.6);
        (0..count)
            .map(|_| {
                let seen = time + sd_s * draw.sample::<f64, _>(rand_distr::StandardNormal);
                time += interval;
                interval *= restitution;
                seen
            })
            .collect()
    }

    fn grow(times: &[f64]) -> Check {
        let seen = crate::bounce_times(times.to_vec()).unwrap();
        checks(&seen, &Expected::default()).into_iter().find(|c| c.kind == findings::BOUNCES_GROW).unwrap()
    }

    #[test]
    fn a_hop_higher_than_the_one_before_is_noticed_with_its_number() {
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(11);
        let mut times = bounce_times(17, 0.95, 5e-4, &mut draw);
        // The hop after the 15th bounce is 5 % longer than the one before.
        let longer = 1.05 * (times[14] - times[13]) - (times[15] - times[14]);
        times[15..].iter_mut().for_each(|t| *t += longer);
        let check = grow(&times);
        assert_eq!(check.state, State::Noticed);
        assert!(check.text.contains("after bounce 15 ") && check.remedy.contains("first 15 bounces"), "{check:?}");
    }

    #[test]
    fn a_metronome_is_no_ball() {
        let even = |ratio: f64| {
            let times = (0..30).scan((0.0, 1.0), |(time, interval), _| {
                let now = *time;
                (*time, *interval) = (*time + *interval, *interval * ratio);
                Some(now)
            });
            let seen = crate::bounce_times(times.collect()).unwrap();
            checks(&seen, &Expected::default()).into_iter().find(|c| c.kind == findings::BOUNCES_EVEN).unwrap().state
        };
        assert_eq!([0.85, 0.98, 1.0].map(even), [State::Passed, State::Passed, State::Noticed]);
    }

    #[test]
    fn a_ball_that_loses_next_to_nothing_is_not_blamed_for_its_clock() {
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(12);
        let (mut lists, mut blamed) = (0, 0);
        for round in 0..2000 {
            let restitution = [0.8, 0.9, 0.95, 0.98, 0.995, 0.999][round % 6];
            let sd_s = [1e-4, 5e-4, 1e-3, 2e-3, 3e-3][round % 5];
            let times = bounce_times(5 + round % 24, restitution, sd_s, &mut draw);
            if times.windows(2).all(|w| w[1] - w[0] > 0.02) {
                lists += 1;
                blamed += usize::from(grow(&times).state != State::Passed);
            }
        }
        assert!(lists > 1500 && blamed * 200 <= lists, "{blamed} of {lists}");
    }
}
