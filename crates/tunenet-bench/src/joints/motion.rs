//! The bench's own integrator: leapfrog (Störmer 1907; Verlet 1967), from each half step's change of speed as much of the dry friction
//! taken as stops it at most. Nothing of it is shared with the simulator under test.

use tunenet_core::statistics::root_mean_square;

use super::servo::{GAIN_1_RAD, GRAVITY_M_S2, Motor, Run, SUPPLY_V, Secrets};

/// Stiffness of a gear that is not said to give way, N·m/rad.
const STIFF_NM_RAD: f64 = 3000.0;
/// A gear with a gap or a compliance needs shorter steps: its link oscillates on it 100 times a second.
const GEAR_STEP_S: f64 = 1e-4;

/// What is measured in one run, without noise: a position for every instant of its clock.
pub fn positions(motor: &Motor, secrets: &Secrets, run: &Run, longest_step_s: f64) -> Vec<f64> {
    let elastic = secrets.gap_rad > 0.0 || secrets.compliance_rad_nm > 0.0;
    let dt = if elastic { longest_step_s.min(GEAR_STEP_S) } else { longest_step_s };
    let joint = Joint::new(motor, secrets, run);
    let drive = Drive::new(secrets, run, dt);
    let path = if elastic { joint.through_gear(&drive, dt) } else { joint.rigid(&drive, dt) };
    let read = |t: &f64| {
        let late = t - secrets.reading_delay_s;
        let latched = if secrets.latch_s > 0.0 {
            let begin = run.latch_phase * secrets.latch_s;
            begin + ((late - begin) / secrets.latch_s).floor() * secrets.latch_s
        } else {
            late
        };
        at(&path, dt, latched)
    };
    run.clock.iter().map(read).collect()
}

fn at(path: &[f64], dt: f64, time_s: f64) -> f64 {
    let place = (time_s / dt).clamp(0.0, (path.len() - 1) as f64);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the path")]
    let below = (place.floor() as usize).min(path.len().saturating_sub(2));
    path[below] + (place - below as f64) * (path[below + 1] - path[below])
}

/// Internal goal and the share of the motor that is on, at every instant of the grid.
struct Drive {
    goal: Vec<f64>,
    on: Vec<f64>,
}

impl Drive {
    fn new(secrets: &Secrets, run: &Run, dt: f64) -> Self {
        let last = run.clock.last().copied().unwrap_or(0.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "steps of some seconds")]
        let count = (last / dt).ceil() as usize + 2;
        let off = run.off_s() + secrets.release_delay_s;
        let (mut near, mut own) = (0, run.goal[0]);
        let mut late = own;
        let stays = if secrets.command_lag_s > 0.0 { (-dt / secrets.command_lag_s).exp() } else { 0.0 };
        let mut drive = Self { goal: Vec::with_capacity(count), on: Vec::with_capacity(count) };
        for k in 0..count {
            let t = k as f64 * dt;
            let wanted = run.goal_at(t - secrets.command_delay_s, &mut near);
            let most = if secrets.inverse_speed_s_rad > 0.0 { dt / secrets.inverse_speed_s_rad } else { f64::INFINITY };
            own = if k == 0 { wanted } else { own + (wanted - own).clamp(-most, most) };
            late = if k == 0 { own } else { own + (late - own) * stays };
            drive.goal.push(late);
            // The instant within whose step it is switched counts by its share.
            drive.on.push(((off - t) / dt + 0.5).clamp(0.0, 1.0));
        }
        drive
    }
}

struct Joint<'a> {
    motor: &'a Motor,
    secrets: &'a Secrets,
    kp: f64,
    duty_max: f64,
    motor_ohm: f64,
    /// Of the load, kg·m², N·m, rad.
    inertia: f64,
    weight: f64,
    side_angle: f64,
}

impl<'a> Joint<'a> {
    fn new(motor: &'a Motor, secrets: &'a Secrets, run: &Run) -> Self {
        let (side, along) = (secrets.com_m[0], run.length_m + secrets.load_offset_m - secrets.com_m[1]);
        let length = side.hypot(along);
        Self {
            motor,
            secrets,
            kp: run.kp * secrets.log_gain.exp(),
            duty_max: 1.0 - secrets.duty_less,
            motor_ohm: motor.back_emf * (SUPPLY_V / motor.stall).powi(2),
            inertia: (run.mass_kg + secrets.extra_kg) * length * length,
            weight: (run.mass_kg + secrets.extra_kg) * GRAVITY_M_S2 * length,
            side_angle: side.atan2(along),
        }
    }

