//! `meta/info.json` of a LeRobot data set: its version, rate and features.

use std::path::{Component, Path, PathBuf};

use serde_json::Value;

use crate::encoding::read_text;
use crate::{Error, Result};

/// Greatest plausible rate, in frames per second.
const FASTEST_HZ: f64 = 1e5;

/// Most numbers of one feature that are columns; more are a picture or a map.
const WIDEST: usize = 512;

/// What stands in every frame besides measurements.
const COUNTS: [&str; 5] = ["timestamp", "frame_index", "episode_index", "index", "task_index"];

/// How the files are laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Layout {
    /// v2.0 and v2.1: a file for each episode.
    FileEach,
    /// v3.0: several episodes in a file.
    Shared,
}

/// What a data set says of itself.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Info {
    pub layout: Layout,
    /// `v2.1`.
    pub version: String,
    /// Empty where it says none.
    pub robot: String,
    pub rate_hz: f64,
    /// How many episodes it says that it has.
    pub episodes: Option<u64>,
    /// The features that are rows of numbers.
    pub features: Vec<Feature>,
    /// Where a file of data stands: `data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet`.
    data_path: String,
    /// How many episodes a folder of version 2 holds.
    chunk: u64,
}

/// A row of numbers in every frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Feature {
    /// Its column: `observation.state`.
    pub column: String,
    /// What each of its numbers is called here: `elbow`, `action.elbow`, `velocity.elbow`.
    pub names: Vec<String>,
    /// Why numbers stand in place of the names that the data set has.
    pub numbered: Option<Numbered>,
}

/// Why names are not used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Numbered {
    /// This one occurs twice.
    Twice(String),
    /// There are so many, and another number of numbers.
    Count(usize),
}

impl Info {
    /// Reads `meta/info.json` below `folder`.
    ///
    /// # Errors
    /// [`Error::Io`] or [`Error::File`] where it cannot be used.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("meta").join("info.json");
        let text = read_text(&path)?;
        let refuse = |message: String, hint: &str| Error::file(&path, message, hint);
        let whole = "download the whole folder `meta` of the data set again";
        let value: Value = serde_json::from_str(&text).map_err(|e| refuse(format!("expected JSON: {e}"), whole))?;
        let version = value.get("codebase_version").and_then(Value::as_str).unwrap_or("none").to_owned();
        let layout = match version.trim_start_matches('v').split('.').next() {
            Some("2") => Layout::FileEach,
            Some("3") => Layout::Shared,
            _ => {
                let message = format!("expected a LeRobot data set of version 2 or 3, found `{version}`");
                return Err(refuse(message, "convert it with LeRobot's own scripts (`lerobot.datasets`)"));
            }
        };
        let rate_hz = value.get("fps").and_then(Value::as_f64).filter(|fps| *fps > 0.0 && *fps <= FASTEST_HZ);
        let Some(rate_hz) = rate_hz else {
            let found = value.get("fps").map_or("none".into(), ToString::to_string);
            return Err(refuse(format!("expected `fps` above 0, found {found}"), whole));
        };
        let features = value.get("features").and_then(Value::as_object);
        let features = features.ok_or_else(|| refuse("expected `features`, found none".into(), whole))?;
        let features: Vec<Feature> = features.iter().filter_map(|(column, about)| feature(column, about)).collect();
        let robot = value.get("robot_type").and_then(Value::as_str).unwrap_or_default().to_owned();
        let episodes = value.get("total_episodes").and_then(Value::as_u64);
        let usual = if layout == Layout::Shared { DATA_PATH } else { EPISODE_PATH };
        let data_path = value.get("data_path").and_then(Value::as_str).unwrap_or(usual).to_owned();
        let chunk = value.get("chunks_size").and_then(Value::as_u64).filter(|size| *size > 0).unwrap_or(CHUNK);
        Ok(Self { layout, version, robot, rate_hz, episodes, features, data_path, chunk })
    }

    /// Where it says that its files of data stand; `None` where that is the usual place.
    pub fn unusual_path(&self) -> Option<&str> {
        Some(self.data_path.as_str()).filter(|path| ![DATA_PATH, EPISODE_PATH].contains(path))
    }

    /// The file of version 3 with these numbers, seen from the folder of the data set. Nothing outside it is named.
    pub fn data_path(&self, chunk: u64, file: u64) -> PathBuf {
        inside(&filled(&filled(&self.data_path, "chunk_index", chunk), "file_index", file))
    }

    /// Where the file of an episode of version 2 usually stands, seen from the folder of the data set.
    pub fn episode_path(&self, number: u64) -> PathBuf {
        let chunk = filled(&self.data_path, "episode_chunk", number / self.chunk);
        inside(&filled(&chunk, "episode_index", number))
    }
}

