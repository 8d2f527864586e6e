//! A bouncing ball by an integrator of its own: nothing here is shared with what is measured.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

pub use crate::scene::GRAVITY_M_S2;

/// Steps of Runge and Kutta's fourth-order method; impacts are located within one by bisection.
const STEP_S: f64 = 1e-3;
/// A rebound slower than this has come to rest.
const REST_M_S: f64 = 0.02;

/// A record as it would be written to a file: stamps, and the ball's centre.
#[derive(Debug, Clone)]
pub struct Record {
    pub clock: Vec<f64>,
    pub position_m: Vec<[f64; 3]>,
}

/// What is drawn for one record.
#[derive(Debug, Clone)]
pub struct Setup {
    pub radius_m: f64,
    pub fall_m: f64,
    pub restitution: f64,
    pub surface_m: f64,
    pub rate_hz: f64,
    pub frames: usize,
    pub noise_m: f64,
    /// Velocity at the start, m/s; zero for a drop.
    pub velocity_m_s: [f64; 3],
    /// Air: a = −c |v| v, 1/m.
    pub drag_1_m: f64,
    /// Decimals of the file, where it was written with few.
    pub decimals: Option<i32>,
    /// Where the table ends along x, and how far below the floor lies, m.
    pub edge: Option<(f64, f64)>,
    /// When something strikes the ball, s, and by how much that changes its velocity.
    pub blow: Option<(f64, [f64; 3])>,
    /// Held at the start for so long, s.
    pub held_s: f64,
}

impl Setup {
    /// A record without fault: heights 0.3 to 5 m, 30 to 240 Hz, noise to 1 % of the height, restitution 0.2 to 0.95; a third
    /// are throws, a third have air.
    pub fn draw(random: &mut ChaCha8Rng) -> Self {
        let fall_m = 0.3 * (5.0f64 / 0.3).powf(random.random());
        let throw = random.random_bool(1.0 / 3.0);
        let sideways = if throw { random.random_range(0.3..3.0) } else { 0.0 };
        let angle: f64 = random.random_range(0.0..std::f64::consts::TAU);
        let up = if throw { random.random_range(-0.5..2.0) } else { 0.0 };
        let rates = [30.0, 50.0, 60.0, 90.0, 100.0, 120.0, 200.0, 240.0];
        let rate_hz = rates[random.random_range(0..rates.len())];
        let restitution: f64 = random.random_range(0.2..0.95);
        let fall_s = (2.0 * fall_m / GRAVITY_M_S2).sqrt();
        // At least the first hop is in the record.
        let least = fall_s * (1.2 + 2.0 * restitution) + 0.4 * f64::max(up, 0.0);
        let seconds = least * random.random_range(1.0..3.0);
        let noise_m = if random.random_bool(0.1) { 0.0 } else { fall_m * 0.01 * random.random::<f64>() };
        let light = random.random_bool(1.0 / 3.0);
        Self {
            radius_m: random.random_range(0.01..0.12),
            fall_m,
            restitution,
            surface_m: random.random_range(-1.0..1.0),
            rate_hz,
            frames: whole(seconds * rate_hz).max(20),
            noise_m,
            velocity_m_s: [sideways * angle.cos(), sideways * angle.sin(), up],
            drag_1_m: if light { 0.15 * random.random::<f64>() } else { 0.0 },
            decimals: random.random_bool(0.4).then(|| random.random_range(3..7)),
            edge: None,
            blow: None,
            held_s: 0.0,
        }
    }

    /// Seconds of the fall alone, without air.
    pub fn fall_s(&self) -> f64 {
        (2.0 * self.fall_m / GRAVITY_M_S2).sqrt()
    }

    pub fn clock(&self) -> Vec<f64> {
        (0..self.frames).map(|i| i as f64 / self.rate_hz).collect()
    }

    /// The ball's centre at these instants, without noise.
    pub fn path(&self, clock: &[f64]) -> Vec<[f64; 3]> {
        let mut ball = Ball {
            position: [0.0, 0.0, self.surface_m + self.radius_m + self.fall_m],
            velocity: self.velocity_m_s,
            time: self.held_s,
            struck: false,
            floor: self.surface_m + self.radius_m,
        };
        clock
            .iter()
            .map(|&t| {
                ball.until(self, t);
                ball.position
            })
            .collect()
    }

