//! Where effects of the built-in worlds act, in words: segments are flights, events contacts, and joints those of an arm.

use tunenet_core::simulator::Phase;

/// A phrase for users: "in flight".
#[must_use]
pub fn name(phase: Phase) -> &'static str {
    match phase {
        Phase::Segment => "in flight",
        Phase::Event => "at contact",
        Phase::Measurement => "in the measurement",
        Phase::Joint => "in the arm",
    }
}

/// The stable code in answers: "flight".
#[must_use]
pub fn code(phase: Phase) -> &'static str {
    match phase {
        Phase::Segment => "flight",
        Phase::Event => "contact",
        Phase::Measurement => "measurement",
        Phase::Joint => "joint",
    }
}