/// A path without what leads out of its folder.
fn inside(path: &str) -> PathBuf {
    Path::new(path).components().filter(|part| matches!(part, Component::Normal(_))).collect()
}

/// Where files of data stand where a data set does not say it.
const DATA_PATH: &str = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet";

/// The same of version 2, and how many episodes a folder of it holds.
const EPISODE_PATH: &str = "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet";
const CHUNK: u64 = 1000;

/// A pattern of Python's `format` with a number in place of `{name}` or `{name:03d}`.
fn filled(pattern: &str, name: &str, number: u64) -> String {
    let Some((before, rest)) = pattern.split_once(&format!("{{{name}")) else { return pattern.to_owned() };
    let Some((form, after)) = rest.split_once('}') else { return pattern.to_owned() };
    let width = form.trim_start_matches(':').trim_end_matches('d').parse::<usize>().unwrap_or(0).min(20);
    format!("{before}{number:0width$}{after}")
}

/// A feature that is a row of numbers.
fn feature(column: &str, about: &Value) -> Option<Feature> {
    let kind = about.get("dtype").and_then(Value::as_str)?;
    let numbers = ["float", "int", "uint", "bool"].iter().any(|start| kind.starts_with(start));
    let shape: Vec<u64> = about.get("shape")?.as_array()?.iter().map(Value::as_u64).collect::<Option<_>>()?;
    let width = match shape.as_slice() {
        [] => 1,
        [width] => usize::try_from(*width).ok()?,
        _ => return None,
    };
    if !numbers || COUNTS.contains(&column) || width == 0 || width > WIDEST {
        return None;
    }
    let prefix = match column {
        "observation.state" => "",
        other => other.strip_prefix("observation.").unwrap_or(other),
    };
    let (parts, numbered) = parts(about.get("names"), width);
    let named = |part: String| match (prefix, width) {
        ("", _) => part,
        (prefix, 1) if part == "0" => prefix.to_owned(),
        (prefix, _) => format!("{prefix}.{part}"),
    };
    let names = parts.into_iter().map(|part| {
        if prefix.is_empty() && part.parse::<u32>().is_ok() { format!("state.{part}") } else { named(part) }
    });
    Some(Feature { column: column.to_owned(), names: names.collect(), numbered })
}

