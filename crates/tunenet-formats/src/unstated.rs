//! Columns whose file states no units: those that `--units` states are converted, and any other is refused where it is asked for.

use std::path::Path;

use crate::findings;
use crate::proposal::proposal;
use crate::quantity::Quantity;
use crate::recording::{ReadOptions, Recording};
use crate::sheet::Sheet;
use crate::units::{self, ACTION};
use crate::{Error, Result, shell_word};
use tunenet_core::observation::plain;

/// The columns of an episode under their units.
pub(crate) struct Unstated {
    names: Vec<String>,
    /// The name of each under its unit, where that is stated, and what its numbers are multiplied with.
    headers: Vec<String>,
    factors: Vec<Option<f64>>,
    /// How they are read: what `--columns` says of them is in their own units by now.
    options: ReadOptions,
}

impl Unstated {
    /// Columns of these names, as `options` say that they are read.
    ///
    /// # Errors
    /// [`Setting`](tunenet_core::Error::Setting) where `--units` names a column that is not there.
    pub fn of(names: &[String], options: &ReadOptions) -> Result<Self> {
        units::refuse_unused(&options.units, names)?;
        let bare = |theirs: &str| theirs.strip_prefix('-').unwrap_or(theirs).to_owned();
        let named = |name: &str| options.others.iter().any(|other| other.name == name);
        let mapped = |name: &str| named(name) || options.columns.iter().any(|(_, theirs)| bare(theirs) == name);
        let (mut headers, mut factors) = (Vec::new(), Vec::new());
        for name in names {
            match units::rule(&options.units, name).map(units::own) {
                // A column that is mapped is looked for by its own name.
                Some((factor, "1")) => {
                    headers.push(name.clone());
                    factors.push(Some(factor));
                }
                Some((factor, unit)) => {
                    headers.push(if mapped(name) { name.clone() } else { format!("{name}_{unit}") });
                    factors.push(Some(factor));
                }
                None => {
                    headers.push(name.clone());
                    factors.push(None);
                }
            }
        }
        let stated = |theirs: &str| {
            let at = names.iter().position(|name| *name == bare(theirs));
            at.is_some_and(|at| factors[at].is_some())
        };
        let columns = options.columns.iter().map(|(ours, theirs)| {
            (if stated(theirs) { units::in_own_unit(ours) } else { ours.clone() }, theirs.clone())
        });
        let options = ReadOptions { columns: columns.collect(), ..options.clone() };
        Ok(Self { names: names.to_vec(), headers, factors, options })
    }

    /// Under which names the columns are looked for.
    pub fn headers(&self) -> &[String] {
        &self.headers
    }

    /// A number of a column in its unit; as it stands where that is not stated.
    pub fn value(&self, column: usize, number: f64) -> f64 {
        match self.factors[column] {
            Some(factor) if factor != 1.0 => number * factor,
            _ => number,
        }
    }

    /// What `sheet`, in which these columns follow the clock, makes. `readings` gives the numbers of a column as the file has them.
    ///
    /// # Errors
    /// [`Error::File`] with the flag to add where a column is asked for whose unit is not stated.
    pub fn recording(&self, path: &Path, sheet: &Sheet, readings: &dyn Fn(usize) -> Vec<f64>) -> Result<Recording> {
        let made = sheet.layout(path, &self.options);
        let asked: Vec<usize> = match &made {
            // The first column is the clock.
            Ok(layout) => {
                let sources = layout.values.iter().flatten().filter(|source| source.quantity != Quantity::BounceNumber);
                sources.filter_map(|source| source.column.checked_sub(1)).collect()
            }
            Err(_) => self.wanted(),
        };
        let unknown: Vec<usize> = asked.into_iter().filter(|column| self.factors[*column].is_none()).collect();
        let Some(first) = unknown.first() else {
            made?;
            let mut found = sheet.recording(path, &self.options)?;
            // A robot has more joints than are simulated; `inspect` lists all of them.
            found.notes.retain(|note| note.kind != findings::COLUMNS_IGNORED);
            return Ok(found);
        };
        let name = &self.names[*first];
        let found = proposal(&readings(*first));
        let flags: Vec<String> = unknown
            .iter()
            .map(|column| {
                let unit = proposal(&readings(*column)).unit.unwrap_or_else(|| "UNIT".into());
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
