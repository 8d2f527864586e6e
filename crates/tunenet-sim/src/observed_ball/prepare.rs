//! A recording made ready for a ball: checked, cut to what can be explained, and given first guesses of what the file
//! leaves open.

use tunenet_core::Result;
use tunenet_core::observation::{Arcs, Kind, LocalEstimate, Note, Observation};
use tunenet_core::simulator::{Parameter, Preparation, Prepared};
use tunenet_core::tune::channel_noise;

use super::{ObservedBall, Unknown};

/// What passes for gravity, as a share of the file's: air alone halves it for a light ball.
const PLAUSIBLE_GRAVITY: std::ops::Range<f64> = 0.25..2.0;
/// A flight strays from a parabola by less than this share of its range, air included.
const WORST_MISFIT_SHARE: f64 = 0.05;
/// Heights of the first fall that bounce times may come from, m.
const PLAUSIBLE_FALL_M: std::ops::Range<f64> = 1e-5..1e3;
/// Bounces whose intervals give the restitution at the speed of the first impacts.
const LEADING_INTERVALS: usize = 4;

/// A record that spans less than this along every axis, m, shows no motion.
const LEAST_MOTION_M: f64 = 1e-6;

impl ObservedBall {
    pub(super) fn prepare_positions(&self, seen: &Observation) -> Result<Preparation> {
        if (0..3).all(|axis| span(seen.column(axis)) < LEAST_MOTION_M) {
            let text = format!("the ball does not move in any of the {} samples", seen.len());
            return Ok(Preparation::Rejected(Note::new("motion.none", text, "check the columns and their units")));
        }
        // Stamps count from 1970; a start that the data supply needs no more than the differences, and keeps its digits.
        let moved = self.release.time_s.is_none().then(|| seen.from_zero());
        let seen = moved.as_ref().unwrap_or(seen);
        let wild = seen.wild();
        let kept = seen.without(&wild);
        let seen = kept.as_ref().unwrap_or(seen);
        let Some(arcs) = Arcs::cut(seen, self.scene.gravity_m_s2) else { return Err(self.wrong_kind(seen)) };
        // A known start also explains the time before it.
        let begin = if self.release.time_s.is_some() { 0 } else { arcs.usable.start };
        let Ok(usable) = seen.slice(begin..arcs.usable.end) else {
            let text = format!("only {} of {} samples are undisturbed free motion", arcs.usable.len(), seen.len());
            return Ok(Preparation::Rejected(Note::new(
                "motion.disturbed",
                text,
                "record a drop that nothing touches but the surface",
            )));
        };
        let lowest = usable.column(2).fold(f64::INFINITY, f64::min);
        let contact = arcs.contacts.iter().map(|c| c.height_m).reduce(f64::min);
        // The start lies above the surface, however the noise has it.
        let surface = contact.unwrap_or(lowest).min(arcs.start_m[2]) - self.scene.radius_m - 1e-9;
        let range = (0..3).map(|axis| span(usable.column(axis))).fold(0.1, f64::max);
        let fastest =
            (2.0 * self.scene.gravity_m_s2 * range).sqrt() + arcs.start_m_s.iter().map(|v| v.abs()).sum::<f64>();
        let begin_s = usable.clock()[0];
        // The start's own instant is the first sample; where only the position is known, it was released at rest then.
        let own = self.unknown.iter().map(|&unknown| {
            let (name, unit) = unknown.name();
            let (value, reach) = match unknown {
                Unknown::Position(axis) => (arcs.start_m[axis], range),
                Unknown::Velocity(axis) => (arcs.start_m_s[axis], fastest),
                _ => (surface, range),
            };
            Parameter::new(name, unit, value, value - reach, value + reach)
        });
        let mut prepared = Prepared::whole(usable, self.parameters.len());
        prepared.own = own.collect::<Result<_>>()?;
        prepared.notes.clone_from(&arcs.notes);
        if kept.is_some() {
            let places: Vec<String> = wild.iter().take(4).map(|i| (i + 1).to_string()).collect();
            let more = if wild.len() > 4 { " and others" } else { "" };
            let text = format!("sample {}{more} leaps far away and back, and was set aside", places.join(", "));
            prepared.notes.push(Note::new("samples.wild", text, "correct or remove it"));
        }
        if arcs.contacts.is_empty() {
            if let Some(note) = self.unlike_a_fall(&arcs) {
                return Ok(Preparation::Rejected(note));
            }
            let duration = seen.clock()[seen.len() - 1] - seen.clock()[0];
            let text = format!(
                "the ball does not bounce within the {duration:.2} s of the record, so nothing is said about its contacts"
            );
            let note = Note::new("contact.none", text, "record until after the first bounce, better the third");
            prepared.silent.fill(Some(note));
        }
        prepared.local[0] = arcs.restitution().map(|l| LocalEstimate { value: l.value.clamp(0.0, 1.0), ..l });
        let start_s = self.release.time_s.unwrap_or(begin_s);
        prepared.scale = Some(self.scale(&prepared.own_values(), start_s));
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    /// Why a motion without a bounce is no flight either, where it is none.
    fn unlike_a_fall(&self, arcs: &Arcs) -> Option<Note> {
        let (apparent, misfit) = (arcs.apparent_gravity_m_s2?, arcs.misfit_share?);
        let gravity = self.scene.gravity_m_s2;
        // Five standard deviations: a short noisy flight is none of its own fault.
        let slack = 5.0 * apparent.sd;
        let plausible = PLAUSIBLE_GRAVITY.start * gravity - slack..PLAUSIBLE_GRAVITY.end * gravity + slack;
        let like = plausible.contains(&apparent.value) && misfit < WORST_MISFIT_SHARE;
        (!like).then(|| {
            let text = if misfit > 1.0 {
                "the height does not change".to_string()
            } else if misfit < WORST_MISFIT_SHARE {
                format!("this is no ball in flight: it falls at {:.3e} m/s², expected near {gravity}", apparent.value)
            } else {
                format!(
                    "this is no bounce and no flight: no parabola comes nearer than {:.0} % of the motion",
                    100.0 * misfit
                )
            };
            Note::new(
                "motion.unlike",
                text,
                "check the units and the sign of z, the unit of the time, and which column is which",
            )
        })
    }

    pub(super) fn prepare_bounces(&self, seen: &Observation) -> Result<Preparation> {
        if seen.kind() != Kind::BounceTimes {
            return Err(self.wrong_kind(seen));
        }
        let times = seen.values();
        let intervals: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
        let noise = channel_noise(seen)[0];
        let local = leading_restitution(&intervals, noise);
        let restitution = local.map_or(0.7, |l| l.value).clamp(0.05, 1.0);
        let gravity = self.scene.gravity_m_s2;
        let approach = gravity * intervals[0] / (2.0 * restitution);
        let height = approach * approach / (2.0 * gravity);
        if !PLAUSIBLE_FALL_M.contains(&height) {
            let text = format!("the first interval of {} s would need a fall of {height:.3e} m", intervals[0]);
            return Ok(Preparation::Rejected(Note::new(
                "bounces.implausible",
                text,
                "check the unit of the times: seconds",
            )));
        }
        let time = times[0] - self.release.height_m.map_or(approach / gravity, |h| (2.0 * h / gravity).sqrt());
        let own = self.unknown.iter().map(|&unknown| {
            let (name, unit) = unknown.name();
            let (value, low, high) = match unknown {
                Unknown::Height => (height, height * 0.01, height * 100.0),
                _ => (time, time - 10.0 * intervals[0], time + 10.0 * intervals[0]),
            };
            Parameter::new(name, unit, value, low, high)
        });
        let mut prepared = Prepared::whole(seen.clone(), self.parameters.len());
        prepared.own = own.collect::<Result<_>>()?;
        prepared.local[0] = local;
        prepared.silent[1] = Some(Note::new(
            "friction.unseen",
            "bounce times say nothing about friction",
            "record positions of a throw along the surface",
        ));
        Ok(Preparation::Usable(Box::new(prepared)))
    }
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

fn span(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    high - low
}
