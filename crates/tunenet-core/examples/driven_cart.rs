//! A driven cart of your own, and two effects that it may lack: which of them do the recordings show?
use tunenet_core::Result;
use tunenet_core::diagnose::{Diagnosis, Recording, Settings, Subject, diagnose};
use tunenet_core::observation::{Channel, Observation};
use tunenet_core::simulator::{Coefficient, Effect, FnSimulator, Parameter, Phase, StartState, StartValue};
use tunenet_core::testing::PushedCart;

pub(crate) fn diagnosed(recordings: &[Observation]) -> Result<Diagnosis> {
    let known = vec![Parameter::new("mass", "kg", 1.0, 0.2, 5.0)?, Parameter::new("damping", "N·s/m", 1.0, 0.0, 9.0)?];
    let effect =
        |name: &'static str, acts, sentence: &'static str, key: &'static str, unit: &'static str, most, typical| {
            Effect::new(name, acts, sentence, vec![Coefficient::new(key, unit, 0.0, (0.0, most), typical)])
        };
    let cart = FnSimulator::new(known, vec![Channel::new("x", "m")], |p, run, clock, out| {
        let [mass, damping, delay_s, stiffness] = p else { return Err("expected four numbers".into()) };
        let (mut x, mut v, mut t) = (run.start[0], 0.0, run.recording.start_s);
        let a = |t: f64, x: f64, v: f64| (run.input(0, t - delay_s) - damping * v - stiffness * x) / mass;
        for (&time, out) in clock.iter().zip(out) {
            while t < time {
                let h = (time - t).min(2e-3); // midpoint steps
                let (x_mid, v_mid) = (x + 0.5 * h * v, v + 0.5 * h * a(t, x, v));
                (x, v, t) = (x + h * v_mid, v + h * a(t + 0.5 * h, x_mid, v_mid), t + h);
            }
            *out = x;
        }
        Ok(())
    })
    .start(StartState::new("x", "m", StartValue::Number(0.0)))
    .candidate(effect("motor_delay", Phase::Actuator, "the motor acts later than commanded", "s", "s", 0.1, 0.01))
    .candidate(effect("cable_spring", Phase::Joint, "a cable pulls the cart back", "n_m", "N/m", 50.0, 0.1));
    let one = |(i, seen)| Recording { name: format!("push {i}"), object: 0, held_out: i + 1 == recordings.len(), seen };
    let all: Vec<Recording> = recordings.iter().enumerate().map(one).collect();
    diagnose(&[Subject { name: "cart".into(), simulator: &cart }], &all, &Settings::default(), &|_| {})
}
pub(crate) fn main() -> Result<()> {
    let truth = PushedCart { mass_kg: 1.8, damping_ns_m: 2.1, delay_s: 0.025, stiffness_n_m: 0.0 };
    let found = diagnosed(&truth.recordings(4, 1e-3, 1)?)?; // the recordings of your cart stand here
    println!("{:?}: {}, {} rollouts", found.verdict(), found.names().join(", "), found.rollouts);
    Ok(())
}
