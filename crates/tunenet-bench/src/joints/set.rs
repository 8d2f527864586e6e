//! One blind set: runs of a joint with something hidden in it, of which the tool gets positions and commands.

use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::motion::{apart, positions};
use super::servo::{Motor, NUMBERS, Run, Secret, Secrets, Shape};
use super::surviving::surviving;

/// Runs that are fitted; as many are held out, with other gains and loads.
pub const FITTED: usize = 3;
/// Standard deviation of the noise, rad, what of it the next sample keeps, and the step of the encoder.
pub const NOISE_RAD: f64 = 4e-3;
const KEPT: f64 = 0.7;
const ENCODER_RAD: f64 = std::f64::consts::TAU / 4096.0;
/// Numbers of the motor differ from the centre by up to this share; the zero by so much, rad.
const SHIFT: f64 = 0.2;
const ZERO_RAD: f64 = 0.02;
/// Steps of the truth, and of what is only compared with itself.
const TRUTH_STEP_S: f64 = 1e-4;
const ROUGH_STEP_S: f64 = 2.5e-4;
/// Runs last so long, sampled at 100 Hz with stamps that scatter.
const SAMPLES: usize = 600;
const PERIOD_S: f64 = 0.01;
const SCATTER_S: f64 = 4e-4;
/// The search for a size: halvings of so many decades below the greatest.
const DECADES: f64 = 5.0;
const HALVINGS: usize = 18;
/// The share by which the ratio may be missed.
const NEAR: f64 = 0.03;

const MASSES_KG: [f64; 4] = [0.535, 0.741, 0.969, 1.168];
const LENGTHS_M: [f64; 2] = [0.1, 0.15];
const GAINS: [f64; 6] = [4.0, 8.0, 12.0, 16.0, 24.0, 32.0];
/// A step is worth recording from this gain on.
const STEP_GAIN: f64 = 16.0;

/// A stream of draws that depends on these words alone.
pub fn stream(purpose: &str, seed: u64, cell: &str, number: u64) -> ChaCha8Rng {
    ChaCha8Rng::from_seed(Sha256::digest(format!("{purpose}/{seed}/{cell}/{number}")).into())
}

/// What is commanded.
#[derive(Debug, Clone, Copy)]
enum Motion {
    /// sin t².
    Faster,
    /// To an angle at once, and back.
    Step,
    /// Slowly up, then the motor is released.
    LiftAndDrop,
}

impl Motion {
    const ALL: [Self; FITTED] = [Self::Faster, Self::Step, Self::LiftAndDrop];

    /// The goal at an instant, by draws of its size and its pace.
    fn goal(self, t: f64, size: f64, pace: f64) -> f64 {
        match self {
            Self::Faster => size * (pace * t * t).sin(),
            Self::Step => {
                if (1.5..4.0).contains(&t) {
                    1.9 * size
                } else {
                    0.0
                }
            }
            Self::LiftAndDrop => {
                let share = (t / LIFTED_S).min(1.0);
                -1.9 * size * share * share * (3.0 - 2.0 * share)
            }
        }
    }
}

/// The instant at which a lifted load is released.
const LIFTED_S: f64 = 2.0;

/// A set as the tool gets it, with its truth.
#[derive(Debug, Clone, Serialize)]
pub struct JointSet {
    pub motor: Motor,
    pub secrets: Secrets,
    pub runs: Vec<Run>,
    /// What was measured in each run; the last half of the runs is held out.
    pub measured: Vec<Vec<f64>>,
    pub surviving: Surviving,
}

/// What is left of the hidden effect in the fitted runs once the motor's numbers are tuned.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Surviving {
    /// Root mean square in units of the noise.
    pub rms: f64,
    /// Root of the summed squares in units of the noise, both whitened: what the best test of a known shape has in standard deviations.
    pub sigma: f64,
}

impl Surviving {
    fn of(left: &[f64]) -> Self {
        let rms = apart(left, &vec![0.0; left.len()]) / NOISE_RAD;
        let new = NOISE_RAD * (1.0 - KEPT * KEPT).sqrt();
        let runs = left.chunks(SAMPLES).flat_map(|run| run.windows(2));
        let squares = runs.map(|two| ((two[1] - KEPT * two[0]) / new).powi(2)).sum::<f64>();
        Self { rms, sigma: squares.sqrt() }
    }
}

