//! What an impact does to velocity and spin: Rapier's solver, asked about one contact alone.
//!
//! Rapier's fixed steps start a rebound from wherever inside the floor a step happened to end. Here the ball is already
//! at its time of impact, so that the solver's restitution comes out exact to rounding.

use rapier3d::math::{Pose, Vector};
use rapier3d::parry::shape::{HalfSpace, SharedShape};
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, ColliderHandle, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
};

use super::range::{GREATEST, within};

/// What a contact has besides restitution and friction. Zero means absent.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Contact {
    /// How restitution falls with the approach speed v: e (v / 3 m/s)^(−exponent), kept within 0 and 1.
    pub restitution_exponent: f64,
    /// The share of the slip that an impact takes, beyond friction; 0 to 2.
    pub tangential_loss: f64,
    /// How long a bounce lasts, s; 0 or more. The ball moves as if on a spring with a damper meanwhile.
    pub duration_s: f64,
    /// How much a rolling ball slows down, as a share of the acceleration that presses it onto the surface; 0 or more.
    pub rolling_resistance: f64,
    /// By how much the normal is turned at each impact, in order: about x, then y, rad. Level where there are no more.
    pub tilts_rad: Vec<[f64; 2]>,
}

impl Contact {
    /// # Errors
    /// A sentence that names the first number that is not finite or outside its range.
    pub fn check(&self) -> Result<(), String> {
        within("restitution_exponent", self.restitution_exponent, -10.0, 10.0)?;
        within("tangential_loss", self.tangential_loss, 0.0, 2.0)?;
        within("duration_s", self.duration_s, 0.0, 10.0)?;
        within("rolling_resistance", self.rolling_resistance, 0.0, GREATEST)?;
        self.tilts_rad.iter().flatten().try_for_each(|angle| within("tilts_rad", *angle, -1.0, 1.0))
    }
}

/// The approach speed at which an exponent leaves the restitution as it is, m/s.
const REFERENCE_M_S: f64 = 3.0;
/// Below this approach speed the restitution stays what it is here, m/s. A power law has no end at small speeds: the ball
/// would bounce for ever. Hops from here are 0.5 mm high.
const SLOWEST_LAW_M_S: f64 = 0.1;
/// How much an impulse of 1 per mass at the skin of a solid sphere changes its slip: 1 + r²/(2/5·r²).
const SLIP_PER_IMPULSE: f64 = 3.5;

/// The law of contact: which coefficients an impact has. Effects that change an impact belong here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// Coefficient of restitution at 3 m/s, 0 to 1.
    pub restitution: f64,
    /// Coulomb's coefficient of friction, 0 or more.
    pub friction: f64,
    /// See [`Contact::restitution_exponent`].
    pub restitution_exponent: f64,
    /// See [`Contact::tangential_loss`].
    pub tangential_loss: f64,
    /// See [`Contact::duration_s`].
    pub duration_s: f64,
    /// See [`Contact::rolling_resistance`].
    pub rolling_resistance: f64,
}

impl Law {
    /// The law of a contact.
    #[must_use]
    pub fn new(restitution: f64, friction: f64, contact: &Contact) -> Self {
        Self {
            restitution,
            friction,
            restitution_exponent: contact.restitution_exponent,
            tangential_loss: contact.tangential_loss,
            duration_s: contact.duration_s,
            rolling_resistance: contact.rolling_resistance,
        }
    }

    /// Restitution and friction at a normal approach speed (m/s, 0 or more).
    #[must_use]
    pub fn at(&self, approach_m_s: f64) -> (f64, f64) {
        if self.restitution_exponent == 0.0 {
            return (self.restitution, self.friction);
        }
        let speed = approach_m_s.max(SLOWEST_LAW_M_S) / REFERENCE_M_S;
        ((self.restitution * speed.powf(-self.restitution_exponent)).clamp(0.0, 1.0), self.friction)
    }

    /// Velocity and spin after the loss of slip that follows an impact on a surface with this unit `normal`.
    pub(crate) fn lose_slip(&self, normal: Vector, radius: f64, (v, w): (Vector, Vector)) -> (Vector, Vector) {
        if self.tangential_loss == 0.0 {
            return (v, w);
        }
        let skin = v - w.cross(normal * radius);
        let slip = skin - normal * normal.dot(skin);
        let impulse = slip * (-self.tangential_loss / SLIP_PER_IMPULSE);
        (v + impulse, w - normal.cross(impulse) * (2.5 / radius))
    }
}

/// `normal` turned about x, then y; the same convention as a tilt of the surface, which a level one's becomes.
pub(crate) fn turned(normal: Vector, [about_x, about_y]: [f64; 2]) -> Vector {
    let ((sin_a, cos_a), (sin_b, cos_b)) = (about_x.sin_cos(), about_y.sin_cos());
    let (x, z) = (cos_b * normal.x + sin_b * normal.z, cos_b * normal.z - sin_b * normal.x);
    Vector::new(x, cos_a * normal.y - sin_a * z, sin_a * normal.y + cos_a * z)
}

