//! The command line's say in how files are read.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_core::text::visible;
use tunenet_core::{Error, Origin};
use tunenet_formats::{ReadOptions, UnitRule, read_calibration, read_text};

use crate::args::Numbers;

/// The command line's say in how files are read.
///
/// # Errors
/// Where the definition of a message or a calibration file cannot be read.
pub fn reading(reading: &Numbers) -> Result<ReadOptions> {
    refuse_two_units(&reading.units)?;
    let mut units = reading.calibration.as_ref().map(read_calibration).transpose()?.unwrap_or_default();
    // The last rule about a column counts: what is typed is more than what a file says.
    units.extend(reading.units.iter().cloned());
    Ok(ReadOptions {
        columns: reading.columns.clone(),
        topic: reading.topic.clone(),
        skip_broken: reading.skip_broken,
        definitions: definitions(&reading.definitions)?,
        units,
        rate_hz: reading.rate_hz,
        ..ReadOptions::default()
    })
}

/// Refuses two rules of `--units` that state different units of one name: none of them is more than the other.
///
/// # Errors
/// [`Setting`](tunenet_core::Error::Setting) with both.
fn refuse_two_units(rules: &[UnitRule]) -> Result<()> {
    let said = |rule: &UnitRule| match rule.factor {
        1.0 => rule.unit.clone(),
        factor => format!("{factor}{}", rule.unit),
    };
    for (at, rule) in rules.iter().enumerate() {
        if let Some(other) = rules[..at].iter().find(|other| other.name == rule.name && *other != rule) {
            let expected = format!("one unit for `{}`", visible(&rule.name));
            let found = format!("{} and {}", said(other), said(rule));
            return Err(Error::Setting { origin: Origin::Flag, name: "--units", expected, found }.into());
        }
    }
    Ok(())
}

/// The definitions of messages in these files.
///
/// # Errors
/// Where one cannot be read.
pub fn definitions(paths: &[PathBuf]) -> Result<Vec<(String, String)>> {
    paths.iter().map(|path| definition(path)).collect()
}

/// The name of a message's type, which its file is called after, and its fields.
fn definition(path: &Path) -> Result<(String, String)> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok((name, read_text(path)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_units_of_one_column_are_refused() {
        let rules = |texts: &[&str]| texts.iter().map(|text| UnitRule::parse(text).unwrap()).collect::<Vec<_>>();
        let refused = refuse_two_units(&rules(&["a=deg", "b=rad", "a=2rad"])).unwrap_err().to_string();
        assert_eq!(refused, "`--units`: expected one unit for `a`, found deg and 2rad");
        assert!(refuse_two_units(&rules(&["*=deg", "a=rad", "a=rad"])).is_ok());
    }
}
