//! How a ball moves while nothing new touches it: forces, and the curves that they bend.

use std::sync::Arc;

use rapier3d::math::Vector;

use super::range::{GREATEST, within};
use super::step_size;
use crate::formula_effect::flight::AppliedForce;

/// What acts on a ball in flight besides gravity, each as an acceleration. Zero means absent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Forces {
    /// Quadratic drag `−c·|v|·v`, 1/m; 0 or more.
    pub quadratic_drag_1_m: f64,
    /// Linear drag `−b·v`, 1/s; 0 or more.
    pub linear_drag_1_s: f64,
    /// A steady push along x and y, m/s².
    pub wind_m_s2: [f64; 2],
    /// Magnus' force `S × v`, 1/s, with `S` in the world's frame and constant.
    pub magnus_1_s: [f64; 3],
    /// What is added to the downward acceleration of gravity, m/s²; buoyancy makes it negative.
    pub effective_gravity_m_s2: f64,
}

impl Forces {
    /// # Errors
    /// A sentence that names the first number that is not finite, too large or of the wrong sign.
    pub fn check(&self) -> Result<(), String> {
        within("quadratic_drag_1_m", self.quadratic_drag_1_m, 0.0, GREATEST)?;
        within("linear_drag_1_s", self.linear_drag_1_s, 0.0, GREATEST)?;
        within("effective_gravity_m_s2", self.effective_gravity_m_s2, -GREATEST, GREATEST)?;
        self.wind_m_s2.into_iter().try_for_each(|a| within("wind_m_s2", a, -GREATEST, GREATEST))?;
        self.magnus_1_s.into_iter().try_for_each(|s| within("magnus_1_s", s, -GREATEST, GREATEST))
    }
}

/// Position (m), velocity (m/s) and spin (rad/s) of a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Motion {
    pub x: Vector,
    pub v: Vector,
    pub w: Vector,
}

/// The acceleration. Every force of [`Forces`] depends on the velocity alone; formulas may depend on place and time as well.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    constant: Vector,
    quadratic: f64,
    linear: f64,
    magnus: Vector,
    /// Whether the acceleration depends on anything.
    pub varies: bool,
    formulas: Option<Arc<[AppliedForce]>>,
}

impl Field {
    pub fn new(gravity_m_s2: f64, forces: &Forces, formulas: &[AppliedForce]) -> Self {
        let magnus = Vector::from_array(forces.magnus_1_s);
        let down = gravity_m_s2 + forces.effective_gravity_m_s2;
        Self {
            constant: Vector::new(forces.wind_m_s2[0], forces.wind_m_s2[1], -down),
            quadratic: forces.quadratic_drag_1_m,
            linear: forces.linear_drag_1_s,
            magnus,
            varies: forces.quadratic_drag_1_m != 0.0
                || forces.linear_drag_1_s != 0.0
                || magnus != Vector::ZERO
                || !formulas.is_empty(),
            formulas: (!formulas.is_empty()).then(|| Arc::from(formulas)),
        }
    }

    /// At an instant (s), a place and a velocity.
    pub fn acceleration(&self, t: f64, x: Vector, v: Vector) -> Vector {
        let own = self.of_velocity(v);
        self.formulas.as_deref().map_or(own, |all| all.iter().fold(own, |sum, one| sum + one.acceleration(t, x, v)))
    }

    /// Which formula has no finite value on a straight way of so many seconds, in words without an end.
    pub fn undefined(&self, (t, x, v): (f64, Vector, Vector), seconds: f64) -> Option<String> {
        let at = |i: u32| {
            let later = seconds * f64::from(i) / f64::from(LOOKED_AT);
            (t + later, x + v * later, v)
        };
        let all = self.formulas.as_deref().into_iter().flatten();
        (0..=LOOKED_AT).find_map(|i| all.clone().find_map(|one| one.undefined(at(i))))
    }

    /// Which formula has a pole between two instants, in words without an end.
    pub fn pole(&self, from: (f64, &Motion), to: (f64, &Motion)) -> Option<String> {
        let at = |(t, motion): (f64, &Motion)| (t, motion.x, motion.v);
        self.formulas.as_deref()?.iter().find_map(|one| one.pole(at(from), at(to)))
    }

