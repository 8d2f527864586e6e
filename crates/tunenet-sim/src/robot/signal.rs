//! Means of a sampled signal over integration steps, exact where a sample falls inside a step, and the same behind a rate limiter or a
//! lag of first order (zero-order or first-order hold: Åström and Wittenmark 1997, section 7).

use std::borrow::Cow;

use tunenet_core::observation::{Hold, Input};

use super::numbers::JointNumbers;

/// A goal closer than this to what follows it is reached.
const REACHED: f64 = 1e-12;

/// A signal that is read forward, `delay_s` after it was recorded.
#[derive(Debug, Clone)]
pub(super) struct Signal<'a> {
    clock: Cow<'a, [f64]>,
    values: Cow<'a, [f64]>,
    hold: Hold,
    delay_s: f64,
    /// How many samples lie at or before the end of the last step.
    at: usize,
    /// What follows the last of them.
    piece: Piece,
}

/// A straight piece of a signal, on the clock of its samples.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Piece {
    value: f64,
    /// 1/s.
    slope: f64,
    /// Where it has that value.
    from_s: f64,
    /// The sample with which it ends.
    until_s: f64,
}

impl Piece {
    #[inline]
    fn at(&self, time_s: f64) -> f64 {
        self.value + self.slope * (time_s - self.from_s)
    }
}

impl<'a> Signal<'a> {
    /// The first channel of `input`, read from the instant `start_s` on.
    pub fn new(input: &'a Input, start_s: f64, delay_s: f64) -> Self {
        let series = input.series();
        let (clock, values) = (Cow::Borrowed(series.clock()), Cow::Borrowed(series.values()));
        Self { clock, values, hold: input.hold(), delay_s, at: 0, piece: Piece::default() }.from(start_s)
    }

    /// The commands in `input` as the joint takes them: scaled, and clipped to its range.
    pub fn of_commands(input: &'a Input, joint: &JointNumbers, start_s: f64) -> Self {
        let mut signal = Self::new(input, start_s, joint.command_delay_s);
        let clips = joint.command_range.iter().any(|end| end.is_finite());
        if joint.command_scale == 1.0 && !clips {
            return signal;
        }
        if clips && signal.hold == Hold::Linear {
            signal.bend(joint);
        }
        signal.values.to_mut().iter_mut().for_each(|value| *value = joint.commanded(*value));
        signal.from(start_s)
    }

    /// Samples where the lines between samples cross an end of the joint's range: a clipped line bends there.
    fn bend(&mut self, joint: &JointNumbers) {
        let (mut clock, mut values) = (Vec::new(), Vec::new());
        for i in 0..self.clock.len() {
            if let Some(before) = i.checked_sub(1) {
                let (from_s, first) = (self.clock[before], self.values[before]);
                let (lasts_s, rise) = (self.clock[i] - from_s, self.values[i] - first);
                let mut shares = joint.command_range.map(|end| (end / joint.command_scale - first) / rise);
                shares.sort_by(f64::total_cmp);
                for share in shares.into_iter().filter(|share| *share > 0.0 && *share < 1.0) {
                    clock.push(from_s + share * lasts_s);
                    values.push(first + share * rise);
                }
            }
            clock.push(self.clock[i]);
            values.push(self.values[i]);
        }
        (self.clock, self.values) = (clock.into(), values.into());
    }

    /// The same, read from this instant on.
    fn from(mut self, start_s: f64) -> Self {
        self.at = self.clock.partition_point(|t| *t + self.delay_s <= start_s);
        self.piece = self.present();
        self
    }

    /// The piece that begins at the last sample.
    fn present(&self) -> Piece {
        let (clock, values, at) = (&*self.clock, &*self.values, self.at);
        let held = Piece {
            value: values[at.saturating_sub(1)],
            slope: 0.0,
            from_s: 0.0,
            until_s: clock.get(at).copied().unwrap_or(f64::INFINITY),
        };
        if at == 0 || at == clock.len() || self.hold == Hold::Previous {
            return held;
        }
        let slope = (values[at] - values[at - 1]) / (clock[at] - clock[at - 1]);
        Piece { slope, from_s: clock[at - 1], ..held }
    }

    /// The value just after the last step.
    pub fn now(&self, time_s: f64) -> f64 {
        self.piece.at(time_s - self.delay_s)
    }

