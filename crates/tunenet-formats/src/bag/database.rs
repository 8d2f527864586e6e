//! A bag's database. It is opened read-only and as a file that never changes, so that SQLite writes neither a log nor an index
//! next to a user's file; what a recorder left unmerged in its log is merged in a copy.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rusqlite::limits::Limit;
use rusqlite::{Connection, OpenFlags, Statement};
use tempfile::TempDir;

use super::unpacked::{Unpacked, unpacked};
use crate::{Action, Error, Result};

/// Largest bag, in bytes, whose unmerged log is merged in a copy.
const LARGEST_COPY: u64 = 4 << 30;

/// Longest text or message that SQLite hands over, in bytes.
const LONGEST: i32 = 512 << 20;

/// What is tried where the tables are others.
const NO_BAG: &str = "give a bag that `ros2 bag record` wrote, or export its tables as CSV";

/// An open bag.
pub(super) struct Database {
    path: PathBuf,
    connection: Connection,
    /// Whether messages can be read in the order of their times without sorting all of them.
    by_time: bool,
    // Dropped after the connection: what it reads.
    _file: Unpacked,
    _copy: Option<TempDir>,
}

/// A topic as the bag lists it.
pub(super) struct Listed {
    pub id: i64,
    pub name: String,
    pub schema: String,
    pub encoding: String,
}

