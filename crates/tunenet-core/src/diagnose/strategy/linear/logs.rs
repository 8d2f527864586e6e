//! The recordings of a driven diagnosis, and what simulators say of them.

use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Result;
use crate::diagnose::Use;
use crate::diagnose::input::{Progress, Recording, Subject};
use crate::simulator::{Effect, Parameter, Preparation, Prepared, Simulator, predict};
use crate::statistics::NORMAL_95;

/// The share of each recording that is fitted to where nothing is held out.
const FITTED: f64 = 2.0 / 3.0;
/// What a coefficient can do at most, in standard deviations of the noise (root of the summed squares), to be seen at all.
const VISIBLE: f64 = 2.0;
/// Step of a derivative, as a share of a coefficient's typical size ...
const STEP: f64 = 1e-3;
/// ... and of a parameter's bounds.
const STEP_SPAN: f64 = 1e-6;

/// A stretch of a recording.
pub(super) struct Run {
    pub recording: usize,
    pub object: usize,
    pub held_out: bool,
    pub prepared: Prepared,
    /// Noise of each channel.
    pub noise: Vec<f64>,
    /// What its residuals are weighed by: the noise, or what the richest model leaves where that is more.
    pub weight: Vec<f64>,
}

impl Run {
    pub fn width(&self) -> usize {
        self.noise.len()
    }
}

/// An effect that may be missing, and where its coefficients stand among a simulator's parameters.
pub(super) struct Entry {
    pub effect: Effect,
    pub first: usize,
}

impl Entry {
    pub fn places(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.effect.coefficients.len()
    }
}

/// A coefficient or parameter of one object.
pub(super) type Place = (usize, usize);
/// Values of all parameters of each object.
pub(super) type Point = Vec<Vec<f64>>;

/// All recordings, with one simulator for each object that can take every effect.
pub(super) struct Logs<'a> {
    pub names: Vec<String>,
    pub given: Vec<&'a dyn Simulator>,
    pub simulators: Vec<Box<dyn Simulator>>,
    /// How many parameters come before the coefficients.
    pub base: usize,
    pub entries: Vec<Entry>,
    pub runs: Vec<Run>,
    /// The share of the values that counts as independent.
    pub independent: f64,
    pub rollouts: AtomicUsize,
}

impl<'a> Logs<'a> {
    /// Prepares the recordings; what became of each is added to `uses`.
    pub fn new(
        subjects: &[Subject<'a>],
        recordings: &[Recording],
        uses: &mut Vec<Use>,
        progress: &dyn Fn(Progress),
    ) -> Result<Self> {
        let known = subjects[0].simulator.effects();
        let shared: Vec<Effect> = known
            .into_iter()
            .filter(|e| subjects.iter().all(|s| s.simulator.effects().iter().any(|o| o.name == e.name)))
            .collect();
        let all: Vec<&str> = shared.iter().map(|e| e.name).collect();
        let simulators = subjects.iter().map(|s| s.simulator.with_effects(&all)).collect::<Result<Vec<_>>>()?;
        let base = subjects[0].simulator.parameters().len();
        let mut first = base;
        let mut entries = Vec::new();
        for effect in shared {
            let count = effect.coefficients.len();
            entries.push(Entry { effect, first });
            first += count;
        }
        let mut runs = Vec::new();
        for (i, recording) in recordings.iter().enumerate() {
            let mut one =
                Use { name: recording.name.clone(), used: true, held_out: recording.held_out, notes: Vec::new() };
            match simulators[recording.object].prepare(recording.seen)? {
                Preparation::Usable(prepared) => {
                    one.notes.clone_from(&prepared.notes);
                    let noise = crate::estimate::floor(&prepared);
                    runs.push(Run {
                        recording: i,
                        object: recording.object,
                        held_out: recording.held_out,
                        weight: noise.clone(),
                        noise,
                        prepared: *prepared,
                    });
                }
                Preparation::Rejected(rejected) => {
                    one.used = false;
                    progress(Progress::NotUsed { name: &recording.name, why: &rejected.note });
                    one.notes.push(rejected.note);
                }
            }
            uses.push(one);
        }
        Ok(Self {
            names: recordings.iter().map(|r| r.name.clone()).collect(),
            given: subjects.iter().map(|s| s.simulator).collect(),
            simulators,
            base,
            entries,
            runs,
            independent: 1.0,
            rollouts: AtomicUsize::new(0),
        })
    }

    /// Holds the end of every recording out.
    pub fn set_aside(&mut self) -> Result<()> {
        let mut ends = Vec::new();
        for run in &mut self.runs {
            let count = run.prepared.seen.len();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
            let cut = (count as f64 * FITTED) as usize;
            if cut < crate::observation::FEWEST_SAMPLES || count - cut < crate::observation::FEWEST_SAMPLES {
                continue;
            }
            let end = Prepared { seen: run.prepared.seen.slice(cut..count)?, ..run.prepared.clone() };
            run.prepared.seen = run.prepared.seen.slice(0..cut)?;
            ends.push(Run {
                recording: run.recording,
                object: run.object,
                held_out: true,
                prepared: end,
                noise: run.noise.clone(),
                weight: run.weight.clone(),
            });
        }
        self.runs.extend(ends);
        Ok(())
    }

    /// The objects that have recordings to fit.
    pub fn objects(&self) -> Vec<usize> {
        (0..self.simulators.len()).filter(|o| self.fitted().any(|r| r.object == *o)).collect()
    }

    pub fn fitted(&self) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(|r| !r.held_out)
    }

