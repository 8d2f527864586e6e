//! Named effects of a ball against what no catalogue holds.

use tunenet_core::diagnose::{Diagnosis, Doubt, Fitted, Gap, Verdict};
use tunenet_core::law::{Contest, Host, MOST_FORCE_NATS, Point, Settings, contest, strongest};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Effect, Preparation, Prepared};
use tunenet_core::statistics::evenly;
use tunenet_formats::Result;

use super::known;
use crate::SimulationFile;
use crate::simulation_file::Domain;

/// Of more recordings than this, residual tests alone distinguish an effect that has coefficients from what is in no catalogue.
const MOST_RECORDINGS: usize = 10;
/// What a doubt kept from being named has to explain the recordings better than anything in no catalogue by so many times the margin.
const CLEAR: f64 = 3.0;
/// A force of a few numbers that explains so large a share of what the draws of a random effect explain is as good: draws follow anything that
/// happens once in a while. In 24 of 25 blind sets of true scatter (3 drops and more) the best force has 0.86 of it at most, in 15 sets with a push
/// of 0.1 s 0.98 and more.
const OF_DRAWS: f64 = 0.9;
/// Over 600 blind sets 99 % of the right names leave of held-out recordings no more than so many times what they leave of those that were fitted.
const BORNE_OUT: f64 = 1.09;

/// `diagnosis` of these recordings by the simulation of `file`, its names in doubt where something in no catalogue explains as much, or where
/// they leave a force; and without the doubt that few recordings show them, where nothing does by far. Effects that are physically required exist in
/// any case: they stay as they are, and so does what names no effect or is no ball whose positions recordings show. Of many recordings only
/// random effects are compared, in some of them.
#[must_use]
pub fn contested(file: &SimulationFile, diagnosis: Diagnosis, recordings: &[&Observation]) -> Diagnosis {
    let seen: Vec<&Observation> = recordings
        .iter()
        .zip(&diagnosis.uses)
        .filter(|(_, used)| used.used && !used.held_out)
        .map(|(seen, _)| *seen)
        .collect();
    let effects: Vec<Effect> = diagnosis.effects().iter().map(|named| named.effect.clone()).collect();
    let are_required = effects.iter().all(Effect::required);
    let is_declared = effects.iter().any(|effect| file.candidate(&effect.name).is_some());
    let is_one = diagnosis.explained.iter().all(|one| one.object == 0);
    let is_ball = file.domain() == Domain::Ball && seen.iter().all(|one| one.kind() == Kind::Positions);
    let is_open = diagnosis.conclusion.doubt() == Some(&Doubt::ForecastHardlyBetter);
    let is_comparable = is_one && is_ball && !seen.is_empty() && !are_required && !is_declared;
    if !is_comparable || !(diagnosis.verdict() == Verdict::Named || is_open) {
        return diagnosis;
    }
    let of = Compared { file, diagnosis: &diagnosis, effects: &effects, seen: &seen };
    // Where these effects cannot be fitted next to a force, nothing is said of them.
    let (Ok(Some(found)), Ok(Some(drawn))) = (of.coefficients(), of.draws()) else { return diagnosis };
    let rollouts = diagnosis.rollouts + found.rollouts + drawn.rollouts;
    let diagnosis = Diagnosis { rollouts, ..diagnosis };
    let margin = Settings::default().margin;
    let is_behind = |by: f64| found.ahead.into_iter().chain(drawn.ahead).all(|ahead| ahead < -by);
    if found.left_force_nats > MOST_FORCE_NATS || !is_behind(margin) {
        diagnosis.doubted(Doubt::InNoCatalogue)
    } else if found.compared == effects.len() && is_behind(CLEAR * margin) && is_borne_out(&diagnosis) {
        diagnosis.undoubted(&Doubt::ForecastHardlyBetter)
    } else {
        diagnosis
    }
}

/// What is compared.
struct Compared<'a> {
    file: &'a SimulationFile,
    diagnosis: &'a Diagnosis,
    effects: &'a [Effect],
    /// The recordings that were fitted.
    seen: &'a [&'a Observation],
}

/// A host, the recordings as it prepares them, and where a fit of all of them begins, if the diagnosis says so.
type Placed = (Box<dyn Host>, Vec<Prepared>, Option<Point>);

/// What the comparison without random effects says of them.
#[derive(Default)]
struct Drawn {
    /// How far something in no catalogue surpasses [`OF_DRAWS`] of what one of them explains, at most, in twice the logarithmic likelihood.
    ahead: Option<f64>,
    rollouts: usize,
}