    /// The straight pieces of the signal from `from_s` to `to_s`: value at the beginning, slope, duration (s).
    #[inline(never)]
    fn pieces(&mut self, from_s: f64, to_s: f64, mut piece: impl FnMut(f64, f64, f64)) {
        let (mut from, to) = (from_s - self.delay_s, to_s - self.delay_s);
        loop {
            let end = self.piece.until_s.min(to);
            if end > from {
                piece(self.piece.at(from), self.piece.slope, end - from);
                from = end;
            }
            if self.piece.until_s > to {
                return;
            }
            self.at += 1;
            self.piece = self.present();
        }
    }

    /// Its value over a step that ends at `to_s`, where it is held and has no sample between them. Steps have to follow one another.
    #[inline]
    pub fn held(&self, to_s: f64) -> Option<f64> {
        let held = self.hold == Hold::Previous && self.piece.until_s > to_s - self.delay_s;
        held.then_some(self.piece.value)
    }

    /// Its mean from `from_s` to `to_s`. Steps have to follow one another.
    #[inline]
    pub fn mean(&mut self, from_s: f64, to_s: f64) -> f64 {
        let mut area = 0.0;
        self.pieces(from_s, to_s, |first, slope, duration| area += (first + 0.5 * slope * duration) * duration);
        area / (to_s - from_s)
    }

    /// The mean of what follows it at no more than `greatest_rate` (1/s) from the value `follower` on, which is moved to its value at
    /// `to_s`.
    #[inline]
    pub fn limited_mean(&mut self, from_s: f64, to_s: f64, greatest_rate: f64, follower: &mut f64) -> f64 {
        let (from, to) = (from_s - self.delay_s, to_s - self.delay_s);
        // Most steps lie within one piece.
        if to < self.piece.until_s {
            return follow(follower, (self.piece.at(from), self.piece.slope), to - from, greatest_rate) / (to - from);
        }
        let mut area = 0.0;
        self.pieces(from_s, to_s, |first, slope, duration| {
            area += follow(follower, (first, slope), duration, greatest_rate);
        });
        area / (to_s - from_s)
    }
}

/// A lag of first order behind what is constant in each step: τ · dy/dt = u − y.
#[derive(Debug, Clone)]
pub(super) struct Lag {
    time_constant_s: f64,
    at: f64,
    /// The step that it was moved by last, and what is left of a difference after it: steps are equal, but for the last.
    decay: (f64, f64),
}

impl Lag {
    /// It stands at `at`.
    pub fn new(time_constant_s: f64, at: f64) -> Self {
        Self { time_constant_s, at, decay: (0.0, 1.0) }
    }

    /// Its mean over a step of `step_s` in which it follows `input`.
    #[inline]
    pub fn mean(&mut self, input: f64, step_s: f64) -> f64 {
        if self.decay.0 != step_s {
            self.decay = (step_s, (-step_s / self.time_constant_s).exp());
        }
        let behind = self.at - input;
        let left = behind * self.decay.1;
        self.at = input + left;
        input + (behind - left) * self.time_constant_s / step_s
    }
}

