//! One blind set: recordings for the code under test, and the truth, which it never gets.

use anyhow::Result;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use sha2::{Digest, Sha256};
use tunenet_core::observation::Observation;

use super::ball::BlindThrow;
use super::camera::{Noise, seen};
use super::hidden::{EffectKind, HiddenEffect};
use super::vector::{Vector, dot, plus};
use super::world::{BallWorld, RADIUS_M};

/// Frames of a recording, and how fast they come.
pub const FRAMES: usize = 216;
pub const RATE_HZ: f64 = 120.0;
/// Bounces whose scatter is drawn; no recording has more.
const MOST_BOUNCES: usize = 40;
/// Halvings of the range of sizes, on a logarithmic scale of [`DECADES`].
const HALVINGS: usize = 22;
const DECADES: f64 = 5.0;

/// What a set is to hold.
#[derive(Debug, Clone)]
pub struct Recipe {
    pub hidden: Vec<EffectKind>,
    /// RMS deviation that each effect causes over the standard deviation of the noise, per number of the recordings and
    /// before any tuning.
    pub ratio: f64,
    pub drops: usize,
    pub held_out: usize,
    pub noise: Noise,
    /// What else is wrong with the set.
    pub trouble: Trouble,
}

/// What is wrong with a set besides its noise and what is hidden in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trouble {
    /// Nothing.
    None,
    /// The simulation file states this many times the ball's true mass.
    WrongMass(f64),
    /// One of the recordings that are fitted shows another ball, whose restitution differs by this.
    OddBall(f64),
    /// The restitution differs from recording to recording, with this standard deviation.
    RestitutionScatters(f64),
    /// Only x and z were recorded.
    PlaneOnly,
}

/// The drag coefficient of a sphere, and the density of air, kg/m³.
const SPHERE_DRAG: f64 = 0.45;
const AIR_KG_M3: f64 = 1.2;
/// Which recording is odd where one is.
const ODD: usize = 1;

/// Recordings, and behind them what is true.
pub struct BlindSet {
    pub seen: Vec<Observation>,
    pub held_out: Vec<Observation>,
    /// The mass that the simulation file states, kg; `None` where it leaves it open.
    pub stated_mass_kg: Option<f64>,
    truth: Truth,
}

struct Truth {
    world: BallWorld,
    held_out: Vec<BlindThrow>,
    noise: Noise,
}

/// What the true world leaves of the held-out recordings once their starts are fitted, m (RMS of the distance).
#[derive(Debug, Clone, Copy)]
pub struct Floor {
    pub held_out_m: f64,
    /// Start fitted to the first 40 %, residual of the rest.
    pub forecast_m: f64,
}

/// Reverses the spin of the first throw where that of all throws has one sign: such a spin is in the catalogue.
fn shown_in_both_signs(throws: &mut [BlindThrow]) {
    let sign = |throw: &BlindThrow| throw.own()[0].signum();
    if throws.len() > 1 && throws.iter().all(|one| sign(one) == sign(&throws[0])) {
        throws[0].scatter.last_mut().into_iter().for_each(|own| own[0] = -own[0]);
    }
}

/// A stream of draws that depends on these words alone.
pub fn stream(purpose: &str, seed: u64, cell: &str, number: u64) -> ChaCha8Rng {
    ChaCha8Rng::from_seed(Sha256::digest(format!("{purpose}/{seed}/{cell}/{number}")).into())
}