impl JointSet {
    /// Draws a set whose hidden effect moves the fitted runs by `ratio` times the noise before any tuning; `None` where no physical
    /// size does.
    pub fn draw(hidden: Option<(&Secret, f64)>, random: &mut ChaCha8Rng) -> Option<Self> {
        let motor = motor(random);
        let runs = runs(random);
        let shape = Shape { sign: if random.random() { 1.0 } else { -1.0 }, share: random.random() };
        let mut secrets = Secrets::NONE;
        let mut left = Surviving::default();
        if let Some((secret, ratio)) = hidden {
            let fitted = &runs[..FITTED];
            let size = size(secret, shape, &motor, fitted, ratio)?;
            (secret.act)(&mut secrets, size, shape);
            left = Surviving::of(&surviving(&motor, &secrets, fitted, ROUGH_STEP_S));
        }
        let measured =
            runs.iter().map(|run| measured(positions(&motor, &secrets, run, TRUTH_STEP_S), random)).collect();
        Some(Self { motor, secrets, runs, measured, surviving: left })
    }
}

fn motor(random: &mut ChaCha8Rng) -> Motor {
    let mut numbers = Motor::CENTRE.numbers();
    for number in &mut numbers {
        *number *= random.random_range(1.0 - SHIFT..1.0 + SHIFT);
    }
    numbers[NUMBERS - 1] = random.random_range(-ZERO_RAD..ZERO_RAD);
    Motor::of(numbers)
}

/// The fitted runs, then those held out: of either three motions with gains and loads of their own.
fn runs(random: &mut ChaCha8Rng) -> Vec<Run> {
    let mut gains = GAINS;
    // Steps get the two largest of three drawn gains that are large enough.
    loop {
        gains.shuffle(random);
        if gains[1] >= STEP_GAIN && gains[4] >= STEP_GAIN {
            break;
        }
    }
    let mut loads: Vec<(f64, f64)> = MASSES_KG.iter().flat_map(|m| LENGTHS_M.map(|l| (*m, l))).collect();
    loop {
        loads.shuffle(random);
        let varied = |of: &[(f64, f64)]| of.iter().any(|one| one.0 != of[0].0) && of.iter().any(|one| one.1 != of[0].1);
        if varied(&loads[..FITTED]) && varied(&loads[FITTED..2 * FITTED]) {
            break;
        }
    }
    let each = (0..2 * FITTED).map(|i| {
        let motion = Motion::ALL[i % FITTED];
        run(motion, gains[i], loads[i], random)
    });
    each.collect()
}

fn run(motion: Motion, kp: f64, (mass_kg, length_m): (f64, f64), random: &mut ChaCha8Rng) -> Run {
    let (size, pace) = (random.random_range(0.65..0.85), random.random_range(0.85..1.15));
    let late = |i: usize, random: &mut ChaCha8Rng| i as f64 * PERIOD_S + random.random_range(0.0..SCATTER_S);
    let clock: Vec<f64> = (0..SAMPLES).map(|i| if i == 0 { 0.0 } else { late(i, random) }).collect();
    let goal = clock.iter().map(|t| motion.goal(*t, size, pace)).collect();
    let off_from = matches!(motion, Motion::LiftAndDrop).then(|| clock.partition_point(|t| *t < LIFTED_S));
    Run { kp, mass_kg, length_m, clock, goal, off_from, latch_phase: random.random() }
}

/// The least size that moves `runs` by `ratio`.
fn size(secret: &Secret, shape: Shape, motor: &Motor, runs: &[Run], ratio: f64) -> Option<f64> {
    let rolled = |secrets: &Secrets| -> Vec<f64> {
        runs.iter().flat_map(|run| positions(motor, secrets, run, ROUGH_STEP_S)).collect()
    };
    let plain = rolled(&Secrets::NONE);
    let moved = |size: f64| {
        let mut secrets = Secrets::NONE;
        (secret.act)(&mut secrets, size, shape);
        apart(&rolled(&secrets), &plain) / NOISE_RAD
    };
    let (mut low, mut high) = (-DECADES, 0.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if moved(secret.greatest * 10_f64.powf(middle)) >= ratio { high = middle } else { low = middle }
    }
    let found = secret.greatest * 10_f64.powf(high);
    ((moved(found) / ratio - 1.0).abs() < NEAR).then_some(found)
}

