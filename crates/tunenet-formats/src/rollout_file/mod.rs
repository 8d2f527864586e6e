//! Answered rollouts on disk, so that an interrupted tuning goes on where it was.
//!
//! The first line says in JSON of which problem the answers are; the records that follow are described in `record`. Each is written when
//! it is answered, so that a kill loses at most the one that is being written: an incomplete record at the end is ignored.

mod record;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use tunenet_core::tune::{Request, RolloutStore};

use crate::{Action, Error, Result};
use record::{HEAD, Record};

/// No more is kept beyond this length: 1 GB, twenty times what a long tuning of a slow simulator needs.
const MOST_BYTES: u64 = 1_000_000_000;
/// How often what was written is made to reach the disk.
const SYNC: Duration = Duration::from_secs(1);
/// The first line is shorter.
const LONGEST_LINE: usize = 1024;
/// Hexadecimal digits of a hash in a sentence.
const SHOWN: usize = 12;
const ANOTHER: &str = "name another file, or delete this one";

/// The first line.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    schema: Schema,
    /// Of everything that the answers depend on.
    sha256: String,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
enum Schema {
    #[serde(rename = "tunenet.rollouts.1")]
    First,
}

/// Answered rollouts of one tuning, kept in a file.
#[derive(Debug)]
pub struct RolloutFile {
    path: PathBuf,
    state: Mutex<State>,
}

/// What a [`RolloutFile`] did.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RolloutFileUse {
    /// Rollouts in the file.
    pub kept: usize,
    /// Rollouts of an earlier run that were asked for again and not simulated.
    pub recalled: usize,
    /// Why later rollouts are not in it, if so.
    pub incomplete: Option<String>,
}

#[derive(Debug)]
struct State {
    file: File,
    places: HashMap<Request, Place>,
    /// Where the next record begins.
    end: u64,
    most: u64,
    recalled: usize,
    incomplete: Option<String>,
    synced: Instant,
}

/// Where an answer is.
#[derive(Debug)]
struct Place {
    at: u64,
    numbers: usize,
    /// Whether it is of an earlier run, and was not asked for since.
    waits: bool,
}