impl Compared<'_> {
    /// The comparison of effects that have coefficients; `None` where the simulation has no place for a force next to them, or refuses a recording.
    /// Random effects have none.
    fn coefficients(&self) -> Result<Option<Contest>> {
        if self.seen.len() > MOST_RECORDINGS || self.effects.iter().all(|effect| effect.random) {
            return Ok(Some(Contest { left_force_nats: 0.0, ahead: None, compared: 0, rollouts: 0 }));
        }
        let names: Vec<&str> = self.effects.iter().map(|effect| effect.name.as_ref()).collect();
        let Some((host, prepared, known)) = self.placed(&names, self.seen)? else { return Ok(None) };
        Ok(Some(contest(host.as_ref(), self.effects, &prepared, known.as_ref())?))
    }

    /// The comparison of random effects, without them: their draws would take up what a force explains.
    fn draws(&self) -> Result<Option<Drawn>> {
        let sample: Vec<&Observation> =
            evenly(self.seen.len(), MOST_RECORDINGS).into_iter().map(|one| self.seen[one]).collect();
        let share = sample.len() as f64 / self.seen.len() as f64;
        let mut drawn = Drawn::default();
        // What an effect gains, it gains in addition to those that were found before it.
        let names: Vec<&str> = self.effects.iter().map(|effect| effect.name.as_ref()).collect();
        for (at, random) in self.diagnosis.effects().iter().enumerate().filter(|(_, named)| named.effect.random) {
            let Some((host, prepared, known)) = self.placed(&names[..at], &sample)? else { return Ok(None) };
            let strongest = strongest(host.as_ref(), &prepared, known.as_ref())?;
            let ahead = strongest.bic_gain.map(|gain| gain - OF_DRAWS * share * random.evidence.bic_gain);
            drawn.ahead = drawn.ahead.into_iter().chain(ahead).reduce(f64::max);
            drawn.rollouts += strongest.rollouts;
        }
        Ok(Some(drawn))
    }

    /// A host in which these effects of the diagnosis are free, with recordings; `None` where it has no place for a force next to them, or refuses
    /// a recording.
    fn placed(&self, names: &[&str], seen: &[&Observation]) -> Result<Option<Placed>> {
        let file = with_effects(self.file, self.diagnosis, names)?;
        let Ok(host) = super::host(&[&file], Kind::Positions, names)? else { return Ok(None) };
        let simulator = host.carrying(&[])?;
        let mut prepared: Vec<Prepared> = Vec::new();
        for one in seen {
            let Preparation::Usable(usable) = simulator.prepare(one)? else { return Ok(None) };
            prepared.push(*usable);
        }
        let known = known(self.diagnosis, simulator.parameters(), &prepared);
        Ok(Some((host, prepared, known)))
    }
}

/// The file with the tuned parameters and those effects of a diagnosis that `names` has.
fn with_effects(file: &SimulationFile, diagnosis: &Diagnosis, names: &[&str]) -> Result<SimulationFile> {
    let mut file = file.clone();
    let is_left_out =
        |effect: &str| diagnosis.effects().iter().any(|named| named.effect.name == effect && !names.contains(&effect));
    for tuned in &diagnosis.parameters {
        // A coefficient of an effect that the file has already bears both names.
        match tuned.name.split_once('.') {
            Some((effect, _)) if is_left_out(effect) => {}
            Some((effect, key)) => file.add_effect(effect, &[(key, tuned.value)])?,
            None => file.set_value(&tuned.name, tuned.value),
        }
    }
    for named in diagnosis.effects().iter().filter(|named| names.contains(&named.effect.name.as_ref())) {
        let value = |fitted: &Fitted| Some((fitted.key.clone(), fitted.values.first()?.value));
        let values: Vec<_> = named.coefficients.iter().filter_map(value).collect();
        let values: Vec<(&str, f64)> = values.iter().map(|(key, value)| (key.as_ref(), *value)).collect();
        file.add_effect(&named.effect.name, &values)?;
    }
    Ok(file)
}

