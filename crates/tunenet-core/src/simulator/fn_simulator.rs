//! A closure as a simulator.

use super::{Declared, Model, Parameter, RolloutResult, Run};
use crate::observation::Channel;

/// A closure as a simulator, with inputs, initial states and candidate effects declared as data.
///
/// The closure takes the parameters followed by the coefficients of all candidates in their order (absent ones have the values that
/// mean "absent"), the [run](Run) with inputs and initial state, the instants to predict, and the numbers to write, row-major
/// `[sample, channel]`.
///
/// ```
/// use tunenet_core::observation::Channel;
/// use tunenet_core::simulator::{Coefficient, Effect, FnSimulator, Parameter, Phase, Simulator, rollout};
/// let parameters = vec![Parameter::new("rate", "1/s", 0.5, 0.0, 5.0)?];
/// let cooling = FnSimulator::new(parameters, vec![Channel::new("warmth", "1")], |p, _, clock, out| {
///     let [rate, room] = p else { return Err("expected two numbers".into()) };
///     clock.iter().zip(out).for_each(|(t, value)| *value = room + (-rate * t).exp());
///     Ok(())
/// });
/// let room = Coefficient::new("level", "1", 0.0, (-1.0, 1.0), 0.01);
/// let cooling = cooling.candidate(Effect::new("room", Phase::Sensor, "the room is warm", vec![room]));
/// assert_eq!(rollout(&cooling, &[0.5], &[], &[0.0])?, [1.0]);
/// assert_eq!(rollout(&cooling.with_effects(&["room"])?, &[0.5, 0.25], &[], &[0.0])?, [1.25]);
/// # Ok::<(), tunenet_core::Error>(())
/// ```
pub struct FnSimulator;

impl FnSimulator {
    /// A simulator with these parameters and channels.
    #[expect(clippy::new_ret_no_self, reason = "a closure is a model, and a declared model is the simulator")]
    pub fn new<F>(parameters: Vec<Parameter>, channels: Vec<Channel>, rollout: F) -> Declared<impl Model>
    where
        F: Fn(&[f64], &Run, &[f64], &mut [f64]) -> RolloutResult + Send + Sync + 'static,
    {
        let model = move |run: &Run, values: &mut [f64]| rollout(run.numbers, run, run.times_s, values);
        Declared::new(model, parameters, channels)
    }
}