impl BlindSet {
    /// Draws a set; `None` where no possible size of an effect reaches the ratio.
    pub fn draw(recipe: &Recipe, random: &mut ChaCha8Rng) -> Result<Option<Self>> {
        let mut world = BallWorld { restitution: random.random_range(0.7..0.9), hidden: vec![] };
        let mut throws: Vec<BlindThrow> = (0..recipe.drops + recipe.held_out).map(|_| throw(random)).collect();
        if recipe.hidden.contains(&EffectKind::SignedSpin) {
            shown_in_both_signs(&mut throws);
        }
        let mut hidden = Vec::new();
        for kind in &recipe.hidden {
            let drawn = HiddenEffect {
                kind: *kind,
                size: 0.0,
                sign: if random.random() { 1.0 } else { -1.0 },
                turn: random.random_range(0.0..std::f64::consts::TAU),
                lift: random.random_range(-1.2..1.2),
            };
            let Some(size) = size(&world, drawn, &throws[..recipe.drops], recipe.ratio * recipe.noise.sd_m) else {
                return Ok(None);
            };
            hidden.push(HiddenEffect { size, ..drawn });
        }
        world.hidden = hidden;
        let mut recordings = Vec::with_capacity(throws.len());
        for (number, throw) in throws.iter().enumerate() {
            let shown = recipe.trouble.shown(&world, number, throw);
            let recording = recorded(&shown, throw, recipe.noise, random)?;
            recordings.push(if recipe.trouble == Trouble::PlaneOnly { in_plane(&recording)? } else { recording });
        }
        let held_out = recordings.split_off(recipe.drops);
        let stated_mass_kg = recipe.trouble.stated_mass_kg(&world);
        let truth = Truth { world, held_out: throws[recipe.drops..].to_vec(), noise: recipe.noise };
        Ok(Some(Self { seen: recordings, held_out, stated_mass_kg, truth }))
    }

    /// One more recording of the same world, thrown from this position at this velocity.
    pub fn thrown(&self, position_m: Vector, velocity_m_s: Vector, random: &mut ChaCha8Rng) -> Result<Observation> {
        let throw = BlindThrow { position_m, velocity_m_s, scatter: scatter(random) };
        recorded(&self.truth.world, &throw, self.truth.noise, random)
    }

    /// What the true world leaves of the held-out recordings.
    pub fn floor(&self) -> Option<Floor> {
        let pairs = self.truth.held_out.iter().zip(&self.held_out);
        let (mut whole, mut rest) = (Rms::default(), Rms::default());
        for (throw, observation) in pairs {
            let (clock, width) = (observation.clock(), observation.channels().len());
            let flat = |throw: &BlindThrow| seen(&self.truth.world, throw, clock).concat();
            let error: Vec<f64> =
                observation.values().iter().zip(flat(throw)).map(|(seen, true_)| seen - true_).collect();
            let columns: Vec<Vec<f64>> = (0..6).map(|i| column(&flat, throw, i)).collect();
            whole.add(&projected(&error, &columns, error.len()), width);
            let early = clock.len() * 2 / 5 * width;
            rest.add(&projected(&error, &columns, early)[early..], width);
        }
        (whole.samples > 0).then(|| Floor { held_out_m: whole.value(), forecast_m: rest.value() })
    }
}

impl Trouble {
    /// The world that recording `number` shows.
    fn shown(self, world: &BallWorld, number: usize, throw: &BlindThrow) -> BallWorld {
        let differs = match self {
            Self::OddBall(by) if number == ODD => by,
            Self::RestitutionScatters(sd) => sd * throw.own()[1],
            _ => 0.0,
        };
        BallWorld { restitution: (world.restitution + differs).clamp(0.05, 0.97), ..world.clone() }
    }

    /// The mass that the simulation file states, kg: of the true one, which follows from the drag.
    fn stated_mass_kg(self, world: &BallWorld) -> Option<f64> {
        let Self::WrongMass(times) = self else { return None };
        let drag = world.hidden.iter().find(|h| h.kind == EffectKind::QuadraticDrag)?;
        let area = std::f64::consts::PI * RADIUS_M * RADIUS_M;
        Some(times * 0.5 * AIR_KG_M3 * SPHERE_DRAG * area / drag.size)
    }
}

