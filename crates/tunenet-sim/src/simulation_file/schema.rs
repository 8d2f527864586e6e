//! Which keys a simulation file may hold, with unit and range: the one list that reading, `--set` and the docs share.

use std::borrow::Cow;
use std::sync::LazyLock;

use toml_edit::{Item, Table, Value};
use tunenet_core::observation::Kind;
use tunenet_core::simulator::measurement_effects;

use crate::ball::effects::{ALL, BallEffect, Body, SCATTER};

/// What a key's value looks like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A number within bounds, both included.
    Number(f64, f64),
    /// A whole number within bounds, both included.
    Whole(i64, i64),
    /// So many numbers within bounds.
    Numbers(usize, f64, f64),
    /// Any number of numbers within bounds, at least one.
    List(f64, f64),
    /// A number, or a list of at least one, each within bounds.
    NumberOrList(f64, f64),
    /// One of these words; any where there are none.
    Word(&'static [&'static str]),
    /// A number within bounds, both included, or this word.
    NumberOrWord(f64, f64, &'static str),
    /// `true` or `false`.
    Flag,
    /// Texts in a list, at least one.
    Texts,
    /// Texts in a list, which may be empty.
    Names,
    /// Anything that TOML can hold.
    Anything,
}

/// Smaller bounds are written with a power of ten.
const TINY: f64 = 1e-6;

impl Shape {
    /// What to write, in words.
    #[must_use]
    pub fn expected(self) -> String {
        match self {
            Self::Number(min, max) => format!("a number {}", range(min, max)),
            Self::Whole(min, max) => format!("a whole number from {min} to {max}"),
            Self::Numbers(count, min, max) => format!("[{count} numbers], each {}", range(min, max)),
            Self::List(min, max) => format!("[numbers], each {}", range(min, max)),
            Self::NumberOrList(min, max) => format!("a number or [numbers], each {}", range(min, max)),
            Self::Word([]) => "a text in quotes".into(),
            Self::Word(words) => words.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(" or "),
            Self::NumberOrWord(min, max, word) => format!("a number {} or \"{word}\"", range(min, max)),
            Self::Flag => "true or false".into(),
            Self::Texts => "[\"text\", …], at least one".into(),
            Self::Names => "[\"text\", …]".into(),
            Self::Anything => "anything".into(),
        }
    }

    /// Whether `value` is such a thing.
    #[must_use]
    pub fn accepts(self, value: &Value) -> bool {
        let within = |v: &Value, min: f64, max: f64| number(v).is_some_and(|n| (min..=max).contains(&n));
        match self {
            Self::Number(min, max) => within(value, min, max),
            Self::Whole(min, max) => value.as_integer().is_some_and(|n| (min..=max).contains(&n)),
            Self::Numbers(count, min, max) => {
                value.as_array().is_some_and(|a| a.len() == count && a.iter().all(|v| within(v, min, max)))
            }
            Self::List(min, max) => {
                value.as_array().is_some_and(|a| !a.is_empty() && a.iter().all(|v| within(v, min, max)))
            }
            Self::NumberOrList(min, max) => {
                Self::Number(min, max).accepts(value) || Self::List(min, max).accepts(value)
            }
            Self::Word(words) => value.as_str().is_some_and(|w| words.is_empty() || words.contains(&w)),
            Self::NumberOrWord(min, max, word) => within(value, min, max) || value.as_str() == Some(word),
            Self::Flag => value.is_bool(),
            Self::Texts => value.as_array().is_some_and(|a| !a.is_empty() && a.iter().all(Value::is_str)),
            Self::Names => value.as_array().is_some_and(|a| a.iter().all(Value::is_str)),
            Self::Anything => true,
        }
    }
}

fn range(min: f64, max: f64) -> String {
    match (min.abs() <= GREATEST, max.abs() <= GREATEST) {
        (true, true) => format!("from {} to {max}", bound(min)),
        (true, false) => format!("from {} up", bound(min)),
        _ => "of any size".into(),
    }
}

/// A bound as a person writes it: with a power of ten where it is tiny.
fn bound(value: f64) -> String {
    if value != 0.0 && value.abs() < TINY { format!("{value:e}") } else { value.to_string() }
}

/// A TOML number, whole or not.
pub(crate) fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).filter(|n| n.is_finite())
}

/// The number that an item holds.
pub(crate) fn item_number(item: &Item) -> Option<f64> {
    item.as_value().and_then(number)
}

/// The item at a path of keys.
pub(crate) fn lookup<'a>(root: &'a Table, path: &str) -> Option<&'a Item> {
    let mut parts = path.split('.');
    let mut item = root.get(parts.next()?)?;
    for part in parts {
        item = item.as_table_like()?.get(part)?;
    }
    Some(item)
}

/// Whether a parameter or a joint may be called so in a simulation file: letters, digits and `_`, with no digit in front.
#[must_use]
pub fn is_name(name: &str) -> bool {
    let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    plain && !name.is_empty() && name.len() <= LONGEST_NAME && !name.starts_with(|c: char| c.is_ascii_digit())
}

/// The texts of a list.
pub(super) fn texts(item: &Item) -> Vec<&str> {
    item.as_array().map_or_else(Vec::new, |all| all.iter().filter_map(Value::as_str).collect())
}

