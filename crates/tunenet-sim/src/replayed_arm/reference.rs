//! Time alignment by maximum cross-correlation of speeds, with a parabola through the peak: a second run of the same motion without the
//! payload, put on the clock of the first.

use tunenet_core::observation::{Channel, Kind, Note, Observation};
use tunenet_core::{Error, Result};

use super::filter::{slope, smooth, whole};
use super::recorded::{columns, cubic, even_step, linear};
use crate::findings;

/// Speeds are compared below this frequency, Hz.
const COMPARED_HZ: f64 = 5.0;
/// Rate of the first comparison, Hz, and its most samples.
const COARSE_HZ: f64 = 20.0;
const COARSE_SAMPLES: f64 = 4000.0;
/// Rate of the second comparison, Hz, and its most samples.
const FINE_HZ: f64 = 500.0;
const FINE_SAMPLES: f64 = 100_000.0;
/// Speeds that agree less than this (cosine) are those of another motion.
const SAME: f64 = 0.9;
/// Positions farther apart than this are not those of one motion: the torques that a rigid arm needs would not cancel.
const NEAR_RAD: f64 = 0.2;
/// The runs have to overlap by this share of the shorter one.
const LEAST_OVERLAP: f64 = 0.3;

/// What a channel of the reference is called next to that of the run with payload.
const PREFIX: &str = "r";

/// Speeds of all joints on an even clock.
struct Speeds {
    step_s: f64,
    joints: usize,
    values: Vec<f64>,
}

impl Speeds {
    fn of(seen: &Observation, rate_hz: f64) -> Self {
        let (step_s, clock) = (1.0 / rate_hz, seen.clock());
        let positions = columns(seen, "q");
        let count = whole((clock[clock.len() - 1] - clock[0]) * rate_hz) + 1;
        let times: Vec<f64> = (0..count).map(|i| clock[0] + i as f64 * step_s).collect();
        let fine = even_step(clock);
        let mut values = vec![0.0; count * positions.len()];
        for (j, &column) in positions.iter().enumerate() {
            let raw: Vec<f64> = seen.column(column).collect();
            let smoothed = smooth(&raw, COMPARED_HZ.min(0.2 / fine), 1.0 / fine);
            let speed = slope(&linear(clock, &smoothed, &times), step_s);
            values.iter_mut().skip(j).step_by(positions.len()).zip(speed).for_each(|(v, s)| *v = s);
        }
        Self { step_s, joints: positions.len(), values }
    }

    fn len(&self) -> usize {
        self.values.len() / self.joints
    }

    /// The cosine between these speeds and `other` shifted by `lag` samples; nothing where they hardly overlap.
    fn alike(&self, other: &Self, lag: isize) -> Option<f64> {
        let from = lag.max(0).cast_unsigned();
        let to = (other.len().cast_signed() + lag).min(self.len().cast_signed()).max(0).cast_unsigned();
        if to <= from || ((to - from) as f64) < LEAST_OVERLAP * self.len().min(other.len()) as f64 {
            return None;
        }
        let mine = &self.values[from * self.joints..to * self.joints];
        let start = (from.cast_signed() - lag).cast_unsigned() * self.joints;
        let (mut both, mut a2, mut b2) = (0.0, 0.0, 0.0);
        for (a, b) in mine.iter().zip(&other.values[start..]) {
            both += a * b;
            a2 += a * a;
            b2 += b * b;
        }
        (a2 > 0.0 && b2 > 0.0).then(|| both / (a2 * b2).sqrt())
    }

    /// The best lag within a range, in samples with a fraction by the parabola through its neighbours, and its cosine.
    fn best(&self, other: &Self, range: std::ops::RangeInclusive<isize>) -> Option<(f64, f64)> {
        let scored = range.filter_map(|lag| Some((lag, self.alike(other, lag)?)));
        let (lag, best) = scored.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let (before, after) = (self.alike(other, lag - 1)?, self.alike(other, lag + 1)?);
        let bend = before - 2.0 * best + after;
        let fraction = if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
        Some((lag as f64 + fraction, best))
    }
}

