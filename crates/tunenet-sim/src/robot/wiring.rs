//! How the recorded command of a joint reaches its motor: its scale and range, delays, the speed limit of the internal goal, a lag,
//! switching on and off.

use tunenet_core::observation::Input;

use super::numbers::{Command, Drive, JointNumbers};
use super::signal::{Lag, Signal};

/// The command of one joint and whether its motor is on, step by step.
#[derive(Debug, Clone)]
pub(super) struct Wire<'a> {
    goal: Option<Signal<'a>>,
    enable: Option<Signal<'a>>,
    /// The greatest rate of the internal goal, and where that is.
    limit: Option<(f64, f64)>,
    /// What lags behind that.
    lag: Option<Lag>,
}

impl<'a> Wire<'a> {
    /// The wire of a joint from the instant `start_s` on. Without a command the goal is 0, without an enabling input the motor is on.
    pub fn new(joint: &JointNumbers, goal: Option<&'a Input>, enable: Option<&'a Input>, start_s: f64) -> Self {
        let goal = goal.map(|input| Signal::of_commands(input, joint, start_s));
        let enable = enable.map(|input| Signal::new(input, start_s, joint.release_delay_s));
        let limited = joint.drive == Drive::Position && joint.inverse_speed > 0.0;
        let limit = goal.as_ref().filter(|_| limited).map(|goal| (joint.inverse_speed.recip(), goal.now(start_s)));
        let lags = goal.as_ref().filter(|_| joint.command_lag_s > 0.0);
        let lag = lags.map(|goal| Lag::new(joint.command_lag_s, goal.now(start_s)));
        Self { goal, enable, limit, lag }
    }

    /// What arrives from one instant (s) to the next. Steps have to follow one another.
    #[inline]
    pub fn step(&mut self, from_s: f64, to_s: f64) -> Command {
        let goal = match (&mut self.goal, &mut self.limit) {
            (Some(goal), Some((rate, at))) => goal.limited_mean(from_s, to_s, *rate, at),
            (Some(goal), None) => goal.mean(from_s, to_s),
            (None, _) => 0.0,
        };
        let goal = self.lag.as_mut().map_or(goal, |lag| lag.mean(goal, to_s - from_s));
        let on = self.enable.as_mut().map_or(1.0, |enable| {
            let mean = enable.held(to_s).unwrap_or_else(|| enable.mean(from_s, to_s));
            mean.clamp(0.0, 1.0)
        });
        Command { goal, on }
    }
}