    /// The name of the formula that accelerates the ball most.
    pub fn strongest(&self, t: f64, motion: &Motion) -> String {
        let size = |one: &&AppliedForce| one.acceleration(t, motion.x, motion.v).length();
        let all = self.formulas.as_deref().into_iter().flatten();
        all.max_by(|a, b| size(a).total_cmp(&size(b))).map_or_else(String::new, |one| one.name().to_owned())
    }

    /// Which formula accelerates the ball beyond all that is followed, in words.
    pub fn violent(&self, t: f64, motion: &Motion) -> Option<String> {
        let all = self.formulas.as_deref()?;
        let (size, one) = all
            .iter()
            .map(|one| (one.acceleration(t, motion.x, motion.v).length(), one))
            .find(|(size, _)| *size > VIOLENT)?;
        Some(format!("`candidates.{}.formula` accelerates the ball by {size:.0e} m/s² at {t:.6} s", one.name()))
    }

    /// How fine the steps are that formulas need.
    fn fineness(&self) -> step_size::Fineness {
        let searched = self.formulas.as_deref().is_some_and(|all| all.iter().any(AppliedForce::is_searched));
        if searched { step_size::Fineness::SEARCHED } else { step_size::Fineness::SIMULATED }
    }

    /// Without formulas.
    fn of_velocity(&self, v: Vector) -> Vector {
        if !self.varies {
            return self.constant;
        }
        self.constant - v * (self.quadratic * v.length() + self.linear) + self.magnus.cross(v)
    }

    /// Whether it follows formulas, which may carry a ball away.
    pub fn has_formulas(&self) -> bool {
        self.formulas.is_some()
    }

    /// Whether it changes while nothing moves.
    pub fn depends_on_time(&self) -> bool {
        self.formulas.as_deref().is_some_and(|all| all.iter().any(AppliedForce::depends_on_time))
    }

    /// A bound on how fast the acceleration follows the velocity, 1/s: the norm of da/dv at that speed.
    fn rate(&self, speed: f64) -> f64 {
        2.0 * self.quadratic * speed + self.linear + self.magnus.length()
    }
}

/// The longest sub-step of the Runge–Kutta arcs, s.
const LONGEST_STEP_S: f64 = 1.0 / 60.0;
/// A sub-step times [`Field::rate`] stays below this; the local error is about its fifth power over 120.
const REACH: f64 = 0.02;
/// A step is not cut at an apex nearer than this share of it.
const SHORTEST: f64 = 1e-3;
/// No ball is followed through an acceleration beyond this, m/s².
const VIOLENT: f64 = 1e12;
/// At how many places of a way formulas are looked at where one has no finite value.
const LOOKED_AT: u32 = 16;
/// A sphere that rolls without slip keeps this share of a tangential acceleration: 1 / (1 + 2/5).
pub(crate) const ROLLING_SHARE: f64 = 5.0 / 7.0;

/// The shortest step of a ball that rolls to a stop on a bent way, s, and how far its direction may turn within one, rad.
const SHORTEST_ROLL_S: f64 = 1e-4;
const TURN: f64 = 0.05;

/// What bends a path.
#[derive(Debug, Clone)]
enum Bend {
    /// Constant linear and angular acceleration: the parabola, exact.
    Even { a: Vector, spin_up: Vector },
    /// A field that follows the velocity: Runge–Kutta of fourth order.
    Flight { field: Field },
    /// The same, but rolling without slip on a plane, slowed by this resistance (m/s²).
    Rolling { field: Field, normal: Vector, radius: f64, resistance: f64 },
    /// In contact: pressed onto a surface until the motion is `end`.
    Pressed { end: Motion, normal: Vector },
}

/// One smooth piece of motion, from its start on.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    pub start: Motion,
    /// When it starts, s: formulas may depend on it.
    start_s: f64,
    /// How long this piece holds, s; may be infinite.
    pub horizon: f64,
    /// How far the acceleration may drift from its present value within the horizon, m/s².
    pub slack: f64,
    bend: Bend,
}

