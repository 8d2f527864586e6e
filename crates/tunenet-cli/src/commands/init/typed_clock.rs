//! The clock of a table, and what its positions suggest.

use tunenet_formats::{Contents, ReadOptions, Result};

use super::columns::Columns;
use super::typed_units::{Recorded, Suggested, suggested};

/// The clock of a table.
pub enum Clock {
    /// Its name says it, or it is no table.
    Known,
    /// Its name has no unit: what `--columns` has to say of it, by how often its rows come.
    Unstated((String, String)),
    /// None of its names is one of times.
    Open,
}

/// How the clock of the recording is known.
pub fn clock(recorded: &Recorded) -> Clock {
    let Contents::Table(table) = recorded.contents else { return Clock::Known };
    match &table.described {
        _ if table.columns.iter().any(|column| column.read_as.as_deref() == Some("t_s")) => Clock::Known,
        Some(described) => described.mapping().map_or(Clock::Known, Clock::Unstated),
        None => Clock::Open,
    }
}

/// A recording as far as it suggests something.
#[derive(Default)]
pub struct Read {
    /// What `--columns` has to say of its clock.
    pub clock: Option<(String, String)>,
    pub suggested: Suggested,
    pub rate_hz: Option<f64>,
}

/// Reads the positions.
///
/// # Errors
/// Where the positions cannot be read.
pub fn read(recorded: &Recorded, columns: &[Columns], clock: Clock) -> Result<Read> {
    let clock = match clock {
        Clock::Known => None,
        Clock::Unstated(mapping) => Some(mapping),
        Clock::Open => return Ok(Read { clock: Some(("t_s".into(), "COLUMN".into())), ..Read::default() }),
    };
    let options = ReadOptions { columns: clock.iter().cloned().collect(), ..recorded.reading.clone() };
    let (suggested, rate_hz) = suggested(recorded, &options, columns)?;
    Ok(Read { clock, suggested, rate_hz })
}
