//! Which files are videos.

use std::io::Read;
use std::path::Path;

use super::names;

/// What videos' names end in.
const ENDINGS: [&str; 9] = ["mp4", "m4v", "mov", "avi", "mkv", "webm", "mpg", "mpeg", "3gp"];

/// What the names of other recordings end in.
const TABLES: [&str; 6] = ["csv", "tsv", "txt", "mcap", "db3", "json"];

/// How videos begin: where, and with which bytes.
const MARKS: [(usize, &[u8]); 4] = [(4, b"ftyp"), (8, b"AVI "), (0, b"\x1a\x45\xdf\xa3"), (0, b"\x00\x00\x01\xba")];

/// Whether a file is a video, by its name or, where that says nothing else, by its first bytes; so is a folder of pictures.
pub fn is_video(path: &Path) -> bool {
    if path.is_dir() {
        return names::pictures(path).is_ok_and(|pictures| !pictures.is_empty());
    }
    // Pipes are waited for where they are opened, and a folder is refused by whoever reads it.
    let file = std::fs::metadata(path).is_ok_and(|about| about.is_file());
    let table = path.extension().is_some_and(|e| TABLES.iter().any(|known| e.eq_ignore_ascii_case(known)));
    if !file || table {
        return false;
    }
    let named = path.extension().is_some_and(|e| ENDINGS.iter().any(|known| e.eq_ignore_ascii_case(known)));
    let mut start = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(16).read_to_end(&mut start));
    named || read.is_ok() && MARKS.iter().any(|(at, mark)| start.get(*at..).is_some_and(|s| s.starts_with(mark)))
}
