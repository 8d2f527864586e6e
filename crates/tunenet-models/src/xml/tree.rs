//! From the text of one file to its elements.

use std::ops::Range;
use std::rc::Rc;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::source::{SourceFile, shown};
use crate::{Error, Result};

/// Deepest nesting: a body hangs on its parent's element, and long chains exist.
pub(crate) const DEEPEST: usize = 200;
/// Most elements of a file, and of all files of a model together.
pub(crate) const MOST_ELEMENTS: usize = 400_000;
/// Most attributes of an element.
const MOST_ATTRIBUTES: usize = 200;

/// An attribute and where it stands.
#[derive(Debug, Clone)]
pub(crate) struct Attribute {
    pub name: String,
    /// Its value, entities replaced.
    pub value: String,
    /// Which file it stands in.
    pub file: usize,
    /// Its name, its value and the quotes.
    pub whole: Range<usize>,
    /// What stands between the quotes.
    pub inner: Range<usize>,
}

/// An element with what it contains.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    pub tag: String,
    /// Which file it stands in.
    pub file: usize,
    /// From `<` to the `>` of its opening tag.
    pub open: Range<usize>,
    /// Whether it ends with `/>`.
    pub empty: bool,
    /// Where its closing tag begins; the end of `open` where it has none.
    pub close: usize,
    pub attributes: Vec<Rc<Attribute>>,
    pub children: Vec<Element>,
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&Rc<Attribute>> {
        self.attributes.iter().find(|a| a.name == name)
    }

    pub fn value(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|a| a.value.as_str())
    }

    /// The element without what it contains.
    pub fn head(&self) -> Self {
        Self {
            children: Vec::new(),
            tag: self.tag.clone(),
            attributes: self.attributes.clone(),
            open: self.open.clone(),
            ..*self
        }
    }

    pub fn named(&self, tag: &str) -> impl Iterator<Item = &Element> {
        self.children.iter().filter(move |child| child.tag == tag)
    }
}

/// The root element of a file; `index` is its place among the files of the model.
///
/// # Errors
/// [`Error::Text`] where it is no XML, nests too deeply or has too many elements.
pub(crate) fn parse(source: &SourceFile, index: usize) -> Result<Element> {
    let text = source.text.strip_prefix('\u{feff}').unwrap_or(&source.text);
    let shift = source.text.len() - text.len();
    let mut reader = Reader::from_str(text);
    reader.config_mut().check_end_names = true;
    let mut open: Vec<Element> = Vec::new();
    let mut count = 0_usize;
    loop {
        let event = match reader.read_event() {
            Ok(event) => event,
            Err(error) => {
                let at = shift + usize::try_from(reader.error_position()).unwrap_or(usize::MAX).min(text.len());
                return Err(broken(source, at..at, &error.to_string()));
            }
        };
        let closed = match event {
            Event::Start(start) => {
                let element = element(source, index, &start, false)?;
                count += 1;
                if open.len() >= DEEPEST || count > MOST_ELEMENTS {
                    return Err(too_much(source, &element, open.len() >= DEEPEST));
                }
                open.push(element);
                None
            }
            Event::Empty(start) => {
                count += 1;
                let element = element(source, index, &start, true)?;
                if count > MOST_ELEMENTS {
                    return Err(too_much(source, &element, false));
                }
                Some(element)
            }
            Event::End(end) => {
                let at = place(source, &end).start;
                open.pop().map(|element| Element { close: at.saturating_sub(2), ..element })
            }
            Event::Eof => {
                let (message, at) = match open.last() {
                    Some(element) => {
                        (format!("`<{}>`, which is not closed", shown(&element.tag)), element.open.clone())
                    }
                    None => ("no element at all".to_owned(), 0..0),
                };
                return Err(broken(source, at, &message));
            }
            _ => None,
        };
        if let Some(element) = closed {
            match open.last_mut() {
                Some(parent) => parent.children.push(element),
                None => return Ok(element),
            }
        }
    }
}

