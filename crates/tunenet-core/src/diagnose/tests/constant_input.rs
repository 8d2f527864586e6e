//! What no constant input distinguishes, and the input that is proposed.

use std::sync::Arc;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::diagnose::{Recording, Settings, Subject, Verdict, diagnose};
use crate::observation::{Channel, Circumstances, Hold, Input, Kind, Observation};
use crate::simulator::{Coefficient, Effect, FnSimulator, Parameter, Phase, StartState, StartValue};

/// Under a constant input, a gain of the actuator and a bias are twins; another input separates them.
#[test]
fn an_input_that_separates_what_is_left_together_is_proposed() {
    let exact = |rate: f64, pushed: f64, start: f64, t: f64| {
        let end = pushed / rate;
        end + (start - end) * (-rate * t).exp()
    };
    let effect = |name: &'static str| {
        Effect::new(name, Phase::Actuator, name, vec![Coefficient::new("c", "1", 0.0, (-5.0, 5.0), 0.1)])
    };
    let rate = Parameter::new("rate", "1/s", 1.0, 0.1, 10.0).unwrap();
    let model = FnSimulator::new(vec![rate], vec![Channel::new("x", "m")], move |p, run, clock, out| {
        let [rate, gain, bias] = p else { return Err("expected three numbers".into()) };
        let from = run.recording.start_s;
        let pushed = run.input(0, from) * (1.0 + gain) + bias;
        clock.iter().zip(out).for_each(|(&t, x)| *x = exact(*rate, pushed, run.start[0], t - from));
        Ok(())
    });
    let start = StartState::new("x", "m", StartValue::First(0)).with_prior(0.02);
    let model = model.start(start).candidate(effect("actuator_gain")).candidate(effect("actuator_bias"));
    let mut draw = ChaCha8Rng::seed_from_u64(8);
    let seen: [Observation; 4] = [-1.0, 0.5, 2.0, 3.5].map(|start| {
        let clock: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
        let mut noisy = |t: &f64| exact(2.0, 2.6, start, *t) + 0.01 * draw.sample::<f64, _>(StandardNormal);
        let values = clock.iter().map(&mut noisy).collect();
        let input = Input::sampled(Channel::new("u", "V"), Hold::Previous, vec![0.0, 1.0, 2.0], vec![2.0; 3]).unwrap();
        let seen = Observation::new(Kind::Other, vec![Channel::new("x", "m")], clock, values).unwrap();
        seen.under(Arc::new(Circumstances::driven_by(vec![input])))
    });
    let recordings: Vec<Recording> = seen
        .iter()
        .enumerate()
        .map(|(i, seen)| Recording { name: format!("{i}"), object: 0, held_out: i == 3, seen })
        .collect();
    let subjects = [Subject { name: "it".into(), simulator: &model }];
    let found = diagnose(&subjects, &recordings, &Settings::default(), &|_| {}).unwrap();
    assert_eq!(found.verdict(), Verdict::OneOf, "{:?}", found.names());
    assert!(["actuator_gain", "actuator_bias"].iter().all(|name| found.names().contains(name)), "{:?}", found.names());
    let next = found.next_experiment.unwrap();
    assert!(next.settings.iter().any(|(name, _)| name.starts_with("inputs.")), "{next:?}");
    assert!(next.text.contains("repeat a recording with") && next.text.contains("it distinguishes"), "{next:?}");
}