/// Moves `follower` after a straight piece, given by its first value and its slope, for `duration` s; returns its integral over that time.
#[inline]
fn follow(follower: &mut f64, (first, slope): (f64, f64), duration: f64, rate: f64) -> f64 {
    let behind = *follower - first;
    let mut area = 0.0;
    let mut left = duration;
    if behind.abs() > REACHED {
        let own = -behind.signum() * rate;
        let closing = slope - own;
        let meets = closing * behind > 0.0 && behind.abs() < closing.abs() * duration;
        let until = if meets { behind / closing } else { duration };
        area += until * (*follower + 0.5 * own * until);
        *follower += own * until;
        left -= until;
        if left <= 0.0 {
            return area;
        }
        *follower = first + slope * until;
    }
    let own = slope.clamp(-rate, rate);
    area += left * (*follower + 0.5 * own * left);
    *follower += own * left;
    area
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::observation::Channel;

    use crate::robot::Drive;

    fn input(hold: Hold) -> Input {
        Input::sampled(Channel::new("goal", "rad"), hold, vec![0.0, 1.0, 2.0], vec![0.0, 2.0, 2.0]).unwrap()
    }

    #[test]
    fn a_step_inside_an_interval_counts_by_its_share() {
        let input = input(Hold::Previous);
        let mut signal = Signal::new(&input, 0.0, 0.25);
        assert_eq!(signal.mean(0.0, 1.0), 0.0);
        assert_eq!(signal.mean(1.0, 1.5), 1.0);
        assert_eq!(signal.mean(1.5, 9.0), 2.0);
    }

    /// The mean of a step within one held sample is that sample, however the step is read.
    #[test]
    fn a_held_sample_is_read_without_its_mean() {
        let input = input(Hold::Previous);
        let mut signal = Signal::new(&input, 0.0, 0.25);
        assert_eq!((signal.held(0.2), signal.mean(0.0, 1.0)), (Some(0.0), 0.0));
        assert_eq!((signal.held(1.2), signal.held(1.5), signal.mean(1.0, 1.5)), (Some(0.0), None, 1.0));
        assert_eq!((signal.held(1.9), signal.mean(1.5, 1.9)), (Some(2.0), 2.0));
        assert_eq!(Signal::new(&self::input(Hold::Linear), 0.0, 0.0).held(0.5), None);
    }

    #[test]
    fn a_lag_follows_a_step_by_its_exponential() {
        let mut lag = Lag::new(0.05, 1.0);
        let mut area = 0.0;
        for step_s in [0.01, 0.01, 0.03] {
            area += step_s * lag.mean(3.0, step_s);
        }
        // 3 − 2 e^(−t/τ) at t = τ, and its integral until then.
        let left = (-1.0_f64).exp();
        assert!((lag.at - (3.0 - 2.0 * left)).abs() < 1e-12, "{lag:?}");
        assert!((area - (3.0 * 0.05 - 2.0 * 0.05 * (1.0 - left))).abs() < 1e-12, "{area}");
        // One far shorter than a step changes nothing.
        assert!((Lag::new(1e-12, 1.0).mean(3.0, 0.001) - 3.0).abs() < 1e-8);
    }

    #[test]
    fn a_linear_signal_has_the_mean_of_its_line() {
        let input = input(Hold::Linear);
        let mut signal = Signal::new(&input, 0.0, 0.0);
        assert!((signal.mean(0.0, 0.5) - 0.5).abs() < 1e-15);
        assert!((signal.mean(0.5, 1.5) - (0.75 + 1.0)).abs() < 1e-15);
        assert_eq!(signal.now(1.5), 2.0);
    }

    /// It rises from 0 to 2 in a second, and stays there: twice that is at the end 1 of the range after a quarter of a second, and minus
    /// twice that at -1.
    #[test]
    fn a_command_is_scaled_and_clipped_between_its_samples_too() {
        let joint = |command_scale, command_range| JointNumbers {
            command_scale,
            command_range,
            ..JointNumbers::free(Drive::Position)
        };
        let input = input(Hold::Linear);
        let mean = |joint: JointNumbers| Signal::of_commands(&input, &joint, 0.0).mean(0.0, 1.0);
        assert!((mean(joint(-0.5, [f64::NEG_INFINITY, f64::INFINITY])) + 0.5).abs() < 1e-15);
        assert!((mean(joint(2.0, [-3.0, 1.0])) - (0.75 + 0.25 / 2.0)).abs() < 1e-12);
        assert!((mean(joint(-2.0, [-1.0, 3.0])) + (0.75 + 0.25 / 2.0)).abs() < 1e-12);
        let held = self::input(Hold::Previous);
        let mut signal = Signal::of_commands(&held, &joint(2.0, [0.5, 1.0]), 0.0);
        assert_eq!((signal.mean(0.0, 1.0), signal.mean(1.0, 2.0)), (0.5, 1.0));
    }

    #[test]
    fn a_limited_follower_meets_the_line_at_the_instant_of_the_closed_form() {
        // It starts at 0, the goal stands at 2 from t = 1 on, the rate is 4: there after half a second.
        let input = input(Hold::Previous);
        let mut signal = Signal::new(&input, 0.0, 0.0);
        let mut follower = 0.0;
        assert_eq!(signal.limited_mean(0.0, 1.0, 4.0, &mut follower), 0.0);
        let mean = signal.limited_mean(1.0, 2.0, 4.0, &mut follower);
        assert!((mean - (0.5 * 1.0 + 0.5 * 2.0)).abs() < 1e-12 && (follower - 2.0).abs() < 1e-12, "{mean} {follower}");
        // Without a limit that bites the mean is that of the signal itself.
        let mut free = Signal::new(&input, 0.0, 0.0);
        let mut after = 0.0;
        assert!((free.limited_mean(0.0, 1.5, 1e9, &mut after) - 2.0 / 3.0).abs() < 1e-8);
    }
}
