//! Files to observations and back: recordings of all formats, data sets and models.
//!
//! [`read`] finds out what a file is by looking into it, then what kind of observation its columns or messages make, and
//! returns the [`Recording`]: the observation and what was noticed on the way. [`contents`] lists what is in a file without
//! asking it to be usable. [`write_csv`] and [`write_mcap`] are their counterparts; both replace a file in one step.
//!
//! | folder or file | subject |
//! |---|---|
//! | `source`, `encoding`, `format`, `documents` | the file itself: what is opened, how its text is written, which format it has, and which texts hold no table |
//! | `quantity`, `ranges` | what a column is by its name and unit, and ranges of columns |
//! | `csv` | lines and cells, the layout of the columns, guesses where names are unknown, the numbers, writing |
//! | `bag` | bags of ROS 2 in SQLite |
//! | `mcap` | records and chunks, pictures, writing |
//! | `ros` | ROS 2 and JSON messages, joints, stamps |
//! | `log` | files of a log, topics of a log, and the series of one of them |
//! | `parquet`, `lerobot` | Parquet files, and data sets of LeRobot in them |
//! | `hdf5`, `npz`, `mat`, `arrays` | demonstrations in HDF5; arrays of NumPy, variables of MATLAB, and the columns that they make |
//! | `joint_words`, `named_columns` | what the name of a column says of a joint; the columns of any recording |
//! | `place`, `episodes`, `numbered` | where a recording stands, recordings in several episodes, and their names |
//! | `kept` | what was read last of files that have not changed |
//! | `units`, `unstated`, `proposal`, `calibration`, `unit_misfit` | units of columns whose file states none |
//! | `sheet` | named columns of numbers from any file but a text |
//! | `dataset` | the pairs that a network learns from, as one MCAP file or in shards |
//! | `model` | trained networks and checkpoints in safetensors |
//! | `rollout_file` | answered rollouts of a tuning, from which it goes on |
//! | `atomic` | replacing a file in one step |
//! | `clock_jump` | a pause that is nearly all of a record |
//! | `contents`, `described` | the listing; the columns of a table by their numbers |
//! | `error` | what a file refuses, with its place and a hint |

#[cfg(feature = "logs")]
mod arrays;
mod atomic;
#[cfg(feature = "logs")]
mod bag;
mod calibration;
mod clock_jump;
mod contents;
mod csv;
pub mod dataset;
mod described;
mod documents;
mod encoding;
mod episodes;
mod error;
pub mod findings;
mod format;
#[cfg(feature = "logs")]
mod hdf5;
mod inputs;
mod joint_words;
#[cfg(feature = "logs")]
mod kept;
#[cfg(feature = "logs")]
mod lerobot;
mod log;
#[cfg(feature = "logs")]
mod mat;
mod mcap;
mod model;
mod named_columns;
#[cfg(feature = "logs")]
mod npz;
mod numbered;
mod others;
#[cfg(feature = "logs")]
mod parquet;
mod place;
mod proposal;
mod quantity;
mod ranges;
mod read;
mod recording;
mod rollout_file;
mod ros;
mod sheet;
mod shown;
mod source;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
#[cfg(feature = "logs")]
mod unit_misfit;
mod units;
#[cfg(feature = "logs")]
mod unstated;

pub use atomic::write_atomically;
pub use calibration::read_calibration;
pub use contents::{BrokenLine, Column, Contents, Log, Table, contents, contents_with};
pub use csv::write::write_csv;
pub use described::Described;
pub use documents::{refuse_git_lfs_pointer, refuse_markup};
pub use encoding::read_text;
pub use episodes::{EpisodeColumn, EpisodeLength, Episodes, Selection, episodes, is_episode};
pub use error::{Error, Result};
pub use inputs::{InputSource, NotedInput, read_if_there, read_input, read_start, under_inputs};
pub use joint_words::{JointQuantity, OfJoint, is_of_commands, of_joint, of_some_joint, unit_of_name};
pub use log::topics::Topic;
pub use mcap::pictures;
pub use mcap::trajectory::{JointPoint, write_approach};
pub use mcap::write::write_mcap;
pub use model::{load_model, model_from_bytes, model_to_bytes, save_model, train_file};
pub use named_columns::{NamedColumn, suggested_units};
pub use quantity::kind_name;
pub use read::{files_of, read, refuse_unused_options};
pub use recording::{LARGEST, MOST_NUMBERS, ReadOptions, Recording, Role};
pub use rollout_file::{RolloutFile, RolloutFileUse};
pub use shown::{shell_word, shown_path};
pub use source::{Version, open, read_bytes};
pub use tunenet_core::Action;
pub(crate) use tunenet_core::Origin;
pub use units::{Calibrated, UnitRule};