fn too_much(source: &SourceFile, element: &Element, deep: bool) -> Error {
    let message = if deep {
        format!("expected at most {DEEPEST} nested elements, found more")
    } else {
        format!("expected at most {MOST_ELEMENTS} elements, found more")
    };
    source.error(element.open.clone(), message, "is this the model of a robot?")
}

fn broken(source: &SourceFile, at: Range<usize>, found: &str) -> Error {
    source.error(at, format!("expected XML, found {found}"), "mend the XML at this place")
}

/// Where a slice of the text stands in it.
fn place(source: &SourceFile, slice: &[u8]) -> Range<usize> {
    let start = (slice.as_ptr() as usize).wrapping_sub(source.text.as_ptr() as usize).min(source.text.len());
    start..(start + slice.len()).min(source.text.len())
}

fn element(source: &SourceFile, file: usize, start: &BytesStart, empty: bool) -> Result<Element> {
    let inside = place(source, start);
    let end = inside.end + if empty { 2 } else { 1 };
    let open = inside.start.saturating_sub(1)..end.min(source.text.len());
    let tag = String::from_utf8_lossy(start.name().as_ref()).into_owned();
    let mut attributes: Vec<Rc<Attribute>> = Vec::new();
    for attribute in start.attributes() {
        if attributes.len() >= MOST_ATTRIBUTES {
            let message = format!("expected at most {MOST_ATTRIBUTES} attributes, found more");
            return Err(source.error(open, message, "is this the model of a robot?"));
        }
        let attribute = attribute.map_err(|e| broken(source, open.clone(), &e.to_string()))?;
        let name = place(source, attribute.key.as_ref());
        let inner = place(source, &attribute.value);
        let value = attribute.unescape_value().map_err(|e| {
            let hint = "write the character itself; entities of one's own are not expanded";
            source.error(inner.clone(), format!("expected text, found {e}"), hint)
        })?;
        let key = String::from_utf8_lossy(attribute.key.as_ref()).into_owned();
        let whole = name.start..(inner.end + 1).min(source.text.len());
        attributes.push(Rc::new(Attribute { name: key, value: value.into_owned(), file, whole, inner }));
    }
    Ok(Element { tag, file, close: open.end, open, empty, attributes, children: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Element> {
        parse(&SourceFile::new("a.xml".as_ref(), text), 0)
    }

    #[test]
    fn places_are_those_of_the_text() {
        let text = "\u{feff}<?xml version='1.0'?>\n<!-- é -- <a> --><a>\n <b  x = '1&lt;2' y=\"z\"/>é</a>\n";
        let root = read(text).unwrap();
        assert_eq!(&text[root.open.clone()], "<a>");
        assert_eq!(&text[root.close..root.close + 4], "</a>");
        let b = &root.children[0];
        assert_eq!(&text[b.open.clone()], "<b  x = '1&lt;2' y=\"z\"/>");
        let x = b.attribute("x").unwrap();
        assert_eq!(
            (x.value.as_str(), &text[x.inner.clone()], &text[x.whole.clone()]),
            ("1<2", "1&lt;2", "x = '1&lt;2'")
        );
    }

    #[test]
    fn what_is_no_xml_is_refused_with_its_place() {
        let deep = "<a>".repeat(100_000);
        let bomb = "<!DOCTYPE a [<!ENTITY b \"bb\">]><a x=\"&b;\"/>";
        for (text, found) in [
            ("", "no element at all"),
            ("<a>\n <b>\n", "not closed"),
            ("<a x=1/>", "expected XML"),
            ("<a x='1' x='2'/>", "expected XML"),
            ("<a></b>", "expected XML"),
            (deep.as_str(), "nested elements"),
            (bomb, "expected text"),
        ] {
            let error = read(text).unwrap_err();
            assert!(matches!(error, Error::Text { .. }), "{error:?}");
            assert!(error.to_string().contains(found), "{error}");
            assert!(!error.hint().is_empty());
        }
    }
}
