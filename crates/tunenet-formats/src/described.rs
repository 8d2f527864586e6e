//! What the numbers of a table show whose columns have names of their own: its clock, and the range, the step and the unit of each column.

use std::ops::RangeInclusive;
use std::path::Path;

use crate::csv::columns::found;
use crate::csv::guess;
use crate::csv::guess_joints::guess_joints;
use crate::findings;
use crate::quantity::{Meaning, Quantity, Scale, meaning};
use crate::recording::{LARGEST, ReadOptions};
use crate::sheet::Sheet;
use crate::shown::list;
use crate::{EpisodeColumn, Result, of_some_joint, read};
use tunenet_core::observation::{Channel, FEWEST_SAMPLES, Note, plain};
use tunenet_core::statistics::median;

/// How columns of times are called.
const CLOCKS: [&str; 6] = ["t", "time", "timestamp", "times", "stamp", "clock"];

/// Units of a clock, as `--columns` has them, and how many rows a second a recording of a robot has.
const TIMES: [&str; 4] = ["t_s", "t_ms", "t_us", "t_ns"];
const USUAL_HZ: RangeInclusive<f64> = 2.0..=10_000.0;

/// A table by its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Described {
    /// The column of times.
    pub clock: String,
    /// What `--columns` calls it where its name has no unit: `t_ms`, the first unit in which its rows come as often as those of a robot.
    pub clock_as: Option<String>,
    /// The other columns of numbers.
    pub columns: Vec<EpisodeColumn>,
    /// Whether the names are those of a ball's position or bounces, or of an arm's log, so that a mapping makes it one.
    pub of_known_names: bool,
    /// The option that makes it a log of an arm with torques, where names suggest one: `--columns t_s=time,q1_rad=q_1,tau1_nm=tau_1`.
    pub arm: Option<String>,
}

impl Described {
    /// The table, and its instants in s; `mapped` are the pairs of `--columns`. `None` where it has no column of times, no other of numbers,
    /// or where the mapping names more than the clock.
    pub(crate) fn of(sheet: &Sheet, mapped: &[(String, String)]) -> Option<(Self, Vec<f64>)> {
        let names: Vec<&str> = sheet.names.iter().map(String::as_str).collect();
        let some = |column: &usize| sheet.column(*column).filter(|value| value.is_finite()).count() >= FEWEST_SAMPLES;
        let numeric: Vec<usize> = (0..names.len()).filter(|column| !names[*column].is_empty()).filter(some).collect();
        let (clock, said) = match mapped {
            [] => {
                let named = |column: &&usize| time_scale(names[**column]).is_some();
                let numeric_names: Vec<&str> = numeric.iter().map(|column| names[*column]).collect();
                let by_words = || clock_of(&numeric_names).map(|at| numeric[at]);
                let clock = numeric.iter().find(named).copied().or_else(by_words)?;
                (clock, time_scale(names[clock]))
            }
            [(ours, theirs)] => (found(theirs, &names)?.0, Some(time_scale(ours)?)),
            _ => return None,
        };
        let ticks: Vec<f64> = sheet.column(clock).filter(|value| value.is_finite()).collect();
        let (clock_as, scale) = if let Some(scale) = said {
            (None, scale)
        } else {
            let (unit, scale) = unit_of(&ticks);
            (Some(unit.to_owned()), scale)
        };
        let others = numeric.iter().filter(|column| **column != clock);
        let described =
            |column: &usize| EpisodeColumn::of(names[*column], &sheet.column(*column).collect::<Vec<f64>>(), &[]);
        let columns: Vec<EpisodeColumn> = others.map(described).collect();
        let arm = guess_joints(&names, &[], &flags(sheet, &numeric)).filter(|_| mapped.is_empty());
        let commanded = columns.iter().any(|column| of_some_joint(&column.name).is_some_and(|of| of.command));
        let of_known_names = guess::guess(&names, &[]).is_some() || arm.is_some() && !commanded;
        let found = Self { clock: names[clock].to_owned(), clock_as, columns, of_known_names, arm };
        (!found.columns.is_empty()).then(|| (found, ticks.into_iter().map(|tick| scale.apply(tick)).collect()))
    }

    /// What `--columns` has to say of the clock.
    #[must_use]
    pub fn mapping(&self) -> Option<(String, String)> {
        self.clock_as.clone().map(|ours| (ours, self.clock.clone()))
    }

