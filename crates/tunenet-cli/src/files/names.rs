//! What files are called.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_core::text::visible;
use tunenet_core::{Error, Origin};

/// What the names of a video's frames end in, where each is a file of its own.
const PICTURES: [&str; 6] = ["png", "jpg", "jpeg", "bmp", "tif", "tiff"];

/// A file's own name, for output that must not depend on where it lies: one line, without characters that cannot be seen.
pub fn file_name(path: &Path) -> String {
    visible(&path.file_name().unwrap_or(path.as_os_str()).to_string_lossy())
}

/// Refuses an output whose name ends otherwise than its contents say: whoever finds the file later goes by its name.
/// `-` is no name: files are written in one step, and standard output is for the answer.
pub fn require_ending(out: &Path, flag: &'static str, endings: &[&str]) -> Result<()> {
    let found = out.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if endings.contains(&found.as_str()) {
        return Ok(());
    }
    let each: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
    let why = if is_standard_output(out) { ", since the answer goes to standard output" } else { "" };
    let (expected, found) = (format!("a name that ends in {}{why}", each.join(" or ")), format!("`{}`", out.display()));
    Err(Error::Setting { origin: Origin::Flag, name: flag, expected, found }.into())
}

/// Whether two files lie in one folder, whether these are there or not.
pub fn in_one_folder(one: &Path, other: &Path) -> bool {
    let folder = |path: &Path| std::path::absolute(path).ok().and_then(|path| path.parent().map(Path::to_path_buf));
    folder(one) == folder(other)
}

/// Whether a name stands for standard output in other programs.
pub fn is_standard_output(out: &Path) -> bool {
    out.as_os_str() == "-"
}

/// The pictures in a folder, in the order of their names.
pub fn pictures(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let picture =
        |path: &PathBuf| path.extension().is_some_and(|e| PICTURES.iter().any(|known| e.eq_ignore_ascii_case(known)));
    let all = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<PathBuf>>>()?;
    let mut pictures: Vec<PathBuf> = all.into_iter().filter(picture).collect();
    pictures.sort();
    Ok(pictures)
}
