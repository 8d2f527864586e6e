//! Where in its text a URDF is wrong: the XML reader behind it says what, and seldom where.

use std::path::Path;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use tunenet_formats::Error;

use crate::simulation_file::check::located;

/// Attributes that hold numbers, element by element, and how many.
const NUMBERS: [(&str, &[&str], usize); 8] = [
    ("origin", &["xyz", "rpy"], 3),
    ("axis", &["xyz"], 3),
    ("mass", &["value"], 1),
    ("inertia", &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"], 1),
    ("limit", &["lower", "upper", "effort", "velocity"], 1),
    ("dynamics", &["damping", "friction"], 1),
    ("mimic", &["multiplier", "offset"], 1),
    ("calibration", &["rising", "falling"], 1),
];

/// The first place of `text` that is no XML, or holds something else where a number belongs; `None` where it has neither.
pub(super) fn broken(path: &Path, text: &str) -> Option<Error> {
    let mut reader = Reader::from_str(text);
    let mut open: Vec<(String, usize)> = Vec::new();
    loop {
        let from = offset(reader.buffer_position());
        match reader.read_event() {
            Ok(Event::Start(element)) => {
                open.push((name(&element), from));
                if let Some(error) = numbers(path, text, from, &element) {
                    return Some(error);
                }
            }
            Ok(Event::Empty(element)) => {
                if let Some(error) = numbers(path, text, from, &element) {
                    return Some(error);
                }
            }
            Ok(Event::End(_)) => {
                open.pop();
            }
            Ok(Event::Eof) => {
                let (name, at) = open.pop()?;
                return Some(xml(path, text, at, &format!("`<{name}>` is not closed")));
            }
            Ok(_) => {}
            Err(error) => return Some(xml(path, text, offset(reader.error_position()), &error.to_string())),
        }
    }
}

/// The same error, at the line of the element of this name where it stands in `text`.
pub(super) fn at_element(path: &Path, text: &str, element: &str, named: &str, message: String, hint: &str) -> Error {
    let mut reader = Reader::from_str(text);
    loop {
        let from = offset(reader.buffer_position());
        match reader.read_event() {
            Ok(Event::Start(found) | Event::Empty(found)) => {
                let attribute = |key: &str| found.try_get_attribute(key).ok().flatten();
                let same = attribute("name").is_some_and(|a| a.value.as_ref() == named.as_bytes());
                // Transmissions name joints too, without a type.
                if name(&found) == element && same && (element != "joint" || attribute("type").is_some()) {
                    let from = start(text, from);
                    return located(path, text, from..from + found.len() + 1, message, hint);
                }
            }
            Ok(Event::Eof) | Err(_) => return Error::file(path, message, hint),
            Ok(_) => {}
        }
    }
}

fn offset(position: u64) -> usize {
    usize::try_from(position).unwrap_or(usize::MAX)
}

/// The `<` at or after this place.
fn start(text: &str, from: usize) -> usize {
    text.get(from..).and_then(|rest| rest.find('<')).map_or(from.min(text.len()), |at| from + at)
}

fn name(element: &BytesStart) -> String {
    String::from_utf8_lossy(element.local_name().as_ref()).into_owned()
}

fn xml(path: &Path, text: &str, at: usize, what: &str) -> Error {
    let message = format!("expected a URDF, found what is no XML: {what}");
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    located(path, text, at..at, message, "mend the XML")
}

fn numbers(path: &Path, text: &str, from: usize, element: &BytesStart) -> Option<Error> {
    let name = name(element);
    let (_, keys, count) = NUMBERS.iter().find(|(known, ..)| *known == name)?;
    let from = start(text, from);
    for attribute in element.attributes() {
        let attribute = match attribute {
            Ok(attribute) => attribute,
            Err(error) => return Some(xml(path, text, from, &error.to_string())),
        };
        let key = String::from_utf8_lossy(attribute.key.as_ref()).into_owned();
        let value = String::from_utf8_lossy(&attribute.value).into_owned();
        let words: Vec<&str> = value.split_whitespace().collect();
        if keys.contains(&key.as_str()) && (words.len() != *count || words.iter().any(|w| w.parse::<f64>().is_err())) {
            let expected = if *count == 1 { "a number".to_owned() } else { format!("{count} numbers") };
            let message = format!("<{name} {key}=…>: expected {expected}, found `{value}`");
            // Under the value itself, where it stands as it was read.
            let at = text[from..].find(&value).filter(|_| !value.is_empty()).map_or(from, |at| from + at);
            return Some(located(path, text, at..at + value.len(), message, "mend the number"));
        }
    }
    None
}