impl RolloutFile {
    /// Opens `path`, or makes it. `sha256` stands for everything that the answers depend on, each of which has a number for every sample
    /// of so many `channels`.
    ///
    /// # Errors
    /// [`Error::File`] where it is no such file, is of another problem, is in use or damaged; [`Error::Io`] where the system refuses.
    pub fn open(path: &Path, sha256: &str, channels: usize) -> Result<Self> {
        if std::fs::metadata(path).is_ok_and(|about| !about.is_file()) {
            return Err(Error::file(path, "expected a file to keep rollouts in, found a folder or a device", ANOTHER));
        }
        let opened = OpenOptions::new().read(true).append(true).create(true).open(path);
        let mut file = opened.map_err(|e| Error::io(path, Action::Opening, e))?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                let message = "expected a file that no other command uses, found it in use";
                return Err(Error::file(path, message, "wait for the other command, or name another file"));
            }
            // Some network disks have no locks.
            Err(TryLockError::Error(error)) if error.kind() != ErrorKind::Unsupported => {
                return Err(Error::io(path, Action::Opening, error));
            }
            _ => {}
        }
        let (places, end) = read(path, &mut file, sha256, channels)?;
        let (most, synced) = (MOST_BYTES, Instant::now());
        let state = State { file, places, end, most, recalled: 0, incomplete: None, synced };
        Ok(Self { path: path.to_path_buf(), state: Mutex::new(state) })
    }

    /// Whether `path` begins as such a file, of any problem.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        let mut start = Vec::new();
        let read = File::open(path).and_then(|file| file.take(LONGEST_LINE as u64).read_to_end(&mut start));
        read.is_ok() && header(&start).is_some()
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was kept and recalled so far.
    #[must_use]
    pub fn used(&self) -> RolloutFileUse {
        let state = self.state();
        RolloutFileUse { kept: state.places.len(), recalled: state.recalled, incomplete: state.incomplete.clone() }
    }

    /// Empties the file: its answers turned out to be wrong.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses.
    pub fn clear(&self) -> Result<()> {
        let mut state = self.state();
        state.places.clear();
        state.end = 0;
        state.incomplete = Some("its answers were discarded".into());
        state.file.set_len(0).map_err(|e| Error::io(&self.path, Action::Writing, e))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl RolloutStore for RolloutFile {
    fn recall(&self, request: &Request) -> Option<Vec<f64>> {
        self.state().recall(request)
    }

    fn keep(&self, request: &Request, answer: &[f64]) {
        let mut state = self.state();
        if state.incomplete.is_none()
            && !state.places.contains_key(request)
            && let Err(why) = state.keep(request, answer)
        {
            state.incomplete = Some(why);
        }
    }
}

impl State {
    fn recall(&mut self, request: &Request) -> Option<Vec<f64>> {
        let place = self.places.get_mut(request)?;
        let mut bytes = vec![0; 8 * place.numbers];
        // What can no longer be read is simulated again.
        self.file.seek(SeekFrom::Start(place.at)).and_then(|_| self.file.read_exact(&mut bytes)).ok()?;
        self.recalled += usize::from(std::mem::take(&mut place.waits));
        record::answer(&bytes)
    }

    /// Appends an answer, or says why it could not.
    fn keep(&mut self, request: &Request, answer: &[f64]) -> std::result::Result<(), String> {
        let full = || format!("it would be longer than {} MB", self.most / 1_000_000);
        let bytes = record::encode(request, answer).ok_or_else(full)?;
        let end = self.end + bytes.len() as u64;
        if end > self.most {
            return Err(full());
        }
        if let Err(error) = self.write(&bytes) {
            // What was written of it is an incomplete record at the end, which is ignored.
            return Err(format!("writing failed: {error}"));
        }
        let numbers = answer.len();
        self.places.insert(request.clone(), Place { at: end - 8 * numbers as u64, numbers, waits: false });
        self.end = end;
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.file.write_all(bytes)?;
        if self.synced.elapsed() >= SYNC {
            self.file.sync_data()?;
            self.synced = Instant::now();
        }
        Ok(())
    }
}

/// The first line of a file that begins so.
fn header(start: &[u8]) -> Option<(Header, usize)> {
    let end = start.iter().position(|byte| *byte == b'\n')?;
    Some((serde_json::from_slice(&start[..end]).ok()?, end + 1))
}

/// The answers in the file, and where they end. What is incomplete there is removed, and a new file gets its first line.
fn read(path: &Path, file: &mut File, sha256: &str, channels: usize) -> Result<(HashMap<Request, Place>, u64)> {
    let reading = |e| Error::io(path, Action::Reading, e);
    let writing = |e| Error::io(path, Action::Writing, e);
    let length = file.metadata().map_err(reading)?.len();
    if length > MOST_BYTES {
        let message = format!("expected at most {MOST_BYTES} bytes, found {length}");
        return Err(Error::file(path, message, ANOTHER));
    }
    let line = serde_json::to_string(&Header { schema: Schema::First, sha256: sha256.into() });
    let line = line.map_err(|e| writing(e.into()))? + "\n";
    let mut start = Vec::new();
    (&*file).take(LONGEST_LINE as u64).read_to_end(&mut start).map_err(reading)?;
    // A kill may leave a part of the line.
    if start.len() < line.len() && line.as_bytes().starts_with(&start) {
        file.set_len(0).and_then(|()| file.write_all(line.as_bytes())).map_err(writing)?;
        return Ok((HashMap::new(), line.len() as u64));
    }
    let Some((header, first)) = header(&start) else {
        return Err(Error::file(path, "expected rollouts that `tunenet tune` kept, found another file", ANOTHER));
    };
    if header.sha256 != sha256 {
        let shown = |hash: &str| hash.chars().filter(char::is_ascii_hexdigit).take(SHOWN).collect::<String>();
        let message = format!(
            "expected rollouts of this simulation and these recordings (SHA-256 {}), found those of others ({})",
            shown(sha256),
            shown(&header.sha256)
        );
        return Err(Error::file(path, message, ANOTHER));
    }
    let first = first as u64;
    file.seek(SeekFrom::Start(first)).map_err(reading)?;
    let (places, end) = records(path, &mut BufReader::new(&*file), (first, length), channels)?;
    if end < length {
        file.set_len(end).map_err(writing)?;
    }
    Ok((places, end))
}

/// The records between two places, and where the last whole one ends.
fn records(
    path: &Path,
    from: &mut impl Read,
    (mut at, length): (u64, u64),
    channels: usize,
) -> Result<(HashMap<Request, Place>, u64)> {
    let reading = |e| Error::io(path, Action::Reading, e);
    let mut places = HashMap::new();
    while at + HEAD as u64 <= length {
        let mut head = [0; HEAD];
        from.read_exact(&mut head).map_err(reading)?;
        let size = record::length(&head);
        let end = at + HEAD as u64 + size;
        if end > length {
            break;
        }
        let mut body = Vec::new();
        from.take(size).read_to_end(&mut body).map_err(reading)?;
        let whole = record::is_whole(&head, &body);
        // A machine that fails may leave the last record with its length only.
        if !whole && end == length {
            break;
        }
        let Some(Record { request, numbers }) = record::decode(&body, channels).filter(|_| whole) else {
            let message = format!("expected a rollout as it was written at byte {at}, found a damaged one");
            return Err(Error::file(path, message, ANOTHER));
        };
        places.insert(request, Place { at: end - 8 * numbers as u64, numbers, waits: true });
        at = end;
    }
    Ok((places, at))
}
