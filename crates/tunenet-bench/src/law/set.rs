//! One blind set: recordings for the tool, and the truth, which it never gets.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use sha2::{Digest, Sha256};

use super::arena::{Arena, Base, Run};
use super::laws;
use super::motion::{Force, World, apart};
use super::strange::Strange;

/// Recordings that are fitted, held out, and faster than those. Of the faster ones the tool knows nothing.
pub const FITTED: usize = 3;
pub const HELD_OUT: usize = 2;
pub const FASTER: usize = 2;
const TIMES_FASTER: f64 = 1.5;
/// Of `DiscoverPhysics`.
const DISCOVER_FITTED: usize = 10;
const DISCOVER_NOISE_M: f64 = 0.15;

/// The search for the size: from the first by this factor until the ratio is passed, then by bisection.
const FIRST_SIZE: f64 = 1e-5;
const SIZE_STEP: f64 = 4.0;
const GREATEST_SIZE: f64 = 1e5;
const HALVINGS: usize = 30;
/// Draws of starts until all motions of a set are finite, and no pendulum swings farther than this, rad: not over the top.
const TRIES: usize = 50;
const FARTHEST_RAD: f64 = 2.6;

/// Outliers lie so many standard deviations off.
const OFF: std::ops::Range<f64> = 5.0..30.0;

