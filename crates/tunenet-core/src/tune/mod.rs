//! What fits: Algorithm 1, the fit through rollouts, intervals and verdicts.
//!
//! ```text
//! recordings → prepare → Algorithm 1 (with a network) → fit with nuisance parameters → intervals → verdict
//! ```
//!
//! [`tune`] runs the whole chain; the pieces are public for those who want only one.

mod algorithm1;
mod assumed_constants;
mod calibration_uncertainty;
mod camera_projection;
mod channel_gaps;
mod channel_weights;
mod evidence;
mod fixed_parameter;
mod judge;
mod local_minima;
mod observable_nuisances;
mod omitted_effect;
mod outcome;
mod pool;
mod secant;
mod starts;
mod tied;

pub use algorithm1::{Loop, Walk, walk};
pub use channel_gaps::{ChannelGap, over_recordings};
pub use evidence::{Comparison, Detail, Evidence, evidence};
pub use fixed_parameter::{FixedValueFit, fit_at_fixed_values};
pub use outcome::{Estimate, Gap, Iteration, Outcome, Status, Stop, Verdict, shares};
pub(crate) use tied::{note as note_tied, tied_near};

pub use crate::estimate::{
    Adequacy, Contour, Direction, End, Fit, Information, Interval, LEVEL, Linearisation, Phase, Point, Problem,
    Profile, Region, Request, RolloutLog, RolloutStore, ScaleEstimate, Watch, channel_noise, contour, ends, free,
    profile,
};

use calibration_uncertainty::CalibrationUncertainty;
use judge::Standing;
use std::sync::Arc;

use nalgebra::DMatrix;

use crate::estimate::{GridPoint, curved, ends_with, unread_states, weights};
use crate::network::Model;
use crate::observation::{Note, Observation, gap_unit};
use crate::simulator::{Preparation, Prepared, Simulator};
use crate::{Error, Origin, Result};

/// How to tune.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Iterations of Algorithm 1 where a model is given.
    pub iterations: usize,
    /// Start values by name, instead of the simulator's own.
    pub initial: Vec<(String, f64)>,
    /// Keep values within the bounds during Algorithm 1. The paper does so in its third experiment only.
    pub clamp: bool,
    /// Finish with a fit through rollouts and return the best iterate; off, the last iterate of Algorithm 1 stands, as in
    /// the paper.
    pub finish: bool,
    /// Stop after the first fit, with the intervals of the curvature.
    pub quick: bool,
    /// Most rollouts; the answer is then what was found so far.
    pub max_rollouts: Option<usize>,
    /// Where answered rollouts are kept, so that an interrupted tuning can go on.
    pub store: Option<Arc<dyn RolloutStore>>,
    /// What is notified of the progress.
    pub watch: Option<Arc<dyn Watch>>,
    /// What each observation is called in sentences for users, such as a file's name; numbered from 1 where left empty.
    pub names: Vec<String>,
}

impl Settings {
    /// What observation `number` (from 0) is called.
    fn name_of(&self, number: usize) -> String {
        self.names.get(number).cloned().unwrap_or_else(|| format!("recording {}", number + 1))
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            iterations: 5,
            initial: Vec::new(),
            clamp: true,
            finish: true,
            quick: false,
            max_rollouts: None,
            store: None,
            watch: None,
            names: Vec::new(),
        }
    }
}

