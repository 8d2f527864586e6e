//! How the recorded command of a joint reaches its motor: its scale and range, delays, the speed limit of the internal goal, a lag,
//! switching on and off.

use tunenet_core::observation::Input;

use super::numbers::{Command, Drive, JointNumbers};
use super::signal::{Lag, Signal};
use super::trajectory::Grid;

/// Commands are computed for so many steps at once, which takes less time than one by one.
const BLOCK: usize = 64;

/// The command of one joint and whether its motor is on, step by step.
#[derive(Debug, Clone)]
pub(super) struct Wire<'a> {
    goal: Option<Signal<'a>>,
    enable: Option<Signal<'a>>,
    /// What lags behind the internal goal.
    lag: Option<Lag>,
    grid: Grid,
    /// The commands of the steps from `first` on, and which of them is next.
    goals: [f64; BLOCK],
    on: [f64; BLOCK],
    first: usize,
    next: usize,
}

impl<'a> Wire<'a> {
    /// The wire of a joint over the steps of `grid`. Without a command the goal is 0, without an enabling input the motor is on.
    pub fn new(joint: &JointNumbers, goal: Option<&'a Input>, enable: Option<&'a Input>, grid: Grid) -> Self {
        let start_s = grid.time(0);
        let limited = joint.drive == Drive::Position && joint.inverse_speed > 0.0;
        let goal = goal.map(|input| {
            let goal = Signal::of_commands(input, joint, start_s);
            if limited { goal.limited(joint.inverse_speed.recip(), start_s) } else { goal }
        });
        let enable = enable.map(|input| Signal::new(input, start_s, joint.release_delay_s));
        let lags = goal.as_ref().filter(|_| joint.command_lag_s > 0.0);
        let lag = lags.map(|goal| Lag::new(joint.command_lag_s, goal.now(start_s)));
        let mut wire = Self { goal, enable, lag, grid, goals: [0.0; BLOCK], on: [1.0; BLOCK], first: 0, next: 0 };
        wire.fill();
        wire
    }

    /// What arrives in the next step.
    #[inline]
    pub fn command(&mut self) -> Command {
        if self.next == BLOCK {
            (self.first, self.next) = (self.first + BLOCK, 0);
            self.fill();
        }
        let command = Command { goal: self.goals[self.next], on: self.on[self.next] };
        self.next += 1;
        command
    }

    /// Computes a block.
    fn fill(&mut self) {
        let (grid, first) = (self.grid, self.first);
        if let Some(goal) = &mut self.goal {
            goal.means(grid, first, &mut self.goals);
        }
        if let Some(lag) = &mut self.lag {
            self.goals.iter_mut().for_each(|goal| *goal = lag.mean(*goal, grid.step_s));
        }
        if let Some(enable) = &mut self.enable {
            enable.means(grid, first, &mut self.on);
            self.on.iter_mut().for_each(|on| *on = on.clamp(0.0, 1.0));
        }
    }
}