/// How much later `seen` does what `reference` did, each counted from its own start, in s; and how alike both are (a cosine of
/// their speeds).
fn lag(seen: &Observation, reference: &Observation) -> Option<(f64, f64)> {
    let span = |o: &Observation| o.clock()[o.len() - 1] - o.clock()[0];
    // Every lag is tried, so that long logs are compared less often at first.
    let coarse_hz = COARSE_HZ.min(COARSE_SAMPLES / span(seen).max(span(reference)));
    let (a, b) = (Speeds::of(seen, coarse_hz), Speeds::of(reference, coarse_hz));
    let (most, least) = (a.len().cast_signed() - 1, 1 - b.len().cast_signed());
    let (coarse, _) = a.best(&b, least..=most)?;
    let rate = (1.0 / even_step(seen.clock())).clamp(coarse_hz, FINE_HZ.min(FINE_SAMPLES / span(seen)).max(coarse_hz));
    let (a, b) = (Speeds::of(seen, rate), Speeds::of(reference, rate));
    let near = (coarse.abs() * rate / coarse_hz).round();
    let near = if coarse < 0.0 { -whole(near).cast_signed() } else { whole(near).cast_signed() };
    let reach = whole((rate / coarse_hz).ceil()).cast_signed() + 2;
    let (fine, alike) = a.best(&b, near - reach..=near + reach)?;
    Some((fine * a.step_s, alike))
}

/// The run `seen` with the `reference` next to it: its channels under names with an `r` before, moved in time so that both do the
/// same at the same time, and cut to where both are. Also how they were aligned.
///
/// # Errors
/// [`Error::Observation`] where the two do not measure the same joints and quantities, do not move alike, or are one and the
/// same.
pub fn with_reference(seen: &Observation, reference: &Observation) -> Result<(Observation, Note)> {
    let refuse =
        |what: &str, expected: String, found: String| Err(Error::Observation { what: what.into(), expected, found });
    let names = |o: &Observation| {
        let kept = o.channels().iter().filter(|c| !c.name.starts_with("dq"));
        kept.map(|c| c.name.clone()).collect::<Vec<_>>().join(", ")
    };
    if reference.kind() != Kind::Joints || names(seen) != names(reference) || columns(seen, "q").is_empty() {
        return refuse("the reference", format!("the same channels as in the run ({})", names(seen)), names(reference));
    }
    let aligned = lag(seen, reference);
    let Some((lag_s, _)) = aligned.filter(|(_, alike)| *alike > SAME) else {
        let found = aligned.map_or("no overlap".into(), |(_, c)| format!("speeds that agree by {c:.2}"));
        return refuse("the reference", format!("the same motion (speeds that agree by {SAME} or more)"), found);
    };
    let shift = seen.clock()[0] - reference.clock()[0] + lag_s;
    let clock: Vec<f64> = reference.clock().iter().map(|t| t + shift).collect();
    let (first, last) = (clock[0], clock[clock.len() - 1]);
    let within: Vec<usize> = (0..seen.len()).filter(|&i| (first..=last).contains(&seen.clock()[i])).collect();
    let both = seen.slice(within[0]..within[within.len() - 1] + 1)?;
    let kept: Vec<usize> =
        (0..reference.channels().len()).filter(|&i| !reference.channels()[i].name.starts_with("dq")).collect();
    let moved: Vec<Vec<f64>> = kept
        .iter()
        .map(|&i| {
            let values: Vec<f64> = reference.column(i).collect();
            let smooth = reference.channels()[i].name.starts_with('q');
            if smooth { cubic(&clock, &values, both.clock()) } else { linear(&clock, &values, both.clock()) }
        })
        .collect();
    let mut channels = both.channels().to_vec();
    channels.extend(kept.iter().map(|&i| {
        let channel = &reference.channels()[i];
        Channel::new(format!("{PREFIX}{}", channel.name), channel.unit.clone())
    }));
    let mut values = Vec::with_capacity(both.len() * channels.len());
    for i in 0..both.len() {
        values.extend_from_slice(both.row(i));
        values.extend(moved.iter().map(|column| column[i]));
    }
    let apart = apart_rad(&both, &moved, &kept, reference);
    if apart > NEAR_RAD {
        let expected = format!("the same positions within {NEAR_RAD} rad (RMS); are its angles in degrees?");
        return refuse("the reference", expected, format!("{apart:.3} rad apart"));
    }
    if seen.values() == reference.values() {
        return refuse("the reference", "a run without the payload".into(), "the same torques as in the run".into());
    }
    let seen = Observation::new(Kind::Joints, channels, both.clock().to_vec(), values)?;
    let text = format!(
        "the reference was aligned by a lag of {lag_s:+.3} s; {:.1} s of both \
         are used, and the positions agree to {apart:.4} rad (RMS)",
        both.clock()[both.len() - 1] - both.clock()[0]
    );
    Ok((seen, Note::new(findings::REFERENCE_ALIGNED, text, "")))
}

fn apart_rad(both: &Observation, moved: &[Vec<f64>], kept: &[usize], reference: &Observation) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for column in columns(both, "q") {
        let name = &both.channels()[column].name;
        let at = kept.iter().position(|&i| reference.channels()[i].name == *name);
        for (a, b) in both.column(column).zip(at.map_or(&[][..], |at| moved[at].as_slice())) {
            sum += (a - b).powi(2);
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}
