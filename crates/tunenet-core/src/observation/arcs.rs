//! Cutting a ball's positions into free flight and contacts.
//!
//! In free flight `w = z + g t²/2` is a straight line, so an impact is a kink of `w` upwards. Kinks are found as slope
//! differences between the samples before and after, and then located where the two neighbouring flights cross. Nothing
//! is smoothed, and no sample is judged by anything but its own flight.

use std::ops::Range;

use super::lasting::lasting;
use super::line::Polynomial;
use super::local::{LocalEstimate, widened};
use super::parabolas::parabolas;
use super::release::release;
use super::{Kind, Note, Observation, noise_sd};

/// A slope difference counts as a kink from this many of its standard deviations on. Noise alone reaches it once in
/// 10^9 samples; the weakest impact that can be tuned to has far more.
const KINK_SIGNIFICANCE: f64 = 6.0;
/// ... and from this many times the change of speed that gravity alone makes between the two windows, so that a ball that
/// is held or rests is no impact.
const KINK_OVER_GRAVITY: f64 = 2.5;
/// ... and from this many times the slope difference that the record shows everywhere, so that slow errors of a camera,
/// which third differences do not see, are no impacts either.
const KINK_OVER_TYPICAL: f64 = 4.0;
/// A blow changes the velocity by more than this share of the typical speed; air does not.
const BLOW_SHARE: f64 = 0.3;
/// The kink detector looks at least at this many samples on either side.
const LEAST_WINDOW: f64 = 4.0;
/// The flights beside a contact are shortened until a parabola explains them to this many times the noise ...
const LOCAL_MISFIT: f64 = 1.6;
/// ... but not below this many samples.
const LOCAL_SAMPLES: usize = 12;
/// A restitution read off one contact with a greater standard deviation says nothing.
const LOCAL_WORST_SD: f64 = 0.2;
/// Fewer samples say nothing of their acceleration.
const FEWEST_FOR_GRAVITY: usize = 6;
/// Above this Coulomb coefficient a change of horizontal speed is a blow, not friction.
const GREATEST_FRICTION: f64 = 1.2;

/// A rise after a fall is none of the noise from this many times its standard deviation, and this share of all heights, on:
/// the difference of two samples is √2 as noisy as each.
const LATE_RISE: f64 = 6.0 * std::f64::consts::SQRT_2;
const LATE_SHARE: f64 = 0.005;
/// A bounce is late where its lowest sample is one of so many at the end ...
const LATE_SAMPLES: usize = 3;
/// ... and as many are left before it.
const LEAST_BEFORE_LATE: usize = 3;

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
    /// What was set aside and why.
    pub notes: Vec<Note>,
    /// The lowest sample of a first bounce so near the end that no flight follows it; what is usable ends before it.
    pub(super) late: Option<usize>,
    /// Every place in the record where the velocity changes at once, impacts or not: the last sample before each.
    pub(super) kinks: Vec<usize>,
}

