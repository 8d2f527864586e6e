//! Bags of ROS 2 in SQLite (`rosbag2_storage_sqlite3`): the messages of one file, one by one.
//!
//! | file | subject |
//! |---|---|
//! | `database` | the file, opened so that nothing is written next to it |
//! | `unpacked` | files and messages that are compressed |

mod database;
mod unpacked;

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rusqlite::types::ValueRef;

use self::database::Database;
pub(crate) use self::unpacked::{Unpacked, message as unpacked_message, unpacked};
use crate::ros::channel::{ChannelInfo, Decoders, RawMessage};
use crate::ros::decoder::{Described, MOST_DEFINITIONS};
use crate::ros::schema::Given;
use crate::ros::wanted::{Wanted, first_of};
use crate::shown::counted;
use crate::{Error, Result};

/// Messages that are fetched at a time, and the most bytes of them.
const BATCH: usize = 256;
const BATCH_BYTES: usize = 16 << 20;

/// Longest message, in bytes, as in an MCAP file.
const LONGEST_MESSAGE: usize = 256 << 20;

/// Most topics of a bag: as many as an MCAP file has numbers for.
const MOST_TOPICS: usize = u16::MAX as usize;

/// The messages of a bag in the order of their times. Ends after the first error.
pub(crate) struct Messages {
    path: PathBuf,
    database: Database,
    channels: Vec<Arc<ChannelInfo>>,
    /// Which channel a topic is, by its number in the file.
    numbers: BTreeMap<i64, usize>,
    library: String,
    /// Topics all of whose messages are fetched with their bytes, by their numbers in the file.
    whole: Vec<i64>,
    /// Topics whose next message is; those of later ones are not.
    first: BTreeMap<i64, u64>,
    fetched: VecDeque<RawMessage>,
    /// Time and row of the last message that was fetched.
    last: (i64, i64),
    count: u64,
    ended: bool,
}

impl Messages {
    /// Opens the bag in the file at `path`, for the bytes of the messages that are `wanted`: those of others are left empty. `given`
    /// defines types that it does not.
    ///
    /// # Errors
    /// [`Error::Io`] or [`Error::File`] where it is no bag. The iterator returns [`Error::File`] once, as its last item, where it is
    /// broken, and says how many messages came before.
    pub fn open(path: &Path, given: &Given, wanted: &Wanted) -> Result<Self> {
        let database = Database::open(path)?;
        let definitions = database.definitions(MOST_DEFINITIONS)?;
        let (mut channels, mut numbers, mut known) = (Vec::new(), BTreeMap::new(), Decoders::new());
        for topic in database.topics(MOST_TOPICS)? {
            let (schema_encoding, definition) =
                definitions.get(&topic.schema).map_or(("", ""), |(encoding, text)| (encoding.as_str(), text.as_str()));
            let described = Described {
                message_encoding: &topic.encoding,
                schema_name: &topic.schema,
                schema_encoding,
                definition: definition.as_bytes(),
            };
            let number = u16::try_from(channels.len()).unwrap_or(u16::MAX);
            numbers.insert(topic.id, channels.len());
            channels.push(Arc::new(ChannelInfo::new(number, topic.name, described, given, &mut known)));
        }
        let library = database.library();
        let (whole, first) = match wanted {
            Wanted::First => {
                let of = |channel: &ChannelInfo| first_of(&channel.schema_name, &channel.message_encoding);
                let first = |(id, at): (&i64, &usize)| (*id, of(&channels[*at]));
                (Vec::new(), numbers.iter().map(first).collect())
            }
            Wanted::Topic { .. } => {
                let is = |(_, at): &(&i64, &usize)| wanted.all_of(&channels[**at]);
                (numbers.iter().filter(is).map(|(id, _)| *id).collect(), BTreeMap::new())
            }
        };
        Ok(Self {
            path: path.to_owned(),
            database,
            channels,
            numbers,
            library,
            whole,
            first,
            fetched: VecDeque::new(),
            last: (i64::MIN, i64::MIN),
            count: 0,
            ended: false,
        })
    }

    /// All topics, with or without messages.
    pub fn channels(&self) -> &[Arc<ChannelInfo>] {
        &self.channels
    }

    /// Who wrote the bag: profile and library.
    pub fn writer(&self) -> (&str, &str) {
        ("ros2", &self.library)
    }

    /// Fetches messages after the last one.
    fn fetch(&mut self) -> Result<()> {
        let (path, count) = (self.path.clone(), self.count);
        let broken = |error: rusqlite::Error| broken(&path, count, &error);
        let mut statement = self.database.after(&self.whole).map_err(broken)?;
        let mut single = self.database.bytes_of_row().map_err(broken)?;
        let mut rows = statement.query([self.last.0, self.last.1]).map_err(broken)?;
        let mut bytes = 0;
        while self.fetched.len() < BATCH && bytes < BATCH_BYTES {
            let Some(row) = rows.next().map_err(broken)? else { break };
            let number = |at: usize| row.get::<_, i64>(at).map_err(broken);
            let (id, topic, time) = (number(0)?, number(1)?, number(2)?);
            let wrong = |what: String| {
                let message =
                    format!("message {} {what}: {} could be read before", count + 1, counted(count, "message"));
                Err(Error::file(&path, message, "copy the recording again, or try `ros2 bag convert`"))
            };
            let mut one = None;
            let left = self.first.get_mut(&topic).filter(|left| **left > 0);
            if let Some(left) = left {
                *left -= 1;
                one = single.query([id]).map_err(broken)?.next().map_err(broken)?.map(|row| unpacked_of(row, 0));
            } else if self.whole.contains(&topic) {
                one = Some(unpacked_of(row, 3));
            }
            let data = match one.transpose() {
                Ok(data) => data.unwrap_or_default(),
                Err(why) => return wrong(why),
            };
            let Some(channel) = self.numbers.get(&topic).map(|at| &self.channels[*at]) else {
                return wrong(format!("is of topic {topic}, which the bag does not list"));
            };
            bytes += data.len();
            self.last = (time, id);
            let log_time = u64::try_from(time).unwrap_or(0);
            self.fetched.push_back(RawMessage { channel: Arc::clone(channel), log_time, data });
        }
        Ok(())
    }
}

/// The bytes of a message in column `at` of a row, or what is wrong with them.
fn unpacked_of(row: &rusqlite::Row<'_>, at: usize) -> std::result::Result<Vec<u8>, String> {
    match row.get_ref(at).map_err(|e| format!("cannot be read ({e})"))? {
        ValueRef::Blob(data) if data.len() <= LONGEST_MESSAGE => unpacked::message(data, LONGEST_MESSAGE),
        ValueRef::Blob(data) => Err(format!("has {} bytes, more than are read", data.len())),
        other => Err(format!("holds {:?} where its bytes are expected", other.data_type())),
    }
}

/// What SQLite said of a file that it could not read on.
fn broken(path: &Path, count: u64, error: &rusqlite::Error) -> Error {
    let message = format!("the bag is broken ({error}): {} could be read before", counted(count, "message"));
    Error::file(path, message, "copy the recording again, or try `sqlite3 BAG.db3 .recover`")
}

impl Iterator for Messages {
    type Item = Result<RawMessage>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        if self.fetched.is_empty()
            && let Err(error) = self.fetch()
            && self.fetched.is_empty()
        {
            self.ended = true;
            return Some(Err(error));
        }
        let next = self.fetched.pop_front();
        self.ended = next.is_none();
        self.count += u64::from(next.is_some());
        next.map(Ok)
    }
}

#[cfg(test)]
mod tests;