impl Database {
    /// Opens the bag at `path`, compressed or not.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses; [`Error::File`] where it is no bag.
    pub fn open(path: &Path) -> Result<Self> {
        let file = unpacked(path)?;
        let copy = merged_copy(path)?;
        let opened = match &copy {
            Some(folder) => Connection::open(folder.path().join(COPY)),
            None => Connection::open_with_flags(
                immutable(file.path()),
                OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX,
            ),
        };
        let failed = |e: rusqlite::Error| {
            let message = format!("expected a bag of ROS 2, found a file that SQLite refuses ({e})");
            Error::file(path, message, "copy the recording again, or try `sqlite3 BAG.db3 .recover`")
        };
        let connection = opened.map_err(failed)?;
        connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, LONGEST).map_err(failed)?;
        // No function of a foreign file's views and defaults is run.
        connection.pragma_update(None, "trusted_schema", false).map_err(failed)?;
        let mut database = Self { path: path.to_owned(), connection, by_time: false, _file: file, _copy: copy };
        database.refuse_other().map_err(|refused| refused.unwrap_or_else(failed))?;
        database.by_time = database.has_index_of_times().map_err(failed)?;
        Ok(database)
    }

    /// Refuses a database that has not the tables of a bag.
    fn refuse_other(&self) -> std::result::Result<(), Refused> {
        for (table, needed) in [("topics", ["id", "name", "type"]), ("messages", ["topic_id", "timestamp", "data"])] {
            let found = self.columns(table)?;
            if let Some(absent) = needed.iter().find(|column| !found.iter().any(|known| known == *column)) {
                let message = if found.is_empty() {
                    format!("expected a bag of ROS 2, found an SQLite database without the table `{table}`")
                } else {
                    format!("expected a bag of ROS 2, found an SQLite database whose table `{table}` has no `{absent}`")
                };
                return Err(Refused::Bag(Error::file(&self.path, message, NO_BAG)));
            }
        }
        Ok(())
    }

    /// The columns of a table that is stored as it stands; none of a view or of a virtual table.
    fn columns(&self, table: &str) -> rusqlite::Result<Vec<String>> {
        let text = "SELECT c.name FROM sqlite_schema s JOIN pragma_table_info(s.name) c \
                    WHERE s.name = ?1 AND s.type = 'table' AND s.rootpage > 0";
        let mut statement = self.connection.prepare(text)?;
        let names = statement.query_map([table], |row| row.get(0))?;
        names.collect()
    }

    /// Whether the recorder made its index of times.
    fn has_index_of_times(&self) -> rusqlite::Result<bool> {
        let text = "SELECT COUNT(*) FROM pragma_index_list('messages') l JOIN pragma_index_info(l.name) i \
                    WHERE i.seqno = 0 AND i.name = 'timestamp' AND l.partial = 0";
        self.connection.query_row(text, [], |row| Ok(row.get::<_, i64>(0)? > 0))
    }

    /// The query of the messages after a time and a row: row, topic, time, and the bytes of those of the topics in `whole`. The
    /// bytes of others stay where they are.
    pub fn after(&self, whole: &[i64]) -> rusqlite::Result<Statement<'_>> {
        let topics = whole.iter().map(i64::to_string).collect::<Vec<_>>().join(", ");
        let chosen = format!("rowid, topic_id, timestamp, CASE WHEN topic_id IN ({topics}) THEN data END");
        self.connection.prepare(&if self.by_time {
            format!("SELECT {chosen} FROM messages WHERE (timestamp, rowid) > (?1, ?2) ORDER BY timestamp, rowid")
        } else {
            format!("SELECT {chosen} FROM messages WHERE rowid > ?2 AND ?1 IS NOT NULL ORDER BY rowid")
        })
    }

    /// The query of the bytes of one message by its row.
    pub fn bytes_of_row(&self) -> rusqlite::Result<Statement<'_>> {
        self.connection.prepare("SELECT data FROM messages WHERE rowid = ?1")
    }

    /// The topics in the order in which they are listed.
    ///
    /// # Errors
    /// [`Error::File`] where one cannot be read, or there are more than `most`.
    pub fn topics(&self, most: usize) -> Result<Vec<Listed>> {
        let refuse =
            |what: String| Error::file(&self.path, format!("the topics of the bag cannot be read: {what}"), NO_BAG);
        let failed = |e: rusqlite::Error| refuse(e.to_string());
        let columns = self.columns("topics").map_err(failed)?;
        let encoding =
            if columns.iter().any(|c| c == "serialization_format") { "serialization_format" } else { "'cdr'" };
        let text = format!("SELECT id, name, type, {encoding} FROM topics ORDER BY rowid LIMIT {}", most + 1);
        let mut statement = self.connection.prepare(&text).map_err(failed)?;
        let topic = |row: &rusqlite::Row<'_>| {
            let (name, schema) = (row.get(1)?, row.get(2)?);
            Ok(Listed { id: row.get(0)?, name, schema, encoding: row.get(3)? })
        };
        let listed = statement.query_map([], topic).map_err(failed)?;
        let listed: Vec<Listed> = listed.collect::<rusqlite::Result<_>>().map_err(failed)?;
        if listed.len() > most {
            return Err(refuse(format!("expected at most {most}, found more")));
        }
        Ok(listed)
    }

    /// The definitions of types that the bag holds, by their names: language and text. Bags before version 4 hold none.
    ///
    /// # Errors
    /// [`Error::File`] where one cannot be read, or they have more than `most` bytes together.
    pub fn definitions(&self, most: usize) -> Result<BTreeMap<String, (String, String)>> {
        let refuse = |what: String| {
            Error::file(&self.path, format!("the message definitions of the bag cannot be read: {what}"), NO_BAG)
        };
        let failed = |e: rusqlite::Error| refuse(e.to_string());
        let columns = self.columns("message_definitions").map_err(failed)?;
        let needed = ["topic_type", "encoding", "encoded_message_definition"];
        if !needed.iter().all(|name| columns.iter().any(|column| column == name)) {
            return Ok(BTreeMap::new());
        }
        let text = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions";
        let mut statement = self.connection.prepare(text).map_err(failed)?;
        let mut rows = statement.query([]).map_err(failed)?;
        let (mut all, mut left) = (BTreeMap::new(), most);
        while let Some(row) = rows.next().map_err(failed)? {
            let text = |at: usize| row.get_ref(at).map_err(failed)?.as_str().map_err(|e| refuse(e.to_string()));
            let (name, language, definition) = (text(0)?, text(1)?, text(2)?);
            // A line without a text counts as well.
            let bytes = name.len() + language.len() + definition.len() + 1;
            left =
                left.checked_sub(bytes).ok_or_else(|| refuse(format!("expected at most {most} bytes, found more")))?;
            all.insert(name.to_owned(), (language.to_owned(), definition.to_owned()));
        }
        Ok(all)
    }

    /// What wrote the bag, as far as it says so: its version of the format, and the distribution of ROS.
    pub fn library(&self) -> String {
        let version = "SELECT schema_version, ros_distro FROM schema LIMIT 1";
        let read = |row: &rusqlite::Row<'_>| Ok((row.get::<_, i64>(0)?, row.get::<_, Option<String>>(1)?));
        match self.connection.query_row(version, [], read) {
            Ok((version, distro)) => {
                let distro =
                    distro.filter(|name| !name.is_empty()).map_or_else(String::new, |name| format!(", {name}"));
                format!("rosbag2 sqlite3, version {version}{distro}")
            }
            Err(_) => "rosbag2 sqlite3".into(),
        }
    }
}