/// Tunes `simulator` to `observations`, all of the same thing: shared parameters, and for each recording its nuisance parameters.
/// A `model` starts the fit; of several recordings it looks at the first that can be used.
///
/// ```
/// # use tunenet_core::{observation::{Channel, Observation, Kind}, simulator::{Parameter, RolloutResult, Simulator}, tune};
/// struct Cooling(Vec<Parameter>, Vec<Channel>);
/// impl Simulator for Cooling {
///     fn parameters(&self) -> &[Parameter] { &self.0 }
///     fn channels(&self) -> &[Channel] { &self.1 }
///     fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
///         clock.iter().zip(values).for_each(|(t, v)| *v = (-p[0] * t).exp());
///         Ok(())
///     }
/// }
/// let cup = Cooling(vec![Parameter::new("rate", "1/s", 0.5, 0.0, 5.0)?], vec![Channel::new("warmth", "1")]);
/// let clock: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
/// let warmth = clock.iter().map(|t| (-1.25 * t).exp()).collect();
/// let seen = Observation::new(Kind::Other, cup.channels().to_vec(), clock, warmth)?;
/// let outcome = tune::tune(&cup, &[seen], None, &tune::Settings::default())?;
/// assert_eq!(outcome.verdict, tune::Verdict::Tuned);
/// assert!((outcome.parameters[0].value - 1.25).abs() < 1e-6);
/// # Ok::<(), tunenet_core::Error>(())
/// ```
///
/// # Errors
/// [`Error::Setting`] where no parameter may be tuned, or `initial` names none or lies outside its bounds;
/// [`Error::Model`] where the model does not fit; what the simulator refuses.
pub fn tune(
    simulator: &dyn Simulator,
    observations: &[Observation],
    model: Option<&Model>,
    settings: &Settings,
) -> Result<Outcome> {
    let mut notes = Vec::new();
    let (mut recordings, mut used, mut preflight) = (Vec::new(), Vec::new(), Vec::new());
    for (number, seen) in observations.iter().enumerate() {
        let named = |note: &Note| {
            let which = if observations.len() > 1 { format!("{}: ", settings.name_of(number)) } else { String::new() };
            Note { text: format!("{which}{}", note.text), ..note.clone() }
        };
        match simulator.prepare(seen)? {
            Preparation::Usable(prepared) => {
                notes.extend(prepared.notes.iter().map(named));
                preflight.push(prepared.checks.clone());
                recordings.push(*prepared);
                used.push(true);
            }
            Preparation::Rejected(rejected) => {
                notes.push(named(&rejected.note));
                preflight.push(rejected.checks);
                used.push(false);
            }
        }
    }
    if recordings.is_empty() {
        return Ok(Outcome { preflight, ..rejected(notes, used) });
    }
    if !simulator.parameters().iter().any(|p| p.tune) {
        let expected = "at least one parameter with `tune = true`".into();
        return Err(Error::Setting { origin: Origin::File, name: "parameters", expected, found: "none".into() });
    }
    if let Some(model) = model {
        agrees(model, simulator)?;
    }
    let free = free(simulator.parameters(), &recordings);
    let log = RolloutLog::new(settings.max_rollouts, settings.store.clone(), settings.watch.clone());
    channel_weights::weigh(simulator, &mut recordings, &free, &log)?;
    let noise: Vec<Vec<f64>> = recordings.iter().map(weights).collect();
    // Numbers as a user counts the recordings, those set aside included.
    let numbers: Vec<usize> = used.iter().enumerate().filter(|(_, used)| **used).map(|(i, _)| i + 1).collect();
    let tuning = Tuning {
        simulator,
        recordings: &recordings,
        numbers: &numbers,
        noise: &noise,
        free: &free,
        settings,
        log: &log,
    };
    let mut outcome = tuning.run(model)?;
    outcome.notes.splice(0..0, notes);
    (outcome.used, outcome.preflight) = (used, preflight);
    if let Some(point) = &outcome.point {
        let mut all = Vec::new();
        for (d, (recording, nuisances)) in recordings.iter().zip(&point.nuisances).enumerate() {
            let at = (point.parameters.as_slice(), nuisances.as_slice());
            all.push(observable_nuisances::observable_nuisances(simulator, (d, recording), &noise[d], at, &log));
        }
        outcome.nuisances = all;
        let each = recordings.iter().zip(&point.nuisances).enumerate();
        let each: Vec<_> = each.map(|(d, (recording, nuisances))| (d, recording, nuisances.as_slice())).collect();
        outcome.notes.extend(unread_states(simulator, &each, &point.parameters, &log));
    }
    outcome.notes.extend(tuning.limit_note(outcome.stop));
    outcome.rollouts = log.count();
    outcome.recordings = recordings;
    Ok(outcome)
}