/// The same recording without y: that channel stands still, as readers of files without it make it.
fn in_plane(seen: &Observation) -> Result<Observation> {
    let positions: Vec<Vector> = seen.values().chunks_exact(3).map(|row| [row[0], 0.0, row[2]]).collect();
    Ok(Observation::positions(seen.clock().to_vec(), &positions)?)
}

/// A throw like a person's: from about a metre, in any direction.
fn throw(random: &mut ChaCha8Rng) -> BlindThrow {
    let turn = random.random_range(0.0..std::f64::consts::TAU);
    let speed = random.random_range(0.4..3.0);
    let at = [random.random_range(-0.3..0.3), random.random_range(-0.3..0.3), random.random_range(0.7..1.8)];
    let velocity_m_s = [speed * turn.cos(), speed * turn.sin(), random.random_range(-0.5..1.5)];
    BlindThrow { position_m: plus(at, [0.0, 0.0, 1.0], RADIUS_M), velocity_m_s, scatter: scatter(random) }
}

fn scatter(random: &mut ChaCha8Rng) -> Vec<[f64; 2]> {
    (0..MOST_BOUNCES).map(|_| [random.sample(StandardNormal), random.sample(StandardNormal)]).collect()
}

fn clock() -> Vec<f64> {
    (0..FRAMES).map(|i| i as f64 / RATE_HZ).collect()
}

fn recorded(world: &BallWorld, throw: &BlindThrow, noise: Noise, random: &mut ChaCha8Rng) -> Result<Observation> {
    let clock = clock();
    let mut positions = seen(world, throw, &clock);
    let arrives = noise.corrupt(&mut positions, random);
    let (clock, positions): (Vec<f64>, Vec<Vector>) =
        clock.into_iter().zip(positions).zip(arrives).filter(|(_, arrives)| *arrives).map(|(sample, _)| sample).unzip();
    Ok(Observation::positions(clock, &positions)?)
}

/// The size at which `hidden` moves the numbers of `throws` by `deviation_m` (RMS).
fn size(world: &BallWorld, hidden: HiddenEffect, throws: &[BlindThrow], deviation_m: f64) -> Option<f64> {
    let clock = clock();
    let plain: Vec<Vec<Vector>> = throws.iter().map(|t| seen(world, t, &clock)).collect();
    let deviation = |size: f64| {
        let mut changed = world.clone();
        changed.hidden.push(HiddenEffect { size, ..hidden });
        let mut sum = 0.0;
        for (throw, plain) in throws.iter().zip(&plain) {
            let moved = seen(&changed, throw, &clock);
            sum += moved.iter().zip(plain).map(|(a, b)| square(plus(*a, *b, -1.0))).sum::<f64>();
        }
        (sum / (3 * clock.len() * throws.len()) as f64).sqrt()
    };
    let greatest = hidden.kind.greatest();
    if deviation(greatest) < deviation_m {
        return None;
    }
    let (mut low, mut high) = (-DECADES, 0.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if deviation(greatest * 10_f64.powf(middle)) < deviation_m { low = middle } else { high = middle }
    }
    Some(greatest * 10_f64.powf(high))
}

fn square(a: Vector) -> f64 {
    dot(a, a)
}

/// How the picture moves with number `i` of the start (three of position, three of velocity).
fn column(flat: &dyn Fn(&BlindThrow) -> Vec<f64>, throw: &BlindThrow, i: usize) -> Vec<f64> {
    const STEP: f64 = 1e-5;
    let moved = |by: f64| {
        let mut throw = throw.clone();
        if i < 3 {
            throw.position_m[i] += by;
        } else {
            throw.velocity_m_s[i - 3] += by;
        }
        flat(&throw)
    };
    moved(STEP).iter().zip(moved(-STEP)).map(|(a, b)| (a - b) / (2.0 * STEP)).collect()
}