/// Why a database is not read.
enum Refused {
    Bag(Error),
    Sqlite(rusqlite::Error),
}

impl Refused {
    fn unwrap_or_else(self, failed: impl FnOnce(rusqlite::Error) -> Error) -> Error {
        match self {
            Self::Bag(error) => error,
            Self::Sqlite(error) => failed(error),
        }
    }
}

impl From<rusqlite::Error> for Refused {
    fn from(error: rusqlite::Error) -> Self {
        Self::Sqlite(error)
    }
}

/// The name of a copy, which its log's name follows from.
const COPY: &str = "copy.db3";

/// A copy with the log that a recorder left next to the bag, where there is one that holds something.
fn merged_copy(path: &Path) -> Result<Option<TempDir>> {
    let neighbour = |suffix: &str| {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(suffix);
        path.with_file_name(name)
    };
    let suffixes = ["-wal", "-journal"];
    let holds =
        |suffix: &&str| std::fs::metadata(neighbour(suffix)).is_ok_and(|about| about.is_file() && about.len() > 0);
    let left: Vec<&str> = suffixes.into_iter().filter(holds).collect();
    if left.is_empty() {
        return Ok(None);
    }
    let bytes = std::fs::metadata(path).map_err(|e| Error::io(path, Action::Reading, e))?.len();
    if bytes > LARGEST_COPY {
        let file = crate::shell_word(&path.to_string_lossy());
        let message =
            format!("the recording was not closed: its last messages stand in `{}`", neighbour(left[0]).display());
        return Err(Error::file(
            path,
            message,
            format!("merge them: `sqlite3 {file} 'PRAGMA wal_checkpoint(TRUNCATE)'`"),
        ));
    }
    let folder = tempfile::tempdir().map_err(|e| Error::io(std::env::temp_dir(), Action::Creating, e))?;
    let copy = |from: &Path, suffix: &str| {
        let to = folder.path().join(format!("{COPY}{suffix}"));
        std::fs::copy(from, to).map_err(|e| Error::io(from, Action::Reading, e))
    };
    copy(path, "")?;
    for suffix in left {
        copy(&neighbour(suffix), suffix)?;
    }
    Ok(Some(folder))
}

/// The address under which SQLite opens a file as one that never changes.
fn immutable(path: &Path) -> PathBuf {
    let mut address = String::from("file:");
    for byte in std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).as_os_str().as_encoded_bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' => address.push(char::from(*byte)),
            other => {
                use std::fmt::Write as _;
                // Writing into a text cannot fail.
                let _ = write!(address, "%{other:02X}");
            }
        }
    }
    address.push_str("?immutable=1");
    address.into()
}
