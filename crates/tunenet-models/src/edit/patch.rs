//! Replacements in a text, by place.

use std::collections::BTreeMap;
use std::fmt::{Display, Write};
use std::ops::Range;

use super::EditedFile;
use crate::xml::{Element, SourceFile};

/// Attributes of elements that get other values.
#[derive(Debug, Default)]
pub(super) struct Patches {
    /// By file and first byte: how many bytes go, and what comes.
    places: BTreeMap<(usize, usize, usize), String>,
    /// Attributes to add, by file and the place behind the last attribute of the element.
    added: BTreeMap<(usize, usize), Vec<(String, String)>>,
}

impl Patches {
    /// The attribute of an element with this value.
    pub fn set(&mut self, element: &Element, source: &SourceFile, name: &str, value: &str) {
        if let Some(attribute) = element.attribute(name) {
            self.replace(attribute.file, attribute.inner.clone(), value.to_owned());
            return;
        }
        let at = element.attributes.last().map_or_else(|| after_name(element, source), |last| last.whole.end);
        let list = self.added.entry((element.file, at)).or_default();
        match list.iter_mut().find(|(old, _)| old == name) {
            Some((_, old)) => value.clone_into(old),
            None => list.push((name.to_owned(), value.to_owned())),
        }
    }

    /// Takes an attribute away, with the space before it.
    pub fn remove(&mut self, element: &Element, source: &SourceFile, name: &str) {
        let Some(attribute) = element.attribute(name) else { return };
        let before = &source.text[element.open.start..attribute.whole.start];
        let space = before.len() - before.trim_end().len();
        self.replace(attribute.file, attribute.whole.start - space..attribute.whole.end, String::new());
    }

    /// Other bytes in place of these.
    pub fn replace(&mut self, file: usize, place: Range<usize>, text: String) {
        self.places.insert((file, place.start, place.len()), text);
    }

    /// The texts: the first file always, others where they change.
    pub fn apply(mut self, files: &[SourceFile]) -> Vec<EditedFile> {
        for ((file, at), list) in std::mem::take(&mut self.added) {
            self.places.insert((file, at, 0), listed(&list));
        }
        let mut texts: Vec<Option<String>> = vec![None; files.len()];
        // From the end to the beginning, so that places before stay where they are.
        for ((file, at, length), new) in self.places.iter().rev() {
            let text = texts[*file].get_or_insert_with(|| files[*file].text.clone());
            text.replace_range(*at..at + length, new);
        }
        let edited = files.iter().zip(texts).enumerate().filter_map(|(i, (file, text))| {
            let text = if i == 0 { Some(text.unwrap_or_else(|| file.text.clone())) } else { text };
            text.map(|text| EditedFile { path: file.path.clone(), text })
        });
        edited.collect()
    }
}

/// Behind the tag of an element without attributes.
fn after_name(element: &Element, source: &SourceFile) -> usize {
    let rest = &source.text[element.open.start + 1..element.open.end];
    element.open.start + 1 + rest.find(|c: char| c.is_whitespace() || c == '>' || c == '/').unwrap_or(rest.len())
}

/// Attributes as they stand in a tag, each after a space.
pub(super) fn listed<N: Display>(attributes: &[(N, String)]) -> String {
    attributes.iter().fold(String::new(), |mut text, (name, value)| {
        let _ = write!(text, " {name}=\"{value}\"");
        text
    })
}

/// A number as an attribute: the shortest text that reads back as the same.
pub(super) fn number(value: f64) -> String {
    let (plain, short) = (format!("{value}"), format!("{value:e}"));
    if short.len() < plain.len() && !(1e-4..1e6).contains(&value.abs()) { short } else { plain }
}