/// Whether held-out recordings are explained as those that were fitted.
fn is_borne_out(diagnosis: &Diagnosis) -> bool {
    let of = |gap: &Gap| Some(gap.held_out?.after <= BORNE_OUT * gap.after);
    diagnosis.gap.as_ref().and_then(of) == Some(true)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;
    use crate::law::host;

    const NOISE_M: f64 = 2e-3;
    const GRAVITY_M_S2: f64 = 9.81;
    const SCENE: &str = "\
kind = \"ball\"
ball.radius_m = 0.02

[parameters.restitution]
value = 0.8
min = 0.0
max = 1.0
";

    /// A flight of 0.7 s that does not reach the floor, from `z` (m) and upwards with `vz` (m/s), pushed sideways by wind · (1 + shear · z).
    fn flight(seed: u64, (z, vz): (f64, f64), (wind_m_s2, shear_1_m): (f64, f64)) -> Observation {
        let at = |t: f64| {
            let height = z + vz * t - 0.5 * GRAVITY_M_S2 * t * t;
            // The double integral of the height.
            let twice = z * t.powi(2) / 2.0 + vz * t.powi(3) / 6.0 - GRAVITY_M_S2 * t.powi(4) / 24.0;
            [0.5 * t + wind_m_s2 * (0.5 * t * t + shear_1_m * twice), 0.3 * t, height]
        };
        noisy(seed, &at)
    }

    /// A flight of 0.7 s at 1.5 m/s along the floor, which a constant force along it brakes (m/s²), heading `turn_rad`.
    fn braked(seed: u64, turn_rad: f64, brake_m_s2: f64) -> Observation {
        noisy(seed, &|t| {
            let along = 1.5 * t - 0.5 * brake_m_s2 * t * t;
            [along * turn_rad.cos(), along * turn_rad.sin(), 5.0 + t - 0.5 * GRAVITY_M_S2 * t * t]
        })
    }

    fn noisy(seed: u64, at: &dyn Fn(f64) -> [f64; 3]) -> Observation {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let clock: Vec<f64> = (0..84_u32).map(|k| f64::from(k) / 120.0).collect();
        let rows: Vec<[f64; 3]> =
            clock.iter().map(|t| at(*t).map(|x| x + NOISE_M * draw.sample::<f64, _>(StandardNormal))).collect();
        Observation::positions(clock, &rows).unwrap()
    }

    /// Of one effect at these values.
    fn contest_of(name: &str, values: &str, seen: &[Observation]) -> Contest {
        let with = SimulationFile::parse(Path::new("flight.toml"), &format!("{SCENE}\n[effects.{name}]\n{values}"));
        let host = host(&[&with.unwrap()], Kind::Positions, &[name]).unwrap().unwrap();
        let simulator = host.carrying(&[]).unwrap();
        let prepared = |one: &Observation| match simulator.prepare(one).unwrap() {
            Preparation::Usable(prepared) => *prepared,
            Preparation::Rejected(rejected) => panic!("{:?}", rejected.note),
        };
        let recordings: Vec<Prepared> = seen.iter().map(prepared).collect();
        let without = SimulationFile::parse(Path::new("flight.toml"), SCENE).unwrap();
        let all =
            crate::law::host(&[&without], Kind::Positions, &[]).unwrap().unwrap().carrying(&[]).unwrap().effects();
        let named: Vec<Effect> = all.into_iter().filter(|effect| effect.name == name).collect();
        contest(host.as_ref(), &named, &recordings, None).unwrap()
    }

    #[test]
    fn a_wind_that_grows_with_height_is_not_left_to_a_steady_wind() {
        let contest_of = |truth: (f64, f64)| {
            let starts = [(5.0, 1.0), (3.0, 0.0), (8.0, -1.0)];
            let seen: Vec<Observation> =
                starts.into_iter().zip(7..).map(|(start, seed)| flight(seed, start, truth)).collect();
            contest_of("wind", "ax_m_s2 = 0.2\nay_m_s2 = 0.0", &seen)
        };
        let steady = contest_of((0.5, 0.0));
        assert!(steady.ahead.is_some_and(|ahead| ahead < -Settings::default().margin), "{steady:?}");
        assert!(steady.left_force_nats < 1.0 && steady.compared == 1, "{steady:?}");
        let sheared = contest_of((0.1, 1.0));
        assert!(sheared.ahead.is_some_and(|ahead| ahead > 0.0), "{sheared:?}");
    }

    /// A wind that turns about the origin, ẅ = i k w of w = x + i y: w(t) = w0 cosh λt + w'0 sinh(λt)/λ with λ = (1 + i) √(k/2).
    fn turning(seed: u64, [x, y]: [f64; 2], [u, v]: [f64; 2], k_1_s2: f64) -> Observation {
        let rate = (k_1_s2 / 2.0).sqrt();
        noisy(seed, &|t| {
            let (a, (sin, cos)) = (rate * t, (rate * t).sin_cos());
            let (even, odd) = ([a.cosh() * cos, a.sinh() * sin], [a.sinh() * cos, a.cosh() * sin]);
            // Division by (1 + i) √(k/2).
            let odd = [(odd[0] + odd[1]) / (2.0 * rate), (odd[1] - odd[0]) / (2.0 * rate)];
            let along = |[p, q]: [f64; 2]| x * p - y * q;
            let across = |[p, q]: [f64; 2]| x * q + y * p;
            let moved = [u * odd[0] - v * odd[1], u * odd[1] + v * odd[0]];
            [along(even) + moved[0], across(even) + moved[1], 5.0 + t - 0.5 * GRAVITY_M_S2 * t * t]
        })
    }

    #[test]
    fn a_wind_that_turns_about_a_place_is_not_left_to_a_spin() {
        let starts = [([0.5, 0.1], [0.9, 0.2]), ([-0.3, 0.4], [0.4, -0.9]), ([0.1, -0.6], [-0.6, 0.5])];
        let seen: Vec<Observation> =
            starts.into_iter().zip(7..).map(|((at, way), seed)| turning(seed, at, way, 0.8)).collect();
        let found = contest_of("magnus", "sx_1_s = 0.1\nsy_1_s = 0.0\nsz_1_s = 0.0", &seen);
        assert!(found.ahead.is_some_and(|ahead| ahead > 0.0), "{found:?}");
    }

    #[test]
    fn a_constant_brake_along_the_floor_is_not_left_to_drag() {
        let seen = [(0.3, 7), (2.4, 8), (4.5, 9)].map(|(turn, seed)| braked(seed, turn, 0.5));
        let found = contest_of("linear_drag", "b_1_s = 0.1", &seen);
        assert!(found.ahead.is_some_and(|ahead| ahead > 0.0), "{found:?}");
    }
}
