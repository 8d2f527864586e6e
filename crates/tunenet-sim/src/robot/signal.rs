//! Means of a sampled signal over integration steps, exact where a sample falls inside a step, and the same behind a rate limiter or a
//! lag of first order (zero-order or first-order hold: Åström and Wittenmark 1997, section 7). All but the lag are piecewise linear.

use std::borrow::Cow;

use tunenet_core::observation::{Hold, Input};

use super::numbers::JointNumbers;
use super::piece::Piece;
use super::rate_limiter::RateLimiter;
use super::trajectory::Grid;

/// A signal that is read forward, `delay_s` after it was recorded.
#[derive(Debug, Clone)]
pub(super) struct Signal<'a> {
    clock: Cow<'a, [f64]>,
    values: Cow<'a, [f64]>,
    hold: Hold,
    delay_s: f64,
    /// How many samples lie at or before the end of the last step.
    at: usize,
    /// What follows the last of them, behind the limiter.
    piece: Piece,
    limiter: Option<RateLimiter>,
}

impl<'a> Signal<'a> {
    /// The first channel of `input`, read from the instant `start_s` on.
    pub fn new(input: &'a Input, start_s: f64, delay_s: f64) -> Self {
        let series = input.series();
        let (clock, values) = (Cow::Borrowed(series.clock()), Cow::Borrowed(series.values()));
        Self { clock, values, hold: input.hold(), delay_s, at: 0, piece: Piece::default(), limiter: None }.from(start_s)
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
        self.skip_repeated();
        self.piece = self.present();
        self
    }

    /// Goes on to the last sample of those that repeat the value before them: they are one piece.
    fn skip_repeated(&mut self) {
        let ahead = usize::from(self.hold == Hold::Linear);
        let values = &*self.values;
        let repeats = |at: usize| {
            at > 0 && at + ahead < values.len() && values[at - 1..=at + ahead].windows(2).all(|two| two[0] == two[1])
        };
        while repeats(self.at) {
            self.at += 1;
        }
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

    /// The same behind a limiter to this rate (1/s), which has the value of the signal at `start_s`.
    pub fn limited(mut self, greatest_rate: f64, start_s: f64) -> Self {
        let (mut limiter, at_s) = (RateLimiter::new(greatest_rate), start_s - self.delay_s);
        self.piece = limiter.behind(self.piece, (at_s, self.piece.at(at_s)));
        self.limiter = Some(limiter);
        self
    }

    /// Goes on to the piece after the present one.
    fn advance(&mut self) {
        if let Some(rest) = self.limiter.as_mut().and_then(RateLimiter::rest) {
            self.piece = rest;
            return;
        }
        self.at += 1;
        self.skip_repeated();
        let (next, at_s) = (self.present(), self.piece.until_s);
        self.piece = match &mut self.limiter {
            Some(limiter) => limiter.behind(next, (at_s, self.piece.at(at_s))),
            None => next,
        };
    }

    /// Its mean from `from_s` to `to_s`. Steps have to follow one another.
    #[inline]
    pub fn mean(&mut self, from_s: f64, to_s: f64) -> f64 {
        let (from, to) = (from_s - self.delay_s, to_s - self.delay_s);
        // Most steps lie within one piece.
        if to < self.piece.until_s { self.piece.at(0.5 * (from + to)) } else { self.mean_of_pieces(from, to) }
    }

    /// Its means over the steps of `grid` from step `first` on. Steps have to follow one another.
    pub fn means(&mut self, grid: Grid, first: usize, means: &mut [f64]) {
        let mut done = 0;
        while done < means.len() {
            let next = first + done;
            let (piece, middle_s) = (self.piece, 0.5 * grid.step_s - self.delay_s);
            let lasts = (piece.until_s + self.delay_s - grid.time(next)) / grid.step_s;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "the cast saturates: a number of steps"
            )]
            let within = (lasts as usize).min(means.len() - done);
            for (i, mean) in means[done..done + within].iter_mut().enumerate() {
                *mean = piece.at(grid.time(next + i) + middle_s);
            }
            done += within;
            if let Some(mean) = means.get_mut(done) {
                *mean = self.mean(grid.time(first + done), grid.time(first + done + 1));
                done += 1;
            }
        }
    }

    #[inline(never)]
    fn mean_of_pieces(&mut self, from_s: f64, to_s: f64) -> f64 {
        let (mut area, mut from) = (0.0, from_s);
        loop {
            let end = self.piece.until_s.min(to_s);
            if end > from {
                area += self.piece.at(0.5 * (from + end)) * (end - from);
                from = end;
            }
            if self.piece.until_s > to_s {
                return area / (to_s - from_s);
            }
            self.advance();
        }
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

    /// The mean of a step within one held sample is that sample, to the last bit.
    #[test]
    fn a_held_sample_is_its_own_mean() {
        let channel = Channel::new("goal", "rad");
        let held = Input::sampled(channel, Hold::Previous, vec![0.0, 1.0, 2.0], vec![0.1, 0.7, 0.7]).unwrap();
        let mut signal = Signal::new(&held, 0.0, 0.25);
        assert_eq!((signal.mean(0.0, 0.3), signal.mean(0.3, 1.2)), (0.1, 0.1));
        assert_eq!(signal.mean(1.25, 1.9), 0.7);
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

    /// Steps of 0.03 s against samples every 0.1 s, some of which repeat the value before them, at a delay of 0.05 s.
    #[test]
    fn means_over_a_grid_are_those_of_single_steps() {
        let clock: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
        let values = clock.iter().map(|t| (2.0 * t).sin().max(0.0)).collect();
        let grid = Grid { start_s: 0.2, step_s: 0.03 };
        for hold in [Hold::Previous, Hold::Linear] {
            let input = Input::sampled(Channel::new("goal", "rad"), hold, clock.clone(), Vec::clone(&values)).unwrap();
            for signal in [Signal::new(&input, 0.2, 0.05), Signal::new(&input, 0.2, 0.05).limited(1.5, 0.2)] {
                let (mut all, mut single) = ([0.0; 150], signal.clone());
                let mut signal = signal;
                signal.means(grid, 0, &mut all[..64]);
                signal.means(grid, 64, &mut all[64..]);
                for (k, mean) in all.iter().enumerate() {
                    let one = single.mean(grid.time(k), grid.time(k + 1));
                    assert!((mean - one).abs() < 1e-14, "{hold:?} {k}: {mean} {one}");
                }
            }
        }
    }

    #[test]
    fn a_limited_follower_meets_the_line_at_the_instant_of_the_closed_form() {
        // It starts at 0, the goal stands at 2 from t = 1 on, the rate is 4: there after half a second.
        let input = input(Hold::Previous);
        let mut signal = Signal::new(&input, 0.0, 0.0).limited(4.0, 0.0);
        assert_eq!(signal.mean(0.0, 1.0), 0.0);
        let mean = signal.mean(1.0, 2.0);
        assert!((mean - (0.5 * 1.0 + 0.5 * 2.0)).abs() < 1e-12 && (signal.now(2.0) - 2.0).abs() < 1e-12, "{mean}");
        // Without a limit that bites the mean is that of the signal itself.
        assert!((Signal::new(&input, 0.0, 0.0).limited(1e9, 0.0).mean(0.0, 1.5) - 2.0 / 3.0).abs() < 1e-8);
    }
}
