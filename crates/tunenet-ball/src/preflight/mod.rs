//! Preflight: what is checked of a recording before anything is tuned to it, and how each check ended.

mod bounces;
mod clock;
mod flights;
mod gravity;
mod motion;
mod skipped;
mod surface;
mod units;
mod values;

pub use gravity::ApparentGravity;

use flights::Flights;
use surface::Level;

use crate::segmentation::{Arcs, FirstFall};
use tunenet_core::observation::{Check, Kind, Note, Observation, State};

/// What is known of the set-up of a recording before looking at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Gravity, m/s², downwards.
    pub gravity_m_s2: f64,
    /// Whether the simulation has forces of flight beyond gravity, so that free flight may fall otherwise.
    pub forces_known: bool,
    /// Radius of the ball, m.
    pub radius_m: Option<f64>,
    /// Height of the surface, m.
    pub surface_height_m: Option<f64>,
    /// Height of fall, m, from the ball's lowest point to the surface.
    pub release_height_m: Option<f64>,
}

impl Default for Expected {
    /// Gravity as on earth, and nothing else.
    fn default() -> Self {
        Self { gravity_m_s2: 9.81, forces_known: false, radius_m: None, surface_height_m: None, release_height_m: None }
    }
}

/// Which bounces a recording of positions shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bounces {
    /// At least one, at a known time.
    Timed,
    /// One, in too few samples to determine its time: [`Preflight::coarse`].
    Coarse,
    /// One at the very end, which no flight follows.
    TooLate,
    /// None.
    None,
}

impl Bounces {
    /// Whether the recording says anything about contacts.
    #[must_use]
    pub fn can_be_examined(self) -> bool {
        matches!(self, Self::Timed | Self::Coarse)
    }
}

/// A recording that was looked at.
#[derive(Debug, Clone)]
pub struct Preflight {
    /// Every check, in the order in which they were made.
    pub checks: Vec<Check>,
    /// The recording without samples that belong to no motion; `None` where nothing moves.
    pub kept: Option<Observation>,
    /// Flights and contacts of what was kept, cut to what can be explained.
    pub arcs: Option<Arcs>,
    /// The first fall of a record of so few samples that its bounce shows by no kink; `None` where `arcs` have contacts.
    pub coarse: Option<FirstFall>,
    /// How fast free flight falls, where any is long enough.
    pub gravity: Option<ApparentGravity>,
    /// Which bounces positions show; `None` for other kinds, and where nothing moves.
    pub bounces: Option<Bounces>,
    /// Which of the checks is that of the bounces.
    bounce_check: Option<usize>,
}

impl Preflight {
    /// Checks without flights or contacts.
    fn without_motion(checks: Vec<Check>, kept: Option<Observation>) -> Self {
        Self { checks, kept, arcs: None, coarse: None, gravity: None, bounces: None, bounce_check: None }
    }

    /// The first check that rejects the recording.
    #[must_use]
    pub fn rejected(&self) -> Option<&Check> {
        self.checks.iter().find(|c| c.state == State::Failed)
    }

    /// What a user should know.
    #[must_use]
    pub fn notes(&self) -> Vec<Note> {
        self.checks.iter().filter_map(Check::note).collect()
    }

    /// Why contacts [cannot be examined](Bounces::can_be_examined), and the other [`notes`](Self::notes).
    #[must_use]
    pub fn notes_split(&self) -> (Option<Note>, Vec<Note>) {
        let not_examined = self.bounce_check.filter(|_| self.bounces.is_some_and(|bounces| !bounces.can_be_examined()));
        let others = self.checks.iter().enumerate().filter(|(i, _)| Some(*i) != not_examined);
        (not_examined.and_then(|i| self.checks[i].note()), others.filter_map(|(_, check)| check.note()).collect())
    }
}

/// A part of all samples in words: "12 % of the samples".
fn share(part: usize, all: usize) -> String {
    let percent = 100.0 * part as f64 / all.max(1) as f64;
    if percent < 1.0 { format!("{percent:.1} % of the samples") } else { format!("{percent:.0} % of the samples") }
}

/// Every check of `seen`.
#[must_use]
pub fn of(seen: &Observation, expected: &Expected) -> Vec<Check> {
    examine(seen, expected).checks
}

/// Looks at a recording of a ball: positions or bounce times. Of other kinds nothing is known, and nothing is checked.
#[must_use]
pub fn examine(seen: &Observation, expected: &Expected) -> Preflight {
    match seen.kind() {
        Kind::Positions => positions(seen, expected),
        Kind::EventTimes => Preflight::without_motion(bounces::checks(seen, expected), Some(seen.clone())),
        _ => Preflight::without_motion(Vec::new(), Some(seen.clone())),
    }
}

fn positions(seen: &Observation, expected: &Expected) -> Preflight {
    let mut checks = vec![motion::moves(seen)];
    if checks[0].state == State::Failed {
        return Preflight::without_motion(checks, None);
    }
    checks.push(clock::irregular(seen.clock()));
    checks.push(clock::gaps(seen.clock()));
    // Samples that belong to no motion go first, so that nothing later is misled by them.
    let standing = clock::standing(seen);
    let (check, repeated) = clock::repeats(seen, &standing);
    checks.push(check);
    let (check, frozen) = values::frozen(seen, &clock::frozen(&standing));
    checks.push(check);
    let kept = seen.without(&[repeated, frozen].concat());
    let mut kept = kept.unwrap_or_else(|| seen.clone());
    let outliers = kept.outliers();
    let rest = kept.without(&outliers);
    checks.push(values::outliers(&outliers, rest.is_some(), seen.len()));
    kept = rest.unwrap_or(kept);
    checks.push(clock::slow(&kept, expected.gravity_m_s2));
    checks.push(skipped::check(&kept, expected.gravity_m_s2));
    let Some(mut arcs) = Arcs::cut(&kept, expected.gravity_m_s2) else {
        return Preflight::without_motion(checks, Some(kept));
    };
    let heights: Vec<f64> = kept.column(2).collect();
    // A bounce at the end bends the flight before it.
    let before = arcs.late.and_then(|low| kept.slice(0..low).ok());
    let flights = Flights::find(before.as_ref().unwrap_or(&kept), &arcs, expected.gravity_m_s2);
    let gravity = ApparentGravity::of(kept.clock(), &heights, &flights);
    // A wrong unit is reported before its symptom.
    checks.push(units::check(gravity.as_ref(), expected));
    checks.push(gravity::check(gravity.as_ref(), expected, clock::rate_hz(seen.clock())));
    checks.push(motion::like(&kept, &arcs, &flights, expected));
    let level = Level::of(&kept, &arcs, &flights);
    let (left, edge) = surface::left(&kept, level, seen.len());
    if let Some(edge) = edge {
        arcs.end_at(edge, kept.clock());
    }
    checks.push(motion::release(&arcs, seen.len()));
    checks.push(motion::blows(&arcs, seen.len()));
    checks.push(motion::undisturbed(arcs.usable.len(), seen.len()));
    let coarse = FirstFall::find(&kept, expected.gravity_m_s2).filter(|_| arcs.contacts.is_empty());
    let (bounces, check) = surface::bounces(&kept, &arcs, coarse.is_some(), seen.len());
    let bounce_check = Some(checks.len());
    checks.push(check);
    checks.push(left);
    checks.push(surface::view(&kept));
    checks.push(surface::height(level, expected));
    checks.extend(surface::agrees(&arcs, level, expected));
    checks.push(motion::rest(&kept));
    Preflight { checks, kept: Some(kept), arcs: Some(arcs), coarse, gravity, bounces: Some(bounces), bounce_check }
}
