//! Which episodes of a LeRobot data set are there, and in which files.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::info::{Info, Layout};
use crate::documents::is_git_lfs_pointer;
use crate::kept::Kept;
use crate::numbered;
use crate::parquet::Parquet;
use crate::shown::shown_path;
use crate::source::open;
use crate::{Action, Error, Result};

/// Most files of a data set that are looked for.
const MOST_FILES: usize = 200_000;

/// Most episodes of a data set.
const MOST_EPISODES: usize = 2_000_000;

/// Longest line of `meta/episodes.jsonl`, in bytes: it lists the tasks of an episode as texts.
const LONGEST_LINE: u64 = 1 << 20;

/// An episode that is there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Episode {
    pub number: u64,
    /// How many frames it has, where that is known without reading it.
    pub frames: Option<u64>,
    /// The files in which it stands, in their order; those of version 3 hold other episodes as well.
    pub files: Vec<PathBuf>,
}

/// What is there of a data set.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Index {
    /// By their numbers.
    pub episodes: Vec<Episode>,
    /// Files that git-lfs has not downloaded.
    pub pointers: Vec<PathBuf>,
}

/// Looks for the episodes below `folder`.
///
/// # Errors
/// [`Error::Io`] or [`Error::File`] where a file cannot be used; a file that git-lfs has not downloaded is only listed.
pub(crate) fn index(folder: &Path, info: &Info) -> Result<Index> {
    let mut found = match info.layout {
        Layout::FileEach => named(folder)?,
        Layout::Shared => match listed_rows(folder)? {
            Some(rows) => there(folder, info, &rows)?,
            None => Index::clone(&*scanned(folder)?),
        },
    };
    if found.episodes.len() > MOST_EPISODES {
        let message = format!("expected at most {MOST_EPISODES} episodes, found more");
        return Err(Error::file(folder, message, "is this the right folder?"));
    }
    found.episodes.sort_by_key(|episode| episode.number);
    found.episodes = once_each(info.layout, found.episodes)?;
    Ok(found)
}

/// The episode of this number alone, where it is found without looking for the others; with an index that was read before, where the
/// files of the data set have not changed.
///
/// # Errors
/// As [`index`].
pub(crate) fn one(folder: &Path, info: &Info, wanted: u64) -> Result<Option<Episode>> {
    match info.layout {
        Layout::FileEach => {
            let file = folder.join(info.episode_path(wanted));
            let there = number(&file) == Some(wanted) && file.is_file() && !is_git_lfs_pointer(&file)?;
            Ok(there.then(|| Episode { number: wanted, frames: None, files: vec![file] }))
        }
        Layout::Shared => {
            let Some(rows) = listed_rows(folder)? else {
                let all = scanned(folder)?;
                let found = all.episodes.binary_search_by_key(&wanted, |episode| episode.number);
                return Ok(found.ok().map(|at| all.episodes[at].clone()));
            };
            let mine: Vec<Row> = rows.iter().filter(|row| row.number == wanted).copied().collect();
            let found = there(folder, info, &mine)?;
            let whole = found.pointers.is_empty() && found.episodes.len() == mine.len();
            Ok(once_each(info.layout, found.episodes)?.pop().filter(|_| whole))
        }
    }
}

/// Sorted episodes, each number once: what a data set of version 3 lists in several lines is one episode.
fn once_each(layout: Layout, episodes: Vec<Episode>) -> Result<Vec<Episode>> {
    let mut all: Vec<Episode> = Vec::with_capacity(episodes.len());
    for episode in episodes {
        let Some(before) = all.last_mut().filter(|before| before.number == episode.number) else {
            all.push(episode);
            continue;
        };
        if layout == Layout::FileEach {
            let (number, other) = (episode.number, shown_path(&before.files[0]));
            let message = format!("expected one file of episode {number}, found {other} as well");
            return Err(Error::file(&episode.files[0], message, "keep the one that belongs to the data set"));
        }
        for file in episode.files.into_iter().filter(|file| !before.files.contains(file)).collect::<Vec<_>>() {
            before.files.push(file);
            before.frames = before.frames.zip(episode.frames).map(|(before, more)| before + more);
        }
    }
    Ok(all)
}

/// Files that are named after their episodes: `episode_000007.parquet`. Their lengths stand in `meta/episodes.jsonl`.
fn named(folder: &Path) -> Result<Index> {
    let mut found = Index::default();
    let lengths = lengths(folder)?;
    for file in parquet_files(&folder.join("data"))? {
        if is_git_lfs_pointer(&file)? {
            found.pointers.push(file);
        } else if let Some(number) = number(&file) {
            let frames = lengths.get(&number).copied();
            found.episodes.push(Episode { number, frames, files: vec![file] });
        }
    }
    Ok(found)
}

/// The number at the end of the name of a file.
fn number(file: &Path) -> Option<u64> {
    numbered::split(file.file_stem()?.to_str()?).1
}

/// The lengths that `meta/episodes.jsonl` lists, where it is there; they are for the listing alone, so a line that is none is left out.
///
/// # Errors
/// [`Error::Io`] where the system refuses the file.
fn lengths(folder: &Path) -> Result<BTreeMap<u64, u64>> {
    let path = folder.join("meta").join("episodes.jsonl");
    if !path.exists() {
        return Ok(BTreeMap::new());
    }
    let of_line = |line: &[u8]| {
        let value: serde_json::Value = serde_json::from_slice(line).ok()?;
        Some((value.get("episode_index")?.as_u64()?, value.get("length")?.as_u64()?))
    };
    let mut all = BTreeMap::new();
    let mut rest = BufReader::new(open(&path)?);
    loop {
        // A line that is longer ends here, and what is left of it is a line that is none.
        let mut line = Vec::new();
        let some = rest.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line);
        if some.map_err(|e| Error::io(&path, Action::Reading, e))? == 0 || all.len() > MOST_EPISODES {
            return Ok(all);
        }
        all.extend(of_line(&line));
    }
}

