//! The files of a log: one, or those of a folder that ROS 2 recorded into, in their order.

use std::path::{Path, PathBuf};

use crate::encoding::read_text;
use crate::findings;
use crate::shown::{counted, list};
use crate::{Action, Error, Result};
use tunenet_core::observation::Note;

/// What ROS 2 writes next to the files of a recording.
const METADATA: &str = "metadata.yaml";

/// Most files of one recording.
const MOST_FILES: usize = 10_000;

/// How the names of the files of a recording end.
const ENDINGS: [&str; 4] = [".db3", ".db3.zstd", ".mcap", ".mcap.zstd"];

/// Whether a folder is a recording of ROS 2: it has its `metadata.yaml`, or files of one next to each other.
pub(crate) fn is_bag(folder: &Path) -> bool {
    folder.join(METADATA).is_file() || in_folder(folder).is_ok_and(|files| !files.is_empty())
}

/// The files of the log at `path`, in the order in which they were recorded.
///
/// # Errors
/// [`Error::File`] where the folder holds none, or lacks one that its `metadata.yaml` lists.
pub(crate) fn files(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let found = in_folder(path)?;
    if found.is_empty() {
        let message = "expected a recording in the folder (.db3 or .mcap), found none";
        return Err(Error::file(path, message, "name the folder that `ros2 bag record` wrote, or the file itself"));
    }
    let metadata = path.join(METADATA);
    if !metadata.is_file() {
        return Ok(found);
    }
    let listed: Vec<PathBuf> = relative_paths(&read_text(&metadata)?)
        .into_iter()
        // Bags of before Foxy name their files from the folder above.
        .map(|name| path.join(Path::new(&name).file_name().unwrap_or_default()))
        .collect();
    // A recording that was compressed or renamed afterwards is what stands there.
    if listed.is_empty() || listed.iter().all(|file| !file.is_file()) {
        return Ok(found);
    }
    let missing: Vec<String> = listed.iter().filter(|file| !file.is_file()).map(|file| name(file)).collect();
    if !missing.is_empty() {
        let absent = list(missing.iter().map(String::as_str), 3);
        let expected = counted(listed.len(), "file");
        let message = format!("expected the {expected} that its {METADATA} lists, found no {absent}");
        return Err(Error::file(path, message, "copy the whole folder, or give single files of it"));
    }
    Ok(listed)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The recorded files in a folder, those with lower numbers first; of a file and its compressed copy, the file.
fn in_folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let failed = |e| Error::io(folder, Action::Reading, e);
    let mut all: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let named = name(&path).to_lowercase();
        if ENDINGS.iter().any(|ending| named.ends_with(ending)) && path.is_file() {
            all.push(path);
        }
        if all.len() > MOST_FILES {
            let message = format!("expected at most {MOST_FILES} files of one recording, found more");
            return Err(Error::file(folder, message, "give a folder of one recording"));
        }
    }
    all.sort_by_cached_key(|path| natural(&name(path)));
    let plain: Vec<PathBuf> = all.clone();
    all.retain(|path| !(path.extension().is_some_and(|e| e == "zstd") && plain.contains(&path.with_extension(""))));
    Ok(all)
}

/// That a file is missing between those of a recording, by their numbers.
pub(crate) fn absent_parts(files: &[PathBuf]) -> Option<Note> {
    let of = |path: &PathBuf| {
        let stem = PathBuf::from(name(path).trim_end_matches(".zstd")).with_extension("");
        let text = stem.to_string_lossy().into_owned();
        let digits = text.len() - text.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (before, number) = text.split_at(text.len() - digits);
        number.parse::<u64>().ok().map(|number| (before.to_owned(), number))
    };
    let unread = || {
        let metadata = files.first()?.parent()?.join(METADATA);
        let unread = metadata.is_file() && relative_paths(&read_text(&metadata).unwrap_or_default()).is_empty();
        let text = format!("its {METADATA} lists no files: they follow in the order of their numbers");
        unread.then(|| Note::new(findings::FILES_MISSING, text, "copy the whole folder, with its metadata.yaml"))
    };
    if files.len() > 1
        && let Some(note) = unread()
    {
        return Some(note);
    }
    let numbers = files.iter().map(of).collect::<Option<Vec<_>>>()?;
    let gap = numbers.windows(2).find(|pair| pair[0].0 == pair[1].0 && pair[1].1 > pair[0].1 + 1)?;
    let text = format!("the recording's files go from `{}{}` to `{}{}`", gap[0].0, gap[0].1, gap[1].0, gap[1].1);
    Some(Note::new(findings::FILES_MISSING, text, "copy the whole folder, with its metadata.yaml"))
}

