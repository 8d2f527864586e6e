//! The surface and the view: whether the ball bounces, leaves the surface or the picture, and whether what the file says of
//! the surface and the release agrees with what is seen.

use super::flights::{Flight, Flights};
use super::{Bounces, Expected, share};
use crate::findings;
use crate::segmentation::Arcs;
use crate::segmentation::polynomial::Polynomial;
use crate::segmentation::span;
use tunenet_core::finding::FindingKind;
use tunenet_core::observation::Check;
use tunenet_core::observation::Observation;

/// A height differs from what is given from this share of the fall on ...
const DIFFERS_SHARE: f64 = 0.02;
/// ... and this many times what the contact is unsure by.
const DIFFERS_SD: f64 = 4.0;
/// Flights meet at a contact where no more samples than this lie between them.
const MEET: usize = 4;
/// A ball is below the surface from this many times the noise, and this share of all heights, on ...
const BELOW_NOISE: f64 = 6.0;
const BELOW_SHARE: f64 = 0.04;
/// ... in this many samples in a row.
const BELOW_SAMPLES: usize = 3;
/// A gap of this many frames may hide a turn beyond the border.
const GAP_FRAMES: f64 = 3.0;
/// The border lies within this share of the range of heights.
const BORDER_SHARE: f64 = 0.15;

/// Whether it bounces, and whether its contacts can be examined; `coarse` says that it bounces, in too few samples to determine
/// when.
pub(crate) fn bounces(seen: &Observation, arcs: &Arcs, coarse: bool, samples: usize) -> (Bounces, Check) {
    const KIND: FindingKind = findings::CONTACT_NONE;
    const REMEDY: &str = "record until after the first bounce, better the third";
    if coarse {
        return (Bounces::Coarse, Check::passed(KIND, "a bounce, with too few samples to determine its time"));
    }
    let duration = seen.clock()[seen.len() - 1] - seen.clock()[0];
    if let Some(low) = arcs.late {
        let text = format!(
            "the ball first bounces at the very end of the {duration:.2} s of the record, near {:.3} s: too late to determine anything about \
             its contacts, so the samples from there on are excluded ({})",
            seen.clock()[low],
            share(seen.len() - low, samples)
        );
        return (Bounces::TooLate, Check::noticed(KIND, text, REMEDY));
    }
    let text = match arcs.contacts.as_slice() {
        [] => {
            let text = format!(
                "the ball does not bounce within the {duration:.2} s of the record, so its contacts cannot be examined"
            );
            return (Bounces::None, Check::noticed(KIND, text, REMEDY));
        }
        [one] => format!("one bounce at {:.3} s", one.time_s),
        [first, ..] => format!("{} bounces, the first at {:.3} s", arcs.contacts.len(), first.time_s),
    };
    (Bounces::Timed, Check::passed(KIND, text))
}

/// The height of the ball's centre at contact, m, when it is there first, and how sure that is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Level {
    pub height_m: f64,
    pub sd_m: f64,
    pub noise_m: f64,
    pub since_s: f64,
}

impl Level {
    /// From where the two flights cross that meet at the first contact; from the contact itself where none do.
    pub fn of(seen: &Observation, arcs: &Arcs, flights: &Flights) -> Option<Self> {
        let contact = arcs.contacts.first()?;
        let (clock, heights) = (seen.clock(), seen.column(2).collect::<Vec<f64>>());
        let meeting = flights.flights.windows(2).find(|pair| {
            let (end, start) = (clock[pair[0].samples.end - 1], clock[pair[1].samples.start]);
            pair[1].samples.start - pair[0].samples.end <= MEET && end <= contact.time_s && contact.time_s <= start
        });
        let noise_m = flights.noise;
        let crossing = meeting.and_then(|pair| {
            // Both fall alike, which is known better than how each of them does.
            let curvature = arcs_curvature(flights);
            let line = |f: &Flight| {
                let part = f.samples.clone();
                Polynomial::fit(&clock[part.clone()], &heights[part], contact.time_s, Some(curvature))
            };
            let (down, up) = (line(&pair[0])?, line(&pair[1])?);
            let (gap, slope) = (
                up.at(contact.time_s) - down.at(contact.time_s),
                up.slope(contact.time_s) - down.slope(contact.time_s),
            );
            let time = contact.time_s - gap / slope;
            let (down_sd, up_sd) = (noise_m * down.value_gain(time), noise_m * up.value_gain(time));
            let sd_m = down_sd.hypot(down.slope(time) / slope * down_sd.hypot(up_sd));
            sd_m.is_finite().then(|| Self { height_m: down.at(time), sd_m, noise_m, since_s: time })
        });
        let frame = (clock[clock.len() - 1] - clock[0]) / (clock.len() - 1) as f64;
        let rough = noise_m + contact.approach_m_s.abs() * frame;
        Some(crossing.unwrap_or(Self { height_m: contact.height_m, sd_m: rough, noise_m, since_s: contact.time_s }))
    }
}

/// Half the common acceleration of all flights, with its sign.
fn arcs_curvature(flights: &Flights) -> f64 {
    let weight = |f: &Flight| f.fit.curvature_gain().powi(-2);
    let total: f64 = flights.flights.iter().map(weight).sum();
    flights.flights.iter().map(|f| weight(f) * f.fit.coefficients[2]).sum::<f64>() / total
}

