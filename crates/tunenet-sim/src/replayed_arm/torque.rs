//! Regressors of inverse dynamics along a log: computed once, then combined for every set of numbers.

use nalgebra::Vector3;
use tunenet_core::Result;
use tunenet_core::observation::{Channel, Kind, Observation};

use super::filter::whole;
use super::recorded::Recorded;
use crate::arm::effects::Imperfections;
use crate::arm::{Frame, Inertia, Model, PAYLOAD_NUMBERS, Recursion, gravity, payload_numbers};

/// Columns of an input for each joint: position, speed, acceleration, rigid torque, and what the payload's numbers add.
const LOADED: usize = 4 + PAYLOAD_NUMBERS;
/// ... of a run without payload.
const BARE: usize = 4;

/// A cube of this mass (kg) and edge (m) at this place (m) of its link.
pub(super) fn cube(mass_kg: f64, com_m: [f64; 3], edge_m: f64) -> Inertia {
    Inertia::cube(mass_kg, Vector3::from(com_m), edge_m)
}

/// The arm that a log was taken of.
#[derive(Debug, Clone)]
pub(super) struct Arm {
    pub model: Model,
    pub payload: Frame,
    pub gravity_m_s2: f64,
}

/// One run within an input: where its columns begin, and whether the arm carried the payload.
#[derive(Clone, Copy)]
struct Run {
    first: usize,
    loaded: bool,
}

impl Arm {
    pub fn joints(&self) -> usize {
        self.model.degrees()
    }

    /// The input of a rollout: the motion on its even clock and what it asks of the rigid arm; that of a `reference` next to it,
    /// sample for sample.
    pub fn input(&self, log: &Recorded, reference: Option<&Recorded>) -> Result<Observation> {
        let n = self.joints();
        let width = n * (LOADED + if reference.is_some() { BARE } else { 0 });
        let mut values = vec![0.0; log.len() * width];
        let mut recursion = Recursion::new(&self.model, gravity(self.gravity_m_s2));
        for (i, row) in values.chunks_exact_mut(width).enumerate() {
            let runs = [(Some(log), true), (reference, false)];
            let mut first = 0;
            for (log, loaded) in runs.into_iter().filter_map(|(log, loaded)| Some((log?, loaded))) {
                let (q, dq, ddq) = (log.row(&log.q, i), log.row(&log.dq, i), log.row(&log.ddq, i));
                for (k, from) in [q, dq, ddq].into_iter().enumerate() {
                    row[first + k * n..first + (k + 1) * n].copy_from_slice(from);
                }
                recursion.inverse_dynamics(q, dq, ddq, &mut row[first + 3 * n..first + 4 * n]);
                if loaded {
                    recursion.payload_regressor(&self.payload, &mut row[first + 4 * n..first + LOADED * n]);
                }
                first += n * if loaded { LOADED } else { BARE };
            }
        }
        let clock = (0..log.len()).map(|i| log.start_s + i as f64 * log.step_s).collect();
        let name = |i: usize| match i / n {
            0 => Channel::new(format!("q{}", i + 1), "rad"),
            1 => Channel::new(format!("dq{}", i - n + 1), "rad/s"),
            _ => Channel::new(format!("m{i}"), "1"),
        };
        let channels = (0..width).map(name).collect();
        Observation::new(Kind::Other, channels, clock, values)
    }

    /// What the sensors show at every sample of `input`, row-major `[sample, joint]`; less what they show without the payload
    /// where the input holds such a run.
    pub fn shown(&self, input: &Observation, load: &Inertia, arm: &Imperfections) -> Vec<f64> {
        let n = self.joints();
        let mut shown = vec![0.0; input.len() * n];
        self.add(input, Run { first: 0, loaded: true }, load, arm, 1.0, &mut shown);
        if input.channels().len() > n * LOADED {
            self.add(input, Run { first: n * LOADED, loaded: false }, &Inertia::zero(), arm, -1.0, &mut shown);
        }
        shown
    }

    fn add(&self, input: &Observation, run: Run, load: &Inertia, arm: &Imperfections, sign: f64, into: &mut [f64]) {
        let n = self.joints();
        let rigid = if arm.bends() { self.bent(input, run, load, arm) } else { self.rigid(input, run, load) };
        for (i, (into, rigid)) in into.chunks_exact_mut(n).zip(rigid.chunks_exact(n)).enumerate() {
            let row = &input.row(i)[run.first..];
            for j in 0..n {
                into[j] += sign * arm.shown(j, rigid[j], input.clock()[i], [row[j], row[n + j], row[2 * n + j]]);
            }
        }
    }

