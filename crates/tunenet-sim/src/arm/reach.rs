//! Inverse kinematics: damped least squares (Nakamura and Hanafusa 1986), with the null space used to keep away from the joint limits.

use nalgebra::{Matrix6, Matrix6xX, Rotation3, Vector3, Vector6};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::{Frame, Kinematics, Limits, Model};

/// Damping grows with the error, so that a far goal is approached in bounded steps: λ² = this · error².
const DAMPING: f64 = 0.01;
/// Least damping, for singular poses.
const LEAST_DAMPING: f64 = 1e-12;
/// Longest step of one joint, rad or m.
const LONGEST_STEP: f64 = 0.3;

/// Where a frame is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Its origin in the world, m.
    pub position_m: Vector3<f64>,
    /// Its orientation in the world; any where there is none.
    pub rotation: Option<Rotation3<f64>>,
}

/// When to stop, and the use of the redundant joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Most steps.
    pub iterations: usize,
    /// Reached where position (m) and orientation (rad) are this near.
    pub tolerance: f64,
    /// How far each step of the first half goes towards the middle of the limits, 0 to 1, without moving the frame. At 0 the
    /// joints move as little as the goal allows.
    pub centring: f64,
    /// Whether joints stay within their limits.
    pub limited: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { iterations: 200, tolerance: 1e-10, centring: 0.05, limited: true }
    }
}

/// Solves for one frame of one model; working memory that is allocated once.
///
/// ```
/// # use tunenet_sim::arm::{Kinematics, reach::{Goal, Reach, Settings}, urdf};
/// # use nalgebra::Vector3;
/// # let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/jaco_robotiq.urdf"));
/// let arm = urdf::parse("jaco_robotiq.urdf".as_ref(), text)?.chain_to("grip")?;
/// let goal = Goal { position_m: Vector3::new(0.3, 0.2, 0.5), rotation: None };
/// let mut q = [0.0, 3.0, 0.0, 2.0, 0.0, 3.0, 0.0];
/// let distance = Reach::new(&arm, arm.frame("grip")?).solve(&goal, &mut q, &Settings::default());
/// let mut at = Kinematics::new(&arm);
/// at.update(&q);
/// assert!(distance <= 1e-10 && (at.frame(arm.frame("grip")?).translation.vector - goal.position_m).norm() <= 1e-10);
/// # Ok::<(), tunenet_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Reach<'a> {
    at: Kinematics<'a>,
    frame: &'a Frame,
    limits: Vec<Limits>,
    jacobian: Matrix6xX<f64>,
}

impl<'a> Reach<'a> {
    /// Working memory for `frame` of `model`.
    #[must_use]
    pub fn new(model: &'a Model, frame: &'a Frame) -> Self {
        let limits = model.joints().iter().map(|j| j.limits).collect();
        Self { at: Kinematics::new(model), frame, limits, jacobian: Matrix6xX::zeros(model.degrees()) }
    }

    /// Moves `q` until the frame is at `goal`, and returns how far from it (m, and rad, in one norm) it ends. At or below
    /// the tolerance it is reached; everything else is the nearest that was found from this start.
    ///
    /// # Panics
    /// Where `q` is shorter than [`Model::degrees`].
    pub fn solve(&mut self, goal: &Goal, q: &mut [f64], settings: &Settings) -> f64 {
        let mut left = self.error(goal, q);
        for i in 0..settings.iterations {
            if left.norm() <= settings.tolerance {
                break;
            }
            // What moves nothing to first order moves a little to second: the last half goes to the goal alone.
            let centring = if i < settings.iterations / 2 { settings.centring } else { 0.0 };
            self.step(goal, &left, q, &Settings { centring, ..*settings });
            left = self.error(goal, q);
        }
        left.norm()
    }

