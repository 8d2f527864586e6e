//! An arm that releases a ball: its postures over the heights, and its way to one of them.

use nalgebra::{Rotation3, Translation3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use tunenet_formats::JointPoint;
use tunenet_formats::{Error, Result};

use super::Reach;
use crate::arm::reach::{self, Goal, Settings};
use crate::arm::{Frame, Model, Pose, model_file};
use crate::scene::ArmTask;

/// Postures that are tried where nothing near is known, and what they are drawn from.
const STARTS: usize = 24;
const SEED: u64 = 0;
/// A ball is held where it should be to a hundredth of a millimetre.
const TOLERANCE: f64 = 1e-5;
const ITERATIONS: usize = 120;
/// The approach begins so far from the release, towards the base, m.
const APPROACH_M: f64 = 0.1;
/// Share of the joints' greatest speeds that it uses.
const SPEED: f64 = 0.5;
/// Where a file states none, rad/s.
const UNSAID_RAD_S: f64 = 1.0;
/// Points of the approach for each second.
const RATE_HZ: f64 = 50.0;
/// Shortest approach, s.
const SHORTEST_S: f64 = 0.5;

/// An arm on its base.
#[derive(Debug, Clone)]
pub struct ArmReach {
    model: Model,
    /// Where the ball's centre is held.
    grip: Frame,
    base: Pose,
    /// How the link is turned, seen from the base.
    rotation: Option<Rotation3<f64>>,
}

impl ArmReach {
    /// Reads the arm of a task. Whether it collides with anything, itself included, is not looked at.
    ///
    /// # Errors
    /// As [`model_file::read`]; [`Setting`](tunenet_core::Error::Setting) where it has no such link, or no joint moves it.
    pub fn new(task: &ArmTask) -> Result<Self> {
        let whole = model_file::read(&task.urdf)?;
        let last = || whole.frames.last().map(|f| f.name.clone()).unwrap_or_default();
        let link = task.link.clone().unwrap_or_else(last);
        let named = |error: tunenet_core::Error| match error {
            tunenet_core::Error::Setting { expected, found, .. } => {
                let message = format!("`arm.link`: expected {expected}, found {found}");
                Error::file(&task.urdf, message, "name the link that holds the ball in the task file")
            }
            other => other.into(),
        };
        let model = whole.chain_to(&link).map_err(named)?;
        let frame = model.frame(&link).map_err(named)?;
        let held = Pose::from_parts(Translation3::from(Vector3::from(task.grip_m)), Rotation3::identity());
        let grip = Frame { placement: frame.placement * held, ..frame.clone() };
        let turned = |[roll, pitch, yaw]: [f64; 3]| Rotation3::from_euler_angles(roll, pitch, yaw);
        let base = Pose::from_parts(Translation3::from(Vector3::from(task.base_position_m)), turned(task.base_rpy_rad));
        let rotation = task.tool_rpy_rad.map(|rpy| base.rotation.inverse() * turned(rpy));
        Ok(Self { model, grip, base, rotation })
    }

    /// The names of its joints.
    #[must_use]
    pub fn joint_names(&self) -> Vec<String> {
        self.model.joints().into_iter().map(|j| j.name.clone()).collect()
    }

    /// The name of the link that stands still.
    #[must_use]
    pub fn base_name(&self) -> &str {
        // Links that are fixed to it have other positions.
        let still = |f: &&Frame| f.body.is_none() && f.placement == Pose::identity();
        self.model.frames.iter().find(still).map_or("", |f| f.name.as_str())
    }

    /// The posture nearest to `start` that holds the ball there.
    fn near(&self, point_m: [f64; 3], start: &[f64]) -> Option<Vec<f64>> {
        let position = self.base.inverse_transform_point(&point_m.into());
        let goal = Goal { position_m: position.coords, rotation: self.rotation };
        let settings = Settings { iterations: ITERATIONS, tolerance: TOLERANCE, ..Settings::default() };
        let mut q = start.to_vec();
        (reach::Reach::new(&self.model, &self.grip).solve(&goal, &mut q, &settings) <= TOLERANCE).then_some(q)
    }

    /// The way to the release at `point_m` in the posture `release` (rad): from a nearby position, with minimum jerk, at half of
    /// the joints' speeds.
    #[must_use]
    pub fn approach(&self, point_m: [f64; 3], release: &[f64]) -> Vec<JointPoint> {
        let mut away = self.base.translation.vector - Vector3::from(point_m);
        away.z = 0.0;
        let away = away.try_normalize(1e-9).unwrap_or_else(Vector3::zeros) * APPROACH_M;
        // Where that is too near to the base, from above or from below; at worst the arm stands ready already.
        let ways = [away, Vector3::z() * APPROACH_M, Vector3::z() * -APPROACH_M];
        let nearby = |way: &Vector3<f64>| self.near((Vector3::from(point_m) + way).into(), release);
        let start = ways.iter().find_map(nearby).unwrap_or_else(|| release.to_vec());
        let joints = self.model.joints();
        let limit = |i: usize| Some(joints[i].limits.velocity).filter(|v| v.is_finite()).unwrap_or(UNSAID_RAD_S);
        let change: Vec<f64> = release.iter().zip(&start).map(|(to, from)| to - from).collect();
        // A way of least jerk is 15/8 as fast in its middle as on average.
        let needed = change.iter().enumerate().map(|(i, d)| 1.875 * d.abs() / (SPEED * limit(i)));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few seconds")]
        let count = (needed.fold(SHORTEST_S, f64::max) * RATE_HZ).ceil() as u32;
        // Whole steps of the clock, if anything slower than needed.
        let seconds = f64::from(count) / RATE_HZ;
        (0..=count)
            .map(|k| {
                let s = f64::from(k) / f64::from(count);
                let place = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
                let rate = 30.0 * s * s * (1.0 - s) * (1.0 - s) / seconds;
                let bend = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (seconds * seconds);
                JointPoint {
                    time_s: f64::from(k) / RATE_HZ,
                    positions_rad: start.iter().zip(&change).map(|(from, d)| from + place * d).collect(),
                    velocities_rad_s: change.iter().map(|d| rate * d).collect(),
                    accelerations_rad_s2: change.iter().map(|d| bend * d).collect(),
                }
            })
            .collect()
    }
}

impl Reach for ArmReach {
    fn joints(&self, point_m: [f64; 3], before: Option<&[f64]>) -> tunenet_core::Result<Option<Vec<f64>>> {
        if let Some(found) = before.and_then(|q| self.near(point_m, q)) {
            return Ok(Some(found));
        }
        let solver = reach::Reach::new(&self.model, &self.grip);
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut start = vec![0.0; self.model.degrees()];
        for _ in 0..STARTS {
            solver.draw(&mut random, &mut start);
            if let Some(found) = self.near(point_m, &start) {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::arm::Kinematics;
    use crate::shot::Task;

    fn arm() -> (Task, ArmReach) {
        let task = Task::read(Path::new("../../assets/shot.toml")).unwrap();
        let arm = ArmReach::new(task.arm.as_ref().unwrap()).unwrap();
        (task, arm)
    }

    /// The ball's centre in a posture, from the impact point.
    fn held(arm: &ArmReach, q: &[f64]) -> Vector3<f64> {
        let mut at = Kinematics::new(&arm.model);
        at.update(q);
        (arm.base * at.frame(&arm.grip)).translation.vector
    }

    #[test]
    fn every_height_of_the_ready_task_is_within_reach_and_limits() {
        let (task, arm) = arm();
        let mut before: Option<Vec<f64>> = None;
        for i in 0..=100 {
            let height =
                task.release.heights_m.0 + 0.01 * f64::from(i) * (task.release.heights_m.1 - task.release.heights_m.0);
            let q = arm.joints([0.0, 0.0, height], before.as_deref()).unwrap();
            let q = q.unwrap_or_else(|| panic!("{height} m is out of reach"));
            assert!((held(&arm, &q) - Vector3::new(0.0, 0.0, height)).norm() <= 2.0 * TOLERANCE);
            for (q, joint) in q.iter().zip(arm.model.joints()) {
                assert!((joint.limits.lower..=joint.limits.upper).contains(q), "{height}: {} {q}", joint.name);
            }
            before = Some(q);
        }
    }

    #[test]
    fn what_is_too_far_is_out_of_reach() {
        assert_eq!(arm().1.joints([0.0, 0.0, 3.0], None).unwrap(), None);
    }

    /// Rates by differences of the positions, their rates by differences of them: what is stated is what is done, from rest
    /// to rest, within half of the speeds that the URDF allows and within its limits.
    #[test]
    fn the_approach_ends_at_rest_at_the_release_within_the_speeds() {
        let (_, arm) = arm();
        assert_eq!(arm.base_name(), "base");
        let release = arm.joints([0.0, 0.0, 0.5], None).unwrap().unwrap();
        let way = arm.approach([0.0, 0.0, 0.5], &release);
        let (first, last) = (&way[0], &way[way.len() - 1]);
        assert_eq!(last.positions_rad.len(), release.len());
        assert!(last.positions_rad.iter().zip(&release).all(|(a, b)| (a - b).abs() < 1e-12));
        for end in [first, last] {
            assert!(end.velocities_rad_s.iter().chain(&end.accelerations_rad_s2).all(|v| v.abs() < 1e-9));
        }
        assert!(first.time_s == 0.0 && (held(&arm, &first.positions_rad) - held(&arm, &release)).norm() > 0.09);
        for (k, point) in way.iter().enumerate() {
            assert!((point.time_s - k as f64 / RATE_HZ).abs() < 1e-12);
        }
        let step = 1.0 / RATE_HZ;
        let seconds = last.time_s;
        for (i, joint) in arm.model.joints().iter().enumerate() {
            // The third derivative is at most 60 times the way over T³, the fourth 360 times; differences over two steps
            // are off by h²/6 of what follows.
            let way_rad = (last.positions_rad[i] - first.positions_rad[i]).abs();
            let (slack, slack2) = (60.0 / seconds.powi(3), 360.0 / seconds.powi(4));
            for three in way.windows(3) {
                let [before, at, after] = three else { unreachable!() };
                let rate = (after.positions_rad[i] - before.positions_rad[i]) / (2.0 * step);
                let bend = (after.velocities_rad_s[i] - before.velocities_rad_s[i]) / (2.0 * step);
                let (rate_off, bend_off) = (rate - at.velocities_rad_s[i], bend - at.accelerations_rad_s2[i]);
                assert!(rate_off.abs() <= way_rad * slack * step * step / 6.0 + 1e-12, "{} {rate_off}", joint.name);
                assert!(bend_off.abs() <= way_rad * slack2 * step * step / 6.0 + 1e-12, "{} {bend_off}", joint.name);
            }
            for point in &way {
                assert!((joint.limits.lower..=joint.limits.upper).contains(&point.positions_rad[i]), "{}", joint.name);
                assert!(point.velocities_rad_s[i].abs() <= SPEED * joint.limits.velocity + 1e-12, "{}", joint.name);
            }
        }
    }

    #[test]
    fn an_unknown_link_is_named_with_those_there_are() {
        let (task, _) = arm();
        let wrong = ArmTask { link: Some("claw".into()), ..task.arm.unwrap() };
        let refused = ArmReach::new(&wrong).unwrap_err().to_string();
        assert!(refused.contains("`arm.link`: expected a link of the URDF") && refused.contains("claw"), "{refused}");
    }
}
