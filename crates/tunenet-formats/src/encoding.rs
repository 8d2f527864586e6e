//! Which encoding a text is in, judged by its first bytes.

use std::path::Path;

use crate::documents::refuse_pointer;
use crate::shown::shell_word;
use crate::{Action, Error, Result};

/// Share of the bytes at even or odd places that have to be 0 for a text without a mark to count as UTF-16: all of them in
/// ASCII, which tables and TOML are but for a few signs.
const MOSTLY: f64 = 0.8;

/// Largest file that [`read_text`] reads, in bytes. A parsed TOML text takes up to 130 times its bytes of memory.
const LARGEST_SMALL_TEXT: u64 = 8 << 20;

/// The whole text of a small file, such as one of settings. A mark at its start (BOM) is left out.
///
/// # Errors
/// [`Error::Io`] where the system refuses; [`Error::File`] where it is no file, larger than 8 MiB, or not in UTF-8.
pub fn read_text(path: impl AsRef<Path>) -> Result<String> {
    use std::io::Read as _;
    let path = path.as_ref();
    let file = crate::source::open(path)?;
    let failed = |e| Error::io(path, Action::Reading, e);
    let bytes = file.metadata().map_err(failed)?.len();
    let mut text = Vec::new();
    file.take(LARGEST_SMALL_TEXT + 1).read_to_end(&mut text).map_err(failed)?;
    // A file that grows meanwhile is larger than it was.
    let bytes = bytes.max(text.len() as u64);
    if bytes > LARGEST_SMALL_TEXT {
        let message = format!("expected a text of at most {LARGEST_SMALL_TEXT} bytes, found {bytes}");
        return Err(Error::file(path, message, "is this the right file?"));
    }
    refuse_pointer(path, &text)?;
    refuse_foreign(path, &text[..text.len().min(512)])?;
    let text = String::from_utf8(text).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = String::from_utf8_lossy(&error.as_bytes()[..valid]).matches('\n').count() + 1;
        let message = format!("expected UTF-8 text, found other bytes in line {line}");
        Error::file(path, message, converted(path, "LATIN1"))
    })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// Refuses a text that is not in bytes of eight bits each, with the command that converts it.
pub(crate) fn refuse_foreign(path: &Path, start: &[u8]) -> Result<()> {
    let Some(name) = foreign(start) else { return Ok(()) };
    Err(Error::file(path, format!("expected UTF-8 text, found {name}"), converted(path, name)))
}

/// The command that makes a copy in UTF-8.
fn converted(path: &Path, from: &str) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let (from_file, to_file) = (shell_word(&name), shell_word(&format!("utf8_{name}")));
    format!("save it as UTF-8, or convert it: `iconv -f {from} -t UTF-8 {from_file} > {to_file}`")
}

/// The name that `iconv` has for the encoding of a text, where it is one of two or four bytes a sign.
fn foreign(start: &[u8]) -> Option<&'static str> {
    match start {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => return Some("UTF-32"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => return Some("UTF-16"),
        _ => {}
    }
    let zeros = |first: usize| {
        let places = start.iter().skip(first).step_by(2);
        let (count, zeros) = places.fold((0, 0), |(count, zeros), byte| (count + 1, zeros + usize::from(*byte == 0)));
        (count > 1, zeros as f64 / f64::from(count.max(1)))
    };
    let ((enough, even), (_, odd)) = (zeros(0), zeros(1));
    match enough {
        true if odd >= MOSTLY && even == 0.0 => Some("UTF-16LE"),
        true if even >= MOSTLY && odd == 0.0 => Some("UTF-16BE"),
        _ => None,
    }
}

/// The text of a line: UTF-8, or where it is not, Latin-1, in which every byte is a sign. Only names and comments have
/// signs beyond ASCII; with a replacement instead, the `µs` of a Latin-1 header would read as `s`.
pub(crate) fn line(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().copied().map(char::from).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_encodings_are_known_by_mark_and_by_zeros() {
        let text = "t_s,z_m\n0,1\n";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        assert_eq!((foreign(&little), foreign(&big)), (Some("UTF-16LE"), Some("UTF-16BE")));
        assert_eq!(foreign(&[&[0xff, 0xfe], &little[..]].concat()), Some("UTF-16"));
        assert_eq!(foreign(&[&[0xfe, 0xff], &big[..]].concat()), Some("UTF-16"));
        assert_eq!(foreign(&[0xff, 0xfe, 0, 0, b't', 0, 0, 0]), Some("UTF-32"));
        for other in [&b""[..], b"t", b"t_s", b"\0\0\0\0", text.as_bytes()] {
            assert_eq!(foreign(other), None, "{other:?}");
        }
    }

    #[test]
    fn a_line_that_is_not_utf8_is_latin_1() {
        assert_eq!(line("t_µs".as_bytes()), "t_µs");
        assert_eq!(line(b"t_\xb5s;H\xf6he"), "t_µs;Höhe");
    }
}