    /// What is missing to `goal`: position, then a rotation vector, in world axes.
    fn error(&mut self, goal: &Goal, q: &[f64]) -> Vector6<f64> {
        self.at.update(q);
        let now = self.at.frame(self.frame);
        let position = goal.position_m - now.translation.vector;
        let turn = goal.rotation.map_or_else(Vector3::zeros, |wanted| turn(&(wanted * now.rotation.inverse())));
        Vector6::new(position.x, position.y, position.z, turn.x, turn.y, turn.z)
    }

    fn step(&mut self, goal: &Goal, left: &Vector6<f64>, q: &mut [f64], settings: &Settings) {
        self.at.jacobian(self.frame, &mut self.jacobian);
        if goal.rotation.is_none() {
            self.jacobian.rows_mut(3, 3).fill(0.0);
        }
        let damping = LEAST_DAMPING + DAMPING * left.norm_squared();
        let mut normal = Matrix6::identity() * damping;
        for column in self.jacobian.column_iter() {
            normal += column * column.transpose();
        }
        // A sum of squares and a positive diagonal.
        let Some(normal) = normal.cholesky() else { return };
        let free = |i: usize, q: &[f64]| settings.centring * middle(&self.limits[i]).map_or(0.0, |m| m - q[i]);
        // Of the step towards the middle only the null-space component is used: z − J⁺·J·z.
        let nullspace =
            self.jacobian.column_iter().enumerate().fold(Vector6::zeros(), |sum, (i, c)| sum + c * free(i, q));
        let wanted = normal.solve(&(left - nullspace));
        let step = |i: usize, q: &[f64]| self.jacobian.column(i).dot(&wanted) + free(i, q);
        let longest = (0..self.limits.len()).map(|i| step(i, q).abs()).fold(LONGEST_STEP, f64::max);
        for i in 0..self.limits.len() {
            q[i] += step(i, q) * LONGEST_STEP / longest;
            if settings.limited {
                q[i] = q[i].clamp(self.limits[i].lower, self.limits[i].upper);
            }
        }
    }

    /// A posture drawn at random within the limits, or within a turn where there are none.
    pub fn draw(&self, random: &mut ChaCha8Rng, q: &mut [f64]) {
        let turn = std::f64::consts::PI;
        for (q, limits) in q.iter_mut().zip(&self.limits) {
            *q = random.random_range(limits.lower.max(-turn)..=limits.upper.min(turn).max(limits.lower.max(-turn)));
        }
    }
}

/// The middle between finite limits.
fn middle(limits: &Limits) -> Option<f64> {
    (limits.lower.is_finite() && limits.upper.is_finite()).then_some(0.5 * (limits.lower + limits.upper))
}

/// The rotation vector of `rotation`, from its skew part: near none it is exact, where nalgebra's own is not a number.
fn turn(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let r = rotation.matrix();
    let skew = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]) * 0.5;
    let (sine, cosine) = (skew.norm(), 0.5 * (r.trace() - 1.0));
    if cosine > 0.0 && sine < 1e-6 {
        return skew;
    }
    if sine < 1e-9 {
        // Half a turn: the axis is a column of R + 1; which sense is all the same.
        let columns = r + nalgebra::Matrix3::identity();
        let longest = (0..3).map(|i| columns.column(i).into_owned()).max_by(|a, b| a.norm().total_cmp(&b.norm()));
        return longest.map_or(skew, |axis| axis.normalize() * std::f64::consts::PI);
    }
    skew * (sine.atan2(cosine) / sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rotation_vector_comes_back() {
        let axis = Vector3::new(0.6, -0.8, 0.0);
        for angle in [0.0, 1e-12, 1e-7, 0.3, 1.6, 3.1] {
            let back = turn(&Rotation3::new(axis * angle));
            assert!((back - axis * angle).norm() < 1e-9 * (1.0 + angle), "{angle}: {back}");
        }
        let half = turn(&Rotation3::new(axis * std::f64::consts::PI));
        assert!((half.norm() - std::f64::consts::PI).abs() < 1e-9 && half.cross(&axis).norm() < 1e-9);
    }
}
