//! Columns whose file states no units: those that `--units` states are converted, and any other is refused where it is asked for.

use std::path::Path;

use crate::csv::columns::{Layout, found};
use crate::findings;
use crate::proposal::proposal;
use crate::quantity::Quantity;
use crate::ranges::written_out;
use crate::recording::{ReadOptions, Recording};
use crate::sheet::Sheet;
use crate::unit_misfit::{calibration_misfit, note_misfit};
use crate::units::{self, ACTION, UnitRule};
use crate::{Error, Result, shell_word};
use tunenet_core::observation::{Channel, Note, plain};

/// What `--units` says of a plain number, which has the unit that `--columns` gives it.
const PLAIN: &str = "1";

/// The columns of an episode under their units.
pub(crate) struct Unstated {
    /// The name of their clock.
    clock: String,
    names: Vec<String>,
    /// The name of each under its unit, where that is stated, and what its numbers are multiplied with.
    headers: Vec<String>,
    factors: Vec<Option<f64>>,
    /// What states the unit of each.
    rules: Vec<Option<UnitRule>>,
    /// How they are read: what `--columns` says of them is in their own units by now.
    options: ReadOptions,
}

impl Unstated {
    /// Columns of these names behind the one that is called `clock`, as `options` say that they are read.
    ///
    /// # Errors
    /// [`Setting`](tunenet_core::Error::Setting) where `--units` names a column that is not there, or a range in `--columns` is none.
    pub fn of(clock: &str, names: &[String], options: &ReadOptions) -> Result<Self> {
        units::refuse_unused(&options.units, names)?;
        let all: Vec<&str> = std::iter::once(clock).chain(names.iter().map(String::as_str)).collect();
        // The channels of a custom simulator have no ranges.
        let pairs =
            if options.channels.is_empty() { written_out(&options.columns, &all)? } else { options.columns.clone() };
        // A column may be named by its number, so its place counts and not how it is written.
        let place = |theirs: &str| found(theirs, &all).and_then(|(column, _)| column.checked_sub(1));
        let mapped: Vec<usize> = pairs.iter().filter_map(|(_, theirs)| place(theirs)).collect();
        let named = |name: &str| options.others.iter().any(|other| other.name == name);
        let (mut headers, mut factors, mut rules) = (Vec::new(), Vec::new(), Vec::new());
        for (at, name) in names.iter().enumerate() {
            let rule = units::rule(&options.units, name).map(units::own);
            headers.push(match rule {
                // A column that is mapped is looked for by its own name.
                Some((_, unit)) if unit != PLAIN && !named(name) && !mapped.contains(&at) => format!("{name}_{unit}"),
                _ => name.clone(),
            });
            // A name that ends in a unit states it, and is converted as it is where it is not mapped.
            let by_name = || {
                let stated = UnitRule::of_name(name)?;
                Some(if mapped.contains(&at) { units::own(&stated).0 } else { 1.0 })
            };
            factors.push(rule.map(|(factor, _)| factor).or_else(by_name));
            rules.push(units::rule(&options.units, name).cloned());
        }
        let converted = |theirs: &str| {
            let Some(name) = place(theirs).map(|at| &names[at]) else { return false };
            let rule = units::rule(&options.units, name).cloned().or_else(|| UnitRule::of_name(name));
            rule.is_some_and(|rule| rule.unit != PLAIN)
        };
        let columns = pairs.into_iter().map(|(ours, theirs)| {
            let ours = if converted(&theirs) { units::in_own_unit(&ours) } else { ours };
            (ours, theirs)
        });
        let options = ReadOptions { columns: columns.collect(), ..options.clone() };
        Ok(Self { clock: clock.to_owned(), names: names.to_vec(), headers, factors, rules, options })
    }

