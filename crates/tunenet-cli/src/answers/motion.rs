//! What the motion of a ball shows: flights, bounces, gravity, noise, and every check.

use tunenet_ball::preflight::{ApparentGravity, Expected, Preflight, examine};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::statistics::median;
use tunenet_core::tune::channel_noise;

/// A recording that was looked at.
pub struct Motion {
    pub preflight: Preflight,
    pub kind: Kind,
    pub bounces: usize,
    pub noise: Option<f64>,
    pub rate_hz: f64,
    /// What was known beforehand.
    pub expected: Expected,
}

impl Motion {
    /// What it shows of a ball of which so much is known; `None` for kinds of which nothing is.
    pub fn of(seen: &Observation, expected: Expected) -> Option<Self> {
        let kind = seen.kind();
        if !matches!(kind, Kind::Positions | Kind::EventTimes) {
            return None;
        }
        // Stamps that count from 1970 are no concern of the checks.
        let moved = (kind == Kind::Positions).then(|| seen.from_zero());
        let preflight = examine(moved.as_ref().unwrap_or(seen), &expected);
        let coarse = usize::from(preflight.coarse.is_some());
        let listed = if seen.kind() == Kind::EventTimes { seen.len() } else { 0 };
        let bounces = preflight.arcs.as_ref().map_or(listed, |arcs| arcs.contacts.len() + coarse);
        let noise = preflight.kept.as_ref().map(|kept| channel_noise(kept)[kept.channels().len() - 1]);
        let rate_hz = 1.0 / median(seen.clock().windows(2).map(|w| w[1] - w[0])).unwrap_or(f64::NAN);
        Some(Self { preflight, kind, bounces, noise, rate_hz, expected })
    }

    pub fn gravity(&self) -> Option<ApparentGravity> {
        self.preflight.gravity
    }

    /// Why it cannot be used.
    pub fn rejected(&self) -> Option<&str> {
        self.preflight.rejected().map(|check| check.text.as_str())
    }

    /// What it is good for, where it bounces less than its kind promises.
    pub fn purpose(&self) -> Option<&'static str> {
        let flies_only = self.kind == Kind::Positions && self.bounces == 0;
        flies_only.then_some("forces in flight only; restitution and friction need a bounce")
    }

    /// What may be behind a gravity that is off.
    pub fn causes(&self) -> Vec<String> {
        let expected = self.expected.gravity_m_s2;
        let off = self.preflight.gravity.filter(|g| g.differs(expected));
        off.map(|g| g.causes(expected, self.rate_hz)).unwrap_or_default()
    }
}
