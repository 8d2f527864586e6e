//! The keys of the simulation file of a custom program, and what no key alone can say of it.

use std::borrow::Cow;
use std::sync::LazyLock;

use toml_edit::{Item, Table, Value};
use tunenet_core::observation::{Channel, Kind};
use tunenet_core::simulator::measurement_effects;

use super::declared_check::{self, Wrong};
use super::declared_schema::Declares;
use super::schema::{Definition, Key, LONGEST_NAME, Shape, key, lookup, texts};

const LONGEST_S: f64 = 86_400.0;
/// Most programs that run at a time, independent of the file.
const MOST_WORKERS: i64 = 1024;
/// Most channels: a line of an answer has as many numbers for every sample.
const MOST_CHANNELS: usize = 256;

/// The keys of a program's file besides its effects, its settings, its parameters and its provenance.
pub const PROCESS_KEYS: &[Key] = &[
    key("kind", Shape::Word(&["process"]), true, "what is simulated: a program of yours"),
    key(
        "process.command",
        Shape::Texts,
        true,
        "the program and its arguments; no shell is used, and it is run only with `--allow-process`",
    ),
    key(
        "process.channels",
        Shape::Texts,
        true,
        "what it predicts, in its order: names with their units, as in the header of a CSV file",
    ),
    key(
        "process.folder",
        Shape::Word(&[]),
        false,
        "where it runs, from the folder of this file (default: that folder)",
    ),
    key(
        "process.timeout_s",
        Shape::Number(0.01, LONGEST_S),
        false,
        "how long it may take for one answer before it is killed (default: 10)",
    ),
    key(
        "process.start_timeout_s",
        Shape::Number(0.01, LONGEST_S),
        false,
        "how long it may take to start (default: 60)",
    ),
    key(
        "process.workers",
        Shape::Whole(1, MOST_WORKERS),
        false,
        "how many of it run at a time (default: one for each core)",
    ),
    key("record.rate_hz", Shape::Number(1e-3, 1e6), false, "samples per second that `simulate` and `gen` write"),
    key("record.frames", Shape::Whole(3, 10_000_000), false, "how many samples they write"),
];

/// What stands below `[settings]`: anything.
pub(super) const SETTING: Key =
    key("settings", Shape::Anything, false, "handed to the program as it stands here, with every request");

/// The keys below `[effects]`: those of the measurement that any series can show.
pub static PROCESS_EFFECT_KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
    let keys = measurement_effects(Kind::Other).into_iter().flat_map(|effect| {
        let one = |i: usize| Key {
            path: Cow::Owned(format!("effects.{}", effect.parameter_name(i))),
            shape: Shape::Number(effect.coefficients[i].min, effect.coefficients[i].max),
            required: false,
            meaning: effect.sentence.clone(),
        };
        (0..effect.coefficients.len()).map(one).collect::<Vec<_>>()
    });
    keys.collect()
});

/// The parameters of the program that `tunenet init process` writes.
pub(super) const SAMPLES: &[Definition] = &[
    Definition {
        name: "length",
        unit: "m",
        default: [1.0, 0.2, 2.0],
        tune: true,
        bounds: (f64::NEG_INFINITY, f64::INFINITY),
        within: "any size",
        meaning: "A number that the program takes, by a name of yours: here the pendulum's length",
    },
    Definition {
        name: "damping",
        unit: "1/s",
        default: [0.1, 0.0, 1.0],
        tune: true,
        bounds: (f64::NEG_INFINITY, f64::INFINITY),
        within: "any size",
        meaning: "Another: how fast the swing dies away",
    },
];

/// The first thing that no key alone shows to be wrong: its path, its place, what is expected and what is found.
pub(super) fn contradiction(root: &Table) -> Option<Wrong> {
    let at = |path: &str| lookup(root, path);
    let place = |path: &str| at(path).and_then(Item::span).unwrap_or(0..0);
    let wrong = |path: &str, expected: &str, found: String| Some((path.into(), place(path), expected.into(), found));
    let channels = at("process.channels").map(texts).unwrap_or_default();
    for (i, header) in channels.iter().enumerate() {
        let expected =
            "lower-case names with their units, such as \"z_m\", \"angle_rad\" or, without a unit, \"slip_1\"";
        match Channel::from_header(header) {
            None => return wrong("process.channels", expected, shown(header)),
            Some(channel) if matches!(channel.name.as_str(), "t" | "time") && channel.unit == "s" => {
                return wrong("process.channels", "channels besides the clock, which is always there", shown(header));
            }
            Some(_) if channels[..i].contains(header) => {
                return wrong("process.channels", "each channel once", format!("{} twice", shown(header)));
            }
            Some(_) => {}
        }
    }
    if channels.len() > MOST_CHANNELS {
        return wrong("process.channels", &format!("at most {MOST_CHANNELS}"), channels.len().to_string());
    }
    if at("process.command").map(texts).and_then(|words| words.first().map(|w| w.trim().is_empty())) == Some(true) {
        return wrong("process.command", "a program's name first", "an empty one".into());
    }
    let nul = ["process.command", "process.folder"].into_iter().find(|path| {
        let words = at(path).map_or_else(Vec::new, |item| item.as_str().map_or_else(|| texts(item), |one| vec![one]));
        words.iter().any(|word| word.contains('\0'))
    });
    if let Some(path) = nul {
        return wrong(path, "text without the character 0", "one with it".into());
    }
    for (name, _) in at("parameters").and_then(Item::as_table_like).into_iter().flat_map(|all| all.iter()) {
        let path = format!("parameters.{name}.unit");
        let unit = at(&path).and_then(Item::as_str).unwrap_or_default();
        if unit.len() > LONGEST_NAME || unit.chars().any(char::is_control) {
            return wrong(&path, &format!("at most {LONGEST_NAME} bytes without control characters"), shown(unit));
        }
    }
    let settings = at("settings").filter(|item| !item.is_none());
    let unsaid = settings.and_then(unsayable).and_then(|found| wrong("settings", "what JSON can say", found));
    unsaid.or_else(|| declared_check::contradiction(root, Declares::Program))
}

/// Text of a stranger's file for a message: no control characters, and no more than a line.
fn shown(text: &str) -> String {
    let short: String = text.chars().take(LONGEST_NAME).collect();
    format!("`{}`", short.escape_debug())
}

/// The first number within that JSON has no word for.
fn unsayable(item: &Item) -> Option<String> {
    fn of(value: &Value) -> Option<String> {
        match value {
            Value::Float(number) if !number.value().is_finite() => Some(number.value().to_string()),
            Value::Array(all) => all.iter().find_map(of),
            Value::InlineTable(all) => all.iter().find_map(|(_, value)| of(value)),
            _ => None,
        }
    }
    match item {
        Item::Value(value) => of(value),
        Item::Table(all) => all.iter().find_map(|(_, item)| unsayable(item)),
        Item::ArrayOfTables(all) => all.iter().find_map(|one| one.iter().find_map(|(_, item)| unsayable(item))),
        Item::None => None,
    }
}
