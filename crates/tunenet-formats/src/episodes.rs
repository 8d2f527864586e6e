//! Recordings in several episodes: what a file or a folder says of them, whichever its format.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[cfg(feature = "logs")]
use crate::format::is_hdf5;
use crate::joint_words::{JointQuantity, of_some_joint};
use crate::numbered;
use crate::place::Place;
#[cfg(feature = "logs")]
use crate::place::is_data_set;
use crate::proposal::{Proposal, proposal};
use crate::shown::list;
use crate::units::{self, Calibrated, UnitRule};
use crate::{Error, Result};
use tunenet_core::observation::Note;

/// A file or a folder of episodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Episodes {
    /// What it is: `LeRobot v3.0`.
    pub format: String,
    /// The robot that it names, empty where it names none.
    pub robot: String,
    /// Frames per second, where it says so.
    pub rate_hz: Option<f64>,
    /// Whether it says nothing of times: no rate, and no column of times with their unit.
    pub lacks_clock: bool,
    /// The episodes that can be read, in their order.
    pub episodes: Vec<EpisodeLength>,
    /// Its columns of numbers.
    pub columns: Vec<EpisodeColumn>,
    /// What `--units` would say of all columns whose numbers suggest a unit: `elbow=1.0122deg,…`; empty where none does.
    pub units: String,
    /// What was noticed.
    pub notes: Vec<Note>,
}

/// An episode and its length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EpisodeLength {
    /// Its name: `episode_3`, which follows the path of the folder.
    pub name: String,
    /// How many frames it has, where that is known without reading it.
    pub frames: Option<u64>,
}

/// A column of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct EpisodeColumn {
    /// Its name: `elbow`, or `action.elbow` for the joint's command.
    pub name: String,
    /// Its unit where it was said, as `--units` says it.
    pub unit: Option<String>,
    /// The unit that its numbers suggest, as `--units` would say it.
    pub proposed: Option<String>,
    /// What that is concluded from.
    pub why: String,
    /// The least and the greatest of its numbers, as the file has them; `None` where there are none.
    pub range: Option<(f64, f64)>,
}

impl EpisodeColumn {
    /// A column by its readings, with the unit that one of `rules` states.
    pub(crate) fn of(name: &str, readings: &[f64], rules: &[UnitRule]) -> Self {
        // What an encoder counts says nothing of speeds and torques.
        let found = match of_some_joint(name).and_then(|of| of.quantity) {
            Some(JointQuantity::Velocity) => unshown("a speed"),
            Some(JointQuantity::Effort) => unshown("a torque or a force"),
            _ => proposal(readings),
        };
        let rule = units::rule(rules, name);
        let calibrated = rule.and_then(|rule| rule.calibrated.as_ref());
        let unit = rule.map(|rule| match rule.factor {
            1.0 => rule.unit.clone(),
            factor if calibrated.is_some() => format!("{factor:.6}{}", rule.unit),
            factor => format!("{factor}{}", rule.unit),
        });
        let unit = unit.or_else(|| UnitRule::of_name(name).map(|rule| rule.unit));
        let why = match calibrated {
            Some(Calibrated { counts, within: (low, high), .. }) => {
                format!("the calibration file: {low} to {high} are {counts} counts")
            }
            None if rule.is_none() && unit.is_some() => "its name".into(),
            None => found.why,
        };
        let finite = || readings.iter().copied().filter(|v| v.is_finite());
        let range = finite()
            .next()
            .map(|first| finite().fold((first, first), |(low, high): (f64, f64), v| (low.min(v), high.max(v))));
        Self { name: name.to_owned(), unit, proposed: found.unit, why, range }
    }
}

/// That nothing proposes the unit of such a quantity.
fn unshown(what: &str) -> Proposal {
    Proposal { unit: None, why: format!("{what} by its name, which says no unit") }
}

/// Which episodes are asked for: `0-7`, `3`, `0,2,5-6`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    text: String,
    /// First and last number of each range.
    ranges: Vec<(u64, u64)>,
}

impl std::str::FromStr for Selection {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let range = |part: &str| {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            let (first, last) = (first.trim().parse::<u64>().ok()?, last.trim().parse::<u64>().ok()?);
            (first <= last).then_some((first, last))
        };
        let ranges: Option<Vec<(u64, u64)>> = text.split(',').map(range).collect();
        let ranges =
            ranges.ok_or_else(|| format!("expected numbers of episodes, such as 0-7 or 0,2,5, found `{text}`"))?;
        Ok(Self { text: text.to_owned(), ranges })
    }
}

