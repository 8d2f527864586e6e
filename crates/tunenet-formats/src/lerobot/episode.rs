//! The columns of one episode: states under the names of the joints, commands under `action.` and these names.

use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use super::DataSet;
use super::index::Episode;
use super::info::{Feature, Layout};
use crate::findings;
use crate::kept::Kept;
use crate::parquet::{Column, Holds, Numbers, Parquet};
use crate::recording::{MOST_NUMBERS, ReadOptions, Recording};
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

/// Rows of a group that follow each other and belong to one episode.
#[derive(Debug, Clone)]
struct Run {
    episode: f64,
    rows: Range<usize>,
}

/// A file that episodes stand in, with what its groups say of whose their rows are, as far as it was asked.
struct Opened {
    table: Parquet,
    runs: Vec<Mutex<Option<Arc<Vec<Run>>>>>,
}

/// The file that was read last.
static OPENED: Kept<Opened> = Kept::new();

impl Opened {
    fn of(table: Parquet) -> Self {
        let runs = (0..table.groups()).map(|_| Mutex::default()).collect();
        Self { table, runs }
    }

    /// Whose the rows of a group are, by the column `index`.
    fn runs(&self, group: usize, index: &Column) -> Result<Arc<Vec<Run>>> {
        let mut known = self.runs[group].lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = &*known {
            return Ok(Arc::clone(known));
        }
        let mut runs: Vec<Run> = Vec::new();
        for (row, episode) in self.table.numbers(group, index)?.values.into_iter().enumerate() {
            match runs.last_mut().filter(|run| run.episode == episode) {
                Some(run) => run.rows.end = row + 1,
                None => runs.push(Run { episode, rows: row..row + 1 }),
            }
        }
        Ok(Arc::clone(known.insert(Arc::new(runs))))
    }
}

impl DataSet {
    /// The observation that an episode makes, with its columns in the units that `options` say.
    ///
    /// # Errors
    /// [`Error::File`] where there is no such episode, its file is broken, or a column is asked for whose unit nothing states.
    pub fn read(&self, path: &Path, name: Option<&str>, options: &ReadOptions) -> Result<Recording> {
        let episode = self.episode(name)?;
        let frames = self.frames_of(episode)?;
        let (clock, note) = self.clock(&frames, path)?;
        let mut notes: Vec<Note> = note.into_iter().chain(still(&frames)).collect();
        notes.extend(other_length(episode, frames.stamps.len() as u64));
        let unstated = Unstated::of("t_s", &frames.names, options)?;
        let found = unstated.recording(path, clock, frames.values, None)?;
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

    /// Adds the frames of an episode in a file, which stays open for the next one.
    fn add(&self, file: &Path, number: u64, all: &mut Frames) -> Result<()> {
        let opened = OPENED.of(&[file.to_owned()], || Ok(Opened::of(Parquet::open(file)?)))?;
        let table = &opened.table;
        for group in 0..table.groups() {
            let column = |name: &str| table.columns().iter().find(|c| c.name == name && c.of == Holds::Number);
            let index = column("episode_index");
            if self.info.layout == Layout::Shared && index.is_some_and(|index| !table.may_hold(group, index, number)) {
                continue;
            }
            // Where nothing says whose frames these are, all are the episode's.
            let rows = match (index, self.info.features.first()) {
                (Some(index), _) => self.rows_of(file, number, &opened.runs(group, index)?)?,
                (None, Some(feature)) => (0..wide(table, group, feature, None)?.rows).collect(),
                (None, None) => Vec::new(),
            };
            let (Some(first), Some(last)) = (rows.first().copied(), rows.last().copied()) else { continue };
            // An episode is read by itself, however many others stand in its group.
            let part = first..last + 1;
            let single = |name: &str| -> Result<Option<Vec<f64>>> {
                let Some(column) = column(name) else { return Ok(None) };
                let found = table.numbers_of(group, column, &part)?;
                Ok(Some(rows.iter().map(|row| found.values[*row - first]).collect()))
            };
            let known = all.numbers.len();
            let counted = || (known..known + rows.len()).map(|i| i as f64).collect();
            all.numbers.extend(single("frame_index")?.unwrap_or_else(counted));
            let rate = self.info.rate_hz;
            let computed = || all.numbers[known..].iter().map(|number| number / rate).collect();
            let stamps = single("timestamp")?.unwrap_or_else(computed);
            all.stamps.extend(stamps);
            let read = |feature: &Feature| wide(table, group, feature, Some(&part));
            let features = self.info.features.iter().map(read).collect::<Result<Vec<Numbers>>>()?;
            for row in rows.iter().map(|row| row - first) {
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
    fn rows_of(&self, file: &Path, number: u64, runs: &[Run]) -> Result<Vec<usize>> {
        let other = runs.iter().find(|run| run.episode != number as f64);
        if let (Layout::FileEach, Some(Run { episode, .. })) = (self.info.layout, other) {
            let message = format!("expected frames of episode {number}, found one of episode {episode}");
            return Err(Error::file(file, message, "give every file its own name again"));
        }
        Ok(runs.iter().filter(|run| run.episode == number as f64).flat_map(|run| run.rows.clone()).collect())
    }

    /// The times of the frames in s. Where the stamps are the numbers of the frames over the rate, in single precision, they are
    /// computed anew to the last digit.
    pub(super) fn clock(&self, frames: &Frames, path: &Path) -> Result<(Vec<f64>, Option<Note>)> {
        let rate = self.info.rate_hz;
        let first =
            frames.stamps.first().copied().unwrap_or(0.0) - frames.numbers.first().copied().unwrap_or(0.0) / rate;
        let computed: Vec<f64> = frames.numbers.iter().map(|number| number / rate).collect();
        let near = |(stamp, time): (&f64, &f64)| (stamp - time).abs() * rate < COMPUTED + stamp.abs() * rate * 1e-6;
        if first.abs() * rate < COMPUTED && frames.stamps.iter().zip(&computed).all(near) {
            if let Some(at) = (1..computed.len()).find(|i| computed[*i] <= computed[i - 1]) {
                let (before, found) = (frames.numbers[at - 1], frames.numbers[at]);
                let message = format!(
                    "`frame_index` does not rise in row {}: expected more than {before}, found {found}",
                    at + 1
                );
                return Err(Error::file(
                    path,
                    message,
                    "sort the rows of the episode by it, or choose another episode",
                ));
            }
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

/// The numbers of a feature in all rows of a group or some of them, as many in each row as it has names.
fn wide(table: &Parquet, group: usize, feature: &Feature, rows: Option<&Range<usize>>) -> Result<Numbers> {
    let column = table.column(&feature.column)?;
    let found = match rows {
        Some(rows) => table.numbers_of(group, column, rows)?,
        None => table.numbers(group, column)?,
    };
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

/// That an episode has not as many frames as `meta` lists.
pub(super) fn other_length(episode: &Episode, found: u64) -> Option<Note> {
    let listed = episode.frames.filter(|listed| *listed != found)?;
    let text = format!("`meta` lists {listed} frames of episode {}, found {found}", episode.number);
    Some(Note::new(findings::FRAMES_DIFFER, text, "download `meta` and `data` of one version"))
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