    /// How many values are fitted.
    pub fn count(&self) -> usize {
        self.fitted().map(|r| r.prepared.seen.values().len()).sum()
    }

    pub fn parameter(&self, (object, i): Place) -> &Parameter {
        &self.simulators[object].parameters()[i]
    }

    /// What the simulation says as it is given, every effect absent.
    pub fn given_point(&self) -> Point {
        self.simulators.iter().map(|s| s.parameters().iter().map(|p| p.value).collect()).collect()
    }

    /// The places of the parameters that may be tuned.
    pub fn tunable(&self) -> Vec<Place> {
        let of =
            |o: usize| (0..self.base).filter(move |&i| self.simulators[o].parameters()[i].tune).map(move |i| (o, i));
        self.objects().into_iter().flat_map(of).collect()
    }

    /// The places of the parameters that stay and are not exact, with the standard deviation of each.
    pub fn carried(&self) -> Vec<(Place, f64)> {
        let of = |o: usize| {
            let all = self.simulators[o].parameters()[..self.base].iter().enumerate();
            all.filter(|(_, p)| !p.tune)
                .filter_map(move |(i, p)| p.known95.map(|(low, high)| ((o, i), (high - low) / (2.0 * NORMAL_95))))
        };
        self.objects().into_iter().flat_map(of).collect()
    }

    /// The places of an effect's coefficients.
    pub fn places(&self, entry: usize) -> Vec<Place> {
        let of = |o: usize| self.entries[entry].places().map(move |i| (o, i));
        self.objects().into_iter().flat_map(of).collect()
    }

    /// What the sensors would show in `run`.
    pub fn prediction(&self, run: &Run, point: &Point) -> Result<Vec<f64>> {
        self.rollouts.fetch_add(1, Ordering::Relaxed);
        let simulator = self.simulators[run.object].as_ref();
        predict(simulator, &run.prepared, &point[run.object], &[], run.prepared.seen.clock())
    }

    /// Measured − predicted in the channels' units.
    pub fn plain(&self, run: &Run, point: &Point) -> Result<Vec<f64>> {
        let mut values = self.prediction(run, point)?;
        values.iter_mut().zip(run.prepared.seen.values()).for_each(|(value, seen)| *value = seen - *value);
        Ok(values)
    }

    /// Weighed residuals of the fitted runs, stacked.
    pub fn residuals(&self, point: &Point) -> Result<Vec<f64>> {
        let mut all = Vec::with_capacity(self.count());
        for run in self.fitted() {
            let plain = self.plain(run, point)?;
            all.extend(plain.iter().enumerate().map(|(i, r)| r / run.weight[i % run.width()]));
        }
        Ok(all)
    }

    /// How predictions change with each of `places` at `point`, weighed and stacked as the residuals are.
    pub fn columns(&self, point: &Point, places: &[Place]) -> Result<Vec<Vec<f64>>> {
        let stays: Vec<Vec<f64>> = self.fitted().map(|run| self.prediction(run, point)).collect::<Result<Vec<_>>>()?;
        places.par_iter().map(|place| self.column(point, *place, &stays)).collect()
    }

    fn column(&self, point: &Point, (object, i): Place, stays: &[Vec<f64>]) -> Result<Vec<f64>> {
        let parameter = self.parameter((object, i));
        let typical = self.entries.iter().find(|e| e.places().contains(&i));
        let typical = typical.map(|e| STEP * e.effect.coefficients[i - e.first].typical);
        let step = typical.unwrap_or(STEP_SPAN * parameter.span());
        let step = if point[object][i] + step > parameter.max { -step } else { step };
        let mut moved = point.clone();
        moved[object][i] += step;
        let mut all = Vec::with_capacity(self.count());
        for (run, stay) in self.fitted().zip(stays) {
            if run.object != object {
                all.resize(all.len() + stay.len(), 0.0);
                continue;
            }
            let there = self.prediction(run, &moved)?;
            let width = run.width();
            all.extend(there.iter().zip(stay).enumerate().map(|(k, (b, a))| (b - a) / step / run.weight[k % width]));
        }
        // What all that is believable of a coefficient moves less than the noise is rounding: the offset of a joint whose axis
        // stands upright, say.
        if let Some(entry) = self.entries.iter().find(|e| e.places().contains(&i)) {
            let (low, high) = entry.effect.plausible[i - entry.first];
            let size = all.iter().map(|v| v * v).sum::<f64>().sqrt();
            if size * (high - low) < VISIBLE {
                all.fill(0.0);
            }
        }
        Ok(all)
    }
}
