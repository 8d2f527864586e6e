//! An observation as a text table.

use std::path::Path;

use super::bounces::doubt;
use crate::Result;
use crate::atomic::write_atomically;
use tunenet_core::observation::{Channel, Kind, Observation};

/// Writes `observation` as CSV under the headers that [`read`](crate::read) knows, each number with the fewest digits that
/// give the same bits back.
///
/// Bounce times get a column `bounce_number` where their numbers cannot be seen from the times alone. A series of
/// [`Kind::Other`] is written under its own names, which `read` finds where [`ReadOptions::channels`](crate::ReadOptions::channels)
/// holds them. The file is replaced in one step.
///
/// # Errors
/// [`Error::Io`](crate::Error::Io) where the system refuses.
pub fn write_csv(observation: &Observation, path: impl AsRef<Path>) -> Result<()> {
    let numbered = observation.kind() != Kind::EventTimes || !countable(observation);
    write_atomically(path, |out| {
        let mut names: Vec<String> = observation.channels().iter().map(Channel::header).collect();
        if numbered {
            let clock = if observation.kind() == Kind::EventTimes { "bounce_number" } else { "t_s" };
            names.insert(0, clock.into());
        }
        writeln!(out, "{}", names.join(","))?;
        for (sample, time) in observation.clock().iter().enumerate() {
            let mut mark = "";
            if numbered {
                write!(out, "{time:?}")?;
                mark = ",";
            }
            for value in observation.row(sample) {
                write!(out, "{mark}{value:?}")?;
                mark = ",";
            }
            writeln!(out)?;
        }
        Ok(())
    })
}

/// Whether a reader would count the same impacts.
fn countable(observation: &Observation) -> bool {
    let in_order = observation.clock().iter().enumerate().all(|(i, number)| *number == i as f64);
    // A zero after a negative time would be taken for an unused row.
    in_order && doubt(observation.values()).is_none() && observation.values()[1..].iter().all(|time| *time != 0.0)
}