/// A name in parts, its numbers as numbers: `bag_10` comes after `bag_9`.
fn natural(name: &str) -> Vec<(String, u64)> {
    let mut parts: Vec<(String, u64)> = vec![(String::new(), 0)];
    let mut in_number = false;
    for letter in name.chars() {
        if let Some(digit) = letter.to_digit(10) {
            if let Some((_, number)) = parts.last_mut() {
                *number = number.saturating_mul(10).saturating_add(u64::from(digit));
            }
            in_number = true;
        } else {
            if in_number {
                parts.push((String::new(), 0));
                in_number = false;
            }
            if let Some((text, _)) = parts.last_mut() {
                text.push(letter);
            }
        }
    }
    parts
}

/// The files that a `metadata.yaml` lists. It is written by a program, always in the same form: an item in a line.
fn relative_paths(text: &str) -> Vec<String> {
    let mut lines = text.lines().skip_while(|line| line.trim() != "relative_file_paths:");
    lines.next();
    let items = lines.map_while(|line| line.trim().strip_prefix("- "));
    items.map(|item| item.trim().trim_matches(['"', '\'']).to_owned()).filter(|item| !item.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            std::fs::write(folder.path().join(name), "x").unwrap();
        }
        folder
    }

    fn found(folder: &tempfile::TempDir) -> Vec<String> {
        files(folder.path()).unwrap().iter().map(|path| name(path)).collect()
    }

    #[test]
    fn the_parts_of_a_recording_follow_in_the_order_of_their_numbers() {
        let bag = folder(&["b_10.db3", "b_9.db3", "b_9.db3-wal", "notes.txt", "b_10.db3.zstd", "b_11.db3.zstd"]);
        assert_eq!(found(&bag), ["b_9.db3", "b_10.db3", "b_11.db3.zstd"]);
        assert!(is_bag(bag.path()));
        assert!(!is_bag(folder(&["a.csv"]).path()));
    }

    #[test]
    fn a_number_that_is_skipped_is_a_file_that_is_missing() {
        let gap = |names: &[&str]| absent_parts(&names.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(
            gap(&["b_0.db3", "b_1.db3.zstd", "b_3.db3"]).unwrap().text,
            "the recording's files go from `b_1` to `b_3`"
        );
        assert_eq!(gap(&["b_0.mcap", "b_1.mcap"]), None);
        assert_eq!(gap(&["a_0.mcap", "b_5.mcap"]), None, "two recordings");
        assert_eq!(gap(&["b.db3"]), None);
    }

    #[test]
    fn metadata_gives_the_order_and_what_is_missing() {
        let bag = folder(&["b.mcap", "a.mcap"]);
        let list = "x:\n  relative_file_paths:\n    - b.mcap\n    - \"old/a.mcap\"\n  duration:\n    - no\n";
        std::fs::write(bag.path().join(METADATA), list).unwrap();
        assert_eq!(found(&bag), ["b.mcap", "a.mcap"]);
        std::fs::remove_file(bag.path().join("a.mcap")).unwrap();
        let error = files(bag.path()).unwrap_err();
        assert!(error.to_string().ends_with("expected the 2 files that its metadata.yaml lists, found no `a.mcap`"));
        let empty = folder(&[]);
        assert!(files(empty.path()).unwrap_err().to_string().contains("expected a recording in the folder"));
    }
}
