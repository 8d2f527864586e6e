//! The groups of a file, which of them are episodes, and the arrays of one.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use hdf5_pure::{AttrValue, Dataset, File, Group};

use super::shape::{Shape, numbers, shape};
use super::{broken, broken_in, listed};
use crate::findings;
use crate::numbered::split;
use crate::recording::MOST_NUMBERS;
use crate::sheet::most_common_rows;
use crate::shown::{counted, list};
use crate::{Error, Result};
use tunenet_core::observation::Note;

/// Deepest group below an episode, and most groups and arrays of a file that are looked at.
const DEEPEST: usize = 8;
const MOST_OBJECTS: usize = 100_000;

/// The attribute in which robomimic and Isaac Lab describe the simulator.
const ENVIRONMENT: &str = "env_args";

/// What was found in a file.
#[derive(Default)]
pub(super) struct Found {
    pub episodes: Vec<(String, String)>,
    pub empty: Vec<String>,
    pub environment: String,
    pub groups: usize,
    /// What there is in place of episodes.
    pub left_out: Option<Note>,
}

/// The numbers of an episode, a row for each instant.
pub(super) struct Columns {
    pub names: Vec<String>,
    /// Row by row.
    pub values: Vec<f64>,
    pub rows: usize,
    /// Columns that stand apart, with their names.
    pub clocks: Vec<(String, Vec<f64>)>,
    /// Which arrays of the episode are no columns.
    pub left_out: Option<Note>,
}

impl Columns {
    /// The numbers of a column.
    pub fn column(&self, column: usize) -> impl Iterator<Item = f64> + Clone {
        self.values.iter().skip(column).step_by(self.names.len().max(1)).copied()
    }
}

/// An array with a row for each instant.
pub(super) struct Array {
    /// Its path below the episode, with dots: `obs.joint_pos`.
    pub name: String,
    pub rows: usize,
    /// Numbers in a row.
    pub width: usize,
    /// Whether it is a list of numbers, not of rows.
    pub flat: bool,
    data: Dataset,
}

impl Array {
    /// What its columns are called: a list is one, an array of rows as many as a row has numbers.
    pub fn column_names(&self) -> Vec<String> {
        if self.flat {
            return vec![self.name.clone()];
        }
        (0..self.width).map(|column| format!("{}.{column}", self.name)).collect()
    }

    /// Its numbers, row by row.
    ///
    /// # Errors
    /// [`Error::File`] where it is broken.
    pub fn numbers(&self, path: &Path) -> Result<Vec<f64>> {
        let found = numbers(&self.data).map_err(|e| broken(path, &e))?;
        if found.len() != self.rows * self.width {
            let message =
                format!("`{}`: expected {} numbers, found {}", self.name, self.rows * self.width, found.len());
            return Err(Error::file(path, message, super::AGAIN));
        }
        Ok(found)
    }
}

/// The episodes of a file: the groups with a number at the end of their names that hold arrays, at the top or one below; or the whole file,
/// where arrays stand at its top or nowhere in such groups.
pub(super) fn episodes(path: &Path, file: &File) -> Result<Found> {
    let root = file.root();
    let mut found = Found::default();
    let groups = sorted(root.groups().map_err(|e| broken_in(path, "/", &e))?);
    found.groups = groups.len();
    let top = own_arrays(path, &root)?;
    for name in &groups {
        let group = root.group(name).map_err(|e| broken(path, &e))?;
        if found.environment.is_empty() {
            found.environment = environment(&group);
        }
        let inner = sorted(group.groups().map_err(|e| broken_in(path, name, &e))?);
        let arrays = group.datasets().map_err(|e| broken_in(path, name, &e))?;
        found.groups += inner.len();
        if inner.is_empty() && arrays.is_empty() {
            found.empty.push(name.clone());
        }
        if top || found.groups > MOST_OBJECTS {
            continue;
        }
        if numbered(name) {
            found.episodes.push((name.clone(), name.clone()));
        } else {
            let below = inner.iter().filter(|inner| numbered(inner));
            found.episodes.extend(below.map(|inner| (inner.clone(), format!("{name}/{inner}"))));
        }
    }
    for (name, group) in distinct(path, std::mem::take(&mut found.episodes))? {
        if arrays(path, file, &group)?.is_empty() {
            found.empty.push(group);
        } else {
            found.episodes.push((name, group));
        }
    }
    if found.episodes.is_empty() {
        let (arrays, left_out) = arrays_and_others(path, file, "/")?;
        if arrays.is_empty() {
            found.left_out = left_out;
        } else {
            found.episodes.push((String::new(), "/".into()));
        }
    }
    if found.environment.is_empty() {
        found.environment = environment(&root);
    }
    Ok(found)
}

