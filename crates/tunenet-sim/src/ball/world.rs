//! One rollout of a ball: pieces of smooth motion, joined by impacts.

use rapier3d::math::Vector;
use rapier3d::parry::shape::Ball;

use super::contact::{Law, Server, turned};
use super::flight::{Field, Motion, Path};
use super::impact::{Gap, Obstacle, first_touch};
use super::range::within;
use super::scene::Scene;
use super::support::{Ground, SLOWEST_REBOUND_M_S, Supports};
use super::{Impact, State};
use crate::formula_effect::contact::AppliedContact;

/// Questions to the contact solver in one rollout; a second or so of work. A ball that falls 10 m with a restitution of
/// 0.999 asks about 20 in a minute.
pub const MOST_CONTACTS: u64 = 200_000;
/// Pieces of motion in one rollout: 4 hours of flight with drag, at 60 steps a second.
pub const MOST_PIECES: u64 = 1_000_000;
/// A ball that a formula drives to more than this, m/s, or whose acceleration drifts by more than that within a step, m/s², is followed no
/// farther.
const FASTEST_M_S: f64 = 1e5;
const GREATEST_DRIFT_M_S2: f64 = 1e9;
/// How far a ball may start inside an obstacle, m; it is lifted out at its first contact.
pub const DEEPEST_START_M: f64 = 1e-6;

/// A ball on its way.
pub struct World {
    server: Server,
    obstacles: Vec<Obstacle>,
    ball: Ball,
    field: Field,
    law: Law,
    /// What formulas add to the restitution.
    returns: Vec<AppliedContact>,
    /// How each impact's normal is turned about x and y, rad.
    tilts_rad: Vec<[f64; 2]>,
    /// The present piece of motion and when it started.
    path: Path,
    started_s: f64,
    /// When the present piece ends, seconds after its start, and with which impact.
    until: f64,
    hit: Option<Gap>,
    supported: bool,
    impacts: Vec<Impact>,
    contacts: u64,
    pieces: u64,
    now_s: f64,
}

impl World {
    /// A ball above the scene's surface, released at `start_time_s`.
    ///
    /// # Errors
    /// A sentence where a number of the scene or the start is not finite or out of range, or where the ball starts more
    /// than [`DEEPEST_START_M`] inside the surface.
    pub fn new(scene: &Scene, start: &State, start_time_s: f64) -> Result<Self, String> {
        scene.check()?;
        let point = Vector::new(0.0, 0.0, scene.surface_height_m);
        Self::among(scene, vec![Obstacle::half_space(point, scene.normal_vector())], start, start_time_s)
    }

    /// A ball among obstacles, which take the place of the scene's surface. Where two are hit at the same instant they
    /// act one after the other, in their order.
    ///
    /// # Errors
    /// As [`World::new`].
    pub fn among(scene: &Scene, obstacles: Vec<Obstacle>, start: &State, start_time_s: f64) -> Result<Self, String> {
        scene.check()?;
        start.check()?;
        within("start_time_s", start_time_s, f64::MIN, f64::MAX)?;
        let ball = Ball::new(scene.radius_m);
        let motion = Motion {
            x: Vector::from_array(start.position_m),
            v: Vector::from_array(start.velocity_m_s),
            w: Vector::from_array(start.spin_rad_s),
        };
        for obstacle in &obstacles {
            let depth = -obstacle.gap(motion.x, ball).distance;
            if depth > DEEPEST_START_M {
                return Err(format!("the ball starts {depth} m inside the surface"));
            }
        }
        let field = scene.field();
        if let Some(refused) = field.violent(start_time_s, &motion) {
            return Err(refused);
        }
        let mut world = Self {
            server: Server::new(),
            obstacles,
            ball,
            path: Path::flight(motion, start_time_s, &field),
            field,
            law: scene.law(),
            returns: scene.formulas.contact.clone(),
            tilts_rad: scene.contact.tilts_rad.clone(),
            started_s: start_time_s,
            until: f64::INFINITY,
            hit: None,
            supported: false,
            impacts: Vec::with_capacity(64),
            contacts: 0,
            pieces: 0,
            now_s: start_time_s,
        };
        world.look_ahead(&Supports::default());
        Ok(world)
    }

    /// Follows the ball up to an instant. How the way there is divided changes no bit of the result.
    ///
    /// # Errors
    /// A sentence where the instant is not finite or lies before the present one, where a formula carries the ball away, or where the ball
    /// needs more than [`MOST_CONTACTS`] contacts or [`MOST_PIECES`] pieces of motion to get there.
    pub fn advance_to(&mut self, time_s: f64) -> Result<(), String> {
        within("time_s", time_s, f64::MIN, f64::MAX)?;
        if time_s < self.now_s {
            return Err(format!("the clock goes from {} s to {time_s} s, but has to rise", self.now_s));
        }
        while self.started_s + self.until <= time_s {
            self.next_piece()?;
        }
        self.now_s = time_s;
        Ok(())
    }

    /// Where the ball is now.
    #[must_use]
    pub fn state(&self) -> State {
        let Motion { x, v, w } = self.path.at(self.now_s - self.started_s);
        State { position_m: x.to_array(), velocity_m_s: v.to_array(), spin_rad_s: w.to_array() }
    }

