//! The training set: every pair of a data set, encoded as network input.

use std::ops::Range;

use super::dataset::{CoveredParameter, DataSet, DatasetHeader, Pair};
use super::input::Input;
use super::preset::{InputChoice, Preset};
use super::rows::{Rollout, Room, Rows};
use crate::{Error, Result};

/// All rollouts of a dataset, encoded. Pair `i` is rollouts `2 i` (proposed) and `2 i + 1` (target).
pub(super) struct TrainingSet<'a> {
    pub(super) header: DatasetHeader,
    pub(super) input: Input,
    /// What it sees of a target, where that is observed otherwise.
    pub(super) target: Option<Input>,
    /// The tuned parameters.
    pub(super) parameters: Vec<CoveredParameter>,
    pub(super) rollouts: Rows<'a>,
    /// The most that a proposed rollout covers of its row.
    pub(super) longest: usize,
    /// Whether any rollout can be paired with any other.
    pub(super) mixable: bool,
}

impl<'a> TrainingSet<'a> {
    /// Goes through `data` once or twice, as `preset` needs.
    pub(super) fn gather(data: &dyn DataSet, preset: &Preset, room: Room<'a>) -> Result<Self> {
        let header = data.header().clone();
        let tuned: Vec<usize> = (0..header.parameters.len()).filter(|&i| header.parameters[i].tuned).collect();
        let parameters: Vec<CoveredParameter> = tuned.iter().map(|&i| header.parameters[i].clone()).collect();
        if parameters.is_empty() {
            return Err(refuse("at least one parameter to learn", "none", ""));
        }
        if let Some(p) = parameters.iter().find(|p| p.span() <= 0.0 || !p.span().is_finite()) {
            return Err(refuse(format!("a range for `{}`", p.name), format!("{} to {}", p.min, p.max), ""));
        }
        let (input, target) = fit_inputs(data, preset)?;
        let rollouts = Rows::new(parameters.len(), input.width(), room);
        let mut set = Self { header, input, target, parameters, rollouts, longest: 0, mixable: true };
        let (mut own, mut differ): (Option<Vec<f64>>, bool) = (None, false);
        for pair in data.pairs()? {
            let pair = pair?;
            differ |= set.push(&pair, &tuned)?;
            set.mixable &= own.get_or_insert_with(|| pair.own.clone()) == &pair.own;
        }
        set.rollouts.finish()?;
        // In units of its own scale a rollout no longer depends on its height.
        set.mixable |= matches!(set.input, Input::Dimensionless { .. });
        if set.pairs() == 0 {
            return Err(refuse("at least one pair", "none", ""));
        }
        if !differ {
            let names: Vec<String> = set.parameters.iter().map(|p| format!("`{}`", p.name)).collect();
            let expected = format!("rollouts that differ with {}", names.join(", "));
            return Err(refuse(expected, "none that do", "learn parameters that change what is observed"));
        }
        Ok(set)
    }

    /// Appends a pair; says whether its two rollouts differ.
    fn push(&mut self, pair: &Pair, tuned: &[usize]) -> Result<bool> {
        let header = &self.header;
        let target = self.target.as_ref().unwrap_or(&self.input);
        let encode = |input: &Input, channels: usize, values: &[f64], all: &[f64]| -> Result<Rollout> {
            let seen = input.encode(header.clock_of(pair), values, channels, pair.scale.as_ref())?;
            Ok(Rollout {
                covered: seen.covered,
                normalised: tuned.iter().zip(&self.parameters).map(|(&i, p)| (all[i] - p.min) / p.span()).collect(),
                row: seen.values.iter().map(|v| super::numbers::single(*v)).collect(),
            })
        };
        let proposed = encode(&self.input, header.channels.len(), &pair.proposed, &pair.proposed_parameters)?;
        let target = encode(target, header.seen_channels().len(), &pair.target, &pair.target_parameters)?;
        self.longest = self.longest.max(proposed.covered.len());
        self.rollouts.push(&proposed)?;
        self.rollouts.push(&target)?;
        Ok(proposed.row != target.row)
    }

    /// How many pairs.
    pub(super) fn pairs(&self) -> usize {
        self.rollouts.len() / 2
    }
}

/// What both rollouts cover.
pub(super) fn common(a: &Rollout, b: &Rollout) -> Range<usize> {
    let start = a.covered.start.max(b.covered.start);
    start..a.covered.end.min(b.covered.end).max(start)
}

/// A data set that cannot be learned from.
fn refuse(expected: impl Into<String>, found: impl Into<String>, remedy: &'static str) -> Error {
    Error::Dataset { expected: expected.into(), found: found.into(), remedy }
}

/// What the network is to see of a proposed rollout, and of a target where that is observed otherwise.
fn fit_inputs(data: &dyn DataSet, preset: &Preset) -> Result<(Input, Option<Input>)> {
    let header = data.header();
    if header.target_channels.is_empty() {
        return Ok((fit_input(data, preset)?, None));
    }
    // The last channel on either side: a body's height, and `v` in its picture.
    let (z, v) = (header.channels.len().saturating_sub(1), header.target_channels.len() - 1);
    match &preset.input {
        InputChoice::Raw { channel: None } if !header.clocks_in_pairs() => {
            let [proposed, target] = bounds(data)?;
            let samples = header.clock.len();
            let raw = |channel: usize, (low, high): (f64, f64)| Input::Raw { channel, samples, low, high };
            Ok((raw(z, proposed[z]), Some(raw(v, target[v]))))
        }
        InputChoice::Dimensionless { channel: None, bins, tau_max } => {
            let (bins, tau_max) = (*bins, *tau_max);
            let seen = Input::Pixels { channel: v, bins, tau_max };
            Ok((Input::Dimensionless { channel: z, bins, tau_max }, Some(seen)))
        }
        _ => {
            let expected = "a preset that sees heights on both sides";
            Err(refuse(expected, "targets that are pictures", "train with preset `default` or `paper`"))
        }
    }
}