    /// What is noticed where a column is read by this clock.
    ///
    /// # Errors
    /// As [`read`](crate::read()).
    pub fn noticed(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Note>> {
        const NAME: &str = "number";
        // A second column of stamps may be too large for a channel.
        let fits =
            |column: &&EpisodeColumn| column.range.is_some_and(|(low, high)| low.abs().max(high.abs()) <= LARGEST);
        let first = self.columns.iter().find(fits).or(self.columns.first());
        let first = first.map(|column| (NAME.to_owned(), column.name.clone()));
        let columns = options.columns.iter().cloned().chain(self.mapping()).chain(first).collect();
        let channels = vec![Channel::new(NAME, "1")];
        let mut notes = read(path, &ReadOptions { columns, channels, ..options.clone() })?.notes;
        // Its other columns are listed.
        notes.retain(|note| ![findings::COLUMNS_IGNORED, findings::COLUMNS_CONVERTED].contains(&note.kind));
        Ok(notes)
    }
}

/// The columns that hold nothing but 0 and 1, and some 1: whether a motor is on is no measurement of it.
fn flags(sheet: &Sheet, columns: &[usize]) -> Vec<usize> {
    let flag = |column: &&usize| {
        let is = |value: f64| sheet.column(**column).any(|found| found == value);
        is(1.0) && sheet.column(**column).all(|found| found == 0.0 || found == 1.0)
    };
    columns.iter().filter(flag).copied().collect()
}

/// How times in a column of this name become seconds, where it states their unit.
fn time_scale(name: &str) -> Option<Scale> {
    match meaning(name) {
        Meaning::Known(Quantity::Time, scale) => Some(scale),
        _ => None,
    }
}

/// The column that is a clock by its name: one that is called as clocks are, or has a word for one.
fn clock_of(names: &[&str]) -> Option<usize> {
    let own = names.iter().position(|name| CLOCKS.contains(&plain(name).as_str()));
    own.or_else(|| guess::time(names))
}

/// That columns speak of joints and none of times, where this is so.
pub(crate) fn lacks_clock(names: &[String]) -> Option<String> {
    let names: Vec<&str> = names.iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
    let of_joints = names.iter().any(|name| of_some_joint(name).is_some());
    let message = || format!("expected a column of times, such as `t_s`, found {}", list(names.iter().copied(), 12));
    (of_joints && clock_of(&names).is_none()).then(message)
}

/// The first unit in which the rows come as often as those of a robot do; seconds where none is.
fn unit_of(ticks: &[f64]) -> (&'static str, Scale) {
    let interval = median(ticks.windows(2).map(|pair| pair[1] - pair[0])).unwrap_or(0.0);
    let units = TIMES.into_iter().filter_map(|unit| Some((unit, time_scale(unit)?)));
    let usual = |(_, scale): &(&str, Scale)| USUAL_HZ.contains(&scale.apply(interval).recip());
    units.clone().find(usual).unwrap_or((TIMES[0], Scale::Keep))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(names: &[&str], row: impl Fn(u32) -> Vec<f64>) -> Sheet {
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        Sheet { names, values: (0..60).flat_map(row).collect(), ..Sheet::default() }
    }

    #[test]
    fn a_clock_without_a_unit_ticks_as_often_as_a_robot_does() {
        for (name, interval, clock_as) in [
            ("time", 0.02, Some("t_s")),
            ("__time", 20.0, Some("t_ms")),
            ("%time", 20_000_000.0, Some("t_ns")),
            ("header.stamp", 20_000.0, Some("t_us")),
            ("time", 5_000_000_000.0, Some("t_s")),
            ("t_ms", 20.0, None),
        ] {
            let found = sheet(&["q", name], |i| vec![f64::from(i), interval * f64::from(i)]);
            let (found, times) = Described::of(&found, &[]).unwrap();
            assert_eq!((found.clock.as_str(), found.clock_as.as_deref()), (name, clock_as));
            assert_eq!(found.columns.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["q"]);
            let in_s = interval > 1e9 || times[1] == 0.02;
            assert!(in_s, "{name}: {}", times[1]);
        }
    }

    #[test]
    fn columns_have_the_unit_that_their_step_shows_and_texts_are_none() {
        let step = 360.0 / 4096.0;
        let row = |i: u32| vec![f64::from(i) * 0.02, f64::from((i * i * 7) % 911) * step, f64::NAN, f64::from(i)];
        let (found, _) = Described::of(&sheet(&["time", "qpos.0", "note", "j_rad"], row), &[]).unwrap();
        let units: Vec<_> = found.columns.iter().map(|c| (c.proposed.as_deref(), c.unit.as_deref())).collect();
        assert_eq!(units[0], (Some("deg"), None));
        assert_eq!((units.len(), units[1].1), (2, Some("rad")));
        assert!(!found.of_known_names && found.arm.is_none());
        let arm = |third: &str| {
            let arm = sheet(&["time", "q_1", "tau_1", third], |i| vec![f64::from(i) * 0.02, 1.5, 2.0, 3.0]);
            let (found, _) = Described::of(&arm, &[]).unwrap();
            (found.of_known_names, found.arm.unwrap())
        };
        let option = "--columns t_s=time,q1_rad=q_1,tau1_nm=tau_1".to_owned();
        assert_eq!(arm("note_1"), (true, option.clone()), "no commands");
        assert_eq!(arm("action_1"), (false, option));
    }

    #[test]
    fn what_has_no_clock_or_more_of_a_mapping_is_not_described() {
        let found = sheet(&["a", "b"], |i| vec![f64::from(i) * 0.02, 1.0]);
        assert_eq!(Described::of(&found, &[]), None);
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let message = lacks_clock(&names(&["qpos.0", "action.0"])).unwrap();
        assert_eq!(message, "expected a column of times, such as `t_s`, found `qpos.0`, `action.0`");
        assert_eq!([lacks_clock(&names(&["time", "qpos.0"])), lacks_clock(&found.names)], [None, None]);
        let pair = |ours: &str, theirs: &str| (ours.to_owned(), theirs.to_owned());
        let (by_hand, times) = Described::of(&found, &[pair("t_ms", "1")]).unwrap();
        assert_eq!((by_hand.clock.as_str(), by_hand.clock_as, times[1]), ("a", None, 0.02 / 1e3));
        assert_eq!(Described::of(&found, &[pair("t_s", "a"), pair("z_m", "b")]), None);
        assert_eq!(Described::of(&found, &[pair("z_m", "b")]), None);
        let ball = sheet(&["time", "height"], |i| vec![f64::from(i) * 0.02, 1.0]);
        assert!(Described::of(&ball, &[]).unwrap().0.of_known_names);
    }
}