    /// Adds noise, and rounds to the decimals of the file.
    pub fn seen(&self, path: &[[f64; 3]], random: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
        let one = |v: f64, random: &mut ChaCha8Rng| {
            let v = v + self.noise_m * random.sample::<f64, _>(StandardNormal);
            self.decimals.map_or(v, |d| (v * 10f64.powi(d)).round() / 10f64.powi(d))
        };
        path.iter().map(|p| p.map(|v| one(v, random))).collect()
    }

    pub fn record(&self, random: &mut ChaCha8Rng) -> Record {
        let clock = self.clock();
        let position_m = self.seen(&self.path(&clock), random);
        Record { clock, position_m }
    }
}

/// Rounded to a count.
pub fn whole(value: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let count = value.clamp(0.0, 1e6).round() as usize;
    count
}

struct Ball {
    position: [f64; 3],
    velocity: [f64; 3],
    time: f64,
    struck: bool,
    floor: f64,
}

impl Ball {
    fn until(&mut self, setup: &Setup, end: f64) {
        while self.time < end - 1e-12 {
            let mut step = STEP_S.min(end - self.time);
            if let Some((at, change)) = setup.blow.filter(|_| !self.struck) {
                if self.time >= at - 1e-12 {
                    self.struck = true;
                    (0..3).for_each(|i| self.velocity[i] += change[i]);
                } else {
                    step = step.min(at - self.time);
                }
            }
            self.step(setup, step);
        }
    }

    fn step(&mut self, setup: &Setup, step: f64) {
        if let Some((edge, depth)) = setup.edge
            && self.position[0] > edge
        {
            self.floor = setup.surface_m + setup.radius_m - depth;
        }
        let on_floor = self.position[2] - self.floor < 1e-9;
        if on_floor && self.velocity[2].abs() < REST_M_S {
            self.velocity[2] = 0.0;
            (self.position[0], self.position[1]) =
                (self.position[0] + step * self.velocity[0], self.position[1] + step * self.velocity[1]);
            self.time += step;
            return;
        }
        let (position, velocity) = self.flown(setup, step);
        if position[2] >= self.floor {
            (self.position, self.velocity) = (position, velocity);
            self.time += step;
            return;
        }
        let (mut low, mut high) = (0.0, step);
        for _ in 0..50 {
            let middle = f64::midpoint(low, high);
            if self.flown(setup, middle).0[2] >= self.floor { low = middle } else { high = middle }
        }
        (self.position, self.velocity) = self.flown(setup, low);
        self.position[2] = self.floor;
        self.velocity = [0.9 * self.velocity[0], 0.9 * self.velocity[1], -setup.restitution * self.velocity[2]];
        self.time += low.max(1e-9);
    }

    /// One step of Runge and Kutta's.
    fn flown(&self, setup: &Setup, step: f64) -> ([f64; 3], [f64; 3]) {
        let acceleration = |v: [f64; 3]| {
            let speed = v.iter().map(|c| c * c).sum::<f64>().sqrt();
            let air = setup.drag_1_m * speed;
            [-air * v[0], -air * v[1], -air * v[2] - GRAVITY_M_S2]
        };
        let along = |a: [f64; 3], b: [f64; 3], h: f64| [a[0] + h * b[0], a[1] + h * b[1], a[2] + h * b[2]];
        let v = self.velocity;
        let a1 = acceleration(v);
        let v2 = along(v, a1, step / 2.0);
        let a2 = acceleration(v2);
        let v3 = along(v, a2, step / 2.0);
        let a3 = acceleration(v3);
        let v4 = along(v, a3, step);
        let a4 = acceleration(v4);
        let mean = |k: [[f64; 3]; 4], i: usize| (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]) / 6.0;
        let (vs, accelerations) = ([v, v2, v3, v4], [a1, a2, a3, a4]);
        let position = [0, 1, 2].map(|i| self.position[i] + step * mean(vs, i));
        (position, [0, 1, 2].map(|i| v[i] + step * mean(accelerations, i)))
    }
}
