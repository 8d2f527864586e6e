//! A recording made ready for a ball: checked, cut to what can be explained, and given first guesses of what the file
//! leaves open.

use tunenet_ball::BallSegmentation;
use tunenet_ball::findings as ball_findings;
use tunenet_ball::preflight::{Expected, Preflight, examine};
use tunenet_core::Result;
use tunenet_core::observation::Check;
use tunenet_core::observation::{Kind, LocalEstimate, Note, Observation};
use tunenet_core::simulator::{Parameter, Phase, Preparation, Prepared, Rejected};
use tunenet_core::statistics;
use tunenet_core::tune::channel_noise;

use super::{Nuisance, ObservedBall};
use crate::ball::Forces;
use crate::findings;
use crate::scene::BallParameters;

/// Bounces whose intervals give the restitution at the speed of the first impacts.
const LEADING_INTERVALS: usize = 4;

/// So many samples are an end of a record.
const ENDS: usize = 3;

impl ObservedBall {
    /// What the file says of the set-up, for the checks.
    fn expected(&self) -> Expected {
        let mut scene = self.scene.clone();
        self.fixed.iter().for_each(|(effect, values)| effect.apply(&mut scene, values));
        let forces = &scene.flight;
        let known = !scene.formulas.flight.is_empty()
            || *forces != Forces { effective_gravity_m_s2: forces.effective_gravity_m_s2, ..Forces::default() };
        Expected {
            gravity_m_s2: scene.gravity_m_s2 + forces.effective_gravity_m_s2,
            // A flight with forces of its own is none of gravity's alone.
            forces_known: known || self.free.iter().chain(&self.per_recording).any(|e| *e.phase() == Phase::Segment),
            radius_m: Some(self.scene.radius_m),
            surface_height_m: self.surface_height_m,
            release_height_m: self.release.height_m,
        }
    }

    /// Which of the parameters is called so.
    fn place(&self, name: &str) -> usize {
        self.parameters.iter().position(|p| p.name == name).expect("a ball has restitution and friction")
    }

    /// A rejection, unless it is to be used nevertheless.
    fn rejects(&self, preflight: &Preflight) -> Option<Preparation> {
        let note = preflight.rejected().and_then(Check::note).filter(|_| !self.forced)?;
        Some(Preparation::Rejected(Box::new(Rejected { note, checks: preflight.checks.clone() })))
    }

