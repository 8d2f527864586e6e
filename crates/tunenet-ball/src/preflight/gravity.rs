//! Apparent gravity of a record: the common acceleration of its flights, with its interval, and possible causes of a difference.

use super::Expected;
use super::flights::{Flight, Flights};
use crate::findings;
use tunenet_core::finding::FindingKind;
use tunenet_core::observation::{Check, State};
use tunenet_core::statistics::{NORMAL_95, UPPER_95, mad_sd, median, student_quantile};

/// A difference below this share has no practical significance.
const PRACTICAL: f64 = 0.01;
/// ... and it has to exceed noise by this many standard deviations: once in a thousand records.
const SIGNIFICANT: f64 = 3.3;
/// What passes for gravity, as a share of what is expected: air alone halves it for a light ball.
pub(crate) const PLAUSIBLE: std::ops::Range<f64> = 0.3..2.0;
/// A cause is named where its factor agrees to this share, or to the interval.
const AGREES: f64 = 0.02;
/// Frames per second that cameras and programs use.
const FRAME_RATES_HZ: [f64; 7] = [24.0, 25.0, 30.0, 50.0, 60.0, 120.0, 240.0];
/// A clock is that of a frame rate within this share.
const SAME_RATE: f64 = 0.02;
/// A recording this many typical spreads from the median of several is of something else.
const FAR: f64 = 5.0;
/// No more causes than this are worth reading.
const MOST_CAUSES: usize = 3;

/// The downward acceleration of free flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ApparentGravity {
    /// The estimate, m/s².
    pub value_m_s2: f64,
    /// Its standard deviation, m/s², with the scatter between flights.
    pub sd_m_s2: f64,
    /// Its 95 % interval, m/s².
    pub interval95_m_s2: (f64, f64),
    /// How many flights it comes from.
    pub flights: usize,
    /// How many samples they hold.
    pub samples: usize,
    /// How the acceleration changes along a flight, in standard deviations: air makes a ball fall ever more slowly than
    /// gravity alone, which is above 0 both in rise and in fall.
    pub bend: f64,
}

impl ApparentGravity {
    /// One common acceleration of all flights by least squares; `None` where there are none.
    pub(crate) fn of(clock: &[f64], heights: &[f64], found: &Flights) -> Option<Self> {
        let flights = &found.flights;
        let samples: usize = flights.iter().map(|f| f.samples.len()).sum();
        let degrees_of_freedom = samples.checked_sub(2 * flights.len() + 1).filter(|f| *f > 0)? as f64;
        let weight: f64 = flights.iter().map(|f| f.fit.curvature_gain().powi(-2)).sum();
        let each = Flight::acceleration;
        let value = flights.iter().map(|f| each(f) * f.fit.curvature_gain().powi(-2)).sum::<f64>() / weight;
        // Residuals about each flight's own parabola; how neighbours follow each other; the cubic that is left of them.
        let (mut squares, mut products, mut cubic, mut cubic_weight) = (0.0, 0.0, 0.0, 0.0);
        for flight in flights {
            let part = flight.samples.clone();
            let half = (clock[part.end - 1] - clock[part.start]) / 2.0;
            let left: Vec<f64> = part.clone().map(|i| heights[i] - flight.fit.at(clock[i])).collect();
            squares += left.iter().map(|r| r * r).sum::<f64>();
            products += left.windows(2).map(|w| w[0] * w[1]).sum::<f64>();
            for (i, r) in part.zip(&left) {
                let u = (clock[i] - flight.fit.origin) / half;
                // The third Legendre polynomial is orthogonal to parabolas; its size grows with the cube of the duration.
                let shape = (u * u * u - 0.6 * u) * half.powi(3);
                cubic += shape * r;
                cubic_weight += shape * shape;
            }
        }
        let sd = (squares / (samples as f64 - 3.0 * flights.len() as f64).max(1.0)).sqrt();
        let follow = (products / squares.max(f64::MIN_POSITIVE)).clamp(0.0, 0.9);
        // Short stretches follow each other by coincidence.
        let follow = if follow > 2.0 / (samples as f64).sqrt() { (1.0 + follow) / (1.0 - follow) } else { 1.0 };
        let own_sd = |f: &Flight| 2.0 * f.fit.curvature_gain() * sd;
        let scatter: f64 = flights.iter().map(|f| ((each(f) - value) / own_sd(f).max(f64::MIN_POSITIVE)).powi(2)).sum();
        let between = if flights.len() > 1 { (scatter / (flights.len() - 1) as f64).max(1.0) } else { 1.0 };
        let sd_m_s2 = 2.0 * sd / weight.sqrt() * follow.max(between).sqrt();
        let half = student_quantile(UPPER_95, degrees_of_freedom) * sd_m_s2;
        Some(Self {
            value_m_s2: value,
            sd_m_s2,
            interval95_m_s2: (value - half, value + half),
            flights: flights.len(),
            samples,
            bend: cubic / (cubic_weight.sqrt() * sd).max(f64::MIN_POSITIVE) / follow.sqrt(),
        })
    }

