//! `<include file="…"/>` of MJCF: the children of the other file's root in its place, each file once.

use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use super::source::shown;
use super::tree::{DEEPEST, MOST_ELEMENTS};
use super::{Attribute, Element, LONGEST, Open, SourceFile, parse};
use crate::{Error, Result};

/// Most files of a model.
const MOST_FILES: usize = 1000;

/// A model's elements, and the files that they stand in; the first is the one that was named.
#[derive(Debug, Clone)]
pub(crate) struct Document {
    pub files: Vec<SourceFile>,
    pub root: Element,
    /// Where files are included, in the order in which they were met.
    pub includes: Vec<Include>,
}

/// One file in the place of an element of another.
#[derive(Debug, Clone)]
pub(crate) struct Include {
    /// The file with the element, and where it is there.
    file: usize,
    element: Range<usize>,
    /// The file that is included, and what is within its root.
    other: usize,
    inner: Range<usize>,
}

impl Document {
    /// The text of the first file with all others in the places where it includes them, with its own line ends; `None` where it
    /// includes none.
    pub fn joined(&self) -> Option<String> {
        (!self.includes.is_empty()).then(|| self.part(0, 0..self.files[0].text.len()))
    }

    /// The same of a part of a file. Files include each other in no circle, so this ends.
    fn part(&self, file: usize, range: Range<usize>) -> String {
        let source = &self.files[file].text;
        let mut within: Vec<&Include> =
            self.includes.iter().filter(|one| one.file == file && range.contains(&one.element.start)).collect();
        within.sort_by_key(|one| one.element.start);
        let (mut text, mut at) = (String::new(), range.start);
        for one in within {
            text.push_str(&source[at..one.element.start]);
            text.push_str(&with_ends_of(source, self.part(one.other, one.inner.clone())));
            at = one.element.end;
        }
        text + &source[at..range.end]
    }

    /// An error at an attribute.
    pub fn error(&self, at: &Attribute, message: impl Into<String>, hint: impl Into<String>) -> Error {
        self.files[at.file].error(at.inner.clone(), message, hint)
    }

    /// An error at the opening tag of an element.
    pub fn error_at(&self, at: &Element, message: impl Into<String>, hint: impl Into<String>) -> Error {
        self.files[at.file].error(at.open.clone(), message, hint)
    }
}

/// The text with the line ends that `whole` has, where that has any.
fn with_ends_of(whole: &str, text: String) -> String {
    let Some(first) = whole.find('\n') else { return text };
    let plain = text.replace("\r\n", "\n");
    if whole[..first].ends_with('\r') { plain.replace('\n', "\r\n") } else { plain }
}

/// From which files a model may include others.
#[derive(Clone, Copy)]
pub(crate) struct Reach<'a> {
    /// Whether paths with `..` may leave the folder of the model; `open` then says where they end.
    pub leaves: bool,
    /// Reads a file.
    pub open: Open<'a>,
}

/// The document of a file with this root, and what it includes.
///
/// # Errors
/// [`Error::Text`] where a file is no XML or an include names a file outside the folder of `source`, one that is not there, one that is
/// included already, or too much; [`Error::Io`] and [`Error::File`] as the reader of files returns them.
pub(crate) fn load(source: SourceFile, mut root: Element, reach: Reach) -> Result<Document> {
    let mut loading =
        Loading { bytes: source.text.len(), elements: 0, files: vec![source], includes: Vec::new(), reach };
    root.children = loading.expanded(std::mem::take(&mut root.children), 1)?;
    Ok(Document { files: loading.files, root, includes: loading.includes })
}

/// The files of a model while they are read.
struct Loading<'a> {
    files: Vec<SourceFile>,
    /// How long they are together.
    bytes: usize,
    elements: usize,
    includes: Vec<Include>,
    reach: Reach<'a>,
}