    /// What the columns with this clock make; `values` are their numbers as the file has them, row by row, and `left_out` says what else it
    /// holds.
    ///
    /// # Errors
    /// [`Error::File`] with the flag to add where a column is asked for whose unit is not stated.
    pub fn recording(
        &self,
        path: &Path,
        clock: Vec<f64>,
        mut values: Vec<f64>,
        left_out: Option<Note>,
    ) -> Result<Recording> {
        self.refuse_others(path, &values)?;
        let factors: Vec<(usize, f64)> = self
            .factors
            .iter()
            .enumerate()
            .filter_map(|(i, factor)| Some((i, (*factor).filter(|f| *f != 1.0)?)))
            .collect();
        for row in values.chunks_exact_mut(self.names.len().max(1)) {
            for (column, factor) in &factors {
                row[*column] *= factor;
            }
        }
        let names = std::iter::once(&self.clock).chain(&self.headers).cloned().collect();
        let sheet = &Sheet { names, clock, values, notes: left_out.into_iter().collect(), ..Sheet::default() };
        let made = sheet.layout(path, &self.options);
        let asked: Vec<usize> = match &made {
            // The first column is the clock.
            Ok(layout) => {
                let sources = layout.values.iter().flatten().filter(|source| source.quantity != Quantity::BounceNumber);
                sources.filter_map(|source| source.column.checked_sub(1)).collect()
            }
            Err(_) => self.wanted(),
        };
        let unknown: Vec<usize> = asked.iter().copied().filter(|column| self.factors[*column].is_none()).collect();
        let Some(first) = unknown.first() else {
            self.refuse_other_dimension(path, &made?)?;
            // As the file has them: what a calibration file states was held against them above.
            let read = |column: usize| -> Vec<f64> {
                let factor = self.factors[column].unwrap_or(1.0);
                sheet.column(column + 1).map(|value| value / factor).collect()
            };
            let misfit = |column: &usize| {
                let rule = self.rules[*column].as_ref().filter(|rule| rule.calibrated.is_none())?;
                note_misfit(&self.names[*column], &read(*column), rule)
            };
            let misfits: Vec<Note> = asked.iter().filter_map(misfit).collect();
            let mut found = sheet.recording(path, &self.options)?;
            found.notes.extend(misfits);
            // A robot has more joints than are simulated; `inspect` lists all of them.
            found.notes.retain(|note| note.kind != findings::COLUMNS_IGNORED);
            return Ok(found);
        };
        let name = &self.names[*first];
        // Without a unit, the numbers are those of the file.
        let proposed = |column: usize| proposal(&sheet.column(column + 1).collect::<Vec<f64>>());
        let found = proposed(*first);
        let flags: Vec<String> = unknown
            .iter()
            .map(|column| {
                let unit = proposed(*column).unit.unwrap_or_else(|| "UNIT".into());
                format!("{}={unit}", self.names[*column])
            })
            .collect();
        let message = format!("the unit of `{name}` is not stated in the file ({})", found.why);
        let hint = format!(
            "say it, after a look at the robot's documents: `--units {}`; a unit is rad, deg, m, mm, or 1 for a plain number",
            shell_word(&flags.join(","))
        );
        Err(Error::file(path, message, hint))
    }

    /// Refuses a unit in which the channel that a column is read as cannot be measured: `--columns` gives it no unit of its own.
    ///
    /// # Errors
    /// [`Error::File`] with both units.
    fn refuse_other_dimension(&self, path: &Path, layout: &Layout) -> Result<()> {
        for (channel, source) in layout.channels.iter().zip(&layout.values) {
            let Some(column) = source.as_ref().and_then(|source| source.column.checked_sub(1)) else { continue };
            let Some(rule) = self.rules[column].as_ref() else { continue };
            let unit = Channel::from_header(&format!("x_{}", units::own(rule).1)).map(|stated| stated.unit);
            if channel.unit == PLAIN || unit.is_none_or(|unit| unit == channel.unit || unit == PLAIN) {
                continue;
            }
            let (name, header, said) = (&self.names[column], channel.header(), &rule.unit);
            let message = format!("`{name}` is read as `{header}`: expected a unit of {}, found {said}", channel.unit);
            return Err(Error::file(path, message, "correct the unit in `--units`, or the column in `--columns`"));
        }
        Ok(())
    }

    /// Refuses numbers that are not normalised as their calibration file says: degrees, or another robot's.
    ///
    /// # Errors
    /// [`Error::File`] with what is seen in place of it.
    fn refuse_others(&self, path: &Path, values: &[f64]) -> Result<()> {
        for (at, rule) in self.rules.iter().enumerate() {
            let Some(rule) = rule.as_ref().filter(|rule| rule.calibrated.is_some()) else { continue };
            let column: Vec<f64> = values.iter().skip(at).step_by(self.names.len()).copied().collect();
            let Some(message) = calibration_misfit(&self.names[at], &column, rule) else { continue };
            let hint = "name the calibration of this robot at the time of the recording, or state the unit with `--units` \
                        (`deg` where the data set is in degrees)";
            return Err(Error::file(path, message, hint));
        }
        Ok(())
    }

