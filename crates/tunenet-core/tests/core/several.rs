//! Several parameters of a simulator of one's own: what the data do not determine is named, and spoils nothing else.

use rand::{Rng, SeedableRng};
use tunenet_core::observation::{Channel, Kind, Observation};
use tunenet_core::simulator::{Parameter, RolloutResult, Simulator};
use tunenet_core::tune::{Outcome, Settings, Status, Verdict, tune};

type Law = fn(&[f64], f64) -> f64;

/// A formula in time.
struct Signal(Vec<Parameter>, Vec<Channel>, Law);

impl Simulator for Signal {
    fn parameters(&self) -> &[Parameter] {
        &self.0
    }

    fn channels(&self) -> &[Channel] {
        &self.1
    }

    fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], out: &mut [f64]) -> RolloutResult {
        clock.iter().zip(out).for_each(|(t, v)| *v = self.2(p, *t));
        Ok(())
    }
}

/// Tunes `law` to a noisy record of `real`; every parameter starts at 0.4 within 0 to 1.
fn tuned(names: &[&str], law: Law, real: impl Fn(f64) -> f64, seed: u64) -> (Outcome, Signal, Observation) {
    let parameter = |name: &&str| Parameter::new(*name, "1", 0.4, 0.0, 1.0).unwrap();
    let signal = Signal(names.iter().map(parameter).collect(), vec![Channel::new("y", "m")], law);
    let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let clock: Vec<f64> = (0..200).map(|i| 0.02 * f64::from(i)).collect();
    let seen = clock.iter().map(|&t| real(t) + 0.01 * draw.sample::<f64, _>(rand_distr::StandardNormal)).collect();
    let seen = Observation::new(Kind::Other, signal.channels().to_vec(), clock, seen).unwrap();
    let outcome = tune(&signal, std::slice::from_ref(&seen), None, &Settings::default()).unwrap();
    (outcome, signal, seen)
}

fn note<'a>(outcome: &'a Outcome, code: &str) -> Option<&'a str> {
    outcome.notes.iter().find(|n| n.kind.code() == code).map(|n| n.text.as_str())
}

const TRUTH: [f64; 5] = [0.3, 0.4, 0.6, 0.2, 0.8];

fn twins(p: &[f64], t: f64) -> f64 {
    (p[0] + p[1]) * (2.0 * t).sin() + p[2] * (3.0 * t).cos() + p[3] * t + p[4] * (-t).exp()
}

#[test]
fn twins_are_named_and_the_rest_keeps_its_intervals() {
    let (outcome, signal, seen) = tuned(&["a", "b", "c", "d", "e"], twins, |t| twins(&TRUTH, t), 1);
    assert_eq!(outcome.verdict, Verdict::NotIdentifiable);
    let text = note(&outcome, "parameter.direction").expect("a named direction");
    let ends = ["+0.71 a -0.71 b", "+0.71 b -0.71 a"];
    assert!(ends.iter().any(|end| text.ends_with(end)), "{text}");
    for (p, truth) in outcome.parameters.iter().zip(TRUTH) {
        let twin = ["a", "b"].contains(&p.name.as_str());
        assert_eq!(p.status, if twin { Status::Direction } else { Status::Pinned }, "{p:?}");
        let (low, high) = p.interval95;
        // Five standard deviations of clean data, not more.
        assert!(twin || high - low < 0.05 && (p.value - truth).abs() < 1.3 * (high - low), "{p:?}");
    }
    // What the twins add up to is determined nevertheless.
    assert!((outcome.parameters[0].value + outcome.parameters[1].value - 0.7).abs() < 0.01);
    let region = outcome.region95.expect("a region of the rest");
    assert_eq!(region.parameters, ["c", "d", "e"]);
    assert!(region.contains(&signal, std::slice::from_ref(&seen), &region.centre).unwrap());
    let far: Vec<f64> = region.centre.iter().map(|v| v + 0.05).collect();
    assert!(!region.contains(&signal, &[seen], &far).unwrap() && !region.draws(&far));
}

#[test]
fn without_effect_a_parameter_keeps_its_value() {
    let law: Law = |p, t| p[0] * t.sin();
    let (outcome, ..) = tuned(&["size", "colour"], law, |t| 0.7 * t.sin(), 2);
    let [size, colour] = &outcome.parameters[..] else { panic!("{outcome:?}") };
    assert_eq!((outcome.verdict, size.status), (Verdict::NotIdentifiable, Status::Pinned));
    assert!((size.value - 0.7).abs() < 0.01 && size.interval95.1 - size.interval95.0 < 0.02, "{size:?}");
    assert_eq!((colour.status, colour.value, colour.interval95), (Status::NoEffect, 0.4, (0.0, 1.0)));
    assert!(!colour.identified);
    assert!(note(&outcome, "parameter.no_effect").is_some_and(|text| text.contains("`colour`")));
}

#[test]
fn a_bound_that_the_data_pull_against_is_no_answer() {
    let law: Law = |p, t| p[0] * t.sin() + p[1] * t;
    let (outcome, ..) = tuned(&["size", "drift"], law, |t| 1.03 * t.sin() + 0.5 * t, 3);
    let size = &outcome.parameters[0];
    assert_eq!((outcome.verdict, size.status, size.value), (Verdict::PoorFit, Status::AtBound, 1.0), "{outcome:?}");
    assert!(note(&outcome, "parameter.at_bound").is_some_and(|text| text.contains("`size`") && text.contains('1')));
}

#[test]
fn a_truth_on_its_bound_is_an_answer() {
    let law: Law = |p, t| p[0] * t.sin() + p[1] * t;
    let mut on_bound = 0;
    for seed in 0..40 {
        let (outcome, ..) = tuned(&["size", "drift"], law, |t| t.sin() + 0.5 * t, 100 + seed);
        let size = &outcome.parameters[0];
        assert_eq!((outcome.verdict, size.status), (Verdict::Tuned, Status::Pinned), "{:?}", outcome.notes);
        assert!(size.interval95.0 > 0.98, "{size:?}");
        if size.value == 1.0 {
            on_bound += 1;
            assert!(note(&outcome, "parameter.one_sided").is_some() && size.interval95.1 == 1.0);
        }
    }
    // Noise puts half of them beyond the bound.
    assert!((10..=30).contains(&on_bound), "{on_bound} of 40");
}