/// Whether the surface's height is known.
pub(crate) fn height(level: Option<Level>, expected: &Expected) -> Check {
    const KIND: FindingKind = findings::SURFACE_UNKNOWN;
    let Some(Level { height_m: level, .. }) = level else {
        return Check::not_run(KIND, "no contact shows the surface height");
    };
    match (expected.surface_height_m, expected.radius_m) {
        (Some(height), _) => Check::passed(KIND, format!("the surface is given at {height} m")),
        (None, Some(radius)) => {
            Check::passed(KIND, format!("surface height estimated from the contacts: about {:.3} m", level - radius))
        }
        (None, None) => Check::passed(KIND, format!("at its contacts the ball's centre is {level:.3} m high")),
    }
}

/// Whether a surface and a height of fall that are given agree with the contacts.
pub(crate) fn agrees(arcs: &Arcs, level: Option<Level>, expected: &Expected) -> [Check; 2] {
    const KINDS: [FindingKind; 2] = [findings::SURFACE_DISAGREES, findings::RELEASE_DISAGREES];
    let Some(Level { height_m: level, sd_m, .. }) = level else {
        return KINDS.map(|kind| Check::not_run(kind, "no contact to compare with"));
    };
    let fall = (arcs.start_m[2] - level).abs();
    let limit = DIFFERS_SHARE * fall + DIFFERS_SD * sd_m;
    let surface = match (expected.surface_height_m, expected.radius_m) {
        (Some(height), Some(radius)) if (level - radius - height).abs() > limit => {
            let text = format!(
                "at contact the ball's centre is {level:.3} m high, which puts the surface at {:.3} m, not at the given {height} m",
                level - radius
            );
            Check::noticed(
                KINDS[0],
                text,
                "correct `surface.height_m` or `ball.radius_m`, or leave the height out so that it is estimated",
            )
        }
        (Some(_), Some(_)) => Check::passed(KINDS[0], "the contacts agree with the given surface"),
        _ => Check::not_run(KINDS[0], "the surface height is not given"),
    };
    let release = match expected.release_height_m {
        Some(height) if (fall - height).abs() > limit => {
            let text = format!("the ball falls {fall:.3} m, not the given {height} m");
            Check::noticed(KINDS[1], text, "correct `release.height_m`, or leave it out so that it is estimated")
        }
        Some(_) => Check::passed(KINDS[1], "the fall agrees with the given height"),
        None => Check::not_run(KINDS[1], "the height of fall is not given"),
    };
    [surface, release]
}

/// Whether the ball stays on its surface; where it does not, the sample at which it has fallen below.
pub(crate) fn left(seen: &Observation, level: Option<Level>, samples: usize) -> (Check, Option<usize>) {
    const KIND: FindingKind = findings::SURFACE_LEFT;
    let Some(level) = level else {
        return (Check::not_run(KIND, "no contact shows the surface height"), None);
    };
    let heights: Vec<f64> = seen.column(2).collect();
    let slack = BELOW_NOISE * level.noise_m + BELOW_SHARE * span(&heights) + DIFFERS_SD * level.sd_m;
    let limit = level.height_m - slack;
    let after = seen.clock().partition_point(|t| *t <= level.since_s);
    let below = (after..heights.len().saturating_sub(BELOW_SAMPLES - 1))
        .find(|&i| heights[i..i + BELOW_SAMPLES].iter().all(|z| *z < limit));
    let Some(below) = below else { return (Check::passed(KIND, "the ball stays on its surface"), None) };
    // It left where it was last as high as the surface.
    let edge = (after..below).rev().find(|&i| heights[i] >= level.height_m).unwrap_or(after);
    let text = format!(
        "the ball leaves its surface at {:.3} s and falls below it; samples from {} on are excluded ({})",
        seen.clock()[edge],
        edge + 2,
        share(seen.len() - edge - 1, samples)
    );
    (Check::noticed(KIND, text, "end the record there, or use a larger surface"), Some(edge + 1))
}

/// Whether the path leaves the view at its top and comes back.
pub(crate) fn view(seen: &Observation) -> Check {
    const KIND: FindingKind = findings::VIEW_LEFT;
    let (clock, heights) = (seen.clock(), seen.column(2).collect::<Vec<f64>>());
    let usual = 1.0 / super::clock::rate_hz(clock);
    let top = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let border = top - BORDER_SHARE * span(&heights);
    let rises = |i: usize| heights[i] > heights[i - 2];
    let hidden: Vec<usize> = (3..clock.len().saturating_sub(3))
        .filter(|&i| {
            clock[i + 1] - clock[i] > GAP_FRAMES * usual
                && heights[i] > border
                && heights[i + 1] > border
                && rises(i)
                && !rises(i + 3)
        })
        .collect();
    let Some(first) = hidden.first() else { return Check::passed(KIND, "the path stays in view") };
    let text = format!(
        "the ball leaves the view upwards {} time{}, first at {:.3} s",
        hidden.len(),
        if hidden.len() == 1 { "" } else { "s" },
        clock[*first]
    );
    Check::noticed(KIND, text, "move the camera back; what was seen is used")
}