    /// The columns that channels without a column are named after.
    fn wanted(&self) -> Vec<usize> {
        let is = |name: &str| {
            self.options.channels.iter().any(|channel| {
                let plain = plain(name);
                plain == channel.name || plain == channel.header()
            })
        };
        let bare =
            |name: &String| is(name) || name.strip_prefix(ACTION).is_some_and(|joint| is(&format!("action_{joint}")));
        self.names.iter().enumerate().filter(|(_, name)| bare(name)).map(|(i, _)| i).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Calibrated;

    /// One reading of 180 in each of the columns `a0` and `a1`, as `--units` and `--columns` say.
    fn read(units: &str, columns: &[(&str, &str)]) -> Result<Vec<f64>> {
        let names = ["a0".to_owned(), "a1".to_owned()];
        let columns = columns.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
        let units = units.split(',').map(|rule| UnitRule::parse(rule).unwrap()).collect();
        let unstated = Unstated::of("t_s", &names, &ReadOptions { columns, units, ..ReadOptions::default() })?;
        let found = unstated.recording(Path::new("a"), vec![0.0, 1.0, 2.0], vec![180.0; 6], None)?;
        Ok(found.observation.row(0).to_vec())
    }

    #[test]
    fn a_unit_is_converted_once_however_the_column_is_named() {
        let half = std::f64::consts::PI;
        for theirs in ["a0", "2"] {
            assert_eq!(read("a0=deg,a1=deg", &[("q1_deg", theirs)]).unwrap(), [half], "{theirs}");
            assert_eq!(read("a0=deg,a1=deg", &[("q1_rad", theirs)]).unwrap(), [half], "{theirs}");
        }
        assert_eq!(read("a0=deg,a1=deg", &[("q1_deg", "-3")]).unwrap(), [-half]);
        for theirs in ["a*", "2..3"] {
            assert_eq!(read("deg", &[("q1..2_deg", theirs)]).unwrap(), [half, half], "{theirs}");
        }
    }

    #[test]
    fn a_name_that_ends_in_a_unit_states_it() {
        let columns = vec![("q1_rad".into(), "elbow_deg".into())];
        let channels = vec![Channel::new("elbow", "rad")];
        let names = ["elbow_deg".to_owned()];
        let found = |options: ReadOptions| {
            let unstated = Unstated::of("t_s", &names, &options).unwrap();
            unstated
                .recording(Path::new("a"), vec![0.0, 1.0, 2.0], vec![180.0; 3], None)
                .unwrap()
                .observation
                .row(0)
                .to_vec()
        };
        assert_eq!(found(ReadOptions { channels, ..ReadOptions::default() }), [std::f64::consts::PI]);
        let half = [std::f64::consts::PI];
        assert_eq!(found(ReadOptions { columns, ..ReadOptions::default() }), half, "mapped to radians");
        let in_degrees = vec![("q1_deg".into(), "elbow_deg".into())];
        assert_eq!(found(ReadOptions { columns: in_degrees, ..ReadOptions::default() }), half, "and to degrees");
    }

    #[test]
    fn a_plain_number_has_the_unit_of_its_mapping() {
        assert_eq!(read("1", &[("q1_deg", "a0")]).unwrap(), [std::f64::consts::PI]);
        assert_eq!(read("1", &[("q1_rad", "a0")]).unwrap(), [180.0]);
    }

    /// Readings of `a0`, an encoder's of so many units a count, under a calibration file that states 200 units over 2000 counts.
    fn calibrated(step: f64, middle: f64) -> Result<Recording> {
        let calibrated = Some(Calibrated { counts: 2000.0, within: (-100.0, 100.0), step: 0.1 });
        let rule = UnitRule { name: "a0".into(), factor: 0.9, unit: "deg".into(), calibrated };
        let other = UnitRule { name: "a1".into(), ..rule.clone() };
        let columns = vec![("q1_rad".into(), "a0".into())];
        let options = ReadOptions { columns, units: vec![rule, other], ..ReadOptions::default() };
        let unstated = Unstated::of("t_s", &["a0".to_owned()], &options)?;
        let values: Vec<f64> = (0..200).map(|i| middle + step * f64::from((i * i * 7 + i * 3) % 311 - 155)).collect();
        unstated.recording(Path::new("a"), (0..200).map(f64::from).collect(), values, None)
    }

    #[test]
    fn a_calibration_file_states_units_and_is_held_against_the_numbers() {
        let first = calibrated(0.1, 10.0).unwrap().observation.row(0)[0];
        assert!((first - (10.0 - 15.5) * 0.9f64.to_radians()).abs() < 1e-12, "{first}");
        let refused = |step: f64, middle: f64| calibrated(step, middle).unwrap_err().to_string();
        let degrees = refused(360.0 / 4096.0, 0.0);
        assert!(degrees.contains("in steps of 0.100000") && degrees.contains("found steps of 0.0878"), "{degrees}");
        assert!(refused(0.1, 120.0).contains("`a0`: expected numbers from -100 to 100"));
        assert!(calibrated(0.2, 0.0).is_ok(), "every other count");
    }
}