/// The episode of this name alone, where a single group has it.
pub(super) fn one(path: &Path, file: &File, name: &str) -> Result<Option<Found>> {
    let root = file.root();
    if !numbered(name) || own_arrays(path, &root)? {
        return Ok(None);
    }
    let tops = sorted(root.groups().map_err(|e| broken_in(path, "/", &e))?);
    let mut places: Vec<String> = tops.iter().filter(|top| *top == name).cloned().collect();
    let mut environment = String::new();
    // What describes the simulator stands in all episodes or above them.
    for (_, top) in tops.iter().enumerate().filter(|(i, top)| *i == 0 || !numbered(top)) {
        let group = root.group(top).map_err(|e| broken(path, &e))?;
        if environment.is_empty() {
            environment = self::environment(&group);
        }
        if numbered(top) {
            continue;
        }
        // Groups of one name in different groups are named by both.
        let by_both = name.strip_prefix(top.as_str()).and_then(|rest| rest.strip_prefix('.'));
        let inner = [Some(name), by_both].into_iter().flatten().filter(|inner| group.group(inner).is_ok());
        places.extend(inner.map(|inner| format!("{top}/{inner}")));
    }
    let [place] = places.as_slice() else { return Ok(None) };
    if arrays(path, file, place)?.is_empty() {
        return Ok(None);
    }
    if environment.is_empty() {
        environment = self::environment(&root);
    }
    let episodes = vec![(name.to_owned(), place.clone())];
    Ok(Some(Found { episodes, environment, ..Found::default() }))
}

/// Episodes whose names occur once each: groups of one name in different groups are named by both, `left.demo_0`.
fn distinct(path: &Path, mut episodes: Vec<(String, String)>) -> Result<Vec<(String, String)>> {
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    for (name, _) in &episodes {
        *times.entry(name.clone()).or_default() += 1;
    }
    for (name, group) in episodes.iter_mut().filter(|(name, _)| times[name] > 1) {
        *name = group.replace('/', ".");
    }
    let mut seen = BTreeSet::new();
    if let Some((name, _)) = episodes.iter().find(|(name, _)| !seen.insert(name)) {
        let message = format!("expected groups of different names, found {} twice", list([name.as_str()], 1));
        return Err(Error::file(path, message, "rename one of them"));
    }
    Ok(episodes)
}

/// Whether a name ends in a number, as those of episodes do.
fn numbered(name: &str) -> bool {
    name.ends_with(|c: char| c.is_ascii_digit())
}

/// Names in the order of the numbers at their ends.
fn sorted(mut names: Vec<String>) -> Vec<String> {
    names.sort_by_cached_key(|name| {
        let (stem, number) = split(name);
        (stem.to_owned(), number.unwrap_or(0))
    });
    names
}

/// Whether arrays with a row for each instant stand in the group itself.
fn own_arrays(path: &Path, group: &Group) -> Result<bool> {
    for name in group.datasets().map_err(|e| broken(path, &e))? {
        let data = group.dataset(&name).map_err(|e| broken(path, &e))?;
        if shape(&data).is_ok() {
            return Ok(true);
        }
    }
    Ok(false)
}

