//! The clock of a table, and what its positions suggest.

use tunenet_core::observation::plain;
use tunenet_formats::{Contents, ReadOptions, Result};

use super::columns::Columns;
use super::typed_units::{Recorded, Suggested, suggested};

/// How columns of times are called.
const CLOCKS: [&str; 6] = ["t", "time", "timestamp", "times", "stamp", "clock"];

/// Units of a clock, as `--columns` has them, and how many rows a second a recording of a robot has.
const TIMES: [&str; 4] = ["t_s", "t_ms", "t_us", "t_ns"];
const USUAL_HZ: std::ops::RangeInclusive<f64> = 2.0..=10_000.0;

/// The clock of a table.
pub enum Clock {
    /// Its name says it, or it is no table.
    Known,
    /// Its name has no unit.
    Unstated(String),
    /// None of its names is one of times.
    Open,
}

/// How the clock of the recording is known.
pub fn clock(recorded: &Recorded) -> Clock {
    let Contents::Table(table) = recorded.contents else { return Clock::Known };
    if table.columns.iter().any(|column| column.read_as.as_deref() == Some("t_s")) {
        return Clock::Known;
    }
    let mut names = recorded.named.iter().map(|column| column.name.as_str());
    let known = names.find(|name| CLOCKS.contains(&plain(name).as_str()));
    known.map_or(Clock::Open, |name| Clock::Unstated(name.to_owned()))
}

/// A recording as far as it suggests something.
#[derive(Default)]
pub struct Read {
    /// What `--columns` has to say of its clock.
    pub clock: Option<(String, String)>,
    pub suggested: Suggested,
    pub rate_hz: Option<f64>,
}

/// Reads the positions. Of a clock without unit, the first unit counts in which the rows come as often as those of a robot do.
///
/// # Errors
/// Where the positions cannot be read.
pub fn read(recorded: &Recorded, columns: &[Columns], clock: Clock) -> Result<Read> {
    let by = |clock: Option<(String, String)>| -> Result<Read> {
        let options = ReadOptions { columns: clock.iter().cloned().collect(), ..recorded.reading.clone() };
        let (suggested, rate_hz) = suggested(recorded, &options, columns)?;
        Ok(Read { clock, suggested, rate_hz })
    };
    match clock {
        Clock::Known => by(None),
        Clock::Open => Ok(Read { clock: Some(("t_s".into(), "COLUMN".into())), ..Read::default() }),
        Clock::Unstated(column) => {
            let usual = |read: &Read| read.rate_hz.is_some_and(|rate| USUAL_HZ.contains(&rate));
            let of = |unit: &str| by(Some((unit.to_owned(), column.clone())));
            let found = TIMES.iter().find_map(|unit| of(unit).ok().filter(usual));
            found.map_or_else(|| of(TIMES[0]), Ok)
        }
    }
}