    /// Several recordings of the same set-up together, each counting by its certainty; the interval covers the scatter
    /// between them. Recordings far from the median are left out. `None` where there are none.
    #[must_use]
    pub fn pooled(all: &[Self]) -> Option<Self> {
        let middle = median(all.iter().map(|g| g.value_m_s2)).unwrap_or(0.0);
        let sd = mad_sd(all.iter().map(|g| g.value_m_s2 - middle));
        let far = |g: &&Self| (g.value_m_s2 - middle).abs() <= FAR * sd.hypot(g.sd_m_s2);
        let near: Vec<Self> = all.iter().filter(far).copied().collect();
        let count = near.len() as f64;
        // One recording does not outweigh all others, however quiet it is: its own camera's error is not in its noise.
        let weight = |g: &Self| g.sd_m_s2.hypot(sd).max(1e-12).powi(-2);
        let total: f64 = near.iter().map(weight).sum();
        let value = near.iter().map(|g| weight(g) * g.value_m_s2).sum::<f64>() / total;
        let scatter: f64 = near.iter().map(|g| weight(g) * (g.value_m_s2 - value).powi(2)).sum();
        let between = if near.len() > 1 { (scatter / (count - 1.0)).max(1.0) } else { 1.0 };
        let sd = (between / total).sqrt();
        let quantile = if near.len() > 1 { student_quantile(UPPER_95, count - 1.0) } else { NORMAL_95 };
        (!near.is_empty()).then(|| Self {
            value_m_s2: value,
            sd_m_s2: sd,
            interval95_m_s2: (value - quantile * sd, value + quantile * sd),
            flights: near.iter().map(|g| g.flights).sum(),
            samples: near.iter().map(|g| g.samples).sum(),
            bend: near.iter().map(|g| g.bend).sum::<f64>() / count.sqrt(),
        })
    }

    /// "9.62 m/s² (95 %: 9.58 to 9.66)".
    #[must_use]
    pub fn text(&self) -> String {
        let (low, high) = self.interval95_m_s2;
        // Two digits of its uncertainty; no fall is known to more than four decimals.
        let half = ((high - low) / 2.0).max(1e-3 * self.value_m_s2.abs()).max(f64::MIN_POSITIVE);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let digits = (1.0 - half.log10().floor()).clamp(0.0, 15.0) as usize;
        format!("{:.*} m/s² (95 %: {:.*} to {:.*})", digits, self.value_m_s2, digits, low, digits, high)
    }

    /// Whether it differs from `expected` by more than noise and by more than the tolerance.
    #[must_use]
    pub fn differs(&self, expected_m_s2: f64) -> bool {
        let difference = (self.value_m_s2 - expected_m_s2).abs();
        difference > PRACTICAL * expected_m_s2 && difference > SIGNIFICANT * self.sd_m_s2
    }

    fn ratio(&self, expected_m_s2: f64) -> f64 {
        self.value_m_s2 / expected_m_s2
    }

    /// Whether no ball falls like that, air and a wrong scale included.
    pub(crate) fn implausible(&self, expected_m_s2: f64) -> bool {
        let slack = 5.0 * self.sd_m_s2;
        let (low, high) = (PLAUSIBLE.start * expected_m_s2, PLAUSIBLE.end * expected_m_s2);
        self.value_m_s2 + slack < low || self.value_m_s2 - slack > high
    }

