//! What a file says of itself, and the units that its numbers suggest.

use super::Demonstrations;
use super::actions::not_joints;
use super::episode::{is_clock, is_named_after_time};
use crate::Result;
use crate::episodes::{EpisodeColumn, EpisodeLength, Episodes};
use crate::findings;
use crate::recording::ReadOptions;
use crate::shown::list;
use tunenet_core::observation::Note;

/// Most episodes whose length is looked for.
const MOST_MEASURED: usize = 1_000;

impl Demonstrations {
    /// Its episodes, or the one of this name, with columns and units.
    ///
    /// # Errors
    /// Where there is no such episode, or the file cannot be used.
    pub fn listing(&self, name: Option<&str>, options: &ReadOptions) -> Result<Episodes> {
        let named = name.map(|_| self.group(name)).transpose()?;
        let first = self.columns(named.unwrap_or(&self.episodes[0].1), &|_| false)?;
        let column = |(i, name): (usize, &String)| {
            EpisodeColumn::of(name, &first.column(i).collect::<Vec<f64>>(), &options.units)
        };
        // The clock is no joint.
        let joints = first.names.iter().enumerate().filter(|(_, name)| !is_clock(name, options));
        let mut columns: Vec<EpisodeColumn> = joints.map(column).collect();
        for times in columns.iter_mut().filter(|column| is_named_after_time(&column.name)) {
            times.proposed = None;
            times.why = "times by its name, in a unit that the name does not state".into();
        }
        let mut episodes = Vec::with_capacity(self.episodes.len());
        let listed = self.episodes.iter().filter(|(_, group)| named.is_none_or(|named| named == group));
        for (i, (name, group)) in listed.enumerate() {
            let frames =
                if i < MOST_MEASURED { self.arrays(group)?.first().map(|array| array.rows as u64) } else { None };
            episodes.push(EpisodeLength { name: name.clone(), frames });
        }
        let mut notes: Vec<Note> = not_joints(&first, &self.environment).into_iter().collect();
        if !self.empty.is_empty() && named.is_none() {
            let text =
                format!("groups without arrays are left out: {}", list(self.empty.iter().map(String::as_str), 8));
            notes.push(Note::new(findings::GROUPS_EMPTY, text, ""));
        }
        notes.extend(first.left_out.clone());
        let rate_hz = options.rate_hz.or_else(|| self.rate());
        // Angles of a simulator are not counted by an encoder: no unit is proposed for all columns at once.
        Ok(Episodes {
            format: "HDF5".into(),
            robot: String::new(),
            rate_hz,
            lacks_clock: rate_hz.is_none() && !first.names.iter().any(|name| is_clock(name, options)),
            episodes,
            columns,
            units: String::new(),
            notes,
        })
    }
}