/// The recordings in the file or folder at `path`, one for each episode, as paths that [`read`](crate::read()) takes: those of `chosen`
/// in its order, or all. `None` where there are no episodes, but a single recording.
///
/// # Errors
/// [`Error::File`] where none of those that are asked for is there, or what is there cannot be used.
pub fn episodes(path: impl AsRef<Path>, chosen: Option<&Selection>) -> Result<Option<Vec<PathBuf>>> {
    let path = path.as_ref();
    let Some(names) = names(path)? else {
        if chosen.is_none() {
            return Ok(None);
        }
        let message = "expected a recording in episodes (LeRobot, HDF5) for `--episodes`, found a single one";
        return Err(Error::file(path, message, "leave `--episodes` out"));
    };
    let Some(chosen) = chosen else {
        let all = names.iter().map(|name| path.join(name)).collect();
        return Ok((names.len() > 1).then_some(all));
    };
    match chosen.among(&names) {
        Ok(found) => Ok(Some(found.into_iter().map(|name| path.join(name)).collect())),
        Err(lost) => {
            let there = list(names.iter().map(String::as_str), 6);
            let message = format!("expected episodes that are there ({there}), found {lost}");
            Err(Error::file(path, message, "choose others with `--episodes`"))
        }
    }
}

impl Selection {
    /// Those of `names` that it asks for, each once, in its order.
    ///
    /// # Errors
    /// The first part that asks for what is not there: an episode, or a range that has none or ends beyond the last.
    fn among<'a>(&self, names: &'a [String]) -> std::result::Result<Vec<&'a str>, &str> {
        let last = names.iter().filter_map(|name| numbered::split(name).1).max();
        let (mut found, mut seen): (Vec<&str>, BTreeSet<&str>) = Default::default();
        for ((from, to), part) in self.ranges.iter().zip(self.text.split(',')) {
            let asked = |name: &&String| numbered::split(name).1.is_some_and(|n| (*from..=*to).contains(&n));
            let mut within = names.iter().filter(asked).map(String::as_str).peekable();
            if within.peek().is_none() || last.is_some_and(|last| *to > last) {
                return Err(part.trim());
            }
            found.extend(within.filter(|name| seen.insert(name)));
        }
        Ok(found)
    }
}

/// Whether a path is that of an episode in a file or folder, which has no file of its own.
#[must_use]
pub fn is_episode(path: &Path) -> bool {
    Place::of(path).episode.is_some()
}

/// The names of the episodes in a file or folder; `None` where it is a single recording.
#[cfg(feature = "logs")]
fn names(path: &Path) -> Result<Option<Vec<String>>> {
    if path.is_dir() && is_data_set(path) {
        return Ok(Some(crate::lerobot::DataSet::open(path)?.names()));
    }
    // Others, such as videos, are left to whoever reads them.
    if is_hdf5(path) {
        return Ok(Some(crate::hdf5::Demonstrations::open(path)?.names()).filter(|names| !names.is_empty()));
    }
    Ok(None)
}

/// Without their readers, nothing has episodes.
#[cfg(not(feature = "logs"))]
fn names(_: &Path) -> Result<Option<Vec<String>>> {
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn episodes_that_are_not_there_are_not_left_out_silently() {
        let names: Vec<String> = [0, 1, 3, 4].iter().map(|n| format!("demo_{n}")).collect();
        let among = |text: &str| {
            let chosen = text.parse::<Selection>().unwrap();
            chosen.among(&names).map(|found| found.len()).map_err(str::to_owned)
        };
        assert_eq!(among("0-4"), Ok(4), "a number that is missing within");
        assert_eq!(among("4,0-1,0"), Ok(3));
        assert_eq!(among("0,3-9"), Err("3-9".into()));
        assert_eq!(among("2"), Err("2".into()));
    }

    #[test]
    fn the_steps_of_an_encoder_say_nothing_of_speeds_and_torques() {
        let steps: Vec<f64> = (0..99).map(|i| f64::from(i * i % 37) * 360.0 / 4096.0).collect();
        let proposed = |name: &str| EpisodeColumn::of(name, &steps, &[]).proposed;
        assert_eq!(proposed("elbow").as_deref(), Some("deg"));
        assert_eq!([proposed("elbow_velocity"), proposed("elbow.effort")], [None, None]);
    }

    #[test]
    fn a_selection_is_numbers_and_ranges() {
        let chosen = "0-2, 7".parse::<Selection>().unwrap();
        assert_eq!(chosen.ranges, [(0, 2), (7, 7)]);
        for wrong in ["", "a", "3-1", "1-", "-1", "1..3"] {
            assert!(wrong.parse::<Selection>().is_err(), "{wrong}");
        }
    }
}
