//! A thing that was driven while it was seen: its simulator predicts from the measured input.

use std::sync::Arc;

use tunenet_core::Result;
use tunenet_core::observation::{Channel, Circumstances, Hold, Input, Kind, Observation};
use tunenet_core::simulator::{Measured, Parameter, Preparation, Prepared, RolloutResult, Simulator, predict};
use tunenet_core::tune::{Settings, Verdict, tune};

/// A cart pushed by a measured force: `a = F / m`. A recording has both, in this order.
struct Cart {
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
}

impl Cart {
    fn new() -> Self {
        Self {
            parameters: vec![Parameter::new("mass", "kg", 1.0, 0.1, 10.0).unwrap()],
            channels: vec![Channel::new("a", "m/s²")],
        }
    }
}

impl Simulator for Cart {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        let column = |i: usize, channel: Channel| {
            let clock = seen.clock().to_vec();
            Observation::new(Kind::Other, vec![channel], clock, seen.column(i).collect())
        };
        let mut prepared = Prepared::whole(column(1, self.channels[0].clone())?, 1);
        let force = Input::new(column(0, Channel::new("force", "N"))?, Hold::Previous);
        prepared.circumstances = Some(Arc::new(Circumstances::driven_by(vec![force])));
        prepared.memoryless = true;
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    fn rollout(&self, _: &[f64], _: &[f64], _: &[f64], _: &mut [f64]) -> RolloutResult {
        Err("nothing pushes the cart".into())
    }

    fn rollout_driven(
        &self,
        parameters: &[f64],
        _: &[f64],
        circumstances: &Circumstances,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        for (t, value) in clock.iter().zip(values) {
            let force = circumstances.inputs[0].series();
            let i = force.clock().partition_point(|c| c < t).min(force.len() - 1);
            *value = force.row(i)[0] / parameters[0];
        }
        Ok(())
    }
}

/// Two pushes of one cart that differ: what drives a recording is its own.
fn pushes(mass_kg: f64) -> Vec<Observation> {
    let push = |force: fn(f64) -> f64| {
        let clock: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
        let values = clock.iter().flat_map(|t| [force(*t), force(*t) / mass_kg]).collect();
        let channels = vec![Channel::new("force", "N"), Channel::new("a", "m/s²")];
        Observation::new(Kind::Other, channels, clock, values).unwrap()
    };
    vec![push(|t| (9.0 * t).sin()), push(|t| 2.0 - t)]
}

#[test]
fn each_recording_is_predicted_from_its_own_input() {
    let outcome = tune(&Cart::new(), &pushes(2.5), None, &Settings::default()).unwrap();
    assert_eq!(outcome.verdict, Verdict::Tuned);
    assert!((outcome.parameters[0].value - 2.5).abs() < 1e-9, "{}", outcome.parameters[0].value);
    assert!(outcome.gap.unwrap().after < 1e-9);
}

#[test]
fn what_is_seen_through_a_measurement_is_driven_too() {
    let seen = Measured::new(Cart::new(), &[]).unwrap();
    let Preparation::Usable(prepared) = seen.prepare(&pushes(2.0)[1]).unwrap() else { panic!("rejected") };
    let values = predict(&seen, &prepared, &[4.0], &[], &[0.0, 0.5]).unwrap();
    assert_eq!(values, [0.5, 0.375]);
}