    pub(super) fn prepare_positions(&self, seen: &Observation) -> Result<Preparation> {
        if seen.kind() != Kind::Positions {
            return Err(self.wrong_kind(seen));
        }
        // Stamps count from 1970; a start that the data supply needs no more than the differences, and keeps its digits.
        let moved = self.release.time_s.is_none().then(|| seen.from_zero());
        let seen = moved.as_ref().unwrap_or(seen);
        let preflight = examine(seen, &self.expected());
        if let Some(rejected) = self.rejects(&preflight) {
            return Ok(rejected);
        }
        let (Some(kept), Some(mut arcs)) = (&preflight.kept, preflight.arcs.clone()) else {
            return Ok(impossible(&preflight, seen));
        };
        // A record of few samples may bounce where no kink can be detected.
        if let Some(fall) = preflight.coarse {
            arcs.usable = fall.begin..kept.len();
            (arcs.start_m, arcs.start_m_s) = (fall.start_m, fall.start_m_s);
        }
        // A known start also explains the time before it.
        let begin = if self.release.time_s.is_some() { 0 } else { arcs.usable.start };
        let Ok(usable) = kept.slice(begin..arcs.usable.end.max(begin)) else { return Ok(impossible(&preflight, seen)) };
        let lowest = usable.column(2).fold(f64::INFINITY, f64::min);
        let contact =
            arcs.contacts.iter().map(|c| c.height_m).reduce(f64::min).or(preflight.coarse.map(|fall| fall.low_m));
        let range = (0..3).map(|axis| statistics::range(usable.column(axis))).fold(0.1, f64::max);
        // In a flight that touches nothing, the simulation must not either: the surface lies out of reach.
        let touched = contact.is_some() || !lowest_at_an_end(&usable);
        let lowest = if touched { lowest } else { lowest - 2.0 * range };
        // The start lies above the surface, however the noise has it.
        let surface = contact.unwrap_or(lowest).min(arcs.start_m[2]) - self.scene.radius_m - 1e-9;
        let fastest =
            (2.0 * self.scene.gravity_m_s2 * range).sqrt() + arcs.start_m_s.iter().map(|v| v.abs()).sum::<f64>();
        let begin_s = usable.clock()[0];
        // The start's own instant is the first sample; where only the position is known, it was released at rest then.
        let nuisances = self.nuisances.iter().map(|&nuisance| {
            let (name, unit) = nuisance.name();
            let (value, half_width) = match nuisance {
                Nuisance::Position(axis) => (arcs.start_m[axis], range),
                Nuisance::Velocity(axis) => (arcs.start_m_s[axis], fastest),
                // The skin is no faster than the ball.
                Nuisance::Spin(_) => (0.0, fastest / self.scene.radius_m),
                _ => (surface, range),
            };
            Parameter::new(name, unit, value, value - half_width, value + half_width)
        });
        let mut prepared = Prepared::whole(usable, self.parameters.len());
        prepared.nuisances = nuisances.collect::<Result<_>>()?;
        prepared.segmentation = BallSegmentation::shared(self.scene.gravity_m_s2);
        prepared.events = arcs.contacts.iter().map(|c| c.time_s).collect();
        // Without a bounce, nothing is known of contacts; that is said where it is asked for.
        let (without_contacts, notes) = preflight.notes_split();
        prepared.silent.fill(without_contacts);
        prepared.notes.extend(notes);
        if self.forced {
            prepared.notes.extend(forced(&preflight));
        }
        prepared.checks.clone_from(&preflight.checks);
        prepared.local[self.place(BallParameters::RESTITUTION)] =
            arcs.restitution().map(|l| LocalEstimate { value: l.value.clamp(0.0, 1.0), ..l });
        let start_s = self.release.time_s.unwrap_or(begin_s);
        prepared.scale = Some(self.scale(&prepared.nuisance_values(), start_s));
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    pub(super) fn prepare_bounces(&self, seen: &Observation) -> Result<Preparation> {
        if seen.kind() != Kind::EventTimes {
            return Err(self.wrong_kind(seen));
        }
        let preflight = examine(seen, &self.expected());
        if let Some(rejected) = self.rejects(&preflight) {
            return Ok(rejected);
        }
        let times = seen.values();
        let intervals: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
        let noise = channel_noise(seen)[0];
        let local = leading_restitution(&intervals, noise);
        let restitution = local.map_or(0.7, |l| l.value).clamp(0.05, 1.0);
        let gravity = self.scene.gravity_m_s2;
        let approach = gravity * intervals[0] / (2.0 * restitution);
        let height = approach * approach / (2.0 * gravity);
        let time = times[0] - self.release.height_m.map_or(approach / gravity, |h| (2.0 * h / gravity).sqrt());
        let nuisances = self.nuisances.iter().map(|&nuisance| {
            let (name, unit) = nuisance.name();
            let (value, low, high) = match nuisance {
                Nuisance::Height => (height, height * 0.01, height * 100.0),
                _ => (time, time - 10.0 * intervals[0], time + 10.0 * intervals[0]),
            };
            Parameter::new(name, unit, value, low, high)
        });
        let mut prepared = Prepared::whole(seen.clone(), self.parameters.len());
        prepared.nuisances = nuisances.collect::<Result<_>>()?;
        prepared.local[self.place(BallParameters::RESTITUTION)] = local;
        prepared.notes = preflight.notes();
        if self.forced {
            prepared.notes.extend(forced(&preflight));
        }
        prepared.checks = preflight.checks;
        prepared.silent[self.place(BallParameters::FRICTION)] = Some(Note::new(
            findings::FRICTION_NOT_OBSERVABLE,
            "bounce times do not depend on friction",
            "record positions of a throw along the surface",
        ));
        Ok(Preparation::Usable(Box::new(prepared)))
    }
}

/// Whether the lowest sample is one of the first or the last, as in a flight that nothing ends.
fn lowest_at_an_end(seen: &Observation) -> bool {
    let heights: Vec<f64> = seen.column(2).collect();
    let low = (0..heights.len()).min_by(|&a, &b| heights[a].total_cmp(&heights[b])).unwrap_or(0);
    low < ENDS || low + ENDS >= heights.len()
}

/// That nothing can be fitted to a recording, forced or not.
fn impossible(preflight: &Preflight, seen: &Observation) -> Preparation {
    let failed = preflight.rejected().and_then(Check::note);
    let none = || {
        let text = format!("fewer than 3 of {} samples can be used", seen.len());
        Note::new(ball_findings::MOTION_DISTURBED, text, "record a drop that touches nothing but the surface")
    };
    let note = failed.unwrap_or_else(none);
    Preparation::Rejected(Box::new(Rejected { note, checks: preflight.checks.clone() }))
}

/// What is said of a recording that was rejected and is used all the same.
fn forced(preflight: &Preflight) -> Option<Note> {
    let failed = preflight.rejected()?;
    let text =
        format!("a rejected recording is used because of --force ({}): the result may be meaningless", failed.kind);
    Some(Note::new(findings::PREFLIGHT_FORCED, text, "correct the recording and omit --force"))
}

/// The restitution at the first impacts: how the logarithm of the interval falls over the first few, long intervals
/// counting more.
fn leading_restitution(intervals: &[f64], noise_s: f64) -> Option<LocalEstimate> {
    let leading = &intervals[..intervals.len().min(LEADING_INTERVALS)];
    let weight: f64 = leading.iter().map(|t| t * t).sum();
    let mean = |of: &dyn Fn(usize, f64) -> f64| {
        leading.iter().enumerate().map(|(k, t)| t * t * of(k, *t)).sum::<f64>() / weight
    };
    let (middle, level) = (mean(&|k, _| k as f64), mean(&|_, t| t.ln()));
    let square = mean(&|k, _| (k as f64 - middle).powi(2));
    let slope = mean(&|k, t| (k as f64 - middle) * (t.ln() - level)) / square;
    let value = slope.exp();
    // An interval's error is √2 of a time's; its logarithm's is that over the interval.
    let sd = value * 2f64.sqrt() * noise_s / (weight * square).sqrt();
    (leading.len() >= 2 && value.is_finite())
        .then_some(LocalEstimate { value: value.clamp(0.0, 1.0), sd: sd.max(1e-9) })
}