    /// The torque of weight and spring at a measured position.
    fn outside(&self, q: f64) -> f64 {
        let q = q + self.motor.zero;
        -self.weight * (q + self.side_angle).sin() - self.secrets.spring_nm_rad * q
    }

    /// The torque of the motor.
    fn driven(&self, goal: f64, on: f64, q: f64, w: f64) -> f64 {
        if on == 0.0 {
            return 0.0;
        }
        let error = goal + self.secrets.goal_offset_rad - q;
        let band = self.secrets.dead_band_rad;
        let error = if error > band {
            error - band
        } else if error < -band {
            error + band
        } else {
            0.0
        };
        let asked = GAIN_1_RAD * self.kp * error - self.secrets.kd_s_rad * w;
        let duty = asked.clamp(-self.duty_max, self.duty_max);
        let sag = self.motor_ohm / (self.motor_ohm + self.secrets.sag_ohm * duty * duty);
        on * sag * (self.motor.stall * duty - self.motor.back_emf * w)
    }

    /// What brakes without being dry.
    fn braking(&self, on: f64, w: f64) -> f64 {
        let linear = self.motor.viscous + (1.0 - on) * self.secrets.release_braking_nms_rad;
        -linear * w - self.secrets.quadratic_nms2_rad2 * w * w.abs()
    }

    /// The most that dry friction takes against positive and against negative speed.
    fn dry(&self, carried: f64, w: f64) -> (f64, f64) {
        let s = self.secrets;
        let mut level = self.motor.coulomb + s.load_friction * carried.abs();
        if s.stribeck_nm > 0.0 {
            level += s.stribeck_nm * (-(w / s.stribeck_rad_s).powi(2)).exp();
        }
        ((level + s.directional_nm).max(0.0), (level - s.directional_nm).max(0.0))
    }

    /// The speed after an impulse over `h` seconds.
    fn after_impulse(inertia: f64, w: f64, free: f64, (forward, backward): (f64, f64), h: f64) -> f64 {
        let ahead = w + h * free / inertia;
        if ahead > h * forward / inertia {
            ahead - h * forward / inertia
        } else if ahead < -h * backward / inertia {
            ahead + h * backward / inertia
        } else {
            0.0
        }
    }

    fn rigid(&self, drive: &Drive, dt: f64) -> Vec<f64> {
        let inertia = self.inertia + self.motor.armature;
        let (mut q, mut w) = (0.0, 0.0);
        let mut path = Vec::with_capacity(drive.goal.len());
        path.push(q);
        let half = |q: f64, w: f64, k: usize| {
            let (motor, outside) = (self.driven(drive.goal[k], drive.on[k], q, w), self.outside(q));
            let free = motor + outside + self.braking(drive.on[k], w);
            Self::after_impulse(inertia, w, free, self.dry(outside - motor, w), 0.5 * dt)
        };
        for k in 0..drive.goal.len() - 1 {
            w = half(q, w, k);
            q += dt * w;
            w = half(q, w, k + 1);
            path.push(q);
        }
        path
    }

    /// Motor and link with a gear between them that has a gap or gives way; the encoder is on the link, dry and other friction on the
    /// motor.
    fn through_gear(&self, drive: &Drive, dt: f64) -> Vec<f64> {
        let stiffness =
            if self.secrets.compliance_rad_nm > 0.0 { self.secrets.compliance_rad_nm.recip() } else { STIFF_NM_RAD };
        let room = 0.5 * self.secrets.gap_rad;
        let pressed = |twist: f64| {
            let over = if twist > room {
                twist - room
            } else if twist < -room {
                twist + room
            } else {
                0.0
            };
            stiffness * over
        };
        let (mut q, mut w, mut turning) = (0.0, 0.0, 0.0);
        // The motor stands where it carries the weight.
        let weight = self.outside(q);
        let mut shaft = if weight == 0.0 { q } else { q - weight.signum() * room - weight / stiffness };
        let mut path = Vec::with_capacity(drive.goal.len());
        path.push(q);
        let half = |(q, w): (f64, f64), (shaft, turning): (f64, f64), k: usize| {
            let (motor, outside) = (self.driven(drive.goal[k], drive.on[k], q, turning), self.outside(q));
            let gear = pressed(shaft - q);
            let free = motor - gear + self.braking(drive.on[k], turning);
            let dry = self.dry(outside - motor, turning);
            let after = Self::after_impulse(self.motor.armature, turning, free, dry, 0.5 * dt);
            (w + 0.5 * dt * (gear + outside) / self.inertia, after)
        };
        for k in 0..drive.goal.len() - 1 {
            (w, turning) = half((q, w), (shaft, turning), k);
            q += dt * w;
            shaft += dt * turning;
            (w, turning) = half((q, w), (shaft, turning), k + 1);
            path.push(q);
        }
        path
    }
}

