//! The keys of a simulation file of equations.

use super::schema::{GREATEST, Key, Shape, key};

const TEXT: Shape = Shape::Word(&[]);

/// The keys of a file of equations besides the tables that it names itself, its effects, its parameters and its provenance.
pub const EQUATIONS_KEYS: &[Key] = &[
    key("kind", Shape::Word(&["equations"]), true, "what is simulated: the equations of this file"),
    key("record.rate_hz", Shape::Number(1e-3, 1e6), false, "samples per second that `simulate` and `gen` write"),
    key("record.frames", Shape::Whole(3, 10_000_000), false, "how many samples they write"),
];

/// The keys of `[states.NAME]`.
pub const STATE_KEYS: &[Key] = &[key("unit", TEXT, false, "its unit, where its name does not end in one")];

/// The keys of `[events.NAME]`.
pub const EVENT_KEYS: &[Key] = &[key("when", TEXT, true, "a formula: the event happens when it falls through zero")];

/// What stands in `[derivatives]`, by the names of states.
pub const DERIVATIVE: Key = key("derivatives.STATE", TEXT, true, "a formula: the derivative of a state by time");
/// What stands in `[outputs]`, by the names of channels.
pub const OUTPUT: Key =
    key("outputs.CHANNEL", TEXT, false, "a formula: what a channel shows (default: every state is a channel)");
/// What stands in `[constants]`, by names.
pub const CONSTANT: Key =
    key("constants.NAME", Shape::Number(-GREATEST, GREATEST), false, "a number that formulas may use");
/// What stands in `[events.NAME.then]`, by the names of states.
pub const THEN: Key = key("events.NAME.then.STATE", TEXT, true, "a formula: what a state is after the event");
/// What stands in `[candidates.NAME.adds]`, by the names of states.
pub const ADDS: Key =
    key("candidates.NAME.adds.STATE", TEXT, true, "a formula: what a candidate adds to the derivative of a state");

/// All keys whose tables a file names itself and that no other kind of file has, by their paths.
pub const EQUATIONS_TABLES: &[Key] = &[
    key("states.NAME.unit", TEXT, false, "its unit, where its name does not end in one"),
    DERIVATIVE,
    OUTPUT,
    CONSTANT,
    key("events.NAME.when", TEXT, true, "a formula: the event happens when it falls through zero"),
    THEN,
    ADDS,
];