impl Loading<'_> {
    /// These elements with what they include, `depth` levels below the root.
    fn expanded(&mut self, elements: Vec<Element>, depth: usize) -> Result<Vec<Element>> {
        let mut all = Vec::with_capacity(elements.len());
        for mut element in elements {
            self.elements += 1;
            let limit = match (depth >= DEEPEST, self.elements > MOST_ELEMENTS) {
                (true, _) => Some(format!("{DEEPEST} nested elements")),
                (_, true) => Some(format!("{MOST_ELEMENTS} elements in all files")),
                _ => None,
            };
            if let Some(limit) = limit {
                let message = format!("expected at most {limit}, found more");
                return Err(self.files[element.file].error(element.open, message, "is this the model of a robot?"));
            }
            if element.tag == "include" {
                let other = self.included(&element)?;
                // Its closing tag, where it has one, ends with the next `>`.
                let after = &self.files[element.file].text[element.close..];
                let end = if element.empty { Some(0) } else { after.find('>').map(|at| at + 1) };
                self.includes.push(Include {
                    file: element.file,
                    element: element.open.start..element.close + end.unwrap_or(0),
                    other: other.file,
                    inner: other.open.end..other.close,
                });
                all.extend(self.expanded(other.children, depth)?);
            } else {
                element.children = self.expanded(std::mem::take(&mut element.children), depth + 1)?;
                all.push(element);
            }
        }
        Ok(all)
    }

    /// The root of the file that an `<include>` names.
    fn included(&mut self, element: &Element) -> Result<Element> {
        let here = &self.files[element.file];
        let Some(name) = element.attribute("file") else {
            let hint = "write <include file=\"parts.xml\"/>, say";
            return Err(here.error(element.open.clone(), "expected <include> to name a file, found no `file`", hint));
        };
        let wrong = |found: String, hint: &str| {
            let message = format!("expected a file in the folder of the model, found {found}");
            Err(here.error(name.inner.clone(), message, hint))
        };
        let Some(inside) = inside(Path::new(&name.value), self.reach.leaves) else {
            return wrong(
                format!("`{}`, which lies outside it", shown(&name.value)),
                "copy the file into the folder of the model, and name it from there",
            );
        };
        // The folder of the main file comes first, as in MuJoCo; then that of the file with the <include>.
        let folder = |file: &SourceFile| file.path.parent().map(Path::to_path_buf).unwrap_or_default();
        let mut places = vec![folder(&self.files[0]).join(&inside)];
        let other = folder(here).join(&inside);
        if other != places[0] {
            places.push(other);
        }
        if self.files.len() >= MOST_FILES {
            return wrong(format!("more than {MOST_FILES} files"), "put them into fewer files");
        }
        for path in places {
            if self.files.iter().any(|file| file.path == path) {
                return wrong(
                    format!("`{}`, which is part of the model already", shown(&name.value)),
                    "include each file once, and none that includes this one",
                );
            }
            match (self.reach.open)(&path) {
                Ok(text) => {
                    let bytes = self.bytes + text.len();
                    if bytes as u64 > LONGEST {
                        let found =
                            format!("`{}`, with which they hold more than {} MB", shown(&name.value), LONGEST >> 20);
                        return wrong(found, "is this the model? meshes stand in files of their own");
                    }
                    self.bytes = bytes;
                    self.files.push(SourceFile::new(&path, &text));
                    let index = self.files.len() - 1;
                    return parse(&self.files[index], index);
                }
                Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        wrong(format!("`{}`, which is not there", shown(&name.value)), "correct the name, or copy the file there")
    }
}

/// The path without `.`; `None` where it is absolute or, unless it may, leaves the folder.
fn inside(path: &Path, leaves: bool) -> Option<PathBuf> {
    let mut clean = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(part) => clean.push(part),
            Component::CurDir => {}
            Component::ParentDir => {
                let back = clean.components().next_back().is_some_and(|last| matches!(last, Component::Normal(_)));
                match (back, leaves) {
                    (true, _) => drop(clean.pop()),
                    (false, true) => clean.push(".."),
                    (false, false) => return None,
                }
            }
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    (!clean.as_os_str().is_empty()).then_some(clean)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder in memory.
    fn read(files: &[(&str, &str)]) -> Result<Document> {
        let open = |path: &Path| {
            let found = files.iter().find(|(name, _)| Path::new(name) == path);
            let missing = || Error::Io { path: path.to_path_buf(), source: ErrorKind::NotFound.into() };
            found.map(|(_, text)| (*text).to_owned()).ok_or_else(missing)
        };
        let source = SourceFile::new(Path::new(files[0].0), files[0].1);
        let root = parse(&source, 0)?;
        load(source, root, Reach { leaves: false, open: &open })
    }

    #[test]
    fn children_of_the_other_root_take_the_place_of_the_include() {
        let main = "<m><a/><include file='x/p.xml'/><d><include file='q.xml'></include ></d></m>";
        let files =
            [("m/a.xml", main), ("m/x/p.xml", "<mujocoinclude><b/><c/></mujocoinclude>"), ("m/q.xml", "<r><e/></r>")];
        let all = read(&files).unwrap();
        let tags: Vec<_> = all.root.children.iter().map(|e| (e.tag.as_str(), e.file)).collect();
        assert_eq!(tags, [("a", 0), ("b", 1), ("c", 1), ("d", 0)]);
        assert_eq!(all.root.children[3].children[0].tag, "e");
        assert_eq!(all.joined().unwrap(), "<m><a/><b/><c/><d><e/></d></m>");
    }

    #[test]
    fn what_is_included_gets_the_line_ends_of_the_file_around_it() {
        let joined = |main: &str, part: &str| read(&[("a.xml", main), ("b.xml", part)]).unwrap().joined().unwrap();
        let (lf, crlf) = ("<m>\n<include file='b.xml'/>\n</m>", "<m>\r\n<include file='b.xml'/>\r\n</m>");
        let (part, other) = ("<r>\n<b/>\n</r>", "<r>\r\n<b/>\r\n</r>");
        for part in [part, other] {
            assert_eq!(joined(lf, part), "<m>\n\n<b/>\n\n</m>");
            assert_eq!(joined(crlf, part), "<m>\r\n\r\n<b/>\r\n\r\n</m>");
        }
        assert_eq!(joined("<m><include file='b.xml'/></m>", other), "<m>\r\n<b/>\r\n</m>");
    }

    #[test]
    fn circles_escapes_and_missing_files_are_refused() {
        for (files, found) in [
            (vec![("a.xml", "<m><include file='b.xml'/></m>"), ("b.xml", "<m><include file='a.xml'/></m>")], "already"),
            (vec![("a.xml", "<m><include file='a.xml'/></m>")], "already"),
            (vec![("m/a.xml", "<m><include file='../b.xml'/></m>"), ("b.xml", "<m/>")], "outside"),
            (vec![("a.xml", "<m><include file='/etc/passwd'/></m>")], "outside"),
            (vec![("a.xml", "<m><include file='x/../../b.xml'/></m>")], "outside"),
            (vec![("a.xml", "<m><include file='none.xml'/></m>")], "not there"),
            (vec![("a.xml", "<m><include/></m>")], "no `file`"),
        ] {
            let error = read(&files).unwrap_err();
            assert!(error.to_string().contains(found), "{error}");
            assert!(matches!(error, Error::Text { .. }));
        }
    }

    #[test]
    fn all_files_together_are_bounded() {
        let part = format!("<r><!--{}--></r>", " ".repeat(6 << 20));
        let main = "<m><include file='b.xml'/><include file='c.xml'/><include file='d.xml'/></m>";
        let files = [("a.xml", main), ("b.xml", &part), ("c.xml", &part), ("d.xml", &part)];
        let error = read(&files).unwrap_err();
        assert!(error.to_string().contains("`d.xml`, with which they hold more than 16 MB"), "{error}");
        let many = format!("<r>{}</r>", "<a/>".repeat(MOST_ELEMENTS / 2));
        let error = read(&[("a.xml", main), ("b.xml", &many), ("c.xml", &many), ("d.xml", "<r/>")]).unwrap_err();
        assert!(error.to_string().contains("elements in all files"), "{error}");
    }
}
