//! Explicit Runge–Kutta pair of order 5(4) with dense output (Dormand & Prince, "A family of embedded Runge–Kutta formulae", J. Comp.
//! Appl. Math. 6, 1980; step control and interpolant of order 4 by Hairer, Nørsett & Wanner, "Solving ODEs I", II.4 and II.6).

/// Usual tolerance of a step relative to the size of each state.
pub(super) const TOLERANCE: f64 = 1e-8;
/// The least size of a state for that, in its unit.
const LEAST_SIZE: f64 = 1e-6;
/// A step grows by at most this factor, and shrinks by at most `1 / SHRINK`.
const GROWTH: f64 = 10.0;
const SHRINK: f64 = 0.2;
const SAFETY: f64 = 0.9;
/// How far is looked ahead for what has no value: so many steps, and at least so many seconds.
const STEPS_AHEAD: f64 = 10.0;
const LEAST_AHEAD_S: f64 = 1e-6;
/// Stages of a step; the last is the first of the next one.
const STAGES: usize = 7;

const NODES: [f64; STAGES] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const WEIGHTS: [[f64; 6]; STAGES] = [
    [0.0; 6],
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19_372.0 / 6561.0, -25_360.0 / 2187.0, 64_448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46_732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18_656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// The solution of order 5 minus that of order 4.
const ERROR: [f64; STAGES] =
    [71.0 / 57_600.0, 0.0, -71.0 / 16_695.0, 71.0 / 1920.0, -17_253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];
const DENSE: [f64; STAGES] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

/// A state that moves, and the step that it takes.
#[derive(Debug, Clone)]
pub(super) struct Stepper {
    /// Where the step begins, s, and the state there.
    pub t: f64,
    pub y: Vec<f64>,
    /// The state at the end of the step.
    pub end: Vec<f64>,
    /// How long the step is, s.
    pub h: f64,
    /// How long the next one should be, s.
    pub proposed: f64,
    /// The derivatives of all stages, one stage after the other.
    stages: Vec<f64>,
    /// The five coefficients of the interpolant, of one state after the other.
    dense: Vec<[f64; 5]>,
    /// The greatest magnitude of each state so far.
    size: Vec<f64>,
    /// The tolerance relative to that.
    tolerance: f64,
}

impl Stepper {
    pub fn new(start: &[f64], tolerance: f64) -> Self {
        let n = start.len();
        Self {
            t: 0.0,
            y: start.to_vec(),
            end: start.to_vec(),
            h: 0.0,
            proposed: 0.0,
            stages: vec![0.0; STAGES * n],
            dense: vec![[0.0; 5]; n],
            size: start.iter().map(|value| value.abs().max(LEAST_SIZE)).collect(),
            tolerance,
        }
    }

    /// Where the derivative leads to in some steps of the present length, and how much later that is, s.
    pub fn ahead(&self) -> (Vec<f64>, f64) {
        let later = (STEPS_AHEAD * self.h).max(LEAST_AHEAD_S);
        (self.y.iter().zip(&self.stages).map(|(y, rate)| y + later * rate).collect(), later)
    }

    /// Evaluates the derivative where the step begins.
    pub fn begin(&mut self, mut field: impl FnMut(f64, &[f64], &mut [f64])) {
        let n = self.y.len();
        field(self.t, &self.y, &mut self.stages[..n]);
    }

    /// A first length of a step, from the derivative at its beginning and how fast that changes.
    pub fn propose(&mut self, mut field: impl FnMut(f64, &[f64], &mut [f64])) {
        let n = self.y.len();
        let (first, rest) = self.stages.split_at_mut(n);
        let norm = |values: &mut dyn Iterator<Item = f64>| {
            let sum: f64 = values.zip(&self.size).map(|(value, size)| (value / (self.tolerance * size)).powi(2)).sum();
            (sum / n.max(1) as f64).sqrt()
        };
        let (position, speed) = (norm(&mut self.y.iter().copied()), norm(&mut first.iter().copied()));
        let small = if position < 1e-5 || speed < 1e-5 { 1e-6 } else { 0.01 * position / speed };
        for (end, (y, rate)) in self.end.iter_mut().zip(self.y.iter().zip(&*first)) {
            *end = y + small * rate;
        }
        field(self.t + small, &self.end, &mut rest[..n]);
        let bend = norm(&mut (0..n).map(|i| (rest[i] - first[i]) / small));
        let greatest = speed.max(bend);
        let long = if greatest <= 1e-15 { (1e-3 * small).max(1e-6) } else { (0.01 / greatest).powf(0.2) };
        self.proposed = long.min(100.0 * small);
    }

    /// Tries a step of this length (s) that ends at `until`; whether it is exact enough. Proposes the length of the next try.
    pub fn attempt(&mut self, h: f64, until: f64, mut field: impl FnMut(f64, &[f64], &mut [f64])) -> bool {
        let n = self.y.len();
        self.h = h;
        for stage in 1..STAGES {
            let (done, new) = self.stages.split_at_mut(stage * n);
            for (i, (end, y)) in self.end.iter_mut().zip(&self.y).enumerate() {
                let known = done[i..].iter().step_by(n);
                let sum: f64 = known.zip(&WEIGHTS[stage]).map(|(rate, weight)| weight * rate).sum();
                *end = y + h * sum;
            }
            let t = if stage >= 5 { until } else { self.t + NODES[stage] * h };
            field(t, &self.end, &mut new[..n]);
        }
        let mut sum = 0.0;
        for i in 0..n {
            let error: f64 = h * (0..STAGES).map(|k| ERROR[k] * self.stages[k * n + i]).sum::<f64>();
            let size = self.size[i].max(self.end[i].abs());
            sum += (error / (self.tolerance * size)).powi(2);
        }
        let error = sum / n as f64;
        if !error.is_finite() {
            self.proposed = 0.1 * h;
            return false;
        }
        // The fifth root of the root of the mean square.
        let raw = error.powf(0.1);
        if error > 1.0 {
            self.proposed = h * (SAFETY / raw).max(SHRINK);
            return false;
        }
        self.proposed = h * (SAFETY / raw).clamp(SHRINK, GROWTH);
        true
    }

    /// Prepares states within the step.
    pub fn interpolate(&mut self) {
        let n = self.y.len();
        for (i, dense) in self.dense.iter_mut().enumerate() {
            let k = |stage: usize| self.stages[stage * n + i];
            let difference = self.end[i] - self.y[i];
            let bend = self.h * k(0) - difference;
            let last: f64 = self.h * (0..STAGES).map(|stage| DENSE[stage] * k(stage)).sum::<f64>();
            *dense = [self.y[i], difference, bend, difference - self.h * k(6) - bend, last];
        }
    }

    /// The state at a share of the step, 0 to 1.
    pub fn within(&self, share: f64, state: &mut [f64]) {
        let rest = 1.0 - share;
        for (value, [a, b, c, d, e]) in state.iter_mut().zip(&self.dense) {
            *value = a + share * (b + rest * (c + share * (d + rest * e)));
        }
    }

    /// Ends the step at `t`, the end of the whole step; the next one begins there with the derivative that is known.
    pub fn advance(&mut self, t: f64) {
        let n = self.y.len();
        self.t = t;
        self.y.copy_from_slice(&self.end);
        self.stages.copy_within(6 * n.., 0);
        self.grow();
    }

    /// Continues from another state, whose derivative is not known yet.
    pub fn restart(&mut self, t: f64, state: &[f64]) {
        self.t = t;
        self.y.copy_from_slice(state);
        self.grow();
    }

    fn grow(&mut self) {
        for (size, value) in self.size.iter_mut().zip(&self.y) {
            *size = size.max(value.abs());
        }
    }

    /// The state that changed most in its last step, for a message.
    pub fn fastest(&self) -> usize {
        let n = self.y.len();
        let speed = |i: usize| {
            let rate = self.stages[i].abs() / self.size[i];
            if rate.is_finite() { rate } else { f64::INFINITY }
        };
        (0..n).fold(0, |most, i| if speed(i) > speed(most) { i } else { most })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The weights of a row sum to its node, and the interpolant meets both ends.
    #[test]
    fn the_table_is_consistent() {
        for (row, node) in WEIGHTS.iter().zip(NODES) {
            assert!((row.iter().sum::<f64>() - node).abs() < 1e-14);
        }
        assert!(ERROR.iter().sum::<f64>().abs() < 1e-15 && DENSE.iter().sum::<f64>().abs() < 1e-12);
    }

    #[test]
    fn an_oscillator_is_followed_at_every_instant() {
        let mut field = |_: f64, y: &[f64], f: &mut [f64]| {
            f[0] = y[1];
            f[1] = -4.0 * y[0];
        };
        let mut stepper = Stepper::new(&[1.0, 0.0], TOLERANCE);
        stepper.begin(&mut field);
        stepper.propose(&mut field);
        let mut steps = 0;
        while stepper.t < 10.0 {
            let h = stepper.proposed;
            let until = stepper.t + h;
            if !stepper.attempt(h, until, &mut field) {
                continue;
            }
            stepper.interpolate();
            let mut state = [0.0; 2];
            for share in [0.2, 0.5, 0.9] {
                stepper.within(share, &mut state);
                let t = stepper.t + share * h;
                assert!((state[0] - (2.0 * t).cos()).abs() < 2e-7, "{t}: {}", state[0] - (2.0 * t).cos());
            }
            stepper.advance(until);
            steps += 1;
        }
        assert!(steps < 400, "{steps}");
    }
}