/// Root mean square of a difference.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    root_mean_square(a.iter().zip(b).map(|(a, b)| a - b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(goal: impl Fn(f64) -> f64, off_from: Option<usize>) -> Run {
        let clock: Vec<f64> = (0..400).map(|i| f64::from(i) / 100.0).collect();
        let goal = clock.iter().map(|t| goal(*t)).collect();
        Run { kp: 16.0, mass_kg: 0.6, length_m: 0.15, clock, goal, off_from, latch_phase: 0.3 }
    }

    const FREE: Motor = Motor { stall: 6.0, back_emf: 0.0, viscous: 0.0, coulomb: 0.0, armature: 0.02, zero: 0.3 };

    /// Off from the start, a small swing has the period of the closed form, with its first correction by the amplitude.
    #[test]
    fn a_free_pendulum_has_its_period() {
        let swing = positions(&FREE, &Secrets::NONE, &run(|_| 0.0, Some(0)), 1e-4);
        let slow = (0.6 * 9.81 * 0.15 / (0.02 + 0.6 * 0.15 * 0.15_f64)).sqrt();
        let period = std::f64::consts::TAU / slow * (1.0 + 0.3_f64.powi(2) / 16.0);
        // Minima of q + 0.3 lie half a period after the start.
        let lowest = (0..150).min_by(|a, b| swing[*a].total_cmp(&swing[*b])).unwrap();
        assert!((lowest as f64 / 100.0 - 0.5 * period).abs() < 0.011, "{lowest} {period}");
        assert!((swing[lowest] + 0.6).abs() < 2e-3, "{}", swing[lowest]);
    }

    #[test]
    fn dry_friction_holds_what_it_can() {
        let motor = Motor { coulomb: 0.5, ..FREE };
        let held = positions(&motor, &Secrets::NONE, &run(|_| 0.0, Some(0)), 1e-4);
        assert!(held.iter().all(|q| *q == 0.0));
    }

    #[test]
    fn steps_are_short_enough() {
        let swing = run(|t| 0.8 * (t * t).sin(), None);
        for secrets in [
            Secrets::NONE,
            Secrets { load_friction: 0.2, inverse_speed_s_rad: 0.25, ..Secrets::NONE },
            Secrets { stribeck_nm: 0.1, kd_s_rad: 0.05, ..Secrets::NONE },
        ] {
            let rolled = |dt: f64| positions(&Motor::CENTRE, &secrets, &swing, dt);
            let apart = rolled(1e-4).iter().zip(&rolled(1e-5)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 3e-4, "{apart}");
        }
    }

    #[test]
    fn a_latch_holds_the_reading_and_a_delay_shifts_it() {
        let swing = run(|t| 0.8 * (t * t).sin(), None);
        let plain = positions(&Motor::CENTRE, &Secrets::NONE, &swing, 1e-4);
        let late = positions(&Motor::CENTRE, &Secrets { reading_delay_s: 0.02, ..Secrets::NONE }, &swing, 1e-4);
        assert!(plain.iter().zip(&late[2..]).all(|(a, b)| (a - b).abs() < 1e-4));
        let latched = positions(&Motor::CENTRE, &Secrets { latch_s: 0.04, ..Secrets::NONE }, &swing, 1e-4);
        let still = latched.windows(2).skip(50).filter(|w| w[0] == w[1]).count();
        assert!(still > 200, "{still}");
    }

    /// A gear that hardly gives way is none.
    #[test]
    fn a_stiff_gear_is_a_rigid_one() {
        let swing = run(|t| 0.8 * (t * t).sin(), None);
        let plain = positions(&Motor::CENTRE, &Secrets::NONE, &swing, 1e-4);
        let stiff = positions(&Motor::CENTRE, &Secrets { gap_rad: 1e-6, ..Secrets::NONE }, &swing, 1e-5);
        let apart = plain.iter().zip(&stiff).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 3e-3, "{apart}");
    }
}
