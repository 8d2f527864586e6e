//! One blind set: recordings of a driven mechanism with something hidden in it, each with inputs of its own.

use std::sync::Arc;

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use tunenet_core::observation::{Circumstances, Input, Kind, Observation};

use super::plant::{CANDIDATES, Plant, Undeclared, World};

/// How many recordings a set has; the last one of up to four is held out, the last two of more.
const RECORDINGS: std::ops::RangeInclusive<usize> = 3..=6;
/// True motion is integrated with this share of the step of the simulator under test.
const FINER: f64 = 0.25;
/// Halvings of the range of sizes, on a logarithmic scale of so many decades below the greatest.
const HALVINGS: usize = 20;
const DECADES: f64 = 6.0;
/// The greatest size as a share of the bound of its candidate, which has to lie beyond every true value.
const WITHIN_BOUND: f64 = 0.9;

/// What is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hidden {
    Nothing,
    /// The candidate at this position.
    Declared(usize),
    Undeclared(Undeclared),
}

/// Recordings that are fitted, and those that are held out.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivenSet {
    pub seen: Vec<Observation>,
    pub held_out: Vec<Observation>,
}

/// What drives one recording, and where it starts.
struct Drawn {
    inputs: Vec<Input>,
    start: Vec<f64>,
}

impl Drawn {
    fn motion(&self, plant: &Plant, world: &World, step_s: f64) -> Vec<f64> {
        let clock = plant.clock();
        let mut values = vec![0.0; clock.len() * plant.channels.len()];
        (plant.simulate)(world, &|i, t| self.inputs[i].at(0, t), &self.start, &clock, step_s, &mut values);
        values
    }
}

impl DrivenSet {
    /// Draws a set whose hidden effect moves the fitted recordings by `ratio` times the noise (RMS over all numbers, each in units
    /// of the noise of its channel, before any tuning); `None` where no possible size does.
    pub fn draw(plant: &Plant, hidden: Hidden, ratio: f64, random: &mut ChaCha8Rng) -> Result<Option<Self>> {
        let unknowns: Vec<f64> = plant.unknowns.iter().map(|u| random.random_range(u.truth.0..u.truth.1)).collect();
        let count = random.random_range(RECORDINGS);
        let held_out = if count > 4 { 2 } else { 1 };
        let drawn = (0..count).map(|_| {
            let start = plant.start.iter().map(|(.., (low, high))| random.random_range(*low..*high)).collect();
            Ok(Drawn { inputs: plant.draw_inputs(random)?, start })
        });
        let drawn = drawn.collect::<Result<Vec<_>>>()?;
        let sign = if random.random() { 1.0 } else { -1.0 };
        let Some(size) = size(plant, &unknowns, hidden, sign, &drawn[..count - held_out], ratio) else {
            return Ok(None);
        };
        let world = hidden.world(plant, &unknowns, sign * size);
        let recordings = drawn.into_iter().map(|one| recorded(plant, &world, one, random));
        let mut seen = recordings.collect::<Result<Vec<_>>>()?;
        let held_out = seen.split_off(count - held_out);
        Ok(Some(Self { seen, held_out }))
    }
}

impl Hidden {
    pub fn name(self, plant: &Plant) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Declared(number) => plant.candidates[number].name,
            Self::Undeclared(kind) => kind.name(),
        }
    }

    /// The mechanism with this hidden in it, `size` away from its absence. What cannot be negative takes the absolute value.
    fn world<'a>(self, plant: &Plant, unknowns: &'a [f64], size: f64) -> World<'a> {
        let mut effects: [f64; CANDIDATES] = plant.absent();
        let mut undeclared = None;
        match self {
            Self::Nothing => {}
            Self::Declared(number) => {
                let candidate = &plant.candidates[number];
                let two_sided = candidate.bounds.0 < candidate.absent;
                effects[number] += if two_sided { size } else { size.abs() };
            }
            Self::Undeclared(kind) => undeclared = Some((kind, size)),
        }
        World { unknowns, effects: effects.into(), undeclared }
    }

    /// The greatest size that is drawn with this sign.
    fn greatest(self, plant: &Plant, sign: f64) -> f64 {
        match self {
            Self::Nothing => 0.0,
            Self::Declared(number) => {
                let candidate = &plant.candidates[number];
                let (low, high) = candidate.bounds;
                let two_sided = low < candidate.absent;
                WITHIN_BOUND * if two_sided && sign < 0.0 { candidate.absent - low } else { high - candidate.absent }
            }
            Self::Undeclared(_) => 10.0,
        }
    }
}

