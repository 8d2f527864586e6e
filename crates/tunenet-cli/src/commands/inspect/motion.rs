//! What `inspect` says of a ball's motion: flights, bounces, gravity, noise, and every check.

use serde_json::{Value, json};
use tunenet_ball::preflight::{ApparentGravity, Expected, Preflight, examine};
use tunenet_core::observation::{Check, State};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::statistics::median;
use tunenet_core::tune::channel_noise;

use crate::view::answer::Printout;
use crate::view::text::{in_words, tally};

/// A recording that was looked at.
pub struct Motion {
    preflight: Preflight,
    kind: Kind,
    bounces: usize,
    noise: Option<f64>,
    rate_hz: f64,
}

impl Motion {
    /// `None` for kinds of which nothing is known.
    pub fn of(seen: &Observation) -> Option<Self> {
        let kind = seen.kind();
        if !matches!(kind, Kind::Positions | Kind::EventTimes) {
            return None;
        }
        // Stamps that count from 1970 are no concern of the checks.
        let moved = (kind == Kind::Positions).then(|| seen.from_zero());
        let preflight = examine(moved.as_ref().unwrap_or(seen), &Expected::default());
        let coarse = usize::from(preflight.coarse.is_some());
        let listed = if seen.kind() == Kind::EventTimes { seen.len() } else { 0 };
        let bounces = preflight.arcs.as_ref().map_or(listed, |arcs| arcs.contacts.len() + coarse);
        let noise = preflight.kept.as_ref().map(|kept| channel_noise(kept)[kept.channels().len() - 1]);
        let rate_hz = 1.0 / median(seen.clock().windows(2).map(|w| w[1] - w[0])).unwrap_or(f64::NAN);
        Some(Self { preflight, kind, bounces, noise, rate_hz })
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
        flies_only.then_some("forces of flight alone; without a bounce neither restitution nor friction")
    }

    pub fn render(&self, shown: &mut Printout) {
        let plural = |n: usize, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
        let noise = self.noise.map(|n| {
            let unit = if self.kind == Kind::Positions { "m" } else { "s" };
            format!(", noise {}", in_words(n, unit))
        });
        let flights = self.preflight.gravity.map(|g| format!("{} of free flight, ", plural(g.flights, "stretch")));
        let flights = flights.map(|text| text.replace("stretchs", "stretches"));
        let bounces = plural(self.bounces, "bounce");
        shown.row("motion", &format!("{}{bounces}{}", flights.unwrap_or_default(), noise.unwrap_or_default()));
        if let Some(gravity) = self.preflight.gravity {
            render_gravity(&gravity, "", shown);
        }
        shown.row("checked", &tally(&self.preflight.checks));
        for check in &self.preflight.checks {
            match check.state {
                State::Noticed | State::Failed => check.note().iter().for_each(|note| shown.warn(note)),
                State::NotRun | State::Passed => {}
            }
        }
    }

    /// "3 bounces", gravity and the checks, for a table of several files.
    pub fn row(&self) -> Vec<String> {
        let gravity = self.preflight.gravity.map_or_else(|| "-".into(), |g| g.text());
        let noticed = self.preflight.checks.iter().filter(|c| matches!(c.state, State::Noticed | State::Failed));
        let noticed: Vec<&str> = noticed.map(|c| c.kind.code()).collect();
        let noticed = if noticed.is_empty() { "all passed".into() } else { noticed.join(", ") };
        vec![self.bounces.to_string(), gravity, noticed]
    }

    /// Adds what was found to the object of a file.
    pub fn add_to(&self, object: &mut Value) {
        object["bounces"] = json!(self.bounces);
        object["gravity"] = json!(self.preflight.gravity.as_ref().map(gravity_json));
        if self.kind == Kind::Positions {
            object["noise_m"] = json!(self.noise);
            object["causes"] = json!(self.causes());
        }
        object["preflight"] = json!(self.preflight.checks);
        if let Some(warnings) = object["warnings"].as_array_mut() {
            let notes = self.preflight.checks.iter().filter_map(Check::note);
            warnings.extend(notes.map(|n| json!({ "code": n.kind, "text": n.text, "remedy": n.remedy })));
        }
    }

    /// What may be behind a gravity that is off.
    fn causes(&self) -> Vec<String> {
        let expected = Expected::default().gravity_m_s2;
        let off = self.preflight.gravity.filter(|g| g.differs(expected));
        off.map(|g| g.causes(expected, self.rate_hz)).unwrap_or_default()
    }

    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }
}

pub fn gravity_json(gravity: &ApparentGravity) -> Value {
    let (low, high) = gravity.interval95_m_s2;
    json!({
        "value_m_s2": gravity.value_m_s2, "interval95_m_s2": [low, high],
        "flights": gravity.flights, "samples": gravity.samples,
    })
}

/// "gravity  9.62 m/s² (95 %: 9.58 to 9.66), 1.9 % below 9.81".
pub fn render_gravity(gravity: &ApparentGravity, from: &str, shown: &mut Printout) {
    let expected = Expected::default().gravity_m_s2;
    let percent = 100.0 * (gravity.value_m_s2 / expected - 1.0);
    let place = if gravity.differs(expected) {
        format!("{:.1} % {} {expected}", percent.abs(), if percent < 0.0 { "below" } else { "above" })
    } else {
        format!("{expected} expected")
    };
    shown.row("gravity", &format!("{}{from}, {place}", gravity.text()));
}