fn rejected(notes: Vec<Note>, used: Vec<bool>) -> Outcome {
    Outcome {
        verdict: Verdict::Rejected,
        parameters: Vec::new(),
        correlation: DMatrix::zeros(0, 0),
        region95: None,
        iterations: Vec::new(),
        gap: None,
        gaps: Vec::new(),
        rollouts: 0,
        stop: Stop::Nothing,
        notes,
        before: None,
        recordings: Vec::new(),
        point: None,
        free: Vec::new(),
        tied: Vec::new(),
        nuisances: Vec::new(),
        used,
        preflight: Vec::new(),
    }
}

/// A model has to tune what is to be tuned: less would leave a parameter standing, more would move one that is fixed.
fn agrees(model: &Model, simulator: &dyn Simulator) -> Result<()> {
    let learned: Vec<&str> = model.parameters().iter().map(|p| p.name.as_str()).collect();
    let asked: Vec<&str> = simulator.parameters().iter().filter(|p| p.tune).map(|p| p.name.as_str()).collect();
    if asked == learned {
        return Ok(());
    }
    Err(Error::Model { what: "tunes other parameters".into(), expected: asked.join(", "), found: learned.join(", ") })
}

/// The estimates of [`tune`] from where another fit of the same recordings ended, without a search for starts, with rollouts counted in
/// `log`; `None` where the recordings leave more than their noise explains.
///
/// # Errors
/// Where the simulator refuses.
pub(crate) fn estimates_near(
    simulator: &dyn Simulator,
    mut recordings: Vec<Prepared>,
    near: &Point,
    log: &RolloutLog,
) -> Result<Option<Vec<Estimate>>> {
    let free = free(simulator.parameters(), &recordings);
    channel_weights::weigh(simulator, &mut recordings, &free, log)?;
    let noise: Vec<Vec<f64>> = recordings.iter().map(weights).collect();
    let settings = &Settings::default();
    let tuning = Tuning { simulator, recordings: &recordings, numbers: &[], noise: &noise, free: &free, settings, log };
    let mut fit = tuning.problem().fit(near.clone(), 1.0)?;
    let Uncertainty { scale, known, interval95, .. } = tuning.uncertainty(&mut fit, &[])?;
    if tuning.poor(&fit) {
        return Ok(None);
    }
    let found = tuning.standings(&fit, &known, &scale, &interval95);
    Ok(Some(tuning.estimates(near, &mut fit, &found, &mut Vec::new())))
}

/// How well the free parameters of a fit are known.
struct Uncertainty {
    scale: ScaleEstimate,
    known: Information,
    interval95: Vec<Interval>,
    calibration: CalibrationUncertainty,
}

/// One call of [`tune`] with everything prepared.
struct Tuning<'a> {
    simulator: &'a dyn Simulator,
    recordings: &'a [Prepared],
    numbers: &'a [usize],
    noise: &'a [Vec<f64>],
    free: &'a [usize],
    settings: &'a Settings,
    log: &'a RolloutLog,
}

