//! Words for what is diagnosed: what a person calls a motion, its segments and its events, and what a person can find out.

use crate::diagnose::hypothesis::context::Context;
use crate::observation::Kind;
use crate::simulator::{Phase, Simulator};

/// What the texts of a diagnosis say where they depend on the thing that moves. [`GENERAL`] fits anything;
/// [`Settings`](crate::diagnose::Settings) takes another for things whose motion has segments between events.
#[derive(Debug)]
pub struct Wording {
    /// What a recording shows, where several show the same: "motion".
    pub motion: &'static str,
    /// Why one motion names nothing.
    pub single: &'static str,
    /// What to do where all recordings show one motion.
    pub otherwise: &'static str,
    /// What to add where effects are left together.
    pub add: &'static str,
    /// What to do where nothing known explains.
    pub vary: &'static str,
    /// What is said before effects that no design separates: "no motion distinguishes".
    pub inseparable: &'static str,
    /// What separates effects that no design separates, by the name of an effect; `None` of one of which nothing is known.
    pub knowledge: fn(&str) -> Option<&'static str>,
    /// A segment between events, and several of them.
    pub segment: [&'static str; 2],
    /// Events.
    pub events: &'static str,
    /// How many events came before, as a quantity: "the count of events".
    pub event_count: &'static str,
    /// What the last channel shows: "the level".
    pub level: &'static str,
    /// Names of the tests on segments that were not fitted: against the residual without effects, and against that of a wrong
    /// effect.
    pub hidden_segments: [&'static str; 2],
}

/// Words for anything that moves and is recorded.
pub static GENERAL: Wording = Wording {
    motion: "motion",
    single: "a single motion does not identify one effect",
    otherwise: "record motions that start otherwise or are driven otherwise, slower and faster",
    add: "add recordings that start otherwise or are driven otherwise",
    vary: "vary one thing at a time (start, inputs, parameters, sensor) and see with which of them it changes",
    inseparable: "no motion distinguishes",
    knowledge,
    segment: ["segment", "segments"],
    events: "events",
    event_count: "the count of events",
    level: "the level",
    hidden_segments: [
        "hidden segments' residual after over before",
        "hidden segments' residual over that of a wrong effect",
    ],
};

/// Whether the motion of all that is diagnosed may have segments between events: it is seen from outside, or effects act in
/// segments or at events.
pub(in crate::diagnose) fn is_segmented(context: &Context<'_>) -> bool {
    context.subjects.iter().all(|s| may_have_segments(s.simulator))
}

/// Why an effect is excluded in whose place something that is fitted in any case does the same.
pub(in crate::diagnose) fn done_already(context: &Context<'_>) -> &'static str {
    if is_segmented(context) {
        "not distinguishable from initial state and parameters in these recordings"
    } else if context.recordings().iter().any(|recording| !recording.prepared.nuisances.is_empty()) {
        "not distinguishable from the parameters and what is fitted of each recording"
    } else {
        "not distinguishable from the parameters in these recordings"
    }
}

/// The words for it.
pub(in crate::diagnose) fn words(context: &Context<'_>) -> &'static Wording {
    if is_segmented(context) { context.settings.wording } else { &GENERAL }
}

fn may_have_segments(simulator: &dyn Simulator) -> bool {
    let seen = matches!(simulator.kind(), Kind::Positions | Kind::Pixels | Kind::EventTimes);
    seen || simulator.effects().iter().any(|effect| matches!(effect.phase, Phase::Segment | Phase::Event))
}

/// What a person can find out besides any motion that settles whether an effect is there.
fn knowledge(name: &str) -> Option<&'static str> {
    Some(match name {
        "length_scale" => "measure a known length with the same sensor",
        "time_scale" => "hold the recorder's clock against another",
        "time_offset" => "record the instant at which the motion starts",
        "observation_blur" => "look up over what time the sensor averages",
        _ => return None,
    })
}