/// What a set is to hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hidden {
    Nothing(Arena),
    Inside(&'static str, Arena),
    Strange(&'static str, Arena, Strange),
    Discover(&'static str),
}

impl Hidden {
    pub fn name(&self) -> &'static str {
        match self {
            Self::Nothing(Arena::Flight) => "nothing, flight",
            Self::Nothing(Arena::Plane) => "nothing, plane",
            Self::Nothing(Arena::Centre) => "nothing, centre",
            Self::Nothing(Arena::Pendulum) => "nothing, pendulum",
            Self::Inside(name, _) | Self::Strange(name, ..) | Self::Discover(name) => name,
        }
    }

    pub fn arena(&self) -> Arena {
        match self {
            Self::Nothing(arena) | Self::Inside(_, arena) | Self::Strange(_, arena, _) => *arena,
            Self::Discover(_) => Arena::Plane,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recipe {
    pub hidden: Hidden,
    /// RMS change of the fitted recordings over the standard deviation of the noise; `DiscoverPhysics` has a size of its own.
    pub ratio: f64,
    /// How much of the noise the next sample keeps, and the share of outliers.
    pub colour: f64,
    pub outliers: f64,
}

/// A recording: what moved, and its numbers with noise, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    pub run: Run,
    pub values: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct BlindSet {
    pub world: World,
    pub noise: f64,
    pub clock: Vec<f64>,
    pub fitted: Vec<Recorded>,
    pub held_out: Vec<Recorded>,
    pub faster: Vec<Recorded>,
}

/// A stream of draws that depends on these words alone.
pub fn stream(purpose: &str, seed: u64, cell: &str, number: u64) -> ChaCha8Rng {
    ChaCha8Rng::from_seed(Sha256::digest(format!("{purpose}/{seed}/{cell}/{number}")).into())
}

impl BlindSet {
    /// Draws a set; `None` where no size of the force reaches the ratio, or no motions are sound.
    pub fn draw(recipe: &Recipe, random: &mut ChaCha8Rng) -> Option<Self> {
        (0..TRIES).find_map(|_| Self::once(recipe, random))
    }

    fn once(recipe: &Recipe, random: &mut ChaCha8Rng) -> Option<Self> {
        let arena = recipe.hidden.arena();
        let clock = arena.clock();
        let base = match recipe.hidden {
            // Bodies that nothing brakes.
            Hidden::Discover(_) => Base { arena, numbers: [0.0; 2] },
            _ => Base::draw(arena, random),
        };
        let force = match recipe.hidden {
            Hidden::Nothing(_) => Force::Nothing,
            Hidden::Inside(name, _) => Force::Law(laws::inside(name, random)),
            Hidden::Strange(_, _, kind) => Force::Strange(laws::strange(kind, random)),
            Hidden::Discover(name) => laws::discover(name),
        };
        let discover = matches!(recipe.hidden, Hidden::Discover(_));
        let (count, noise) = if discover { (DISCOVER_FITTED, DISCOVER_NOISE_M) } else { (FITTED, arena.noise()) };
        let mut run = |faster: f64| match recipe.hidden {
            Hidden::Discover(name) => Arena::orbit(|r| laws::discover_inward(name, r), random),
            _ => arena.draw(faster, random),
        };
        let fitted: Vec<Run> = (0..count).map(|_| run(1.0)).collect();
        let held_out: Vec<Run> = (0..HELD_OUT).map(|_| run(1.0)).collect();
        let faster: Vec<Run> = (0..FASTER).map(|_| run(TIMES_FASTER)).collect();
        let size = match recipe.hidden {
            Hidden::Nothing(_) | Hidden::Discover(_) => 1.0,
            _ => size(base, &force, &fitted, &clock, recipe.ratio * noise)?,
        };
        let world = World { base, force: force.sized(size) };
        let mut record = |runs: Vec<Run>| -> Option<Vec<Recorded>> {
            let one = |run: Run| {
                let mut values = world.seen(&run, &clock);
                let farthest = if arena == Arena::Pendulum { FARTHEST_RAD } else { f64::INFINITY };
                let sound = values.iter().all(|v| v.is_finite() && v.abs() < farthest);
                corrupt(&mut values, arena.channels(), noise, recipe, random);
                sound.then_some(Recorded { run, values })
            };
            runs.into_iter().map(one).collect()
        };
        let (fitted, held_out, faster) = (record(fitted)?, record(held_out)?, record(faster)?);
        Some(Self { world, noise, clock, fitted, held_out, faster })
    }
}

/// The size at which the force changes the records of `runs` by `wanted` (RMS).
fn size(base: Base, force: &Force, runs: &[Run], clock: &[f64], wanted: f64) -> Option<f64> {
    let of = |force: Force| -> Vec<f64> {
        let world = World { base, force };
        runs.iter().flat_map(|run| world.seen(run, clock)).collect()
    };
    let plain = of(Force::Nothing);
    let change = |size: f64| apart(&of(force.sized(size)), &plain);
    let mut high = FIRST_SIZE;
    while change(high) < wanted {
        high *= SIZE_STEP;
        if high > GREATEST_SIZE {
            return None;
        }
    }
    let (mut low, mut high) = ((high / SIZE_STEP).ln(), high.ln());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if change(middle.exp()) < wanted { low = middle } else { high = middle }
    }
    // Where the force jumps past the ratio there is no such size.
    let found = low.exp();
    ((change(found) / wanted - 1.0).abs() < 0.02).then_some(found)
}

/// Adds noise, autocorrelated where that is asked for, and outliers.
fn corrupt(values: &mut [f64], channels: usize, noise: f64, recipe: &Recipe, random: &mut ChaCha8Rng) {
    let fresh = (1.0 - recipe.colour * recipe.colour).sqrt();
    let mut last: Vec<f64> = (0..channels).map(|_| random.sample(StandardNormal)).collect();
    for row in values.chunks_exact_mut(channels) {
        // Drawn whether needed or not, so that sets differ in what is asked for alone.
        let (off, by) = (random.random::<f64>(), random.random_range(OFF));
        let way: f64 = if random.random() { 1.0 } else { -1.0 };
        let outlier = if off < recipe.outliers { way * by } else { 0.0 };
        for (value, last) in row.iter_mut().zip(&mut last) {
            *value += noise * (*last + outlier);
            *last = recipe.colour * *last + fresh * random.sample::<f64, _>(StandardNormal);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(hidden: Hidden, ratio: f64) -> Recipe {
        Recipe { hidden, ratio, colour: 0.0, outliers: 0.0 }
    }

    fn drawn(hidden: Hidden, ratio: f64) -> BlindSet {
        let set = BlindSet::draw(&recipe(hidden, ratio), &mut stream("test", 1, hidden.name(), 0));
        set.unwrap_or_else(|| panic!("{} cannot be made as large as {ratio}", hidden.name()))
    }

    fn every() -> impl Iterator<Item = Hidden> {
        let inside = laws::INSIDE.into_iter().map(|(name, arena)| Hidden::Inside(name, arena));
        let strange = laws::OUTSIDE.into_iter().chain(laws::HIDDEN_STATE);
        inside.chain(strange.map(|(name, arena, kind)| Hidden::Strange(name, arena, kind)))
    }

    #[test]
    fn what_is_hidden_changes_the_records_by_the_ratio() {
        for hidden in every() {
            let set = drawn(hidden, 10.0);
            let plain = World { force: Force::Nothing, ..set.world.clone() };
            let of = |world: &World| -> Vec<f64> {
                set.fitted.iter().flat_map(|one| world.seen(&one.run, &set.clock)).collect()
            };
            let change = apart(&of(&set.world), &of(&plain)) / set.noise;
            assert!((change / 10.0 - 1.0).abs() < 0.02, "{}: {change}", hidden.name());
        }
    }

    #[test]
    fn the_noise_is_as_large_as_it_says() {
        let set = drawn(Hidden::Nothing(Arena::Flight), 0.0);
        let all = set.fitted.iter().chain(&set.held_out).chain(&set.faster);
        let square: f64 = all.map(|one| apart(&one.values, &set.world.seen(&one.run, &set.clock)).powi(2)).sum();
        assert!(((square / 7.0).sqrt() / set.noise - 1.0).abs() < 0.05, "{square}");
    }

    #[test]
    fn orbits_of_discover_physics_are_ten_and_stay_finite() {
        for name in laws::DISCOVER {
            let set = drawn(Hidden::Discover(name), 0.0);
            assert_eq!(set.fitted.len(), 10);
            assert!(set.fitted.iter().all(|one| one.values.iter().all(|v| v.is_finite())), "{name}");
        }
    }

    #[test]
    fn no_pendulum_swings_over_the_top() {
        for number in 0..10 {
            let recipe = recipe(Hidden::Inside("cubic-spring", Arena::Pendulum), 10.0);
            let set = BlindSet::draw(&recipe, &mut stream("test", 4, "swing", number)).unwrap();
            let all = set.fitted.iter().chain(&set.held_out).chain(&set.faster);
            let farthest = all.flat_map(|one| &one.values).fold(0.0, |most: f64, q| most.max(q.abs()));
            assert!((0.2..2.7).contains(&farthest), "{farthest}");
        }
    }

    #[test]
    fn equal_words_draw_equal_sets() {
        assert_eq!(
            drawn(Hidden::Inside("screened", Arena::Plane), 10.0),
            drawn(Hidden::Inside("screened", Arena::Plane), 10.0)
        );
    }
}
