//! Contact times by intersecting the flights before and after (least-squares parabolas), and the restitution of each contact.

use std::ops::Range;

use tunenet_core::observation::{LocalEstimate, noise_sd, widened};

use super::polynomial::Polynomial;

/// The flights next to a contact are shortened until a parabola explains them to this many times the noise ...
const LOCAL_MISFIT: f64 = 1.6;
/// ... but not below this many samples.
const LOCAL_SAMPLES: usize = 12;
/// A restitution read off one contact with a greater standard deviation says nothing.
const LOCAL_WORST_SD: f64 = 0.2;

/// One impact on the surface.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// When the two flights cross, s.
    pub time_s: f64,
    /// Height of the ball's centre then, m.
    pub height_m: f64,
    /// Approach speed along the vertical, m/s, positive.
    pub approach_m_s: f64,
    /// Rebound over approach speed from the flights right at the contact, each with its own vertical acceleration, so that
    /// an unmodelled force in flight (drag, a wrong scale) does not bias it. `None` where a flight is too short.
    pub restitution: Option<LocalEstimate>,
}

/// Locates every impact where the flights next to it cross and measures its restitution.
pub(crate) fn contacts(
    clock: &[f64],
    heights: &[f64],
    usable: &Range<usize>,
    impacts: &[usize],
    gravity: f64,
) -> Vec<Contact> {
    let sd = noise_sd(&heights[usable.clone()]).max(1e-9);
    let bounds: Vec<usize> =
        std::iter::once(usable.start).chain(impacts.iter().map(|k| k + 1)).chain([usable.end]).collect();
    let mut found: Vec<Contact> = Vec::new();
    for (i, &k) in impacts.iter().enumerate() {
        let (before, after) = (bounds[i]..k, k + 2..bounds[i + 2].saturating_sub(1).max(k + 2));
        let line = |range: Range<usize>| {
            Polynomial::fit(&clock[range.clone()], &heights[range.clone()], clock[k], Some(-gravity / 2.0))
        };
        let (Some(down), Some(up)) = (line(before.clone()), line(after.clone())) else { continue };
        let time_s = crossing(&down, &up, clock[k], clock[k + 1]);
        let restitution = local_restitution(clock, heights, before, after, time_s, sd);
        found.push(Contact { time_s, height_m: down.at(time_s), approach_m_s: -down.slope(time_s), restitution });
    }
    found
}

/// Where two flights with equal curvature cross; the middle of the gap where they do so outside its neighbourhood.
pub(crate) fn crossing(down: &Polynomial, up: &Polynomial, before: f64, after: f64) -> f64 {
    // Their difference is a line; it is zero where they cross.
    let (difference, slope) = (up.at(before) - down.at(before), up.slope(before) - down.slope(before));
    let time = before - difference / slope;
    let slack = after - before;
    if (before - slack..=after + slack).contains(&time) { time } else { before.midpoint(after) }
}

/// Rebound over approach speed, from the widest samples next to the contact that a parabola of free acceleration explains.
fn local_restitution(
    clock: &[f64],
    heights: &[f64],
    before: Range<usize>,
    after: Range<usize>,
    time_s: f64,
    sd: f64,
) -> Option<LocalEstimate> {
    let widest = |range: Range<usize>, at_end: bool| -> Option<(f64, f64)> {
        let mut length = range.len();
        let part =
            |length: usize| if at_end { range.end - length..range.end } else { range.start..range.start + length };
        let fit = |length| Polynomial::fit(&clock[part(length)], &heights[part(length)], time_s, None);
        loop {
            let whole = fit(length)?;
            if whole.residual_sd < LOCAL_MISFIT * sd || length <= LOCAL_SAMPLES {
                let slope = whole.slope(time_s);
                // What the nearer samples alone would say shows how far a parabola fails here; the scatter of few samples
                // is little known.
                let stray = fit(length * 2 / 3).map_or(0.0, |nearer| nearer.slope(time_s) - slope);
                let slope_sd = whole.residual_sd.max(sd) * whole.slope_gain(time_s);
                let slope_sd = widened(slope_sd.hypot(stray), length as f64 - 3.0);
                return (length >= 4).then_some((slope, slope_sd));
            }
            length = (length * 4 / 5).max(LOCAL_SAMPLES).min(length - 1);
        }
    };
    let ((approach, down), (rebound, up)) = (widest(before, true)?, widest(after, false)?);
    let approach = -approach;
    let value = rebound / approach;
    let sd = up.hypot(value * down) / approach;
    (approach > 0.0 && (-0.3..1.5).contains(&value) && sd < LOCAL_WORST_SD)
        .then_some(LocalEstimate { value, sd: sd.max(1e-9) })
}
