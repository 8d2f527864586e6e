//! Contexts of closed-form recordings, on which every step of the pipeline is tested.

use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::evidence::validation_split::hold_end_out;
use crate::diagnose::evidence::{Evidence, copies};
use crate::diagnose::hypothesis::catalogue::catalogue;
use crate::diagnose::hypothesis::context::Context;
use crate::diagnose::{Settings, Subject};
use crate::estimate::RolloutLog;
use crate::observation::Observation;
use crate::simulator::{Preparation, Simulator};
use crate::testing::{Exact, Levers, Pendulum, Shuttle};

/// Standard deviation of the noise of [`swings`].
pub const NOISE_RAD: f64 = 1e-3;
/// Names of the coefficients of a pendulum.
pub const FRICTION: &str = "viscous_friction.rate_1_s";
pub const REST: &str = "rest_angle.angle_rad";
/// Standard deviation of the noise of shuttles.
const SHUTTLE_NOISE_M: f64 = 2e-4;
/// Names of coefficients of a shuttle: between events, and at them.
pub const BETWEEN: &str = "friction.rate_1_s";
pub const AT_EVENTS: &str = "kick.speed_m_s";

/// Swings of a pendulum of 0.8 m with these coefficients, each from another start.
pub fn swings(truth: &[(&str, f64)], count: u32) -> Vec<Observation> {
    let all: Vec<(&str, f64)> = truth.iter().copied().chain([("length", 0.8)]).collect();
    (0..count).map(|k| swing(&all, k)).collect()
}

/// One swing, the `k`th of its starts.
pub fn swing(truth: &[(&str, f64)], k: u32) -> Observation {
    let turn = 1.3 * f64::from(k);
    let start = [0.2 * turn.cos(), 0.6 * turn.sin()];
    Exact::new(Pendulum).observe(truth, &start, NOISE_RAD, u64::from(k)).unwrap()
}

/// Runs `test` in the context of these recordings, of which the last `held_out` are held out.
pub fn in_context(simulator: &dyn Simulator, seen: &[Observation], held_out: usize, test: impl FnOnce(&Context)) {
    let (subjects, settings) = ([Subject { name: "it".into(), simulator }], Settings::default());
    let prepared = |(i, one): (usize, &Observation)| match simulator.prepare(one).unwrap() {
        Preparation::Usable(prepared) => PreparedRecording::new(i, 0, i + held_out >= seen.len(), *prepared),
        Preparation::Rejected(rejected) => panic!("{:?}", rejected.note),
    };
    let mut recordings: Vec<PreparedRecording> = seen.iter().enumerate().map(prepared).collect();
    copies::label(&mut recordings);
    test(&Context::new(&subjects, Evidence::new(recordings), catalogue(&subjects), &settings, &RolloutLog::default()));
}

/// The same of swings with these coefficients.
pub fn in_swings(truth: &[(&str, f64)], count: u32, held_out: usize, test: impl FnOnce(&Context)) {
    in_context(&Exact::new(Pendulum), &swings(truth, count), held_out, test);
}

/// The same of three shuttles that lack these coefficients, each from another start.
pub fn in_shuttles(truth: &[(&str, f64)], test: impl FnOnce(&Context)) {
    let shuttle = Exact::new(Shuttle::default());
    let all: Vec<(&str, f64)> = truth.iter().copied().chain([("returned", 0.8)]).collect();
    let starts = [[0.0, 1.5], [0.1, -2.0], [0.2, 1.0]];
    let seen: Vec<Observation> =
        (0u64..).zip(starts).map(|(k, start)| shuttle.observe(&all, &start, SHUTTLE_NOISE_M, k).unwrap()).collect();
    in_context(&shuttle, &seen, 0, test);
}

/// Standard deviation of the noise of [`levers`].
pub const NOISE_NM: f64 = 0.02;
/// A coefficient of levers.
pub const LEVER_FRICTION: &str = "viscous_friction.nms_rad.1";

/// The context of one recording of driven levers with these coefficients, its end held out.
pub fn in_levers(levers: &Levers, truth: &[(&str, f64)], test: impl FnOnce(&Context)) {
    let (subjects, settings) = ([Subject { name: "levers".into(), simulator: levers }], Settings::default());
    let seen = levers.observe(truth, NOISE_NM, 5).unwrap();
    let Preparation::Usable(prepared) = levers.prepare(&seen).unwrap() else { panic!("usable") };
    let mut recording = PreparedRecording::new(0, 0, false, *prepared);
    let end = hold_end_out(&mut recording).unwrap().unwrap();
    test(&Context::new(
        &subjects,
        Evidence::new(vec![recording, end]),
        catalogue(&subjects),
        &settings,
        &RolloutLog::default(),
    ));
}

/// The position of an effect in the catalogue.
pub fn entry(context: &Context, name: &str) -> usize {
    context.catalogue.iter().position(|e| e.name == name).unwrap()
}

/// The names of these effects.
pub fn names<'a>(context: &'a Context<'_>, effects: &[usize]) -> Vec<&'a str> {
    effects.iter().map(|&e| context.catalogue[e].name.as_ref()).collect()
}
