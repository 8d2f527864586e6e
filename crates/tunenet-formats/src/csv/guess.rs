//! Which column of a foreign table could be which, judged by its name: what a message proposes, never what is read.

use crate::quantity::{Meaning, Quantity, Scale, abbreviated, meaning, plain};
use crate::shown::shell_word;

/// The words that say what a name stands for. German ones too: spreadsheets speak their owner's language.
const WORDS: [(Quantity, &[&str]); 5] = [
    (Quantity::BounceTime, &["bounce", "bounces", "impact", "impacts", "click", "clicks", "hit", "hits"]),
    (Quantity::Z, &["z", "posz", "zpos", "height", "heights", "alt", "altitude", "elevation", "höhe", "hoehe"]),
    (Quantity::X, &["x", "posx", "xpos"]),
    (Quantity::Y, &["y", "posy", "ypos"]),
    (
        Quantity::Time,
        &["t", "time", "times", "timestamp", "stamp", "elapsed", "clock", "sec", "secs", "seconds", "zeit"],
    ),
];

/// Words of other quantities (`vel_z`, `quat_x`) and of units that are not read: such a column is not proposed.
#[rustfmt::skip]
const OTHER: [&str; 24] = [
    "v", "vel", "velocity", "speed", "a", "acc", "accel", "acceleration", "rot", "rotation", "quat", "orientation",
    "angular", "angle", "gyro", "force", "ft", "feet", "inch", "inches", "yd", "min", "px", "pixel",
];

/// Words of a number that counts something, wherever they stand in a name: such a column is not proposed.
const COUNTS: [&str; 9] = ["no", "nr", "num", "number", "index", "idx", "id", "count", "n"];
/// ... and those that count where they end it: `frame_time` is a time, `time_step` none.
const COUNT_LAST: [&str; 2] = ["frame", "step"];

/// A column whose name says what it could be.
#[derive(Clone, Copy)]
struct Candidate {
    index: usize,
    quantity: Quantity,
    /// The unit in its name.
    unit: Option<&'static str>,
    /// Whether it is read under this name already.
    known: bool,
}

/// The option that would make a table with these columns an observation, `--columns t_s=time,z_m=height`, and whether a
/// unit in it is assumed; `None` where the names do not say enough. What stands in the columns `counting` is 0, 1, 2, … or 1, 2,
/// 3, …: no times of impacts, and no clock whose name has no unit.
pub(crate) fn guess(names: &[&str], counting: &[usize]) -> Option<(String, bool)> {
    let counts = |c: &Candidate| match c.quantity {
        Quantity::BounceTime => counting.contains(&c.index),
        Quantity::Time => counting.contains(&c.index) && c.unit.is_none() && !c.known,
        _ => false,
    };
    let candidates = names.iter().enumerate().filter_map(|(i, name)| candidate(i, name));
    let candidates: Vec<Candidate> = candidates.filter(|c| !counts(c)).collect();
    let of =
        |quantity: Quantity| candidates.iter().filter(|c| c.quantity == quantity).min_by_key(|c| !c.known).copied();
    let wanted = match (of(Quantity::Time), of(Quantity::Z), of(Quantity::BounceTime)) {
        (None, None, Some(impacts)) => vec![(Quantity::BounceTime, Some(impacts))],
        (Some(time), Some(z), _) => vec![
            (Quantity::Time, Some(time)),
            (Quantity::X, of(Quantity::X)),
            (Quantity::Y, of(Quantity::Y)),
            (Quantity::Z, Some(z)),
        ],
        // Programs that track a ball in a picture write x and y, and their y points up.
        (Some(time), None, _) => {
            vec![(Quantity::Time, Some(time)), (Quantity::X, of(Quantity::X)), (Quantity::Z, Some(of(Quantity::Y)?))]
        }
        _ => return None,
    };
    let missing: Vec<(Quantity, Candidate)> = wanted
        .into_iter()
        .filter_map(|(quantity, candidate)| Some((quantity, candidate?)))
        .filter(|(quantity, candidate)| !candidate.known || candidate.quantity != *quantity)
        .collect();
    if missing.is_empty() {
        return None;
    }
    let pairs: Vec<String> = missing.iter().map(|(quantity, candidate)| pair(names, *quantity, *candidate)).collect();
    Some((format!("--columns {}", shell_word(&pairs.join(","))), missing.iter().any(|(_, c)| c.unit.is_none())))
}

/// The column that is the clock, by its name.
pub(crate) fn time(names: &[&str]) -> Option<usize> {
    let candidates = names.iter().enumerate().filter_map(|(i, name)| candidate(i, name));
    candidates.filter(|c| c.quantity == Quantity::Time).min_by_key(|c| !c.known).map(|c| c.index)
}