/// The step in which the solver resolves an impact, s. Long enough for arithmetic, and so short that a spinning contact
/// point does not lift off within it (a step of 1e-5 s costs 0.4 % of the friction of a roll) and that the solver's cap
/// on spin, π/4 per step, lies at 8e8 rad/s.
const STEP_S: f64 = 1e-9;
/// How deep the ball is put into the surface, in radii. At a positive gap so short a step would find no contact; at 1e-12
/// the solver's push out of the surface shows in the spin. The coordinates here are about 1, so 1e-14 is never rounded off.
const DEPTH: f64 = 1e-14;
/// Where the ball waits while its last contact is forgotten, in radii.
const AWAY: f64 = 1e3;

/// A Rapier world with one unit sphere on one level half-space at the origin.
///
/// An impact of a sphere depends on nothing but the contact's normal, the velocity and the speed `r·ω` of its skin. So
/// every impact, of any ball size, place and obstacle, is turned into this one: far-off coordinates and
/// tiny balls cost no digits.
pub(crate) struct Server {
    world: PhysicsWorld,
    ball: RigidBodyHandle,
    skin: ColliderHandle,
}

impl Server {
    pub fn new() -> Self {
        let mut world = PhysicsWorld { gravity: Vector::ZERO, ..PhysicsWorld::default() };
        let parameters = &mut world.integration_parameters;
        // One contact converges at once; more iterations only cost time.
        parameters.num_solver_iterations = 1;
        // Continuous collision detection and recycled contacts would bring back the state of an earlier impact.
        parameters.max_ccd_substeps = 0;
        parameters.contact_recycling = false;
        parameters.warmstart_coefficient = 0.0;
        parameters.normalized_prediction_distance = 1e-3;
        parameters.normalized_max_linear_velocity = f64::MAX;
        world.physics_pipeline.counters.disable();

        let floor = ColliderBuilder::new(SharedShape::new(HalfSpace::new(Vector::Z)))
            .friction(1.0)
            .restitution(1.0)
            .friction_combine_rule(CoefficientCombineRule::Multiply)
            .restitution_combine_rule(CoefficientCombineRule::Multiply);
        world.colliders.insert(floor);
        let body = RigidBodyBuilder::dynamic().can_sleep(false).translation(Vector::Z * AWAY);
        let ball = world.bodies.insert(body);
        // A solid sphere of mass 1: the collider brings the inertia 2/5.
        let skin = world.colliders.insert_with_parent(ColliderBuilder::ball(1.0).mass(1.0), ball, &mut world.bodies);
        Self { world, ball, skin }
    }

    /// Velocity and spin after an impact on a surface with this unit `normal`, of a ball with this radius (m).
    pub fn resolve(
        &mut self,
        normal: Vector,
        radius: f64,
        (v, w): (Vector, Vector),
        (restitution, friction): (f64, f64),
    ) -> (Vector, Vector) {
        let (side, front) = normal.any_orthonormal_pair();
        let into = |u: Vector| Vector::new(side.dot(u), front.dot(u), normal.dot(u));
        let back = |u: Vector| side * u.x + front * u.y + normal * u.z;

        // The solver bounces a contact only if it bore no load before; a step without time, far away, makes it new.
        self.place(AWAY);
        self.world.integration_parameters.dt = 0.0;
        self.world.step();

        self.place(1.0 - DEPTH);
        let Some(ball) = self.world.bodies.get_mut(self.ball) else { return (v, w) };
        ball.set_linvel(into(v), true);
        ball.set_angvel(into(w) * radius, true);
        if let Some(skin) = self.world.colliders.get_mut(self.skin) {
            skin.set_restitution(restitution);
            // The solver bounds friction by the impulse of the compression alone, m·v, and adds the rebound afterwards;
            // Coulomb's bound is the whole normal impulse, (1 + e)·m·v.
            skin.set_friction(friction * (1.0 + restitution));
        }
        self.world.integration_parameters.dt = STEP_S;
        self.world.step();

        // Only the velocities are of interest: the pose has moved by STEP_S and is thrown away.
        let ball = &self.world.bodies[self.ball];
        (back(ball.linvel()), back(ball.angvel()) / radius)
    }

    /// Puts the ball at a height, upright: a rotation left over from the last impact would change the next one's bits.
    fn place(&mut self, height: f64) {
        if let Some(ball) = self.world.bodies.get_mut(self.ball) {
            ball.set_position(Pose::from_translation(Vector::Z * height), true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn restitution_is_exact_at_any_speed_and_in_any_order() {
        let mut server = Server::new();
        for speed in [1e-4, 50.0, 1e-2, 1.0, 1e3] {
            for e in [0.0, 0.01, 0.5, 0.99, 1.0] {
                let (v, w) = server.resolve(Vector::Z, 0.02, (Vector::Z * -speed, Vector::ZERO), (e, 0.3));
                assert!((v.z / speed - e).abs() < 1e-15 && v.x == 0.0 && w == Vector::ZERO, "{speed} {e}: {v} {w}");
            }
        }
    }

    #[test]
    fn without_rebound_a_rolling_push_keeps_five_sevenths() {
        let normal = Vector::new(0.6, 0.0, 0.8);
        let down = Vector::new(0.8, 0.0, -0.6);
        let push = down * 0.03 - normal * 0.04;
        let (v, w) = Server::new().resolve(normal, 0.1, (push, Vector::ZERO), (0.0, 0.5));
        assert!((v - down * (0.03 * 5.0 / 7.0)).length() < 1e-14, "{v}");
        assert!((v - w.cross(normal * 0.1)).length() < 1e-14, "no slip is left: {w}");
    }
}
