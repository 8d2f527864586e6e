//! Randomisation test (Fisher 1935) of the draws of a random effect: whether they are drawn at random.
//!
//! A random effect of events can imitate any force that acts at events: one that pushes a whole recording to one side, or along its
//! motion. True draws are symmetric about 0 and depend neither on their recording nor on the motion, so that a change of the sign
//! of any of them does not change the distribution of their sums.

use std::collections::BTreeSet;

use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::judge::held_out_proof::HeldOut;

/// Random changes of signs.
const TURNS: u32 = 4000;
/// Samples before an event between which its velocity is taken.
const STEPS: usize = 3;

/// One draw of a random effect.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::diagnose) struct Draw {
    /// The number of its recording; held-out ones follow those that are fitted.
    recording: usize,
    /// Its two components.
    value: [f64; 2],
    /// How fast each channel changes right before the event, in the channels' unit per second.
    velocity: Vec<f64>,
}

/// The draws of `model`, of recordings that were fitted and of held-out ones.
pub(in crate::diagnose) fn draws_of(context: &Context, model: &Hypothesis, held_out: Option<&HeldOut>) -> Vec<Draw> {
    let training = (&context.evidence.training, &model.fit.point.nuisances);
    let validation = held_out.map(|held_out| (&context.evidence.validation, &held_out.nuisances));
    let mut draws = Vec::new();
    let mut number = 0;
    for (recordings, nuisances) in [Some(training), validation].into_iter().flatten() {
        for (recording, nuisances) in recordings.iter().zip(nuisances) {
            let each = pairs(recording, nuisances).into_iter().zip(velocities(recording));
            draws.extend(each.map(|(value, velocity)| Draw { recording: number, value, velocity }));
            number += 1;
        }
    }
    draws
}

/// The least probability that [`p_value`] can find by the sums over recordings: of draws that all push their recording to one side.
pub(in crate::diagnose) fn least_p_of_recordings(draws: &[Draw]) -> f64 {
    let recordings: BTreeSet<usize> = draws.iter().map(|draw| draw.recording).collect();
    // The first draw of a recording has either sign, the others have that sign.
    (2.0 * 0.5_f64.powf((draws.len() - recordings.len()) as f64)).min(1.0)
}