fn environment(group: &Group) -> String {
    match group.attrs().ok().and_then(|mut attributes| attributes.remove(ENVIRONMENT)) {
        Some(
            AttrValue::String(text)
            | AttrValue::AsciiString(text)
            | AttrValue::VarLenString(text)
            | AttrValue::VarLenAsciiString(text)
            | AttrValue::StringSized { value: text, .. }
            | AttrValue::AsciiStringSized { value: text, .. },
        ) => text,
        Some(other) => format!("{other:?}"),
        None => String::new(),
    }
}

/// The arrays below a group that have as many rows as most of its numbers have.
pub(super) fn arrays(path: &Path, file: &File, group: &str) -> Result<Vec<Array>> {
    Ok(arrays_and_others(path, file, group)?.0)
}

/// The same, and what is said of the arrays that have another number of rows.
pub(super) fn arrays_and_others(path: &Path, file: &File, top_name: &str) -> Result<(Vec<Array>, Option<Note>)> {
    let top = if top_name == "/" { file.root() } else { file.group(top_name).map_err(|e| broken(path, &e))? };
    let (mut found, mut no_rows, mut objects) = (Vec::new(), Vec::new(), 0);
    let mut open = vec![(top, String::new(), 0)];
    while let Some((group, prefix, depth)) = open.pop() {
        let place = place_of(top_name, &prefix);
        for name in group.datasets().map_err(|e| broken_in(path, &place, &e))? {
            objects += 1;
            let data = group.dataset(&name).map_err(|e| broken(path, &e))?;
            match shape(&data) {
                Ok(Shape { rows, width, flat }) => {
                    found.push(Array { name: format!("{prefix}{name}"), rows, width, flat, data });
                }
                Err(why) => no_rows.push((format!("{prefix}{name}"), why.to_string())),
            }
        }
        for name in group.groups().map_err(|e| broken_in(path, &place, &e))? {
            objects += 1;
            if depth < DEEPEST {
                let inner = group.group(&name).map_err(|e| broken(path, &e))?;
                open.push((inner, format!("{prefix}{name}."), depth + 1));
            }
        }
        if objects > MOST_OBJECTS {
            let message = format!("expected at most {MOST_OBJECTS} groups and arrays in an episode, found more");
            return Err(Error::file(path, message, "is this the right file?"));
        }
    }
    let rows = most_common_rows(found.iter().map(|array| array.rows)).unwrap_or(0);
    let others = found.iter().filter(|array| array.rows != rows);
    let of_length = others.map(|array| (array.name.clone(), counted(array.rows, "row")));
    let others: Vec<(String, String)> = of_length.chain(no_rows).collect();
    let which = if rows == 0 { "arrays".to_owned() } else { format!("arrays that are no {rows} rows of numbers") };
    let text = format!("{which} are left out: {}", listed(&others));
    let note = Note::new(findings::COLUMNS_IGNORED, text, "save them with a row for each instant if they matter");
    found.retain(|array| array.rows == rows);
    found.sort_by(|a, b| a.name.cmp(&b.name));
    if found.iter().map(|array| array.rows * array.width).sum::<usize>() > MOST_NUMBERS {
        let message = format!("expected at most {MOST_NUMBERS} numbers in an episode, found more");
        return Err(Error::file(path, message, "cut the episode into shorter ones"));
    }
    Ok((found, (!others.is_empty()).then_some(note)))
}

/// The path of a group below `top`, whose arrays have `prefix` before their names.
fn place_of(top: &str, prefix: &str) -> String {
    let inner = prefix.trim_end_matches('.').replace('.', "/");
    match (top, inner.as_str()) {
        (top, "") => top.to_owned(),
        ("/", inner) => inner.to_owned(),
        (top, inner) => format!("{top}/{inner}"),
    }
}
