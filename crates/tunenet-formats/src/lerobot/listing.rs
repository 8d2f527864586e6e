//! What a data set says of itself, and the units that its numbers suggest.

use super::DataSet;
use super::episode::other_length;
use super::info::{Feature, Numbered};
use crate::Result;
use crate::episodes::{EpisodeColumn, EpisodeLength, Episodes};
use crate::findings;
use crate::numbered::EPISODE;
use crate::recording::ReadOptions;
use crate::shown::{counted, list};
use crate::unit_misfit::note_misfit;
use crate::units::{self, ACTION};
use tunenet_core::observation::Note;
use tunenet_core::text::visible;

/// How many frames are looked at for the units: a few episodes.
const LOOKED_AT: usize = 20_000;

/// How many episodes are read for that at most, so that many short ones are listed as fast as few long ones.
const MOST_READ: usize = 8;

/// Most numbers that a message lists.
const MOST_LISTED: usize = 8;

impl DataSet {
    /// Its episodes, or the one of this name, with columns and units.
    ///
    /// # Errors
    /// Where there is no such episode, a file cannot be used, or `--units` names no column.
    pub fn listing(&self, name: Option<&str>, options: &ReadOptions) -> Result<Episodes> {
        let mut names: Vec<String> = Vec::new();
        let mut values: Vec<f64> = Vec::new();
        let listed = match name {
            Some(one) => std::slice::from_ref(self.episode(Some(one))?),
            None => self.index.episodes.as_slice(),
        };
        let mut lengths: Vec<Note> = Vec::new();
        for episode in listed.iter().take(MOST_READ) {
            let frames = self.frames_of(episode)?;
            // What `tune` would refuse is no recording here either.
            self.clock(&frames, &self.folder.join(format!("{EPISODE}{}", episode.number)))?;
            lengths.extend(other_length(episode, frames.stamps.len() as u64));
            names = frames.names;
            let left = LOOKED_AT * names.len() - values.len();
            values.extend_from_slice(&frames.values[..frames.values.len().min(left)]);
            if frames.values.len() >= left {
                break;
            }
        }
        units::refuse_unused(&options.units, &names)?;
        let width = names.len().max(1);
        let readings = |column: usize| values.iter().skip(column).step_by(width).copied().collect::<Vec<f64>>();
        let column = |(i, name): (usize, &String)| EpisodeColumn::of(name, &readings(i), &options.units);
        let misfit = |(i, name): (usize, &String)| note_misfit(name, &readings(i), units::rule(&options.units, name)?);
        let misfits: Vec<Note> = names.iter().enumerate().filter_map(misfit).collect();
        let mut columns: Vec<EpisodeColumn> = names.iter().enumerate().map(column).collect();
        as_joints(&mut columns);
        // What is said of a joint holds for its command.
        let own = |column: &EpisodeColumn| command_of(&columns, column).is_none_or(|joint| joint.proposed.is_none());
        let suggested = columns.iter().filter(|column| column.unit.is_none() && own(column));
        let flags = suggested.filter_map(|column| Some(format!("{}={}", column.name, column.proposed.as_ref()?)));
        let units = flags.collect::<Vec<String>>().join(",");
        let length = |episode: &super::Episode| EpisodeLength {
            name: format!("{EPISODE}{}", episode.number),
            frames: episode.frames,
        };
        Ok(Episodes {
            format: format!("LeRobot {}", self.info.version),
            robot: self.info.robot.clone(),
            rate_hz: Some(self.info.rate_hz),
            lacks_clock: false,
            episodes: listed.iter().map(length).collect(),
            columns,
            units,
            notes: self
                .missing()
                .filter(|_| name.is_none())
                .into_iter()
                .chain(self.numbered())
                .chain(lengths)
                .chain(misfits)
                .collect(),
        })
    }

    /// That numbers stand in place of the names that it has.
    fn numbered(&self) -> Option<Note> {
        let one = |feature: &Feature| {
            let why = match feature.numbered.as_ref()? {
                Numbered::Twice(name) => format!("`{}` occurs twice", visible(name)),
                Numbered::Count(names) => {
                    format!("{} for {}", counted(*names, "name"), counted(feature.names.len(), "number"))
                }
            };
            Some(format!("`{}` ({why})", visible(&feature.column)))
        };
        let all: Vec<String> = self.info.features.iter().filter_map(one).collect();
        let text = format!("numbers replace the names of {}", all.join(", "));
        let note = Note::new(findings::COLUMNS_NUMBERED, text, "correct `names` in `meta/info.json`");
        (!all.is_empty()).then_some(note)
    }

    /// That not all of the episodes that it says it has are there.
    fn missing(&self) -> Option<Note> {
        let total = self.info.episodes?;
        let there = self.index.episodes.len() as u64;
        if there >= total {
            return None;
        }
        let listed: Vec<String> = self.index.episodes.iter().map(|episode| episode.number.to_string()).collect();
        let listed = list(listed.iter().map(String::as_str), MOST_LISTED);
        let text = format!("{there} of {} are there: {listed}", counted(total, "episode"));
        let remedy = if self.index.pointers.is_empty() {
            "download the other files of `data` where they are needed".to_owned()
        } else {
            let (count, were) =
                (self.index.pointers.len(), if self.index.pointers.len() == 1 { "was" } else { "were" });
            format!("run `git lfs pull` in its repository: {} of `data` {were} not downloaded", counted(count, "file"))
        };
        Some(Note::new(findings::EPISODES_MISSING, text, &remedy))
    }
}

/// The joint that a column holds the commands of.
fn command_of<'a>(columns: &'a [EpisodeColumn], column: &EpisodeColumn) -> Option<&'a EpisodeColumn> {
    let joint = column.name.strip_prefix(ACTION)?;
    columns.iter().find(|column| column.name == joint)
}

/// Gives commands the unit of their joints: a leader's numbers, normalised to its own range, are goals in the range of the follower.
fn as_joints(columns: &mut [EpisodeColumn]) {
    let before = columns.to_vec();
    for column in columns.iter_mut().filter(|column| column.unit.is_none()) {
        let Some(joint) = command_of(&before, column).filter(|joint| joint.proposed.is_some()) else { continue };
        if joint.proposed != column.proposed {
            column.proposed.clone_from(&joint.proposed);
            column.why = format!("a goal of `{}` is in the unit of its positions", joint.name);
        }
    }
}