/// One key.
#[derive(Debug, Clone)]
pub struct Key {
    /// Its path: `ball.radius_m`.
    pub path: Cow<'static, str>,
    /// What it holds.
    pub shape: Shape,
    /// Whether a file cannot do without it.
    pub required: bool,
    /// One line for users.
    pub meaning: Cow<'static, str>,
}

/// A parameter that a kind of file may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Definition {
    /// Its name: `[parameters.NAME]`.
    pub name: &'static str,
    /// Its unit; `1` where there is none.
    pub unit: &'static str,
    /// Value, least and greatest where the file says nothing.
    pub default: [f64; 3],
    /// Whether it is tuned where the file says nothing.
    pub tune: bool,
    /// What no file may go beyond.
    pub bounds: (f64, f64),
    /// What is to be written within these bounds, in words.
    pub within: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

pub(super) const GREATEST: f64 = 1e9;
pub(super) const LEAST: f64 = 1e-6;
const STEEPEST: f64 = 1.5;
/// Most characters of a parameter's name or unit.
pub(super) const LONGEST_NAME: usize = 64;

pub(crate) const fn key(path: &'static str, shape: Shape, required: bool, meaning: &'static str) -> Key {
    Key { path: Cow::Borrowed(path), shape, required, meaning: Cow::Borrowed(meaning) }
}

/// The keys of a ball's file besides its effects, its parameters and its provenance.
pub const BALL_KEYS: &[Key] = &[
    key("kind", Shape::Word(&["ball"]), true, "what is simulated"),
    key("world.gravity_m_s2", Shape::Number(LEAST, 1e3), false, "gravity, downwards (default: 9.81)"),
    key("world.medium", Shape::Word(&["air", "other"]), false, "what the ball moves in (default: air)"),
    key("ball.radius_m", Shape::Number(LEAST, 1e3), true, "radius of the ball"),
    key("ball.mass_kg", Shape::Number(1e-9, 1e6), false, "mass of the ball"),
    key("surface.height_m", Shape::Number(-1e6, 1e6), false, "height of the surface (default: estimated)"),
    key("surface.tilt_about_x_rad", Shape::Number(-STEEPEST, STEEPEST), false, "tilt of the surface about x"),
    key("surface.tilt_about_y_rad", Shape::Number(-STEEPEST, STEEPEST), false, "tilt of the surface about y"),
    key(
        "release.height_m",
        Shape::Number(0.0, 1e6),
        false,
        "height of fall, lowest point to surface (default: estimated)",
    ),
    key(
        "release.position_m",
        Shape::Numbers(3, -1e6, 1e6),
        false,
        "where the ball's centre starts (default: estimated)",
    ),
    key("release.velocity_m_s", Shape::Numbers(3, -1e6, 1e6), false, "how fast it starts (default: estimated)"),
    key("release.spin_rad_s", Shape::Numbers(3, -1e6, 1e6), false, "its spin (default: none)"),
    key(
        "release.time_s",
        Shape::Number(-GREATEST, GREATEST),
        false,
        "time of the release (default: the first usable sample)",
    ),
    key("record.rate_hz", Shape::Number(1e-3, 1e6), false, "frames per second that `simulate` and `gen` write"),
    key("record.frames", Shape::Whole(3, 10_000_000), false, "how many frames they write"),
];

/// The keys below `[effects]`: one for each coefficient of the catalogues, within the bounds that it has there; and whether `tune`
/// may change those of a physical effect that is no chance.
pub static EFFECT_KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
    let any = Body { radius_m: 1.0, mass_kg: None, gravity_m_s2: 1.0, in_air: true };
    let tuned = |effect: &BallEffect| Key {
        path: Cow::Owned(format!("effects.{}.tune", effect.name)),
        shape: Shape::Flag,
        required: false,
        meaning: Cow::Borrowed("whether `tune` may change these numbers (default: false)"),
    };
    let physical = ALL.iter().map(|e| (e.entry(&any), (e.name != SCATTER).then(|| tuned(e))));
    let entries = physical.chain(measurement_effects(Kind::Positions).into_iter().map(|e| (e, None)));
    let keys = entries.flat_map(|(effect, tuned)| {
        let one = |i: usize| Key {
            path: Cow::Owned(format!("effects.{}", effect.parameter_name(i))),
            shape: Shape::Number(effect.coefficients[i].min, effect.coefficients[i].max),
            required: false,
            meaning: effect.sentence.clone(),
        };
        (0..effect.coefficients.len()).map(one).chain(tuned).collect::<Vec<_>>()
    });
    keys.collect()
});

/// The keys within `[parameters.NAME]`.
pub const PARAMETER_KEYS: &[Key] = &[
    key("value", Shape::Number(-GREATEST, GREATEST), true, "present value"),
    key("min", Shape::Number(-GREATEST, GREATEST), true, "least value that tuning may reach"),
    key("max", Shape::Number(-GREATEST, GREATEST), true, "greatest value that tuning may reach"),
    key("unit", Shape::Word(&[]), false, "its unit"),
    key("tune", Shape::Flag, false, "whether `tune` may change it (default: true)"),
];
