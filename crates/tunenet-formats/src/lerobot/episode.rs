//! The columns of one episode: states under the names of the joints, commands under `action.` and these names.

use std::path::Path;

use super::DataSet;
use super::index::Episode;
use super::info::{Feature, Layout};
use crate::findings;
use crate::parquet::{Holds, Numbers, Parquet};
use crate::recording::{MOST_NUMBERS, ReadOptions, Recording};
use crate::sheet::Sheet;
use crate::shown::list;
use crate::unstated::Unstated;
use crate::{Error, Result};
use tunenet_core::observation::Note;

/// How far the stamp of a frame may be from its number over the rate, in frames, to count as computed from it: stamps are in
/// single precision.
const COMPUTED: f64 = 0.01;

/// The numbers of an episode: the stamps and the numbers of the frames, and a row of all features for each frame.
pub(super) struct Frames {
    pub stamps: Vec<f64>,
    pub numbers: Vec<f64>,
    pub names: Vec<String>,
    pub values: Vec<f64>,
}

impl DataSet {
    /// The observation that an episode makes, with its columns in the units that `options` say.
    ///
    /// # Errors
    /// [`Error::File`] where there is no such episode, its file is broken, or a column is asked for whose unit nothing states.
    pub fn read(&self, path: &Path, name: Option<&str>, options: &ReadOptions) -> Result<Recording> {
        let frames = self.frames_of(self.episode(name)?)?;
        let (clock, note) = self.clock(&frames, path)?;
        let mut notes: Vec<Note> = note.into_iter().chain(still(&frames)).collect();
        let unstated = Unstated::of("t_s", &frames.names, options)?;
        let width = frames.names.len();
        let rows = clock.iter().zip(frames.values.chunks_exact(width.max(1)));
        let row = |(time, row): (&f64, &[f64])| -> Vec<f64> {
            std::iter::once(*time).chain(row.iter().enumerate().map(|(i, v)| unstated.value(i, *v))).collect()
        };
        let values = rows.flat_map(row).collect();
        let names = std::iter::once("t_s".to_owned()).chain(unstated.headers().iter().cloned()).collect();
        let sheet = Sheet { names, values, unnamed: false };
        let readings = |column: usize| frames.values.iter().skip(column).step_by(width).copied().collect::<Vec<f64>>();
        let found = unstated.recording(path, &sheet, &readings)?;
        notes.extend(found.notes);
        Ok(Recording { notes, ..found })
    }

    /// The frames of an episode.
    pub(super) fn frames_of(&self, episode: &Episode) -> Result<Frames> {
        let names = self.info.features.iter().flat_map(|feature| feature.names.clone()).collect();
        let mut all = Frames { stamps: Vec::new(), numbers: Vec::new(), names, values: Vec::new() };
        for file in &episode.files {
            self.add(file, episode.number, &mut all)?;
        }
        if all.values.is_empty() {
            let message = format!("expected frames in episode {}, found none", episode.number);
            return Err(Error::file(
                &episode.files[0],
                message,
                "choose another episode, or download `meta` and `data` of one version",
            ));
        }
        Ok(all)
    }

    /// Adds the frames of an episode in a file.
    fn add(&self, file: &Path, number: u64, all: &mut Frames) -> Result<()> {
        let table = Parquet::open(file)?;
        for group in 0..table.groups() {
            let column = |name: &str| {
                let known = table.columns().iter().find(|c| c.name == name && c.of == Holds::Number);
                known.map(|column| table.numbers(group, column)).transpose()
            };
            // Where nothing says whose frames these are, all are the episode's.
            let rows = match (column("episode_index")?, self.info.features.first()) {
                (Some(found), _) => self.rows_of(file, number, &found.values)?,
                (None, Some(feature)) => (0..wide(&table, group, feature)?.rows).collect(),
                (None, None) => Vec::new(),
            };
            if rows.is_empty() {
                continue;
            }
            let first = all.numbers.len();
            let of_rows = |found: Numbers| rows.iter().map(|row| found.values[*row]).collect::<Vec<f64>>();
            let counted = || (first..first + rows.len()).map(|i| i as f64).collect();
            all.numbers.extend(column("frame_index")?.map_or_else(counted, of_rows));
            let rate = self.info.rate_hz;
            let computed = || all.numbers[first..].iter().map(|number| number / rate).collect();
            let stamps = column("timestamp")?.map_or_else(computed, of_rows);
            all.stamps.extend(stamps);
            let read = |feature: &Feature| wide(&table, group, feature);
            let features = self.info.features.iter().map(read).collect::<Result<Vec<Numbers>>>()?;
            for row in rows {
                for found in &features {
                    all.values.extend_from_slice(&found.values[row * found.width..(row + 1) * found.width]);
                }
            }
            if all.values.len() > MOST_NUMBERS {
                let message = format!("expected at most {MOST_NUMBERS} numbers in an episode, found more");
                return Err(Error::file(file, message, "cut the episode into shorter ones"));
            }
        }
        Ok(())
    }

