//! What a file holds and the description of the robot leaves out: nothing is left out without a word.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::xml::{SourceFile, shown};

/// What leaving something out changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Changes {
    /// Which bodies and joints there are.
    Structure,
    /// How joints move under given torques, or what torques actuators make.
    Dynamics,
    /// What happens in contact.
    Contact,
    /// Only how a simulator integrates or solves.
    Solver,
    /// What sensors read.
    Readings,
    /// Nothing that moves: looks, names, start positions.
    Nothing,
    /// Unknown: neither the format nor this crate knows it.
    Unknown,
}

/// An element or attribute that is left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unused {
    /// The element's tag.
    pub element: String,
    /// The attribute; `None` where the element as a whole is left out, with what it contains.
    pub attribute: Option<String>,
    /// The file.
    pub path: PathBuf,
    /// Line of the first such place, from 1.
    pub line: usize,
    /// How many such places the file has.
    pub count: usize,
    /// What leaving it out changes.
    pub changes: Changes,
    /// The same in words: what the attribute or element would do.
    pub what: String,
}

impl std::fmt::Display for Unused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "<{}", self.element)?;
        if let Some(attribute) = &self.attribute {
            write!(f, " {attribute}=…")?;
        }
        write!(f, "> (line {}", self.line)?;
        if self.count > 1 {
            write!(f, " and {} more", self.count - 1)?;
        }
        write!(f, "): {}", self.what)
    }
}

/// Most entries of a list; what lies beyond is counted.
const MOST_ENTRIES: usize = 1000;

/// What distinguishes entries: file, element, attribute, consequence.
type Key = (usize, String, Option<String>, Changes, String);

/// Collects what is left out, one entry for each file, element, attribute and consequence.
#[derive(Debug, Default)]
pub(crate) struct Collector {
    /// The first byte and the count of each.
    found: BTreeMap<Key, (usize, usize)>,
}

impl Collector {
    /// Notes a place: `at` is its byte in the file.
    pub fn add(&mut self, file: usize, at: usize, of: (&str, Option<&str>), changes: Changes, what: &str) {
        let mut key = (file, shown(of.0), of.1.map(shown), changes, what.to_owned());
        if self.found.len() >= MOST_ENTRIES && !self.found.contains_key(&key) {
            key = (file, "…".into(), None, Changes::Unknown, "further ones, which no list has room for".into());
        }
        let entry = self.found.entry(key).or_insert((at, 0));
        *entry = (entry.0.min(at), entry.1 + 1);
    }

    /// Everything, what matters most first.
    pub fn finish(self, files: &[SourceFile]) -> Vec<Unused> {
        let entry = |((file, element, attribute, changes, what), (at, count)): (Key, (usize, usize))| {
            let source = &files[file];
            Unused { element, attribute, path: source.path.clone(), line: source.line(at), count, changes, what }
        };
        let mut all: Vec<Unused> = self.found.into_iter().map(entry).collect();
        all.sort_by(|a, b| (a.changes, &a.path, a.line).cmp(&(b.changes, &b.path, b.line)));
        all
    }
}
