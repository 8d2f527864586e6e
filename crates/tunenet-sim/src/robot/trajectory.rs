//! A rollout on the grid of its steps, and how it is read: late, or by a clock of the device itself.

/// Equal steps from an instant on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    pub start_s: f64,
    pub step_s: f64,
}

impl Grid {
    /// The instant at which step `k` begins.
    #[inline]
    pub fn time(self, k: usize) -> f64 {
        self.start_s + k as f64 * self.step_s
    }
}

/// Positions, speeds and motor torques of all joints at every instant of the grid, shape `[instant][joint]`.
#[derive(Debug, Clone)]
pub(super) struct Trajectory {
    pub grid: Grid,
    joints: usize,
    q: Vec<f64>,
    w: Vec<f64>,
    /// Over the step that ends at the instant; empty where nobody asks for it.
    torque: Vec<f64>,
}

/// What is read of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// rad or m.
    Position,
    /// rad/s or m/s.
    Speed,
    /// N·m or N.
    Torque,
}

/// How a reading is late, s.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Readout {
    /// By a constant.
    pub delay_s: f64,
    /// A value is latched with this period at an unknown phase: the mean over all phases is predicted.
    pub latch_s: f64,
}

impl Trajectory {
    /// So many steps.
    pub fn new(grid: Grid, steps: usize, joints: usize, torques: bool) -> Self {
        let size = (steps + 1) * joints;
        let torque = if torques { vec![0.0; size] } else { Vec::new() };
        Self { grid, joints, q: vec![0.0; size], w: vec![0.0; size], torque }
    }

    pub fn steps(&self) -> usize {
        self.q.len() / self.joints - 1
    }

    /// The instant at which step `k` begins.
    #[inline]
    pub fn time(&self, k: usize) -> f64 {
        self.grid.time(k)
    }

    pub fn step_s(&self) -> f64 {
        self.grid.step_s
    }

    pub fn holds_torques(&self) -> bool {
        !self.torque.is_empty()
    }

    #[inline]
    pub fn state(&mut self, k: usize, joint: usize, q: f64, w: f64) {
        let at = k * self.joints + joint;
        (self.q[at], self.w[at]) = (q, w);
    }

    /// Position and speed of a joint at instant `k`.
    pub fn state_at(&self, k: usize, joint: usize) -> (f64, f64) {
        let at = k * self.joints + joint;
        (self.q[at], self.w[at])
    }

    pub fn joints(&self) -> usize {
        self.joints
    }

    /// The torque of the step from instant `k` to the next.
    #[inline]
    pub fn torque(&mut self, k: usize, joint: usize, torque: f64) {
        self.torque[(k + 1) * self.joints + joint] = torque;
        if k == 0 {
            self.torque[joint] = torque;
        }
    }

    /// What is read at `time_s`.
    pub fn read(&self, time_s: f64, joint: usize, what: Quantity, readout: Readout) -> f64 {
        // The torque of a step is that at its middle, half a step before the instant with which it stands.
        let (series, late) = match what {
            Quantity::Position => (&self.q, 0.0),
            Quantity::Speed => (&self.w, 0.0),
            Quantity::Torque => (&self.torque, 0.5 * self.step_s()),
        };
        let end = time_s - readout.delay_s + late;
        if readout.latch_s <= 0.0 {
            return self.value(series, joint, self.place(end));
        }
        // The mean over one period before, by the trapezoidal rule on the grid and its two ends.
        let (first, last) = (self.place(end - readout.latch_s), self.place(end));
        let whole = readout.latch_s / self.step_s();
        let held = (whole - (last - first)).max(0.0) * self.value(series, joint, 0.0);
        let mut area = 0.0;
        let mut at = first;
        while at < last {
            let next = (at.floor() + 1.0).min(last);
            area += 0.5 * (next - at) * (self.value(series, joint, at) + self.value(series, joint, next));
            at = next;
        }
        (area + held) / whole
    }

    /// An instant in steps from the start, within the grid.
    fn place(&self, time_s: f64) -> f64 {
        ((time_s - self.grid.start_s) / self.step_s()).clamp(0.0, self.steps() as f64)
    }

    fn value(&self, series: &[f64], joint: usize, place: f64) -> f64 {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place on the grid")]
        let before = (place as usize).min(self.steps());
        let after = (before + 1).min(self.steps());
        let share = place - before as f64;
        let at = |k: usize| series[k * self.joints + joint];
        at(before) + share * (at(after) - at(before))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Trajectory {
        let mut ramp = Trajectory::new(Grid { start_s: 1.0, step_s: 0.5 }, 4, 1, false);
        (0..=4).for_each(|k| ramp.state(k, 0, 2.0 * k as f64, 4.0));
        ramp
    }

    #[test]
    fn a_reading_is_late_and_holds_the_start_before_it() {
        let read =
            |t: f64, delay_s: f64| ramp().read(t, 0, Quantity::Position, Readout { delay_s, ..Readout::default() });
        assert_eq!((read(1.25, 0.0), read(2.0, 0.25), read(1.0, 0.25), read(9.0, 0.0)), (1.0, 3.0, 0.0, 8.0));
    }

    /// A torque that rises by 4 N·m/s, in steps of 0.5 s, each of which has its middle's.
    #[test]
    fn the_torque_of_a_step_is_that_of_its_middle() {
        let mut rising = Trajectory::new(Grid { start_s: 1.0, step_s: 0.5 }, 4, 1, true);
        (0..4).for_each(|k| rising.torque(k, 0, 4.0 * 0.5 * (k as f64 + 0.5)));
        let read = |t: f64| rising.read(t, 0, Quantity::Torque, Readout::default());
        assert_eq!((read(1.5), read(1.75), read(2.1), read(2.5)), (2.0, 3.0, 4.4, 6.0));
    }

    #[test]
    fn a_latched_reading_is_the_mean_over_its_phases() {
        let read =
            |t: f64, latch_s: f64| ramp().read(t, 0, Quantity::Position, Readout { latch_s, ..Readout::default() });
        // Of a line with slope 4: half a period late. At 1.1 s the half that lies before the start counts as the start.
        assert!((read(2.0, 0.2) - (4.0 - 0.4)).abs() < 1e-12, "{}", read(2.0, 0.2));
        assert!((read(1.1, 0.2) - 0.5 * (0.5 * 0.4)).abs() < 1e-12, "{}", read(1.1, 0.2));
    }
}