impl Path {
    /// Free flight from an instant (s) on.
    pub fn flight(start: Motion, start_s: f64, field: &Field) -> Self {
        if field.varies {
            return Self::bent(start, start_s, field, Bend::Flight { field: field.clone() });
        }
        Self::even(start, field.constant, Vector::ZERO, f64::INFINITY)
    }

    /// Rolling without slip on the plane with this normal, slowed by a resistance (m/s², 0 or more).
    pub fn rolling(start: Motion, start_s: f64, field: &Field, normal: Vector, radius: f64, resistance: f64) -> Self {
        let a = rolling(field, normal, resistance, start_s, start.x, start.v);
        let bend = || Bend::Rolling { field: field.clone(), normal, radius, resistance };
        if resistance == 0.0 {
            if field.varies {
                return Self::bent(start, start_s, field, bend());
            }
            return Self::even(start, a, normal.cross(a) / radius, f64::INFINITY);
        }
        let (speed, size) = (start.v.length(), a.length());
        let towards = start.v.dot(a);
        // On a straight way the ball slows evenly, and what held it back turns round only after it has stopped.
        let stop = if towards < 0.0 { speed * speed / -towards } else { f64::INFINITY };
        if !field.varies && start.v.cross(a).length() <= 1e-12 * speed * size {
            return Self::even(start, a, normal.cross(a) / radius, stop);
        }
        let mut path = Self::bent(start, start_s, field, bend());
        // The direction of the resistance must not turn far within a step.
        path.horizon = path.horizon.min((TURN * speed / size).max(SHORTEST_ROLL_S)).min(stop);
        path.slack += 2.0 * resistance;
        path
    }

    /// In contact for `duration` seconds: from `start`, with a velocity into the surface, to `end`'s velocity and spin.
    ///
    /// Normal to the surface the ball is on a spring with a damper, at whose restitution e the depth is
    /// (v T/π) e^(t/T) sin(π t/T): it starts with −v and ends on the surface with e v. Along it, velocity and spin change
    /// evenly. Both join the flights before and after without a jump of speed.
    pub fn pressed(start: Motion, mut end: Motion, normal: Vector, duration: f64) -> Self {
        end.x = start.x + along(start.v + end.v, normal) * (0.5 * duration);
        Self { start, start_s: 0.0, horizon: duration, slack: 0.0, bend: Bend::Pressed { end, normal } }
    }

    /// Constant accelerations for a while.
    pub fn even(start: Motion, a: Vector, spin_up: Vector, horizon: f64) -> Self {
        Self { start, start_s: 0.0, horizon, slack: 0.0, bend: Bend::Even { a, spin_up } }
    }

    fn bent(start: Motion, start_s: f64, field: &Field, bend: Bend) -> Self {
        if field.formulas.is_some() {
            let path = Self { start, start_s, horizon: LONGEST_STEP_S, slack: 0.0, bend };
            let (horizon, slack) =
                step_size::by_doubling((LONGEST_STEP_S, field.fineness()), (start.x, start.v), |t, x, v| {
                    path.bent_acceleration(start_s + t, x, v)
                });
            return Self { horizon, slack, ..path };
        }
        let acceleration = field.of_velocity(start.v);
        let a = acceleration.length();
        let rate = field.rate(start.v.length() + a * LONGEST_STEP_S);
        let mut horizon = LONGEST_STEP_S.min(REACH / rate);
        // |v|·v has a kink in its second derivative where v turns, which would cost a step across it two orders. So a
        // step ends at the apex; what the estimate misses is too short to matter.
        let apex = -start.v.dot(acceleration) / (a * a);
        if field.quadratic > 0.0 && apex > horizon * SHORTEST && apex < horizon {
            horizon = apex;
        }
        Self { start, start_s, horizon, slack: 1.2 * rate * horizon * a, bend }
    }