/// With noise, in steps of the encoder.
fn measured(mut values: Vec<f64>, random: &mut ChaCha8Rng) -> Vec<f64> {
    let mut noise: f64 = NOISE_RAD * random.sample::<f64, _>(StandardNormal);
    for value in &mut values {
        *value = ((*value + noise) / ENCODER_RAD).round() * ENCODER_RAD;
        noise = KEPT * noise + (1.0 - KEPT * KEPT).sqrt() * NOISE_RAD * random.sample::<f64, _>(StandardNormal);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::super::servo::SECRETS;
    use super::super::surviving::fitted;
    use super::*;

    #[test]
    fn what_is_hidden_moves_the_runs_by_the_ratio_and_survives_tuning_in_part() {
        for name in ["speed_limit", "load_friction", "backlash", "joint_spring"] {
            let secret = SECRETS.iter().find(|one| one.name == name).unwrap();
            // Of some motors no physical size moves the runs so much.
            let drawn = |number| JointSet::draw(Some((secret, 10.0)), &mut stream("test", 1, name, number));
            let set = (0..8).find_map(drawn).unwrap();
            let rolled = |secrets: &Secrets| -> Vec<f64> {
                set.runs[..FITTED].iter().flat_map(|run| positions(&set.motor, secrets, run, TRUTH_STEP_S)).collect()
            };
            let ratio = apart(&rolled(&set.secrets), &rolled(&Secrets::NONE)) / NOISE_RAD;
            assert!((ratio - 10.0).abs() < 0.6, "{name}: {ratio}");
            let Surviving { rms, sigma } = set.surviving;
            assert!(rms > 0.1 && rms < 10.0 && sigma > 3.0 * rms, "{name}: {rms} {sigma}");
        }
    }

    #[test]
    fn noise_has_its_size_and_its_correlation() {
        let noise = measured(vec![0.0; 20_000], &mut stream("test", 1, "noise", 0));
        let square = |lag: usize| noise.iter().zip(&noise[lag..]).map(|(a, b)| a * b).sum::<f64>() / noise.len() as f64;
        assert!((square(0).sqrt() / NOISE_RAD - 1.0).abs() < 0.03, "{}", square(0).sqrt());
        assert!((square(1) / square(0) - KEPT).abs() < 0.03);
        assert!(noise.iter().all(|v| (v / ENCODER_RAD - (v / ENCODER_RAD).round()).abs() < 1e-9));
    }

    #[test]
    fn runs_differ_in_gain_and_load_and_those_held_out_from_the_fitted() {
        let runs = runs(&mut stream("test", 1, "runs", 0));
        assert_eq!(runs.len(), 2 * FITTED);
        for (i, one) in runs.iter().enumerate() {
            let load = |run: &Run| (run.mass_kg, run.length_m);
            assert!(runs[..i].iter().all(|other| other.kp != one.kp && load(other) != load(one)));
            assert_eq!(one.clock.len(), SAMPLES);
        }
        assert!(runs[1].kp >= STEP_GAIN && runs[4].kp >= STEP_GAIN);
        assert_eq!(runs[2].off_s(), runs[2].clock[200]);
    }

    #[test]
    fn equal_words_draw_equal_sets() {
        let draw = || JointSet::draw(None, &mut stream("test", 3, "a", 0)).unwrap().measured;
        assert_eq!(draw(), draw());
    }

    #[test]
    fn another_motor_is_tuned_away_and_a_delay_is_not() {
        let set = JointSet::draw(None, &mut stream("test", 1, "surviving", 0)).unwrap();
        let runs = &set.runs[..3];
        let truth: Vec<f64> = runs.iter().flat_map(|run| positions(&set.motor, &Secrets::NONE, run, 2.5e-4)).collect();
        let plain = |numbers: [f64; NUMBERS]| -> Vec<f64> {
            runs.iter().flat_map(|run| positions(&Motor::of(numbers), &Secrets::NONE, run, 2.5e-4)).collect()
        };
        let size = |left: Vec<f64>| apart(&left, &vec![0.0; left.len()]);
        assert!(size(fitted(Motor::CENTRE.numbers(), &truth, &plain)) < 0.1 * NOISE_RAD);
        let late = Secrets { command_delay_s: 0.02, ..Secrets::NONE };
        assert!(size(surviving(&set.motor, &late, runs, 2.5e-4)) > 3.0 * NOISE_RAD);
    }
}
