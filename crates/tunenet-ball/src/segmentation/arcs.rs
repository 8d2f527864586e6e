//! Cutting a ball's positions into free flight and contacts.
//!
//! Kinks of the path are found first ([`Kinks`]), and then located where the two neighbouring flights cross
//! ([`contacts`]). Nothing is smoothed, and no sample is judged by anything but its own flight.

use std::ops::Range;

use tunenet_core::observation::{Kind, LocalEstimate, Observation};

use super::contacts::{Contact, contacts};
use super::kinks::{Blows, Kinks};
use super::polynomial::Polynomial;
use super::release::release;
use super::span;

/// Fewer samples say nothing of their acceleration.
const FEWEST_FOR_GRAVITY: usize = 6;

/// A recording of a bouncing ball, cut into what can be used and what cannot.
#[derive(Debug, Clone)]
pub struct Arcs {
    /// The samples of undisturbed motion: after the release, before a blow or before the ball leaves the surface.
    pub usable: Range<usize>,
    /// The impacts within them, in order.
    pub contacts: Vec<Contact>,
    /// Start position at the first usable sample, m: a line through the first flight for each axis.
    pub start_m: [f64; 3],
    /// Start velocity there, m/s.
    pub start_m_s: [f64; 3],
    /// The downward acceleration that explains the usable samples best where they hold no impact, m/s².
    pub apparent_gravity_m_s2: Option<LocalEstimate>,
    /// How far they stray from that parabola (RMS), as a share of the range of their heights.
    pub misfit_share: Option<f64>,
    /// How long the record shows the ball before its release, s, where it does; these samples are excluded.
    pub held_s: Option<f64>,
    /// How many samples these are.
    pub(crate) held_samples: usize,
    /// Blows by something other than the surface, where samples are excluded because of them.
    pub blows: Option<Blows>,
    /// The lowest sample of a first bounce so near the end that no flight follows it; what is usable ends before it.
    pub(crate) late: Option<usize>,
    /// Every place in the record where the velocity changes at once, impacts or not: the last sample before each.
    pub(crate) kinks: Vec<usize>,
}

impl Arcs {
    /// Cuts `seen`, positions of a ball under gravity `gravity_m_s2`. `None` for other kinds of observation.
    #[must_use]
    pub fn cut(seen: &Observation, gravity_m_s2: f64) -> Option<Self> {
        if seen.kind() != Kind::Positions {
            return None;
        }
        let axes: [Vec<f64>; 3] = [0, 1, 2].map(|axis| seen.column(axis).collect());
        let mut kinks = Kinks::find(seen.clock(), &axes, gravity_m_s2);
        let late = kinks.take_late(&axes[2]);
        let (mut usable, blows) = kinks.usable(seen.clock());
        let inside: Vec<usize> =
            kinks.impacts.iter().copied().filter(|&k| k > usable.start + 1 && k + 1 < usable.end).collect();
        let release =
            release(seen.clock(), &axes[2], usable.start, *inside.first().unwrap_or(&usable.end), gravity_m_s2);
        let held_s = (release > usable.start).then(|| seen.clock()[release] - seen.clock()[usable.start]);
        let held_samples = release.saturating_sub(usable.start);
        usable.start = usable.start.max(release);
        let contacts = contacts(seen.clock(), &axes[2], &usable, &inside, gravity_m_s2);
        let first_end = contacts.first().map_or(usable.end, |c| seen.clock().partition_point(|t| *t < c.time_s));
        let flight = usable.start..first_end.max(usable.start + 2).min(usable.end);
        let (mut start_m, mut start_m_s) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let curvature = if axis == 2 { -gravity_m_s2 / 2.0 } else { 0.0 };
            let origin = seen.clock()[usable.start];
            let line =
                Polynomial::fit(&seen.clock()[flight.clone()], &axes[axis][flight.clone()], origin, Some(curvature));
            (start_m[axis], start_m_s[axis]) =
                line.map_or((axes[axis][usable.start], 0.0), |l| (l.at(origin), l.slope(origin)));
        }
        let (times, heights) = (&seen.clock()[usable.clone()], &axes[2][usable.clone()]);
        let free = (contacts.is_empty() && times.len() >= FEWEST_FOR_GRAVITY)
            .then(|| Polynomial::fit(times, heights, times[0], None))
            .flatten();
        let misfit_share = free.map(|f| f.residual_sd / span(heights).max(f64::MIN_POSITIVE));
        let apparent_gravity_m_s2 = free.map(|f| {
            // The acceleration of a parabola through n even samples over T has standard deviation sd·√720 / (√n T²).
            let duration = times[times.len() - 1] - times[0];
            let sd = f.residual_sd * (720.0 / times.len() as f64).sqrt() / (duration * duration);
            LocalEstimate { value: -2.0 * f.coefficients[2], sd }
        });
        Some(Self {
            usable,
            contacts,
            start_m,
            start_m_s,
            apparent_gravity_m_s2,
            misfit_share,
            held_s,
            held_samples,
            blows,
            late,
            kinks: kinks.all(),
        })
    }

    /// Leaves out what comes from sample `end` on.
    pub(crate) fn end_at(&mut self, end: usize, clock: &[f64]) {
        self.usable.end = self.usable.end.min(end).max(self.usable.start);
        let last = self.usable.end.checked_sub(1).map_or(f64::NEG_INFINITY, |i| clock[i]);
        self.contacts.retain(|c| c.time_s < last);
    }

    /// The restitution of all contacts together, weighted by their certainty; the standard deviation covers the scatter
    /// between them.
    #[must_use]
    pub fn restitution(&self) -> Option<LocalEstimate> {
        let each: Vec<LocalEstimate> = self.contacts.iter().filter_map(|c| c.restitution).collect();
        LocalEstimate::mean(&each)
    }
}