fn candidate(index: usize, name: &str) -> Option<Candidate> {
    let words = plain(name);
    let words: Vec<&str> = words.split('_').collect();
    let unit = |quantity: Quantity| {
        let units = quantity.units().iter().map(|(unit, _)| *unit);
        // "seconds" is a name and a unit.
        units.rev().find(|unit| words.iter().skip(1).any(|word| abbreviated(word) == *unit))
    };
    match meaning(name) {
        Meaning::Known(quantity, scale) => {
            let own = matches!(scale, Scale::Keep).then(|| quantity.units()[0].0);
            Some(Candidate { index, quantity, unit: own.or(unit(quantity)), known: true })
        }
        Meaning::WrongUnit(..) => None,
        Meaning::Unknown if words.iter().any(|word| OTHER.contains(word) || COUNTS.contains(word)) => None,
        Meaning::Unknown if words.last().is_some_and(|word| COUNT_LAST.contains(word)) => None,
        Meaning::Unknown => {
            let (quantity, _) = WORDS.iter().find(|(_, known)| words.iter().any(|word| known.contains(word)))?;
            Some(Candidate { index, quantity: *quantity, unit: unit(*quantity), known: false })
        }
    }
}

/// Ours with its unit, and theirs: by its name, or by its number where the name would be misread.
fn pair(names: &[&str], quantity: Quantity, candidate: Candidate) -> String {
    let channel = quantity.channel();
    let ours = format!("{}_{}", channel.name, candidate.unit.unwrap_or(&channel.unit));
    let name = names[candidate.index];
    let twice = names.iter().filter(|other| **other == name).count() > 1;
    if twice || name.contains([',', '\'', '`', '"']) || name.chars().any(char::is_control) {
        format!("{ours}={}", candidate.index + 1)
    } else {
        format!("{ours}={name}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_units_give_the_mapping() {
        for (names, option, assumed) in [
            (&["time", "height"][..], "t_s=time,z_m=height", true),
            (&["t", "z_m"], "t_s=t", true),
            (&["t_s", "height (mm)", "note"], "'z_mm=height (mm)'", false),
            (&["Zeit [ms]", "Höhe [cm]"], "'t_ms=Zeit [ms],z_cm=Höhe [cm]'", false),
            (&["frame", "t", "x", "y"], "t_s=t,x_m=x,z_m=y", true),
            (&["t_s", "x_m", "y_m"], "z_m=y_m", false),
            (&["timestamp", "pos_x", "pos_y", "pos_z", "vel_z"], "t_s=timestamp,x_m=pos_x,y_m=pos_y,z_m=pos_z", true),
            (&["time_s", "z", "z"], "z_m=2", true),
            (&["impact"], "bounce_time_s=impact", true),
            (&["n", "click time (ms)"], "'bounce_time_ms=click time (ms)'", false),
            (&["click_no", "click_at_ms"], "bounce_time_ms=click_at_ms", false),
            (&["hit index", "hit [msec]"], "'bounce_time_ms=hit [msec]'", false),
            (&["time_step", "frame_time", "height"], "t_s=frame_time,z_m=height", true),
        ] {
            assert_eq!(guess(names, &[]), Some((format!("--columns {option}"), assumed)), "{names:?}");
        }
        for names in
            [&["a", "b"][..], &["time", "vel_z"], &["t_s", "z_m"], &["time", "height_ft"], &["", ""], &["click_no"]]
        {
            assert_eq!(guess(names, &[]), None, "{names:?}");
        }
    }

    #[test]
    fn a_column_that_counts_is_no_time() {
        let option = |names: &[&str], counting: &[usize]| guess(names, counting).map(|(option, _)| option);
        assert_eq!(option(&["click", "hit"], &[0]).as_deref(), Some("--columns bounce_time_s=hit"));
        assert_eq!(option(&["time", "elapsed", "height"], &[0]).as_deref(), Some("--columns t_s=elapsed,z_m=height"));
        assert_eq!(option(&["time", "height"], &[0]), None);
        // A clock that says its unit may tick once a second.
        assert_eq!(option(&["clock [s]", "height"], &[0]).as_deref(), Some("--columns 't_s=clock [s],z_m=height'"));
    }

    /// What is proposed can be typed: every pair is of the form that `--columns` takes.
    #[test]
    fn every_pair_names_a_quantity_of_ours() {
        for (quantity, words) in WORDS {
            for word in words {
                let candidate = candidate(0, word).unwrap();
                let pair = pair(&[word], quantity, candidate);
                let ours = pair.split_once('=').unwrap().0;
                assert!(matches!(meaning(ours), Meaning::Known(found, _) if found == quantity), "{pair}");
            }
        }
    }
}
