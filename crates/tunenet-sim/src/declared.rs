//! What a simulation file declares itself, as core and the simulators take it: channels, inputs, initial states and candidates.

use std::borrow::Cow;

use tunenet_core::observation::Channel;
use tunenet_core::simulator::{Coefficient, Declared, Effect, Model, StartState, StartValue};
use tunenet_core::text::visible;
use tunenet_formats::{Error, Result};

use crate::scene::{Candidate, CandidateCoefficient, First, Hold, Start};
use crate::{SimulationFile, phase, scene};

/// An input.
#[derive(Debug, Clone)]
pub(crate) struct DeclaredInput {
    pub name: String,
    pub unit: String,
    pub hold: Hold,
}

/// The channels that `file` predicts, in its order; none of a ball or an arm.
///
/// # Errors
/// [`Error::File`] where a name has no unit, which reading the file refuses already.
pub fn channels(file: &SimulationFile) -> Result<Vec<Channel>> {
    let one = |header: &String| {
        Channel::from_header(header).ok_or_else(|| {
            let message = format!("channels: expected names with their units, found `{}`", visible(header));
            Error::file(file.path(), message, "write \"z_m\" or \"angle_rad\"")
        })
    };
    file.headers().iter().map(one).collect()
}

/// The inputs, in the order of the file.
pub(crate) fn inputs(file: &SimulationFile) -> Result<Vec<DeclaredInput>> {
    let one = |(name, input): (&str, &scene::Input)| {
        let channel = input.channel(name).ok_or_else(|| {
            let message = format!("`inputs.{name}`: expected a name that ends in its unit, or `unit`, found neither");
            Error::file(file.path(), message, "write the unit, for example `unit = \"N\"`")
        })?;
        Ok(DeclaredInput { name: name.to_owned(), unit: channel.unit, hold: input.hold })
    };
    file.inputs().map(one).collect()
}

/// The candidates as entries of a catalogue, in the order of the file.
pub(crate) fn candidates(file: &SimulationFile) -> Vec<Effect> {
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
        typical: c.typical(false),
        number: None,
        shape: false,
        channels: None,
    };
    let coefficients = candidate.coefficients.iter().map(one).collect();
    Effect {
        plausible: candidate.coefficients.values().map(|c| c.plausible.unwrap_or((c.min, c.max))).collect(),
        mistaken_for: candidate.mistaken_for.iter().map(|name| own(name)).collect(),
        ..Effect::new(own(name), phase::parse(&candidate.acts), own(&candidate.sentence), coefficients)
    }
}

/// The coefficients of all candidates that the file has, or their absent values.
pub(crate) fn present(file: &SimulationFile) -> Vec<f64> {
    let known = file.effects();
    let each = file.candidates().flat_map(|(name, candidate)| {
        let values = known.iter().find(|effect| effect.name == name).map(|effect| effect.values.clone());
        values.unwrap_or_else(|| candidate.coefficients.values().map(|c| candidate.absent(c)).collect())
    });
    each.collect()
}

/// The initial states of a setup.
pub(crate) fn states(file: &SimulationFile) -> Result<Vec<StartState>> {
    let channels = file.headers();
    let one = |(name, start): (&str, &Start)| {
        let said = file.equations().ok().and_then(|scene| scene.states.get(name)?.unit.clone());
        let unit = said.or_else(|| Channel::from_header(name).map(|c| c.unit)).unwrap_or_else(|| "1".into());
        let value = match start.value {
            scene::StartValue::Number(value) => StartValue::Number(value),
            scene::StartValue::Word(First::First) => {
                let at = channels.iter().position(|header| header == name).ok_or_else(|| {
                    let message = format!("`start.{name}`: expected a channel of that name, found none");
                    Error::file(file.path(), message, "write a number, or let the file predict that channel")
                })?;
                StartValue::First(at)
            }
        };
        let mut state = StartState::new(name, unit, value);
        state.sd = start.sd;
        state.rate_of = rate_of(file, name);
        state.bounds = start.min.zip(start.max);
        Ok(state)
    };
    file.starts().map(one).collect()
}

/// The channel of which a state of equations is the rate: its name is all of the derivative of a state that is observed as it is.
fn rate_of(file: &SimulationFile, name: &str) -> Option<usize> {
    let scene = file.equations().ok()?;
    let (observed, _) = scene.derivatives.iter().find(|(_, formula)| formula.trim() == name)?;
    shown_by(file, observed)
}

/// The channel that shows a state of equations as it is: its output is nothing but the state.
#[must_use]
pub fn shown_by(file: &SimulationFile, name: &str) -> Option<usize> {
    let scene = file.equations().ok()?;
    let as_it_is = scene.outputs.is_empty() || scene.outputs.get(name).is_some_and(|formula| formula.trim() == name);
    file.headers().iter().position(|header| header == name).filter(|_| as_it_is)
}

/// The states of equations that are estimated in every recording and begin where its first samples show them, apart from those whose value is
/// the first sample; none of a file of another kind.
#[must_use]
pub fn shown_states(file: &SimulationFile) -> Vec<&str> {
    let is_first = |start: &Start| matches!(start.value, scene::StartValue::Word(First::First));
    let free = file.starts().filter(|(_, start)| (start.sd.is_some() || start.min.is_some()) && !is_first(start));
    free.map(|(name, _)| name).filter(|name| shown_by(file, name).or_else(|| rate_of(file, name)).is_some()).collect()
}

/// `simulator` with the candidates of `file`: those that it has at the values that it says, the others absent.
pub(crate) fn with_candidates<M: Model>(mut simulator: Declared<M>, file: &SimulationFile) -> Result<Declared<M>> {
    let present = file.effects();
    for effect in candidates(file) {
        simulator = match present.iter().find(|one| one.name == effect.name) {
            Some(one) => simulator.present(effect, &one.values)?,
            None => simulator.candidate(effect),
        };
    }
    Ok(simulator)
}

/// Refuses a scale of lengths where no channel is a length.
pub(crate) fn refuse_scale_without_lengths(file: &SimulationFile, channels: &[Channel]) -> Result<()> {
    let lengths = channels.iter().any(|channel| channel.unit == "m");
    if lengths || file.effects().iter().all(|effect| effect.name != "length_scale") {
        return Ok(());
    }
    let message = "expected a channel in m besides [effects.length_scale], found none";
    Err(Error::file(file.path(), message, "remove the effect: it applies only to lengths"))
}