/// The least size of a hidden effect that moves `drawn` by `ratio`; 0 for nothing.
fn size(plant: &Plant, unknowns: &[f64], hidden: Hidden, sign: f64, drawn: &[Drawn], ratio: f64) -> Option<f64> {
    if hidden == Hidden::Nothing {
        return Some(0.0);
    }
    let motions = |size: f64| -> Vec<Vec<f64>> {
        let world = hidden.world(plant, unknowns, sign * size);
        drawn.iter().map(|one| one.motion(plant, &world, plant.step_s)).collect()
    };
    let plain = motions(0.0);
    let noise: Vec<f64> = plant.noise().collect();
    let deviation = |size: f64| {
        let (mut sum, mut count) = (0.0, 0_usize);
        for (moved, plain) in motions(size).iter().zip(&plain) {
            let each = moved.iter().zip(plain).enumerate();
            sum += each.map(|(i, (a, b))| ((a - b) / noise[i % noise.len()]).powi(2)).sum::<f64>();
            count += plain.len();
        }
        (sum / count as f64).sqrt()
    };
    let greatest = hidden.greatest(plant, sign);
    // A size that cannot be simulated is above any ratio.
    let enough = |size: f64| {
        let deviation = deviation(size);
        deviation.is_nan() || deviation >= ratio
    };
    let (mut low, mut high) = (-DECADES, 0.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if enough(greatest * 10_f64.powf(middle)) { high = middle } else { low = middle }
    }
    let found = greatest * 10_f64.powf(high);
    ((deviation(found) / ratio - 1.0).abs() < 0.02).then_some(found)
}

fn recorded(plant: &Plant, world: &World, drawn: Drawn, random: &mut ChaCha8Rng) -> Result<Observation> {
    let mut values = drawn.motion(plant, world, FINER * plant.step_s);
    let noise: Vec<f64> = plant.noise().collect();
    for (i, value) in values.iter_mut().enumerate() {
        *value += noise[i % noise.len()] * random.sample::<f64, _>(StandardNormal);
    }
    let seen = Observation::new(Kind::Other, plant.channels(), plant.clock(), values)?;
    Ok(seen.under(Arc::new(Circumstances::driven_by(drawn.inputs))))
}

#[cfg(test)]
mod tests {
    use super::super::PLANTS;
    use super::*;
    use crate::diagnose::blind::stream;

    #[test]
    fn what_is_hidden_moves_the_recordings_by_the_ratio() {
        let every = (0..CANDIDATES).map(Hidden::Declared).chain(Undeclared::ALL.map(Hidden::Undeclared));
        for (plant, hidden) in PLANTS.into_iter().flat_map(|plant| every.clone().map(move |h| (plant, h))) {
            let draw = |hidden| DrivenSet::draw(plant, hidden, 10.0, &mut stream("test", 1, plant.name, 0));
            let name = hidden.name(plant);
            let (plain, set) = (draw(Hidden::Nothing).unwrap().unwrap(), draw(hidden).unwrap());
            let set = set.unwrap_or_else(|| panic!("{}: {name} cannot be made visible", plant.name));
            let noise: Vec<f64> = plant.noise().collect();
            // Inputs, parameters and noise are drawn alike, so that the noise cancels.
            let squares = plain.seen.iter().zip(&set.seen).map(|(a, b)| {
                let each = a.values().iter().zip(b.values()).enumerate();
                each.map(|(i, (a, b))| ((a - b) / noise[i % noise.len()]).powi(2)).sum::<f64>()
                    / a.values().len() as f64
            });
            let ratio = (squares.sum::<f64>() / plain.seen.len() as f64).sqrt();
            assert!((ratio - 10.0).abs() < 0.4, "{}: {name} {ratio}", plant.name);
        }
    }

    #[test]
    fn equal_words_draw_equal_sets() {
        let draw =
            || DrivenSet::draw(PLANTS[0], Hidden::Declared(2), 3.0, &mut stream("test", 3, "a", 0)).unwrap().unwrap();
        assert_eq!(draw(), draw());
        assert!((3..=6).contains(&(draw().seen.len() + draw().held_out.len())));
    }
}