impl Arcs {
    /// Cuts `seen`, positions of a ball under gravity `gravity_m_s2`. `None` for other kinds of observation.
    #[must_use]
    pub fn cut(seen: &Observation, gravity_m_s2: f64) -> Option<Self> {
        if seen.kind() != Kind::Positions {
            return None;
        }
        let axes: [Vec<f64>; 3] = [0, 1, 2].map(|axis| seen.column(axis).collect());
        let mut notes = Vec::new();
        let mut kinks = Kinks::find(seen.clock(), &axes, gravity_m_s2);
        let late = kinks.take_late(&axes[2]);
        let mut usable = kinks.usable(&mut notes, seen.clock());
        let inside: Vec<usize> =
            kinks.impacts.iter().copied().filter(|&k| k > usable.start + 1 && k + 1 < usable.end).collect();
        let release = release(seen.clock(), &axes[2], usable.start, *inside.first().unwrap_or(&usable.end));
        if release > usable.start {
            let held = seen.clock()[release] - seen.clock()[usable.start];
            let text = format!("the first {held:.3} s before the release were set aside");
            notes.push(Note::new("release.late", text, ""));
            usable.start = release;
        }
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
            notes,
            late,
            kinks: kinks.all(),
        })
    }

    /// Leaves out what comes from sample `end` on.
    pub(super) fn end_at(&mut self, end: usize, clock: &[f64]) {
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

/// Where the motion kinks.
struct Kinks {
    samples: usize,
    /// Samples at either end in which none can be told.
    blind: usize,
    /// Impacts on the surface: the flight before ends at this sample, the next begins after it.
    impacts: Vec<usize>,
    /// Anything else that changes the velocity at once: a hand, a racket, another surface.
    blows: Vec<usize>,
}

impl Kinks {
    fn find(clock: &[f64], axes: &[Vec<f64>; 3], gravity: f64) -> Self {
        let samples = clock.len();
        let straight: Vec<f64> = clock.iter().zip(&axes[2]).map(|(t, z)| z + gravity / 2.0 * t * t).collect();
        let sd = [0, 1, 2].map(|axis| noise_sd(&axes[axis]));
        let half = window(clock, &axes[2], sd[2], gravity);
        if samples < 2 * half + 1 {
            return Self { samples, blind: half, impacts: Vec::new(), blows: Vec::new() };
        }
        let slope = |values: &[f64], range: Range<usize>| {
            Polynomial::fit(&clock[range.clone()], &values[range.clone()], clock[range.start], Some(0.0))
        };
        // Each kink is a local maximum of its slope difference within one window on either side.
        let jump = |values: &[f64], k: usize| -> Option<(f64, f64, f64)> {
            let (before, after) = (slope(values, k + 1 - half..k + 1)?, slope(values, k + 1..k + 1 + half)?);
            let gain = before.slope_gain(clock[k]).hypot(after.slope_gain(clock[k]));
            Some((after.slope(clock[k]) - before.slope(clock[k]), gain, clock[k + half] - clock[k + 1 - half]))
        };
        let range = half - 1..samples - half;
        let profile = |values: &[f64]| -> Vec<(f64, f64, f64)> {
            range.clone().map(|k| jump(values, k).unwrap_or((0.0, 0.0, 0.0))).collect()
        };
        // A kink stands out of the noise, of gravity's own bend, and of whatever the whole record shows.
        let judged = |profile: &[(f64, f64, f64)], sd: f64, least: f64| -> Vec<(f64, bool)> {
            let typical = typical(profile.iter().map(|p| p.0.abs())) * KINK_OVER_TYPICAL;
            let limit = |&(_, gain, span): &(f64, f64, f64)| {
                (KINK_SIGNIFICANCE * gain * sd).max(KINK_OVER_GRAVITY * gravity * span / 2.0).max(typical).max(least)
            };
            profile.iter().map(|p| (p.0, p.0 > limit(p))).collect()
        };
        let up = judged(&profile(&straight), sd[2], 0.0);
        let speed = median(range.clone().map(|k| {
            let along = |axis: usize| {
                (axes[axis][k + half] - axes[axis][k + 1 - half]) / (clock[k + half] - clock[k + 1 - half])
            };
            along(0).hypot(along(1)).hypot(along(2))
        }));
        let across: Vec<(f64, f64, f64)> =
            profile(&axes[0]).iter().zip(profile(&axes[1])).map(|(x, y)| (x.0.hypot(y.0), x.1, x.2)).collect();
        let across = judged(&across, sd[0].hypot(sd[1]), BLOW_SHARE * speed);
        let peaks = |signal: &[(f64, bool)]| -> Vec<usize> {
            (0..signal.len())
                .filter(|&i| {
                    let near = i.saturating_sub(half)..(i + half + 1).min(signal.len());
                    signal[i].1
                        && near.clone().all(|j| signal[j].0 < signal[i].0 || j >= i && signal[j].0 <= signal[i].0)
                })
                .map(|i| i + range.start)
                .collect()
        };
        let (mut impacts, mut blows) = (Vec::new(), Vec::new());
        let mut surface: Option<f64> = None;
        let (sharp, aside) = (peaks(&up), peaks(&across));
        let lasting = lasting(clock, [&axes[0], &axes[1], &straight], &[sharp.as_slice(), &aside].concat(), half);
        let stays = |mut kinks: Vec<usize>| {
            kinks.retain(|k| lasting.contains(k));
            kinks
        };
        let (sharp, aside) = (stays(sharp), stays(aside));
        // A weak rebound, seen by few frames, stands out from nothing; the fewest parabolas still end there.
        let places = if sharp.is_empty() { cuts(clock, &axes[2], &range) } else { sharp };
        for k in places {
            let lines = (slope(&straight, k + 1 - half..k + 1), slope(&straight, k + 1..k + 1 + half));
            let (Some(before), Some(after)) = lines else { continue };
            let time = crossing(&before, &after, clock[k], clock[k + 1]);
            let height = before.at(time) - gravity / 2.0 * time * time;
            let (fall, rise) = (before.slope(time) - gravity * time, after.slope(time) - gravity * time);
            // What the noise leaves unsure of a speed, and of a height.
            let doubt = 0.5 * KINK_SIGNIFICANCE * sd[2] * before.slope_gain(time).hypot(after.slope_gain(time));
            let slack = KINK_SIGNIFICANCE * sd[2]
                + 0.5 * (fall.abs() + doubt) * (clock[k + 1] - clock[k])
                + 0.02 * span(&axes[2]);
            let level = surface.is_none_or(|s: f64| (height - s).abs() < slack);
            let shift = across[k - range.start].0;
            let unsure =
                0.5 * KINK_SIGNIFICANCE * sd[0].hypot(sd[1]) * before.slope_gain(time).hypot(after.slope_gain(time));
            let rubbed = shift <= GREATEST_FRICTION * (rise - fall) + doubt + unsure;
            let energetic = rise > -0.3 * fall.abs() - doubt && rise < 1.3 * fall.abs() + doubt;
            if fall < doubt && level && rubbed && energetic {
                surface = Some(surface.map_or(height, |s: f64| s.min(height)));
                impacts.push(k);
            } else {
                blows.push(k);
            }
        }
        for k in aside {
            if impacts.iter().chain(&blows).all(|&i| i.abs_diff(k) > half) {
                blows.push(k);
            }
        }
        blows.sort_unstable();
        Self { samples, blind: half, impacts, blows }
    }

    fn all(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.impacts.iter().chain(&self.blows).copied().collect();
        all.sort_unstable();
        all
    }

    /// The sample at which a first bounce begins that is too near the end for a flight after it: the ball falls to it and
    /// rises after it, which no flight does. The record ends there then, and what seemed a kink beside it is none.
    fn take_late(&mut self, heights: &[f64]) -> Option<usize> {
        let last = heights.len().checked_sub(LATE_SAMPLES).filter(|from| *from >= LEAST_BEFORE_LATE)?;
        let low = (last..heights.len()).min_by(|&a, &b| heights[a].total_cmp(&heights[b]))?;
        let clear = LATE_RISE * noise_sd(heights) + LATE_SHARE * span(heights);
        let highest = heights[low..].iter().fold(f64::NEG_INFINITY, |high, z| high.max(*z));
        let falls = heights[low - 2] > heights[low - 1] && heights[low - 1] > heights[low] + clear;
        let beside = |k: &usize| k + self.blind + 1 >= low;
        if !falls || highest < heights[low] + clear || !self.impacts.iter().all(beside) {
            return None;
        }
        let blind = self.blind;
        self.impacts.clear();
        self.blows.retain(|k| k + blind + 1 < low);
        self.samples = low;
        Some(low)
    }

    /// The longest stretch with the most impacts and no blow inside.
    fn usable(&self, notes: &mut Vec<Note>, clock: &[f64]) -> Range<usize> {
        let cuts: Vec<usize> = self.blows.iter().copied().chain([self.samples]).collect();
        let mut best = 0..0;
        let mut best_rank = (0, 0);
        let mut start = 0;
        for &cut in &cuts {
            // A window's width on either side of a blow still feels it.
            let end = if cut == self.samples { cut } else { cut.saturating_sub(1) };
            let impacts = self.impacts.iter().filter(|&&k| k > start && k < end).count();
            let rank = (impacts.min(1), end.saturating_sub(start));
            if end > start && rank > best_rank {
                (best, best_rank) = (start..end, rank);
            }
            start = cut + 2;
        }
        if best.len() < self.samples && !self.blows.is_empty() {
            let times: Vec<String> = self.blows.iter().take(4).map(|&k| format!("{:.3} s", clock[k])).collect();
            let text = format!(
                "something other than the surface changes the velocity at {}{}: samples {} to {} of {} are used",
                times.join(", "),
                if self.blows.len() > 4 { " and later" } else { "" },
                best.start + 1,
                best.end,
                self.samples
            );
            notes.push(Note::new(
                "motion.blow",
                text,
                "record without touching the ball; a hand, a racket or a second surface does this",
            ));
        }
        best
    }
}

/// The samples of `range` at which one of the fewest parabolas that explain the heights falls and the next does so less.
fn cuts(clock: &[f64], heights: &[f64], range: &Range<usize>) -> Vec<usize> {
    let fit =
        |part: &Range<usize>| Polynomial::fit(&clock[part.clone()], &heights[part.clone()], clock[part.start], None);
    let pieces: Vec<Range<usize>> = parabolas(clock, heights).into_iter().filter(|p| p.len() > 3).collect();
    let mut places = Vec::new();
    for pair in pieces.windows(2) {
        let (Some(before), Some(after)) = (fit(&pair[0]), fit(&pair[1])) else { continue };
        let k = pair[0].end - 1;
        let (falls, then) = (before.slope(clock[k]), after.slope(clock[k]));
        // A release is no kink: its speed does not change.
        let clear =
            (then - falls) > 0.5 * falls.abs() + KINK_SIGNIFICANCE * noise_sd(heights) * before.slope_gain(clock[k]);
        if falls < 0.0 && clear && range.contains(&k) {
            places.push(k);
        }
    }
    places
}

/// Half the width of the kink detector, in samples: the fewest whose slopes are known to a fourteenth of the speed of a fall
/// through the range of heights seen.
fn window(clock: &[f64], heights: &[f64], sd: f64, gravity: f64) -> usize {
    let step = (clock[clock.len() - 1] - clock[0]) / (clock.len() - 1) as f64;
    let speed = (2.0 * gravity * span(heights)).sqrt();
    // The slope of m even samples has standard deviation sd·√12 / (step · m^1.5).
    let wanted = (12f64.sqrt() * sd * 14.0 / (step * speed).max(f64::MIN_POSITIVE)).powf(2.0 / 3.0).ceil();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let wanted = wanted.clamp(LEAST_WINDOW, 1e6) as usize;
    wanted.min((clock.len() / 6).max(3))
}

/// A standard deviation by the median of absolute values, or by their lower quartile where that is less: in a short record
/// with many kinks, or one that ends in a long rest, half of the windows hold something else than noise.
fn typical(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |place: usize| sorted.get(place).copied().unwrap_or(0.0);
    // Half of a normal distribution's absolute values lie below .6745 standard deviations, a quarter below .3186.
    (at(sorted.len() / 2) / 0.6745).min(at(sorted.len() / 4) / 0.3186)
}

pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

pub(super) fn span(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    high - low
}

/// Locates every impact where the flights beside it cross and measures its restitution.
fn contacts(clock: &[f64], heights: &[f64], usable: &Range<usize>, impacts: &[usize], gravity: f64) -> Vec<Contact> {
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
fn crossing(down: &Polynomial, up: &Polynomial, before: f64, after: f64) -> f64 {
    // Their difference is a line; it is zero where they cross.
    let (difference, slope) = (up.at(before) - down.at(before), up.slope(before) - down.slope(before));
    let time = before - difference / slope;
    let slack = after - before;
    if (before - slack..=after + slack).contains(&time) { time } else { before.midpoint(after) }
}

/// Rebound over approach speed, from the widest samples beside the contact that a parabola of free acceleration explains.
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
                let spread = whole.residual_sd.max(sd) * whole.slope_gain(time_s);
                let spread = widened(spread.hypot(stray), length as f64 - 3.0);
                return (length >= 4).then_some((slope, spread));
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