/// The least and the greatest value of every channel, of the proposed rollouts and of the targets.
fn bounds(data: &dyn DataSet) -> Result<[Vec<(f64, f64)>; 2]> {
    let header = data.header();
    let mut bounds =
        [header.channels.len(), header.seen_channels().len()].map(|n| vec![(f64::INFINITY, f64::NEG_INFINITY); n]);
    for pair in data.pairs()? {
        let pair = pair?;
        for (bounds, values) in bounds.iter_mut().zip([&pair.proposed, &pair.target]) {
            for sample in values.chunks_exact(bounds.len().max(1)) {
                for ((low, high), value) in bounds.iter_mut().zip(sample) {
                    (*low, *high) = (low.min(*value), high.max(*value));
                }
            }
        }
    }
    Ok(bounds)
}

/// Bounds that hold all of these.
fn around<'a>(all: impl Iterator<Item = &'a (f64, f64)>) -> (f64, f64) {
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), b| (low.min(b.0), high.max(b.1)))
}

/// Raw samples mean something only on one clock.
fn clocks_differ() -> Error {
    refuse("one clock for all pairs", "one in each: raw samples cannot be compared", "train with another preset")
}

/// The network's input, with what must be computed from the data first.
fn fit_input(data: &dyn DataSet, preset: &Preset) -> Result<Input> {
    let header = data.header();
    let find = |name: &Option<String>| match name {
        None => Ok(header.channels.len().saturating_sub(1)),
        Some(name) => header.channels.iter().position(|c| c.name == *name).ok_or_else(|| {
            let found: Vec<&str> = header.channels.iter().map(|c| c.name.as_str()).collect();
            refuse(format!("a channel `{name}`"), found.join(", "), "")
        }),
    };
    match &preset.input {
        InputChoice::Raw { channel } => {
            let channel = find(channel)?;
            if header.clocks_in_pairs() {
                return Err(clocks_differ());
            }
            let (low, high) = around(bounds(data)?.iter().map(|side| &side[channel]));
            Ok(Input::Raw { channel, samples: header.clock.len(), low, high })
        }
        InputChoice::Dimensionless { channel, bins, tau_max } => {
            let first = data.pairs()?.next().transpose()?;
            if first.is_some_and(|pair| pair.scale.is_some()) {
                return Ok(Input::Dimensionless { channel: find(channel)?, bins: *bins, tau_max: *tau_max });
            }
            standardised(data, *bins)
        }
        InputChoice::Scaled { bins, tau_max } => scaled(data, *bins, *tau_max),
        InputChoice::Standardised { bins } => standardised(data, *bins),
        InputChoice::Recorded => {
            if header.clocks_in_pairs() {
                return Err(clocks_differ());
            }
            let (channels, samples) = (header.channels.len(), header.clock.len());
            let (low, high) = around(bounds(data)?.iter().flatten());
            Ok(Input::Recorded { channels, samples, low, high })
        }
        InputChoice::Balanced { bins } => balanced(data, *bins),
    }
}

/// Every channel less its mean, in units of one spread: the root mean square of those of all channels.
fn balanced(data: &dyn DataSet, bins: usize) -> Result<Input> {
    let Input::Standardised { bins, mean, sd } = standardised(data, bins)? else { unreachable!("as asked") };
    let together = (sd.iter().map(|s| s * s).sum::<f64>() / sd.len() as f64).sqrt();
    Ok(Input::Standardised { bins, mean, sd: vec![together; sd.len()] })
}

/// Every channel in the recording's own units, its root mean square over the training set brought to 1.
fn scaled(data: &dyn DataSet, bins: usize, tau_max: f64) -> Result<Input> {
    let header = data.header();
    let channels = header.channels.len();
    let plain = Input::Scaled { bins, tau_max, unit: vec![1.0; channels] };
    let (mut squares, mut count) = (vec![0.0; channels], 0.0);
    for pair in data.pairs()? {
        let pair = pair?;
        let seen = plain.encode(header.clock_of(&pair), &pair.proposed, channels, pair.scale.as_ref())?;
        for (i, value) in seen.values.iter().enumerate() {
            squares[i % channels] += value * value;
        }
        count += seen.covered.len() as f64 / channels as f64;
    }
    // A channel that never changes says nothing: any unit keeps it at 0.
    let unit = |s: &f64| if *s > 1e-12 * count { (s / f64::max(count, 1.0)).sqrt() } else { 1.0 };
    Ok(Input::Scaled { bins, tau_max, unit: squares.iter().map(unit).collect() })
}

fn standardised(data: &dyn DataSet, bins: usize) -> Result<Input> {
    let channels = data.header().channels.len();
    // Welford's running mean and sum of squares: no loss of digits where the mean is far from 0.
    let (mut mean, mut squares, mut count) = (vec![0.0; channels], vec![0.0; channels], 0.0);
    for pair in data.pairs()? {
        let pair = pair?;
        for row in pair.proposed.chunks_exact(channels).chain(pair.target.chunks_exact(channels)) {
            count += 1.0;
            for ((value, mean), squares) in row.iter().zip(&mut mean).zip(&mut squares) {
                let off: f64 = value - *mean;
                *mean += off / count;
                *squares += off * (value - *mean);
            }
        }
    }
    // A channel that never changes says nothing: any spread keeps it at 0.
    let spread = |s: &f64| if *s > 0.0 { (s / f64::max(count, 1.0)).sqrt() } else { 1.0 };
    Ok(Input::Standardised { bins, sd: squares.iter().map(spread).collect(), mean })
}