    /// Rigid torques where everything stands as the encoders say.
    fn rigid(&self, input: &Observation, run: Run, load: &Inertia) -> Vec<f64> {
        let n = self.joints();
        let numbers = payload_numbers(load);
        let mut torques = Vec::with_capacity(input.len() * n);
        for i in 0..input.len() {
            let row = &input.row(i)[run.first..];
            for j in 0..n {
                let mut torque = row[3 * n + j];
                if run.loaded && load.mass_kg != 0.0 {
                    let columns = &row[4 * n + j * PAYLOAD_NUMBERS..4 * n + (j + 1) * PAYLOAD_NUMBERS];
                    torque += columns.iter().zip(&numbers).map(|(c, v)| c * v).sum::<f64>();
                }
                torques.push(torque);
            }
        }
        torques
    }

    /// Rigid torques of an arm that stands otherwise than its encoders say: by offsets, by a tilted base, by gears that twist
    /// under the torque of the rigid arm.
    fn bent(&self, input: &Observation, run: Run, load: &Inertia, arm: &Imperfections) -> Vec<f64> {
        let n = self.joints();
        let model =
            if run.loaded && load.mass_kg != 0.0 { self.model.loaded(&self.payload, load) } else { self.model.clone() };
        let mut recursion = Recursion::new(&model, arm.gravity(self.gravity_m_s2));
        let count = input.len();
        let elastic = arm.elasticity_rad_nm.iter().any(|e| *e != 0.0);
        let twist = if elastic { self.rigid(input, run, load) } else { Vec::new() };
        let step = (input.clock()[count - 1] - input.clock()[0]) / (count - 1) as f64;
        // Twist and its first two slopes, by central differences.
        let twisted = |i: usize, j: usize| -> [f64; 3] {
            if !elastic {
                return [0.0; 3];
            }
            let m = i.clamp(1, count - 2);
            let [before, at, after] = [m - 1, m, m + 1].map(|i| twist[i * n + j]);
            let e = arm.elasticity_rad_nm[j];
            [e * twist[i * n + j], e * (after - before) / (2.0 * step), e * (after - 2.0 * at + before) / (step * step)]
        };
        let mut torques = vec![0.0; count * n];
        let mut moved = vec![0.0; 3 * n];
        for (i, torque) in torques.chunks_exact_mut(n).enumerate() {
            let row = &input.row(i)[run.first..];
            for j in 0..n {
                let [at, first, second] = twisted(i, j);
                moved[j] = row[j] + arm.offset_rad[j] - at;
                moved[n + j] = row[n + j] - first;
                moved[2 * n + j] = row[2 * n + j] - second;
            }
            recursion.inverse_dynamics(&moved[..n], &moved[n..2 * n], &moved[2 * n..], torque);
        }
        torques
    }
}

/// Means over windows of an even series; the primitive is summed once.
pub(super) struct Means {
    start_s: f64,
    step_s: f64,
    width: usize,
    /// The integral up to the lower edge of every cell, row-major; cells are centred on the samples.
    integral: Vec<f64>,
}

impl Means {
    /// Of `values`, row-major with `width` columns, the first at `start_s`.
    pub fn new(values: &[f64], width: usize, start_s: f64, step_s: f64) -> Self {
        let mut integral = vec![0.0; values.len() + width];
        for (i, value) in values.iter().enumerate() {
            integral[i + width] = integral[i] + value * step_s;
        }
        Self { start_s, step_s, width, integral }
    }

    /// The mean over `window_s` about `time_s`, as far as the series goes.
    pub fn at(&self, time_s: f64, window_s: f64, into: &mut [f64]) {
        let cells = self.integral.len() / self.width - 1;
        let edge = |t: f64| ((t - self.start_s) / self.step_s + 0.5).clamp(0.0, cells as f64);
        let (mut low, mut high) = (edge(time_s - 0.5 * window_s), edge(time_s + 0.5 * window_s));
        if high - low < 0.5 {
            // Beyond the ends, or a window shorter than a cell: the nearest cell.
            low = low.min(cells as f64 - 1.0).floor();
            high = low + 1.0;
        }
        let value = |edge: f64, column: usize| {
            let cell = whole(edge).min(cells - 1);
            let (a, b) = (self.integral[cell * self.width + column], self.integral[(cell + 1) * self.width + column]);
            a + (edge - cell as f64) * (b - a)
        };
        for (column, into) in into.iter_mut().enumerate() {
            *into = (value(high, column) - value(low, column)) / ((high - low) * self.step_s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_those_of_the_samples() {
        let means = Means::new(&[1.0, 2.0, 6.0, 7.0], 1, 0.0, 0.1);
        let at = |t: f64, w: f64| {
            let mut into = [0.0];
            means.at(t, w, &mut into);
            into[0]
        };
        assert!((at(0.15, 0.2) - 4.0).abs() < 1e-12);
        assert!((at(0.1, 0.3) - 3.0).abs() < 1e-12);
        assert!((at(0.15, 0.4) - 4.0).abs() < 1e-12);
        assert!((at(9.0, 0.1) - 7.0).abs() < 1e-12 && (at(-9.0, 0.1) - 1.0).abs() < 1e-12);
    }
}