/// What `meta/episodes` says of an episode: its length, and the numbers of the file that it stands in.
#[derive(Debug, Clone, Copy)]
struct Row {
    number: u64,
    frames: u64,
    chunk: u64,
    file: u64,
}

/// What was read last.
static ROWS: Kept<Vec<Row>> = Kept::new();
static SCANNED: Kept<Index> = Kept::new();

/// The episodes that `meta/episodes` lists; `None` where it lists none.
fn listed_rows(folder: &Path) -> Result<Option<Arc<Vec<Row>>>> {
    let tables = folder.join("meta").join("episodes");
    if !tables.is_dir() {
        return Ok(None);
    }
    let tables = parquet_files(&tables)?;
    let read = || {
        let mut rows = Vec::new();
        for path in &tables {
            add_rows(path, &mut rows)?;
        }
        Ok(rows)
    };
    Ok(Some(ROWS.of(&tables, read)?).filter(|rows| !rows.is_empty()))
}

/// Adds the episodes that a table lists.
fn add_rows(path: &Path, rows: &mut Vec<Row>) -> Result<()> {
    let table = Parquet::open(path)?;
    for group in 0..table.groups() {
        let column = |name: &str| -> Result<Vec<u64>> {
            let numbers = table.numbers(group, table.column(name)?)?.values;
            numbers.into_iter().map(|n| whole(path, name, n)).collect()
        };
        let (numbers, lengths) = (column("episode_index")?, column("length")?);
        let (chunks, files) = (column("data/chunk_index")?, column("data/file_index")?);
        for (((number, frames), chunk), file) in numbers.into_iter().zip(lengths).zip(chunks).zip(files) {
            rows.push(Row { number, frames, chunk, file });
        }
        if rows.len() > MOST_EPISODES {
            let message = format!("expected at most {MOST_EPISODES} episodes, found more");
            return Err(Error::file(path, message, "is this the right folder?"));
        }
    }
    Ok(())
}

/// Those of the listed episodes whose files are there.
fn there(folder: &Path, info: &Info, rows: &[Row]) -> Result<Index> {
    let mut found = Index::default();
    // By the numbers of a file: its path where it is there.
    let mut known: BTreeMap<(u64, u64), Option<PathBuf>> = BTreeMap::new();
    for Row { number, frames, chunk, file } in rows {
        if let Entry::Vacant(new) = known.entry((*chunk, *file)) {
            let path = folder.join(info.data_path(*chunk, *file));
            let is_file = path.is_file();
            let pointer = is_file && is_git_lfs_pointer(&path)?;
            found.pointers.extend(pointer.then(|| path.clone()));
            new.insert(Some(path).filter(|_| is_file && !pointer));
        }
        if let Some(Some(path)) = known.get(&(*chunk, *file)) {
            found.episodes.push(Episode { number: *number, frames: Some(*frames), files: vec![path.clone()] });
        }
    }
    Ok(found)
}

/// The episodes in the files below `data`, by their column of numbers.
fn scanned(folder: &Path) -> Result<Arc<Index>> {
    let files = parquet_files(&folder.join("data"))?;
    SCANNED.of(&files, || scan(&files))
}

fn scan(files: &[PathBuf]) -> Result<Index> {
    let mut found = Index::default();
    let mut episodes: BTreeMap<u64, Episode> = BTreeMap::new();
    for file in files.iter().cloned() {
        if is_git_lfs_pointer(&file)? {
            found.pointers.push(file);
            continue;
        }
        let table = Parquet::open(&file)?;
        let column = table.column("episode_index")?;
        for group in 0..table.groups() {
            for number in table.numbers(group, column)?.values {
                let number = whole(&file, "episode_index", number)?;
                let new = || Episode { number, frames: Some(0), files: Vec::new() };
                let episode = episodes.entry(number).or_insert_with(new);
                episode.frames = episode.frames.map(|frames| frames + 1);
                if episode.files.last() != Some(&file) {
                    episode.files.push(file.clone());
                }
            }
        }
    }
    found.episodes = episodes.into_values().collect();
    Ok(found)
}

/// A number of a table as a whole one.
fn whole(path: &Path, column: &str, number: f64) -> Result<u64> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number below 2^53")]
    if number.fract() == 0.0 && (0.0..9e15).contains(&number) {
        return Ok(number as u64);
    }
    let message = format!("expected whole numbers from 0 on in `{column}`, found {number}");
    Err(Error::file(path, message, "download the file again"))
}

/// The Parquet files below a folder, in the order of their names.
fn parquet_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = vec![(folder.to_owned(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        let failed = |e| Error::io(&folder, Action::Reading, e);
        for entry in std::fs::read_dir(&folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            if path.extension().is_some_and(|e| e == "parquet") {
                files.push(path);
            } else if depth < 2 && path.is_dir() {
                folders.push((path, depth + 1));
            }
            if files.len() > MOST_FILES {
                let message = format!("expected at most {MOST_FILES} files, found more");
                return Err(Error::file(&folder, message, "is this the right folder?"));
            }
        }
    }
    files.sort();
    Ok(files)
}