/// `error` less its least-squares fit by `columns` over the first `fitted` numbers; the fit is carried on to the others.
fn projected(error: &[f64], columns: &[Vec<f64>], fitted: usize) -> Vec<f64> {
    let inner = |a: &[f64], b: &[f64]| a[..fitted].iter().zip(&b[..fitted]).map(|(a, b)| a * b).sum::<f64>();
    let (mut rest, mut basis) = (error.to_vec(), Vec::<Vec<f64>>::new());
    // Gram and Schmidt, on whole columns, so that what is fitted early is taken along to the end.
    for column in columns {
        let mut column = column.clone();
        for _ in 0..2 {
            for one in &basis {
                let share = inner(one, &column);
                column.iter_mut().zip(one).for_each(|(c, o)| *c -= share * o);
            }
        }
        let norm = inner(&column, &column).sqrt();
        if norm > 1e-12 {
            for c in &mut column {
                *c /= norm;
            }
            basis.push(column);
        }
    }
    for one in &basis {
        let share = inner(one, &rest);
        rest.iter_mut().zip(one).for_each(|(r, o)| *r -= share * o);
    }
    rest
}

#[derive(Default)]
struct Rms {
    squares: f64,
    samples: usize,
}

impl Rms {
    fn add(&mut self, numbers: &[f64], width: usize) {
        self.squares += numbers.iter().map(|v| v * v).sum::<f64>();
        self.samples += numbers.len() / width;
    }

    fn value(&self) -> f64 {
        (self.squares / self.samples as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(hidden: Vec<EffectKind>, ratio: f64, noise: Noise) -> Recipe {
        Recipe { hidden, ratio, drops: 3, held_out: 2, noise, trouble: Trouble::None }
    }

    #[test]
    fn every_effect_moves_the_recordings_by_the_ratio() {
        let quiet = Noise { sd_m: 1e-12, ..Noise::WHITE };
        for kind in EffectKind::CATALOGUE.into_iter().chain(EffectKind::OUTSIDE) {
            let stream = || stream("test", 1, kind.name(), 0);
            let plain = BlindSet::draw(&recipe(vec![], 0.0, quiet), &mut stream()).unwrap().unwrap();
            let target = Recipe { noise: Noise::WHITE, ..recipe(vec![kind], 3.0, quiet) };
            let Some(set) = BlindSet::draw(&target, &mut stream()).unwrap() else {
                assert_eq!(kind, EffectKind::ObservationBlur, "{kind:?} cannot be made visible");
                continue;
            };
            // Starts and restitution are drawn first, so they are the same.
            let squares = plain.seen.iter().zip(&set.seen).map(|(a, b)| {
                let each = a.values().iter().zip(b.values());
                each.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.values().len() as f64
            });
            let ratio = (squares.sum::<f64>() / 3.0).sqrt() / 0.002;
            // Signal and noise of ratio 3 and 1: √10.
            assert!((ratio - 10_f64.sqrt()).abs() < 0.25, "{kind:?} {ratio}");
        }
    }

    #[test]
    fn the_true_world_leaves_the_noise() {
        let mut mean = 0.0;
        for number in 0..8 {
            let set = BlindSet::draw(
                &recipe(vec![EffectKind::Wind], 10.0, Noise::WHITE),
                &mut stream("test", 2, "floor", number),
            );
            mean += set.unwrap().unwrap().floor().unwrap().held_out_m / 8.0;
        }
        let expected = 0.002 * (3.0 * (1.0 - 6.0 / (3.0 * FRAMES as f64))).sqrt();
        assert!((mean / expected - 1.0).abs() < 0.02, "{mean} {expected}");
    }

    #[test]
    fn equal_words_draw_equal_sets() {
        let draw =
            || BlindSet::draw(&recipe(vec![EffectKind::Magnus], 3.0, Noise::WHITE), &mut stream("test", 3, "a", 0));
        assert_eq!(draw().unwrap().unwrap().seen, draw().unwrap().unwrap().seen);
    }
}
