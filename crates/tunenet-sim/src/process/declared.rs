//! What a simulation file declares, as core and the program take it.

use std::borrow::Cow;

use tunenet_core::simulator::{Coefficient, Effect, StartState, StartValue};
use tunenet_formats::{Error, Result};

use crate::scene::{Candidate, CandidateCoefficient, First, Hold, Start};
use crate::{SimulationFile, phase, scene};

/// An input, as it is announced to the program.
#[derive(Debug, Clone)]
pub(super) struct ProgramInput {
    pub name: String,
    pub unit: String,
    pub hold: Hold,
}

/// The inputs, in the order of the file.
pub(super) fn inputs(file: &SimulationFile) -> Result<Vec<ProgramInput>> {
    let one = |(name, input): (&str, &scene::Input)| {
        let channel = input.channel(name).ok_or_else(|| {
            let message = format!("`inputs.{name}`: expected a name that ends in its unit, or `unit`, found neither");
            Error::file(file.path(), message, "write the unit, for example `unit = \"N\"`")
        })?;
        Ok(ProgramInput { name: name.to_owned(), unit: channel.unit, hold: input.hold })
    };
    file.inputs().map(one).collect()
}

/// The candidates as entries of a catalogue, in the order of the file.
pub(super) fn candidates(file: &SimulationFile) -> Vec<Effect> {
    file.candidates().map(|(name, candidate)| effect(name, candidate)).collect()
}

fn effect(name: &str, candidate: &Candidate) -> Effect {
    let own = |text: &str| Cow::Owned(text.to_owned());
    let one = |(key, c): (&String, &CandidateCoefficient)| Coefficient {
        key: own(key),
        unit: own(&c.unit),
        absent: candidate.absent(c),
        min: c.min,
        max: c.max,
        typical: c.typical.unwrap_or(c.max - c.min),
        number: None,
        shape: false,
    };
    Effect {
        name: own(name),
        phase: phase::parse(&candidate.acts),
        coefficients: candidate.coefficients.iter().map(one).collect(),
        plausible: candidate.coefficients.values().map(|c| c.plausible.unwrap_or((c.min, c.max))).collect(),
        plausible_rests_on: Vec::new(),
        sentence: own(&candidate.sentence),
        random: false,
        mistaken_for: candidate.mistaken_for.iter().map(|name| own(name)).collect(),
        implausible: None,
        feigned_by: None,
        forecast_share: 1.0,
    }
}

/// The coefficients of all candidates that the file has, or their absent values.
pub(super) fn present(file: &SimulationFile) -> Vec<f64> {
    let known = file.effects();
    let each = file.candidates().flat_map(|(name, candidate)| {
        let values = known.iter().find(|effect| effect.name == name).map(|effect| effect.values.clone());
        values.unwrap_or_else(|| candidate.coefficients.values().map(|c| candidate.absent(c)).collect())
    });
    each.collect()
}

/// The initial states of a setup.
pub(super) fn states(file: &SimulationFile) -> Result<Vec<StartState>> {
    let channels = file.process()?.channels.clone();
    let one = |(name, start): (&str, &Start)| {
        let unit = tunenet_core::observation::Channel::from_header(name).map_or_else(|| "1".into(), |c| c.unit);
        let value = match start.value {
            scene::StartValue::Number(value) => StartValue::Number(value),
            scene::StartValue::Word(First::First) => {
                let at = channels.iter().position(|header| header == name).ok_or_else(|| {
                    let message = format!("`start.{name}`: expected a channel of that name, found none");
                    Error::file(file.path(), message, "write a number, or name the channel under `process.channels`")
                })?;
                StartValue::First(at)
            }
        };
        let mut state = StartState::new(name, unit, value);
        state.sd = start.sd;
        state.bounds = start.min.zip(start.max);
        Ok(state)
    };
    file.starts().map(one).collect()
}
