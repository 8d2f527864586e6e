//! What the answer to each recording is called: as the recording, within the folder that all of them share.

use crate::files::names;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result};
use tunenet_formats::Error;

/// Names of files for the answers to `recordings`, in their order: `b/drop.csv.json` for `runs/b/drop.csv` next to
/// `runs/a/drop.csv`. They depend on how the recordings lie to each other, not on where they lie: every machine has the same.
///
/// # Errors
/// [`Error::File`] where a recording is given twice.
pub fn of(recordings: &[PathBuf]) -> Result<Vec<String>> {
    let places: Vec<PathBuf> = recordings.iter().map(|path| straight(path)).collect::<Result<_>>()?;
    let mut shared: PathBuf = places.first().and_then(|p| p.parent()).unwrap_or(Path::new("")).into();
    while !places.iter().all(|place| place.parent().is_some_and(|folder| folder.starts_with(&shared))) {
        if !shared.pop() {
            break;
        }
    }
    let (mut names, mut known) = (Vec::with_capacity(places.len()), BTreeMap::new());
    for (path, place) in recordings.iter().zip(&places) {
        let within = place.strip_prefix(&shared).unwrap_or(place);
        let parts: Vec<&str> = within
            .components()
            .filter_map(|part| if let Component::Normal(name) = part { Some(name.to_str()) } else { None })
            .collect::<Option<_>>()
            .with_context(|| format!("the name of {} is not Unicode", path.display()))?;
        let name = format!("{}.json", parts.join("/"));
        if known.insert(name.clone(), path).is_some() {
            let message = "expected every recording once, found this one twice";
            return Err(Error::file(path, message, "give every recording once").into());
        }
        names.push(name);
    }
    Ok(names)
}

/// What each of `recordings` is called for users, in their order: the file's name, and of several files with one name as
/// many of their folders as distinguish them. One that is given twice is called the same twice.
pub fn shown(recordings: &[PathBuf]) -> Vec<String> {
    let parts = |path: &PathBuf| -> Vec<String> {
        let place = straight(path).unwrap_or_else(|_| path.clone());
        place.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect()
    };
    let places: Vec<Vec<String>> = recordings.iter().map(parts).collect();
    let tail = |place: &Vec<String>, count: usize| place[place.len().saturating_sub(count)..].to_vec();
    let one = |(path, place): (&PathBuf, &Vec<String>)| {
        let alone = |count: &usize| places.iter().all(|p| p == place || tail(p, *count) != tail(place, *count));
        match (1..=place.len()).find(alone) {
            Some(1) | None => names::file_name(path),
            Some(count) => tail(place, count).join("/"),
        }
    };
    recordings.iter().zip(&places).map(one).collect()
}

/// The path from the root on, without `.` and `..`; links stay what they are.
fn straight(path: &Path) -> Result<PathBuf> {
    let mut place = PathBuf::new();
    let whole = std::path::absolute(path).with_context(|| format!("the place of {}", path.display()))?;
    for part in whole.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(place.pop()),
            other => place.push(other),
        }
    }
    Ok(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(paths: &[&str]) -> Result<Vec<String>> {
        of(&paths.iter().map(PathBuf::from).collect::<Vec<_>>())
    }

    #[test]
    fn files_of_one_name_get_names_of_their_own() {
        let shown = |paths: &[&str]| shown(&paths.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(shown(&["runs/a/drop.csv", "runs/b/other.csv"]), ["drop.csv", "other.csv"]);
        assert_eq!(shown(&["runs/a/drop.csv", "runs/b/drop.csv", "c.csv"]), ["a/drop.csv", "b/drop.csv", "c.csv"]);
        assert_eq!(shown(&["a/x/drop.csv", "b/x/drop.csv"]), ["a/x/drop.csv", "b/x/drop.csv"]);
        assert_eq!(shown(&["drop.csv", "./drop.csv"]), ["drop.csv", "drop.csv"]);
        assert_eq!(shown(&["/x/drop.csv", "/drop.csv"])[0], "x/drop.csv");
    }

    #[test]
    fn answers_lie_as_recordings_do() {
        assert_eq!(named(&["runs/a/drop.csv", "runs/b/drop.csv"]).unwrap(), ["a/drop.csv.json", "b/drop.csv.json"]);
        assert_eq!(named(&["a/../one.csv", "./two.csv"]).unwrap(), ["one.csv.json", "two.csv.json"]);
        assert_eq!(named(&["/x/y/one.csv"]).unwrap(), ["one.csv.json"]);
        assert_eq!(named(&["/x/y/one.csv", "/x/two.csv"]).unwrap(), ["y/one.csv.json", "two.csv.json"]);
        assert_eq!(named(&["x/ab/1.csv", "x/a/1.csv"]).unwrap(), ["ab/1.csv.json", "a/1.csv.json"]);
        assert!(named(&["a/1.csv", "a/../a/1.csv"]).unwrap_err().to_string().contains("found this one twice"));
        assert!(named(&[]).unwrap().is_empty());
    }
}