impl Tuning<'_> {
    fn problem(&self) -> Problem<'_> {
        Problem {
            simulator: self.simulator,
            recordings: self.recordings,
            noise: self.noise,
            free: self.free,
            log: Some(self.log),
        }
    }

    fn start(&self) -> Result<Point> {
        let mut point = Point::start(self.simulator, self.recordings);
        for (name, value) in &self.settings.initial {
            let known = || self.simulator.parameters().iter().map(|p| p.name.clone()).collect::<Vec<_>>().join(", ");
            let position =
                self.simulator.parameters().iter().position(|p| p.name == *name).ok_or_else(|| Error::Setting {
                    origin: Origin::Caller,
                    name: "initial",
                    expected: format!("a parameter: {}", known()),
                    found: format!("`{name}`"),
                })?;
            let p = &self.simulator.parameters()[position];
            if !(p.min..=p.max).contains(value) {
                let expected = format!("{} to {} for `{name}`", p.min, p.max);
                return Err(Error::Setting {
                    origin: Origin::Caller,
                    name: "initial",
                    expected,
                    found: value.to_string(),
                });
            }
            point.parameters[position] = *value;
        }
        Ok(point)
    }

    /// Takes the answer from the events only where they say something; the recordings' nuisance parameters follow the parameters
    /// that now stand, and so does all that is said of the answer.
    fn settle_on_local(&self, fit: &mut Fit, found: &mut [Standing], notes: &mut Vec<Note>) -> Result<()> {
        let whole = self.problem().rmse(&fit.residuals);
        if !self.fall_back_on_local(fit, found, whole, notes) {
            return Ok(());
        }
        let nuisances = Problem { free: &[], ..self.problem() }.fit(fit.point.clone(), 1.0)?;
        (fit.point, fit.residuals) = (nuisances.point, nuisances.residuals);
        Ok(())
    }

    /// The 95 % interval of each free parameter, and the calibration uncertainty of fixed ones.
    fn intervals(
        &self,
        fit: &Fit,
        scale: &ScaleEstimate,
        grid: &[Vec<GridPoint>],
    ) -> Result<(Vec<Interval>, CalibrationUncertainty)> {
        let problem = self.problem();
        self.log.phase(Phase::Intervals);
        let curvature = self.settings.quick || self.takes_curvature(fit);
        let (mut interval95, _) =
            if curvature { (curved(&problem, fit, scale), 0) } else { ends_with(&problem, fit, scale, grid) };
        let calibration = CalibrationUncertainty::of(&problem, fit, &mut interval95)?;
        Ok((interval95, calibration))
    }

    /// Whether intervals are those of the curvature: of a poor fit of recordings with inputs, they say how far the answer depends on noise
    /// and not how far it is off, and a profile likelihood takes many times the rollouts of the fit.
    fn takes_curvature(&self, fit: &Fit) -> bool {
        let rolls_on = |recording: &Prepared| recording.has_inputs() && !recording.memoryless;
        !self.free.is_empty() && self.recordings.iter().all(rolls_on) && self.poor(fit)
    }

    /// How well the free parameters are known at `fit`, whose covariance is stated by the way.
    fn uncertainty(&self, fit: &mut Fit, grid: &[Vec<GridPoint>]) -> Result<Uncertainty> {
        let problem = self.problem();
        let linear = problem.settle(fit)?;
        let scale = ScaleEstimate::of(&problem, fit, &linear);
        let known = Information::of(&problem, fit, &linear, &scale);
        fit.covariance = known.covariance.clone();
        let (mut interval95, mut calibration) = self.intervals(fit, &scale, grid)?;
        // A residual that is more than noise names an effect by other means; the paper's fit knows no effects.
        if self.settings.finish && !self.settings.quick && !fit.cut_short && !self.poor(fit) {
            for omission in omitted_effect::widen(&problem, fit, &scale, &mut interval95)? {
                calibration.add(omission.moves, omission.note);
            }
        }
        Ok(Uncertainty { scale, known, interval95, calibration })
    }

    /// The network's iterations from `start`, and where they end.
    fn residual_tuning(&self, model: &Model, start: &Point) -> Result<(Vec<Iteration>, Point)> {
        let secant = self.settings.finish && self.free.len() == 1;
        let how = Loop {
            iterations: self.settings.iterations,
            clamp: self.settings.clamp,
            secant,
            best: self.settings.finish,
            library: self.settings.finish && self.settings.initial.is_empty(),
        };
        let walk = walk(self.simulator, &self.recordings[0], model, start, how)?;
        self.log.add(walk.rollouts);
        if !self.settings.finish {
            return Ok((walk.iterations, walk.point));
        }
        // The recordings' nuisance parameters are fitted first, so that they do not bias the parameters.
        let nuisances = Problem { free: &[], ..self.problem() }.fit(walk.point, 1.0)?;
        Ok((walk.iterations, nuisances.point))
    }

    fn run(&self, model: Option<&Model>) -> Result<Outcome> {
        let problem = self.problem();
        let start = self.start()?;
        // The gap before is the old parameters' best: only the recordings' nuisance parameters are fitted.
        let before = self.fit_nuisances(&start)?;
        let gap_before = problem.rmse(&before.residuals);
        let (mut iterations, mut stop, mut notes) = (Vec::new(), Stop::Converged, Vec::new());
        let mut near = Point { parameters: start.parameters.clone(), nuisances: before.point.nuisances.clone() };
        if let Some(model) = model.filter(|_| !self.free.is_empty()) {
            (iterations, near) = self.residual_tuning(model, &start)?;
            stop = Stop::Iterations;
        }
        let mut grid = Vec::new();
        let mut fit = if self.settings.finish || iterations.is_empty() {
            // The start without a network stays among the starts: with one, the answer is never worse.
            let plain = Point { parameters: start.parameters.clone(), nuisances: before.point.nuisances.clone() };
            let (fit, places) = self.best_fit(&near, (!iterations.is_empty()).then_some(plain))?;
            grid = places;
            if iterations.is_empty() {
                iterations.push(Iteration { k: 0, parameters: near.at(self.free), rmse: gap_before });
            }
            let after = fit.trace.iter().skip(1).enumerate();
            let first = iterations.len();
            iterations.extend(after.map(|(i, (parameters, rmse))| Iteration {
                k: first + i,
                parameters: parameters.clone(),
                rmse: *rmse,
            }));
            fit
        } else {
            problem.evaluate(near)?
        };
        let cut_short = fit.cut_short;
        if cut_short {
            stop = Stop::Limit;
        }
        let Uncertainty { scale, known, interval95, calibration } = self.uncertainty(&mut fit, &grid)?;
        let mut poor = self.poor(&fit);
        self.report_unchecked(&fit, &mut notes);
        if self.settings.finish && !poor && !self.settings.quick {
            let disagree = self.disagreement(&fit)?;
            poor = disagree.is_some();
            notes.extend(disagree);
        }
        if self.settings.finish && !poor && !self.settings.quick {
            notes.extend(assumed_constants::ask(&problem, &fit, &interval95)?);
        }
        let mut found = self.standings(&fit, &known, &scale, &interval95);
        let short = judge::leave_open_where_short(self, &mut found, &mut notes);
        let joint = judge::joint(&found);
        let region95 = if self.settings.finish && !poor && !short && !cut_short && joint.len() > 1 {
            let mut region = if self.settings.quick {
                Region::from_curvature(&problem, &fit, &scale, &joint)
            } else {
                Region::of(&problem, &fit, &scale, &interval95, &joint).0
            };
            calibration.widen_region(&mut region, &joint);
            Some(region)
        } else {
            None
        };
        // The paper's last iterate stands as it is; anything else would not be the paper's.
        if poor && self.settings.finish {
            self.settle_on_local(&mut fit, &mut found, &mut notes)?;
        }
        if !cut_short {
            // What an unfinished fit leaves says nothing of the model.
            self.report_misfit(&fit, poor, &mut notes);
        }
        let gap = Gap {
            unit: gap_unit(self.simulator.channels()).to_owned(),
            before: gap_before,
            after: problem.rmse(&fit.residuals),
            noise_floor: self.noise_floor(),
        };
        let parameters = self.estimates(&start, &mut fit, &found, &mut notes);
        notes.extend(calibration.notes);
        judge::name_directions(self, &known, &mut notes);
        let tied = self.tied(&fit, &known, &mut notes)?;
        let verdict = judge::verdict(&parameters, poor || cut_short);
        let correlation = judge::correlation(&fit.covariance);
        let free = self.free.iter().map(|&i| self.simulator.parameters()[i].name.clone()).collect();
        Ok(Outcome {
            verdict,
            parameters,
            correlation,
            region95,
            iterations,
            gap: Some(gap),
            gaps: channel_gaps::channel_gaps(self.recordings, self.noise, &before.residuals, &fit.residuals),
            rollouts: self.log.count(),
            stop,
            notes,
            before: Some(before.point),
            recordings: Vec::new(),
            point: Some(fit.point),
            free,
            tied,
            nuisances: Vec::new(),
            used: Vec::new(),
            preflight: Vec::new(),
        })
    }
}