/// The names of a feature's numbers: from a list, from a list in a list, or from a table of one (`{"motors": […]}`) or of names and
/// places (`{"elbow.pos": 0}`); their numbers from 0 where these are not as many. What all of them end in, such as `.pos`, is left out.
/// The second value says why numbers are used although there are names.
fn parts(names: Option<&Value>, width: usize) -> (Vec<String>, Option<Numbered>) {
    let numbered = || (0..width).map(|i| i.to_string()).collect();
    let texts = |list: &Vec<Value>| list.iter().map(|v| v.as_str().map(str::to_owned)).collect::<Option<Vec<String>>>();
    let found = match names {
        Some(Value::Array(list)) => match list.as_slice() {
            [Value::Array(inner)] => texts(inner),
            _ => texts(list),
        },
        Some(Value::Object(table)) => {
            let lists: Option<Vec<Vec<String>>> = table.values().map(|v| texts(v.as_array()?)).collect();
            let placed = || {
                let mut places: Vec<(u64, &String)> =
                    table.iter().map(|(name, v)| Some((v.as_u64()?, name))).collect::<Option<_>>()?;
                places.sort();
                Some(places.into_iter().map(|(_, name)| name.clone()).collect())
            };
            lists.map(|lists| lists.concat()).or_else(placed)
        }
        _ => None,
    };
    let Some(mut found) = found else { return (numbered(), None) };
    if found.len() != width {
        return (numbered(), Some(Numbered::Count(found.len())).filter(|_| !found.is_empty()));
    }
    let twice = (0..width).find(|i| found[..*i].contains(&found[*i])).map(|i| found[i].clone());
    if twice.is_some() || found.iter().any(String::is_empty) {
        return (numbered(), twice.map(Numbered::Twice));
    }
    if let Some(end) = found[0].rfind('.').map(|at| found[0][at..].to_owned())
        && found.iter().all(|name| name.len() > end.len() && name.ends_with(&end))
    {
        let cut: Vec<String> = found.iter().map(|name| name[..name.len() - end.len()].to_owned()).collect();
        if (0..width).all(|i| !cut[..i].contains(&cut[i])) {
            found = cut;
        }
    }
    (found, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn names_are_read_in_every_form() {
        let list = json!(["a.pos", "b.pos"]);
        for names in [list.clone(), json!([["a", "b"]]), json!({"motors": ["a", "b"]}), json!({"b": 1, "a": 0})] {
            assert_eq!(parts(Some(&names), 2).0, ["a", "b"], "{names}");
        }
        for names in [Some(&json!(["a"])), Some(&json!(["a", "a"])), Some(&json!([1, 2])), None] {
            assert_eq!(parts(names, 2).0, ["0", "1"]);
        }
        assert_eq!(parts(Some(&json!(["a", "a"])), 2).1, Some(Numbered::Twice("a".into())));
        assert_eq!(parts(Some(&json!(["a", "b"])), 3).1, Some(Numbered::Count(2)));
        assert_eq!(
            [parts(Some(&json!([])), 2).1, parts(Some(&json!([1, 2])), 2).1, parts(None, 2).1],
            [None, None, None]
        );
        let mixed = json!(["a.pos", "a.vel"]);
        assert_eq!(parts(Some(&mixed), 2).0, ["a.pos", "a.vel"]);
    }

    #[test]
    fn a_path_is_filled_in_and_stays_in_the_folder() {
        assert_eq!(filled("a-{x:03d}/{y}.p", "x", 7), "a-007/{y}.p");
        assert_eq!(filled("a-{x}", "x", 7), "a-7");
        let info = Info {
            layout: Layout::Shared,
            version: String::new(),
            robot: String::new(),
            rate_hz: 30.0,
            episodes: None,
            features: Vec::new(),
            data_path: "../../{chunk_index:02d}/{file_index:03d}".into(),
            chunk: CHUNK,
        };
        assert_eq!(info.data_path(1, 2), Path::new("01/002"));
        assert_eq!(info.unusual_path(), Some("../../{chunk_index:02d}/{file_index:03d}"));
        let old = Info { layout: Layout::FileEach, data_path: EPISODE_PATH.into(), ..info };
        assert_eq!(old.episode_path(2345), Path::new("data/chunk-002/episode_002345.parquet"));
    }

    #[test]
    fn features_are_named_by_what_they_are() {
        let of = |column: &str, about: Value| feature(column, &about).map(|found| found.names);
        let row = |names: Value| json!({"dtype": "float32", "shape": [2], "names": names});
        assert_eq!(of("observation.state", row(json!(["a", "b"]))).unwrap(), ["a", "b"]);
        assert_eq!(of("action", row(json!(["a", "b"]))).unwrap(), ["action.a", "action.b"]);
        assert_eq!(of("observation.velocity", row(json!(null))).unwrap(), ["velocity.0", "velocity.1"]);
        assert_eq!(of("observation.state", row(json!(null))).unwrap(), ["state.0", "state.1"]);
        assert_eq!(
            of("next.reward", json!({"dtype": "float32", "shape": [1], "names": null})).unwrap(),
            ["next.reward"]
        );
        assert_eq!(of("observation.image", json!({"dtype": "video", "shape": [480, 640, 3]})), None);
        assert_eq!(of("timestamp", json!({"dtype": "float32", "shape": [1], "names": null})), None);
    }
}