/// The draws of one recording: its last nuisance parameters, two to each event.
fn pairs(recording: &PreparedRecording, nuisances: &[f64]) -> Vec<[f64; 2]> {
    let first = nuisances.len().saturating_sub(recording.random_draws);
    nuisances[first..].chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// The velocity right before each event.
fn velocities(recording: &PreparedRecording) -> Vec<Vec<f64>> {
    let (seen, clock) = (&recording.prepared.seen, recording.clock());
    let one = |event: &f64| -> Vec<f64> {
        let last = clock.partition_point(|t| t < event).clamp(1, clock.len() - 1) - 1;
        let (first, last) = (last.saturating_sub(STEPS), last.max(1));
        let dt = clock[last] - clock[first];
        seen.row(last).iter().zip(seen.row(first)).map(|(b, a)| (b - a) / dt).collect()
    };
    recording.events.iter().map(one).collect()
}

/// The least probability of sums as large as those of these draws if they were random, of two, doubled: of the squared sums over
/// recordings, and of those along the motion. 1 where nothing is drawn.
pub(in crate::diagnose) fn p_value(draws: &[Draw], seed: u64) -> f64 {
    if draws.is_empty() {
        return 1.0;
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let measured = statistics(draws, |_| 1.0);
    let mut larger = [0u32; 2];
    for _ in 0..TURNS {
        let signs: Vec<f64> = draws.iter().map(|_| if random.random() { 1.0 } else { -1.0 }).collect();
        let turned = statistics(draws, |i| signs[i]);
        for k in 0..2 {
            larger[k] += u32::from(turned[k] >= measured[k] * (1.0 - 1e-12));
        }
    }
    let share = |count: u32| (f64::from(count) + 1.0) / (f64::from(TURNS) + 1.0);
    (2.0 * share(larger[0]).min(share(larger[1]))).min(1.0)
}

/// The squared sums over each recording, and those weighed by each channel's velocity over its squared sum.
fn statistics(draws: &[Draw], sign: impl Fn(usize) -> f64) -> [f64; 2] {
    let recordings = draws.iter().map(|draw| draw.recording + 1).max().unwrap_or(0);
    let channels = draws.first().map_or(0, |draw| draw.velocity.len());
    let mut sums = vec![[0.0; 2]; recordings];
    let mut along = vec![[0.0; 2]; channels];
    let mut squares = vec![0.0; channels];
    for (i, draw) in draws.iter().enumerate() {
        for j in 0..2 {
            let value = sign(i) * draw.value[j];
            sums[draw.recording][j] += value;
            along.iter_mut().zip(&draw.velocity).for_each(|(along, velocity)| along[j] += velocity * value);
        }
        squares.iter_mut().zip(&draw.velocity).for_each(|(square, velocity)| *square += velocity * velocity);
    }
    let square = |[a, b]: &[f64; 2]| a * a + b * b;
    let along = along.iter().zip(&squares).map(|(sum, whole)| square(sum) / f64::max(*whole, f64::MIN_POSITIVE));
    [sums.iter().map(square).sum(), along.sum()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::StandardNormal;

    /// Five recordings of four events each, whose draws are `of` their recording, their velocity and two normal numbers.
    fn drawn(seed: u64, of: impl Fn(usize, &[f64], [f64; 2]) -> [f64; 2]) -> f64 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let draws: Vec<Draw> = (0..20)
            .map(|i| {
                let mut normal = || random.sample::<f64, _>(StandardNormal);
                let velocity = vec![normal(), normal(), -3.0 + 0.1 * normal()];
                let value = of(i / 4, &velocity, [normal(), normal()]);
                Draw { recording: i / 4, value, velocity }
            })
            .collect();
        p_value(&draws, 7)
    }

    #[test]
    fn true_draws_pass_as_often_as_the_level_says() {
        let rejected = (0..200).filter(|&seed| drawn(seed, |_, _, value| value) < 0.05).count();
        assert!(rejected <= 20, "{rejected} of 200 at 5 %");
    }

    #[test]
    fn draws_that_know_their_recording_or_the_motion_do_not_pass() {
        let to_one_side = |r: usize, _: &[f64], [a, b]: [f64; 2]| [a + if r.is_multiple_of(2) { 2.0 } else { -2.0 }, b];
        assert!(drawn(1, to_one_side) < 0.01);
        assert!(drawn(2, |_, v, [a, b]| [a + 2.0 * v[0], b + 2.0 * v[1]]) < 0.01);
        assert!(drawn(3, |_, _, [a, b]| [a, b + 1.5]) < 0.01, "a mean that is not 0");
    }

    /// Of two contacts in each of five recordings, every pair has one sign by chance in 1 of 32 cases; of four in each of three, in 1 of 512.
    #[test]
    fn few_draws_of_each_recording_are_not_distinguished_from_chance() {
        let draws = |recordings: usize, each: usize| -> Vec<Draw> {
            let one = |i: usize| Draw { recording: i / each, value: [1.0, 0.0], velocity: vec![0.0, 0.0, -3.0] };
            (0..recordings * each).map(one).collect()
        };
        assert_eq!(least_p_of_recordings(&draws(5, 2)), 2.0 / 32.0);
        assert_eq!(least_p_of_recordings(&draws(3, 4)), 2.0 / 512.0);
        assert_eq!(least_p_of_recordings(&draws(8, 1)), 1.0);
        let alone = |i: usize| Draw { velocity: vec![], ..draws(3, 4)[i].clone() };
        let found = p_value(&(0..12).map(alone).collect::<Vec<_>>(), 7);
        // Three standard deviations of so many random changes of signs.
        assert!((found - 2.0 / 512.0).abs() < 4.2e-3, "{found}");
    }

    #[test]
    fn without_draws_nothing_is_said() {
        assert_eq!((p_value(&[], 0), least_p_of_recordings(&[])), (1.0, 1.0));
    }
}