    /// The present instant, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.now_s
    }

    /// Whether an obstacle holds the ball up: it lies, rolls or slides.
    #[must_use]
    pub fn is_supported(&self) -> bool {
        self.supported
    }

    /// The impacts so far, in order, but for touches too slow to rebound from.
    #[must_use]
    pub fn impacts(&self) -> &[Impact] {
        &self.impacts
    }

    /// Follows the ball until `count` impacts are on record, it comes to rest on a surface or flies off for good.
    ///
    /// # Errors
    /// As [`World::advance_to`], where the ball needs too much work to get there.
    pub fn advance_to_impact(&mut self, count: usize) -> Result<(), String> {
        // On the only obstacle there is nothing left to strike.
        while self.impacts.len() < count && self.until < f64::INFINITY && !(self.supported && self.obstacles.len() == 1)
        {
            self.next_piece()?;
            self.now_s = self.now_s.max(self.started_s);
        }
        Ok(())
    }

    /// Ends the present piece of motion and starts the next.
    fn next_piece(&mut self) -> Result<(), String> {
        self.pieces += 1;
        if self.contacts > MOST_CONTACTS || self.pieces > MOST_PIECES {
            return Err(format!(
                "the ball touches the surface too often to be followed: {} contacts and {} pieces of motion by {} s",
                self.contacts, self.pieces, self.started_s
            ));
        }
        let mut motion = self.path.at(self.until);
        if self.field.has_formulas() {
            self.defined(&motion)?;
        }
        self.started_s += self.until;
        // Speed that grows with speed has no end; near it a step says nothing any more of how far the acceleration drifts.
        if self.field.has_formulas() && (motion.v.length() > FASTEST_M_S || self.path.slack > GREATEST_DRIFT_M_S2) {
            let at = self.started_s;
            let name = self.field.strongest(self.started_s, &motion);
            return Err(format!(
                "`candidates.{name}.formula` is too steep to follow: the ball speeds up without end by {at:.6} s"
            ));
        }
        if let Some(touch) = self.hit.take() {
            // Onto the surface, so that what rounding left of the gap does not add up over the impacts.
            motion.x -= touch.normal * touch.distance;
            let before = motion;
            motion = self.strike(before, &touch)?;
            if self.law.duration_s > 0.0 && !self.supported && touch.normal.dot(before.v) < 0.0 {
                self.path = Path::pressed(before, motion, touch.normal, self.law.duration_s);
                self.until = self.law.duration_s;
                return Ok(());
            }
        }
        let mut supports = Supports::default();
        if self.supported {
            let ground = Ground {
                obstacles: &self.obstacles,
                ball: self.ball,
                field: &self.field,
                law: &self.law,
                now_s: self.started_s,
            };
            match ground.follow(motion, &mut self.server, &mut self.contacts) {
                Some((path, held_by)) => (self.path, supports) = (path, held_by),
                None => self.supported = false,
            }
        }
        if !self.supported {
            self.path = Path::flight(motion, self.started_s, &self.field);
        }
        self.look_ahead(&supports);
        Ok(())
    }

    /// One impact, at its instant.
    fn strike(&mut self, mut motion: Motion, touch: &Gap) -> Result<Motion, String> {
        let radius = self.ball.radius;
        let tilt = self.tilts_rad.get(self.impacts.len()).filter(|tilt| **tilt != [0.0; 2]);
        let struck = tilt.map_or(touch.normal, |tilt| turned(touch.normal, *tilt));
        let approach = -struck.dot(motion.v);
        if approach > 0.0 {
            let mut coefficients = self.law.at(approach);
            if !self.returns.is_empty() {
                coefficients.0 = self.returned(struck, &motion, approach, coefficients.0)?;
            }
            let after = self.server.resolve(struck, radius, (motion.v, motion.w), coefficients);
            (motion.v, motion.w) = self.law.lose_slip(struck, radius, after);
            self.contacts += 1;
        }
        if approach >= SLOWEST_REBOUND_M_S {
            self.impacts.push(Impact { time_s: self.started_s, approach_m_s: approach });
        }
        let normal = touch.normal;
        let rebound = normal.dot(motion.v);
        self.supported = rebound < SLOWEST_REBOUND_M_S
            && normal.dot(self.field.acceleration(self.started_s, motion.x, motion.v)) < 0.0;
        if self.supported {
            motion.v -= normal * rebound;
        }
        Ok(motion)
    }

    /// The restitution with what formulas add to it, 0 to 1.
    fn returned(&self, normal: Vector, motion: &Motion, approach: f64, restitution: f64) -> Result<f64, String> {
        let skin = motion.v - motion.w.cross(normal * self.ball.radius);
        let along = (skin - normal * normal.dot(skin)).length();
        let added = self.returns.iter().map(|one| one.added(approach, along, restitution)).sum::<Result<f64, _>>();
        let added = added.map_err(|part| format!("{part} at {:.6} s", self.started_s))?;
        Ok((restitution + added).clamp(0.0, 1.0))
    }

    /// Refuses the present piece of motion, which ends with `motion`, where a formula has no finite value in it.
    fn defined(&self, motion: &Motion) -> Result<(), String> {
        let (start, end_s) = (&self.path.start, self.started_s + self.until);
        let refused = if (motion.x + motion.v).is_finite() {
            self.field.pole((self.started_s, start), (end_s, motion))
        } else {
            self.undefined()
        };
        refused.map_or(Ok(()), |part| Err(format!("{part} by {end_s:.6} s")))
    }

    /// Which formula has no finite value in the present piece of motion, in words without an end.
    pub(super) fn undefined(&self) -> Option<String> {
        let Motion { x, v, .. } = self.path.start;
        self.field.undefined((self.started_s, x, v), self.until.min(self.path.horizon))
    }

    /// Finds out how the present piece of motion ends.
    fn look_ahead(&mut self, supports: &Supports) {
        let outlook = first_touch(&self.obstacles, self.ball, &self.path, |i| supports.contains(i));
        self.until = outlook.until;
        self.hit = outlook.hit;
    }
}