    /// The motion `t` seconds after the start. Depends on nothing but the path and `t`, so that the instants at which
    /// a path is read never change it.
    pub fn at(&self, t: f64) -> Motion {
        let Motion { x, v, w } = self.start;
        match &self.bend {
            Bend::Even { a, spin_up } => Motion { x: x + (v + *a * (0.5 * t)) * t, v: v + *a * t, w: w + *spin_up * t },
            Bend::Flight { field } => {
                let (x, v) = if field.formulas.is_some() {
                    step_size::runge_kutta((x, v), t, |t, x, v| self.bent_acceleration(self.start_s + t, x, v))
                } else {
                    runge_kutta(x, v, t, |v| field.of_velocity(v))
                };
                Motion { x, v, w }
            }
            Bend::Rolling { field, normal, radius, resistance } => {
                let (x, v) = if field.formulas.is_some() {
                    step_size::runge_kutta((x, v), t, |t, x, v| self.bent_acceleration(self.start_s + t, x, v))
                } else {
                    runge_kutta(x, v, t, |v| rolling(field, *normal, *resistance, 0.0, Vector::ZERO, v))
                };
                Motion { x, v, w: normal.cross(v) / *radius + *normal * normal.dot(w) }
            }
            Bend::Pressed { end, .. } if t >= self.horizon => *end,
            Bend::Pressed { end, normal } => {
                let share = t / self.horizon;
                let approach = -normal.dot(v);
                let restitution = (normal.dot(end.v) / approach).max(f64::MIN_POSITIVE);
                let (sin, cos) = (std::f64::consts::PI * share).sin_cos();
                let swing = approach * restitution.powf(share);
                let depth = swing * self.horizon * std::f64::consts::FRAC_1_PI * sin;
                let speed = swing * (cos + restitution.ln() * std::f64::consts::FRAC_1_PI * sin);
                let (before, after) = (along(v, *normal), along(end.v, *normal));
                Motion {
                    x: x + (before + (after - before) * (0.5 * share)) * t - *normal * depth,
                    v: before + (after - before) * share - *normal * speed,
                    w: w + (end.w - w) * share,
                }
            }
        }
    }

    /// The acceleration of the motion `t` seconds after the start.
    pub fn acceleration(&self, t: f64, motion: &Motion) -> Vector {
        self.bent_acceleration(self.start_s + t, motion.x, motion.v)
    }

    fn bent_acceleration(&self, t: f64, x: Vector, v: Vector) -> Vector {
        match &self.bend {
            Bend::Even { a, .. } => *a,
            Bend::Flight { field } => field.acceleration(t, x, v),
            Bend::Rolling { field, normal, resistance, .. } => rolling(field, *normal, *resistance, t, x, v),
            // Nothing else is looked for during a contact.
            Bend::Pressed { .. } => Vector::ZERO,
        }
    }
}

/// The part of `a` that lies in the plane with this normal.
pub(crate) fn along(a: Vector, normal: Vector) -> Vector {
    a - normal * normal.dot(a)
}

/// The acceleration of a ball that rolls at velocity `v`; from rest the resistance points against the drive.
fn rolling(field: &Field, normal: Vector, resistance: f64, t: f64, x: Vector, v: Vector) -> Vector {
    let drive = along(field.acceleration(t, x, v), normal) * ROLLING_SHARE;
    if resistance == 0.0 {
        return drive;
    }
    drive - if v == Vector::ZERO { drive } else { v }.normalize_or_zero() * resistance
}

/// The classical step of fourth order for x' = v, v' = a(v). As a depends on v alone, the position needs no stages of
/// its own: its four slopes are the velocities of the stages, and their weighted sum collapses to three accelerations.
fn runge_kutta(x: Vector, v: Vector, h: f64, a: impl Fn(Vector) -> Vector) -> (Vector, Vector) {
    let k1 = a(v);
    let k2 = a(v + k1 * (0.5 * h));
    let k3 = a(v + k2 * (0.5 * h));
    let k4 = a(v + k3 * h);
    (x + (v + (k1 + k2 + k3) * (h / 6.0)) * h, v + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0))
}
