//! The pairs of a data set: drawn, checked and rolled out.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::dataset::{DatasetHeader, Pair};
use crate::simulator::Scale;
use crate::simulator::{Simulator, rollout};
use crate::{Error, Origin, Result};

/// Pairs on which each parameter is tried out before any is written.
const PROBES: u64 = 32;

/// What one pair is rolled out with.
#[derive(Debug, Clone, PartialEq)]
pub struct PairDraw {
    /// All parameters of the proposed model, in the simulator's order.
    pub proposed: Vec<f64>,
    /// All parameters of the target.
    pub target: Vec<f64>,
    /// Nuisance parameters that both share.
    pub own: Vec<f64>,
    /// What makes both dimensionless, where the simulator has such a thing.
    pub scale: Option<Scale>,
}

/// What draws pair 0, 1, … from a generator of its own; see [`stream`].
pub type Draw<'a> = dyn Fn(u64, &mut ChaCha8Rng) -> PairDraw + Sync + 'a;

/// Refuses parameters to be learned that change no rollout, since a network would learn to make them up.
///
/// # Errors
/// [`Error::Setting`] for the first such parameter; [`Error::Simulator`] where a rollout fails.
pub fn check_learned(simulator: &dyn Simulator, header: &DatasetHeader, draw: &Draw<'_>) -> Result<()> {
    for i in (0..header.parameters.len()).filter(|&i| header.parameters[i].tuned) {
        if !matters(simulator, header, draw, i)? {
            return Err(Error::Setting {
                origin: Origin::File,
                name: "parameters",
                expected: "parameters to learn that change what is observed".into(),
                found: format!("`{}`, which changes nothing", header.parameters[i].name),
            });
        }
    }
    Ok(())
}

/// Whether parameter `i`, moved alone from the proposed model's value to the target's or to an end of its range, changes
/// any rollout.
fn matters(simulator: &dyn Simulator, header: &DatasetHeader, draw: &Draw<'_>, i: usize) -> Result<bool> {
    for number in 0..PROBES.min(header.pairs) {
        let drawn = draw(number, &mut stream(header.seed, number));
        let seen = rollout(simulator, &drawn.proposed, &drawn.own, &header.clock)?;
        let range = &header.parameters[i];
        for value in [drawn.target[i], range.min, range.max] {
            let mut moved = drawn.proposed.clone();
            moved[i] = value;
            // Values that cannot be simulated are no proof of either.
            if rollout(simulator, &moved, &drawn.own, &header.clock).is_ok_and(|other| other != seen) {
                return Ok(true);
            }
        }
    }
    Ok(header.pairs == 0)
}

/// What pair `number` of a dataset with this seed is drawn from.
#[must_use]
pub fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    random
}

/// A pair as drawn, rolled out on the header's clock.
///
/// # Errors
/// [`Error::Simulator`] where a rollout fails.
pub fn roll_pair(simulator: &dyn Simulator, header: &DatasetHeader, draw: PairDraw) -> Result<Pair> {
    let PairDraw { proposed, target, own, scale } = draw;
    Ok(Pair {
        proposed: rollout(simulator, &proposed, &own, &header.clock)?,
        target: rollout(simulator, &target, &own, &header.clock)?,
        proposed_parameters: proposed,
        target_parameters: target,
        own,
        scale,
        clock: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::CoveredParameter;
    use crate::observation::Channel;
    use crate::simulator::{Parameter, RolloutResult};
    use rand::Rng;

    /// A line whose second parameter is forgotten.
    struct Line(Vec<Parameter>, Vec<Channel>);

    impl Simulator for Line {
        fn parameters(&self) -> &[Parameter] {
            &self.0
        }

        fn channels(&self) -> &[Channel] {
            &self.1
        }

        fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], out: &mut [f64]) -> RolloutResult {
            clock.iter().zip(out).for_each(|(t, v)| *v = p[0] * t);
            Ok(())
        }
    }

    #[test]
    fn a_parameter_that_changes_nothing_is_refused_by_name() {
        let parameter = |name| Parameter::new(name, "1", 0.5, 0.0, 1.0).unwrap();
        let line = Line(vec![parameter("slope"), parameter("colour")], vec![Channel::new("y", "m")]);
        let header = |learned: [bool; 2]| DatasetHeader {
            preset: "line".into(),
            seed: 1,
            pairs: 4,
            parameters: ["slope", "colour"]
                .into_iter()
                .zip(learned)
                .map(|(name, tuned)| CoveredParameter {
                    name: name.into(),
                    unit: "1".into(),
                    min: 0.0,
                    max: 1.0,
                    tuned,
                })
                .collect(),
            channels: line.channels().to_vec(),
            target_channels: Vec::new(),
            clock: (0..20).map(f64::from).collect(),
            scene: String::new(),
        };
        let draw = |_: u64, random: &mut ChaCha8Rng| PairDraw {
            proposed: vec![random.random(), random.random()],
            target: vec![random.random(), random.random()],
            own: Vec::new(),
            scale: None,
        };
        let error = check_learned(&line, &header([true, true]), &draw).unwrap_err().to_string();
        assert!(error.contains("`colour`") && !error.contains("`slope`"), "{error}");
        check_learned(&line, &header([true, false]), &draw).unwrap();
    }
}
