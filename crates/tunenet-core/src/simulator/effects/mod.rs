//! Effects of the measurement: what a camera and its clock do to a motion that is simulated rightly.
//!
//! One file each, which holds the entry of the catalogue and the formula; [`ALL`] is the list. To add one, write its file
//! and its line. Points are true positions in m, x and y horizontal, z up. The picture shows x and z, seen along y.

mod aspect_ratio;
mod camera_tilt;
mod length_scale;
mod lens_distortion;
mod observation_blur;
mod perspective;
mod rolling_shutter;
mod time_offset;
mod time_scale;

use super::{Coefficient, Effect, Phase};
use crate::observation::Kind;

/// An effect of the measurement: its entry in the catalogue, and how it acts.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeasurementEffect {
    pub name: &'static str,
    pub coefficients: &'static [Coefficient],
    pub plausible: &'static [(f64, f64)],
    pub sentence: &'static str,
    pub mistaken_for: &'static [&'static str],
    /// The kinds of observation that can show it.
    pub kinds: &'static [Kind],
    pub act: Act,
}

/// How an effect changes what is observed, given its coefficients.
#[derive(Debug, Clone, Copy)]
pub(super) enum Act {
    /// The true instant of a stamp, and the stamp of a true instant.
    Clock { to_true: fn(f64, &[f64]) -> f64, to_seen: fn(f64, &[f64]) -> f64 },
    /// The instants that one sample is the mean of: at stamp + length · (−½ to ½).
    Exposure(fn(&[f64]) -> f64),
    /// How much later (s) than its stamp a point at this height (m) is read.
    Readout(fn(f64, &[f64]) -> f64),
    /// Where a point is seen; nowhere where it lies behind the camera.
    Point(fn([f64; 3], &[f64]) -> Option<[f64; 3]>),
    /// As what a length is seen, on every channel in m.
    Length(fn(f64, &[f64]) -> f64),
}

/// The catalogue, in the order in which light goes: the clock, the shutter, then the camera's pose, projection and lens,
/// the grid of pixels, the scale.
const ALL: [MeasurementEffect; 9] = [
    time_scale::EFFECT,
    time_offset::EFFECT,
    observation_blur::EFFECT,
    rolling_shutter::EFFECT,
    camera_tilt::EFFECT,
    perspective::EFFECT,
    lens_distortion::EFFECT,
    aspect_ratio::EFFECT,
    length_scale::EFFECT,
];

impl MeasurementEffect {
    /// Whether these values mean that it is not there.
    pub fn is_absent(&self, values: &[f64]) -> bool {
        self.coefficients.iter().zip(values).all(|(c, v)| c.absent == *v)
    }

    /// Whether it reads everything late or early by the same.
    fn is_late(&self) -> bool {
        let typical: Vec<f64> = self.coefficients.iter().map(|c| c.typical).collect();
        match self.act {
            Act::Clock { to_true, .. } => to_true(0.0, &typical) != 0.0,
            _ => false,
        }
    }

    /// Its entry.
    pub fn entry(&self) -> Effect {
        Effect {
            late: self.is_late(),
            plausible: self.plausible.to_vec(),
            mistaken_for: self.mistaken_for.iter().map(|name| (*name).into()).collect(),
            ..Effect::new(self.name, Phase::Measurement, self.sentence, self.coefficients.to_vec())
        }
    }
}

/// The effect of this name that observations of `kind` can show, and its place in the order of action.
pub(super) fn find(name: &str, kind: Kind) -> Option<(usize, &'static MeasurementEffect)> {
    static LIST: [MeasurementEffect; 9] = ALL;
    LIST.iter().enumerate().find(|(_, e)| e.name == name && e.kinds.contains(&kind))
}

/// The effects of the measurement that observations of `kind` can show; see
/// [`Measured`](super::Measured), which applies them.
#[must_use]
pub fn measurement_effects(kind: Kind) -> Vec<Effect> {
    ALL.iter().filter(|e| e.kinds.contains(&kind)).map(MeasurementEffect::entry).collect()
}