    /// The rows of an episode; all of them where the file is named after it.
    fn rows_of(&self, file: &Path, number: u64, episodes: &[f64]) -> Result<Vec<usize>> {
        let other = episodes.iter().find(|found| **found != number as f64);
        if let (Layout::FileEach, Some(other)) = (self.info.layout, other) {
            let message = format!("expected frames of episode {number}, found one of episode {other}");
            return Err(Error::file(file, message, "give every file its own name again"));
        }
        Ok((0..episodes.len()).filter(|row| episodes[*row] == number as f64).collect())
    }

    /// The times of the frames in s. Where the stamps are the numbers of the frames over the rate, in single precision, they are
    /// computed anew to the last digit.
    fn clock(&self, frames: &Frames, path: &Path) -> Result<(Vec<f64>, Option<Note>)> {
        let rate = self.info.rate_hz;
        let first =
            frames.stamps.first().copied().unwrap_or(0.0) - frames.numbers.first().copied().unwrap_or(0.0) / rate;
        let computed: Vec<f64> = frames.numbers.iter().map(|number| number / rate).collect();
        let near = |(stamp, time): (&f64, &f64)| (stamp - time).abs() * rate < COMPUTED + stamp.abs() * rate * 1e-6;
        if first.abs() * rate < COMPUTED && frames.stamps.iter().zip(&computed).all(near) {
            let text = format!("the stamps are frame numbers over {rate} Hz: jitter of the recorder is not in them");
            return Ok((computed, Some(Note::new(findings::CLOCK_COMPUTED, text, ""))));
        }
        if let Some(at) = (1..frames.stamps.len()).find(|i| frames.stamps[*i] <= frames.stamps[i - 1]) {
            let (before, found) = (frames.stamps[at - 1], frames.stamps[at]);
            let message =
                format!("`timestamp` does not rise in frame {}: expected more than {before}, found {found}", at + 1);
            return Err(Error::file(path, message, "record the episode again, or choose another one"));
        }
        Ok((frames.stamps.clone(), None))
    }
}

/// The numbers of a feature, as many in each row as it has names.
fn wide(table: &Parquet, group: usize, feature: &Feature) -> Result<Numbers> {
    let found = table.numbers(group, table.column(&feature.column)?)?;
    if found.width == feature.names.len() {
        return Ok(found);
    }
    let (expected, width) = (feature.names.len(), found.width);
    let message = format!(
        "`{}`: expected {expected} numbers in each row as `meta/info.json` says, found {width}",
        feature.column
    );
    Err(Error::file(table.path(), message, "download `meta` and `data` of one version"))
}

/// That states do not change, where some do not.
fn still(frames: &Frames) -> Option<Note> {
    let width = frames.names.len();
    let constant = |column: &usize| {
        let mut values = frames.values.iter().skip(*column).step_by(width);
        let first = values.next();
        values.all(|value| Some(value) == first)
    };
    let still: Vec<&str> = (0..width).filter(constant).map(|i| frames.names[i].as_str()).collect();
    let text =
        format!("constant to the last digit, as of a robot that stands still: {}", list(still.iter().copied(), 12));
    let note = Note::new(findings::STATE_CONSTANT, text, "choose an episode in which it moves");
    (!still.is_empty()).then_some(note)
}