    /// What may be behind the difference, the likeliest first.
    #[must_use]
    pub fn causes(&self, expected_m_s2: f64, rate_hz: f64) -> Vec<String> {
        let ratio = self.ratio(expected_m_s2);
        let unsure = (2.0 * self.sd_m_s2 / self.value_m_s2.abs()).max(AGREES);
        let agrees = |factor: f64| (ratio / factor).ln().abs() < unsure;
        let mut causes: Vec<(f64, String)> = Vec::new();
        let mut cause = |rank: f64, text: String| causes.push((rank, text));
        let off = |factor: f64| (ratio / factor).ln().abs();
        if agrees(0.25) {
            cause(off(0.25), "every frame occurs twice in the record, or its clock runs at half speed".into());
        }
        if agrees(4.0) {
            cause(off(4.0), "every second frame is missing, or the clock runs at double speed".into());
        }
        if let Some(said) = FRAME_RATES_HZ.iter().find(|f| (rate_hz / **f - 1.0).abs() < SAME_RATE) {
            for taken in FRAME_RATES_HZ.iter().filter(|f| *f != said && agrees((said / **f).powi(2))) {
                let factor = (said / taken).powi(2);
                cause(off(factor), format!("frames were taken at {taken} Hz, though the clock says {said} Hz"));
            }
        }
        if (expected_m_s2 - 9.81).abs() > 0.1 && agrees(9.81 / expected_m_s2) {
            let text = format!("the record falls as on earth, though gravity is given as {expected_m_s2} m/s²");
            cause(-1.0, text);
        }
        if (0.3..1.0).contains(&ratio) {
            // The bend along a flight is air's own sign; a scale or a clock leaves the path a parabola.
            let rank = if self.bend > 3.0 { 0.0 } else { 0.2 };
            cause(rank, "air holds the ball back".into());
        }
        if PLAUSIBLE.contains(&ratio) {
            let way = if ratio < 1.0 { "short" } else { "long" };
            let percent = 100.0 * (ratio - 1.0).abs();
            cause(0.1, format!("vertical lengths are {percent:.1} % too {way} (scale, camera)"));
            let spin = if ratio < 1.0 { "lifts" } else { "presses down" };
            cause(0.35, format!("spin {spin} the ball"));
            let clock = 100.0 * (1.0 / ratio.sqrt() - 1.0).abs();
            let speed = if ratio < 1.0 { "slow" } else { "fast" };
            // Time read off a clock that runs fast is too long, and what falls seems to fall more slowly.
            let speed = if speed == "slow" { "fast" } else { "slow" };
            cause(0.3, format!("the clock runs {clock:.1} % too {speed}"));
        }
        causes.sort_by(|a, b| a.0.total_cmp(&b.0));
        causes.into_iter().take(MOST_CAUSES).map(|c| c.1).collect()
    }
}

/// The check of gravity within what is plausible; [`units`](super::units) answers for the rest.
pub(crate) fn check(found: Option<&ApparentGravity>, expected: &Expected, rate_hz: f64) -> Check {
    const KIND: FindingKind = findings::GRAVITY_APPARENT;
    let Some(found) = found else {
        return Check::not_run(KIND, "no free flight is long enough to measure the fall");
    };
    let gravity = expected.gravity_m_s2;
    let seen = format!("free flight falls at {}", found.text());
    if found.implausible(gravity) {
        let causes = found.causes(gravity, rate_hz);
        let text =
            format!("{seen}, {:.3} times the expected {gravity}: not plausible for a ball", found.ratio(gravity));
        return Check::failed(KIND, text, remedy(&causes));
    }
    if !found.differs(gravity) {
        return Check::passed(KIND, format!("{seen}, expected {gravity}"));
    }
    let percent = 100.0 * (found.ratio(gravity) - 1.0);
    let way = if percent < 0.0 { "below" } else { "above" };
    let text = format!("{seen}, {:.1} % {way} {gravity}", percent.abs());
    if expected.forces_known {
        return Check {
            state: State::Passed,
            ..Check::passed(KIND, format!("{text}; expected, because the simulation has forces in flight"))
        };
    }
    Check::noticed(KIND, text, remedy(&found.causes(gravity, rate_hz)))
}

fn remedy(causes: &[String]) -> String {
    match causes {
        [] => "check the scale of the lengths and the clock".into(),
        [only] => format!("perhaps {only}"),
        [first, rest @ ..] => format!("perhaps {first}; or {}", rest.join("; or ")),
    }
}
