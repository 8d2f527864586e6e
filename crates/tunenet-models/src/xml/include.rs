//! `<include file="…"/>` of MJCF: the children of the other file's root in its place, each file once.

use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use super::source::shown;
use super::tree::DEEPEST;
use super::{Attribute, Element, Open, SourceFile, parse};
use crate::{Error, Result};

/// Most files of a model.
const MOST_FILES: usize = 1000;

/// A model's elements, and the files that they stand in; the first is the one that was named.
#[derive(Debug, Clone)]
pub(crate) struct Document {
    pub files: Vec<SourceFile>,
    pub root: Element,
}

impl Document {
    /// An error at an attribute.
    pub fn error(&self, at: &Attribute, message: impl Into<String>, hint: impl Into<String>) -> Error {
        self.files[at.file].error(at.inner.clone(), message, hint)
    }

    /// An error at the opening tag of an element.
    pub fn error_at(&self, at: &Element, message: impl Into<String>, hint: impl Into<String>) -> Error {
        self.files[at.file].error(at.open.clone(), message, hint)
    }
}

/// From which files a model may include others.
#[derive(Clone, Copy)]
pub(crate) struct Reach<'a> {
    /// Whether paths with `..` may leave the folder of the model; `open` then says where they end.
    pub leaves: bool,
    /// Reads a file.
    pub open: Open<'a>,
}

/// The document whose text is `text`, with what it includes.
///
/// # Errors
/// [`Error::Text`] where a file is no XML or an include names a file outside the folder of `path`, one that is not there,
/// or one that is included already; [`Error::Io`] and [`Error::File`] as the reader of files returns them.
pub(crate) fn load(path: &Path, text: &str, reach: Reach) -> Result<Document> {
    let mut files = vec![SourceFile { path: path.to_path_buf(), text: text.to_owned() }];
    let mut root = parse(&files[0], 0)?;
    root.children = expanded(std::mem::take(&mut root.children), 1, &mut files, reach)?;
    Ok(Document { files, root })
}

/// These elements with what they include, `depth` levels below the root.
fn expanded(elements: Vec<Element>, depth: usize, files: &mut Vec<SourceFile>, reach: Reach) -> Result<Vec<Element>> {
    let mut all = Vec::with_capacity(elements.len());
    for mut element in elements {
        if depth >= DEEPEST {
            let message = format!("expected at most {DEEPEST} nested elements, found more");
            return Err(files[element.file].error(element.open, message, "is this the model of a robot?"));
        }
        if element.tag == "include" {
            let other = included(&element, files, reach)?;
            all.extend(expanded(other.children, depth, files, reach)?);
        } else {
            element.children = expanded(std::mem::take(&mut element.children), depth + 1, files, reach)?;
            all.push(element);
        }
    }
    Ok(all)
}

/// The root of the file that an `<include>` names.
fn included(element: &Element, files: &mut Vec<SourceFile>, reach: Reach) -> Result<Element> {
    let here = &files[element.file];
    let Some(name) = element.attribute("file") else {
        let hint = "write <include file=\"parts.xml\"/>, say";
        return Err(here.error(element.open.clone(), "expected <include> to name a file, found no `file`", hint));
    };
    let wrong = |found: String, hint: &str| {
        let message = format!("expected a file in the folder of the model, found {found}");
        here.error(name.inner.clone(), message, hint)
    };
    let Some(inside) = inside(Path::new(&name.value), reach.leaves) else {
        return Err(wrong(
            format!("`{}`, which lies outside it", shown(&name.value)),
            "copy the file into the folder of the model and name it from there, or allow the folder that holds both",
        ));
    };
    // The folder of the main file comes first, as in MuJoCo; then that of the file with the <include>.
    let folder = |file: &SourceFile| file.path.parent().map(Path::to_path_buf).unwrap_or_default();
    let mut places = vec![folder(&files[0]).join(&inside)];
    let other = folder(here).join(&inside);
    if other != places[0] {
        places.push(other);
    }
    if files.len() >= MOST_FILES {
        return Err(wrong(format!("the {MOST_FILES}th file"), "put them into fewer files"));
    }
    for path in places {
        if files.iter().any(|file| file.path == path) {
            return Err(wrong(
                format!("`{}`, which is part of the model already", shown(&name.value)),
                "include each file once, and none that includes this one",
            ));
        }
        match (reach.open)(&path) {
            Ok(text) => {
                files.push(SourceFile { path, text });
                let index = files.len() - 1;
                return parse(&files[index], index);
            }
            Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
    }
    Err(wrong(format!("`{}`, which is not there", shown(&name.value)), "correct the name, or copy the file there"))
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
        load(Path::new(files[0].0), files[0].1, Reach { leaves: false, open: &open })
    }

    #[test]
    fn children_of_the_other_root_take_the_place_of_the_include() {
        let main = "<m><a/><include file='x/p.xml'/><d><include file='q.xml'/></d></m>";
        let files =
            [("m/a.xml", main), ("m/x/p.xml", "<mujocoinclude><b/><c/></mujocoinclude>"), ("m/q.xml", "<r><e/></r>")];
        let all = read(&files).unwrap();
        let tags: Vec<_> = all.root.children.iter().map(|e| (e.tag.as_str(), e.file)).collect();
        assert_eq!(tags, [("a", 0), ("b", 1), ("c", 1), ("d", 0)]);
        assert_eq!(all.root.children[3].children[0].tag, "e");
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
}
