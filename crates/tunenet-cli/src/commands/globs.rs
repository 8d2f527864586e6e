//! Patterns in quotes: `'logs/*.mcap'` is expanded here, in the same way on every machine, where a shell's command line may be
//! too short for all names.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_core::{Error, Origin};

/// `paths` with every pattern among them replaced by the names that match, in order. What exists under the very name is no
/// pattern.
///
/// # Errors
/// [`Error::Setting`] for `flag` where a pattern matches nothing or is none.
pub fn expanded(paths: &[PathBuf], flag: &'static str) -> Result<Vec<PathBuf>> {
    let mut all = Vec::with_capacity(paths.len());
    for path in paths {
        let Some(pattern) = path.to_str().filter(|text| text.contains(['*', '?', '['])).filter(|_| !exists(path))
        else {
            all.push(path.clone());
            continue;
        };
        let refuse = |expected: &str, found: String| Error::Setting {
            origin: Origin::Flag,
            name: flag,
            expected: expected.into(),
            found,
        };
        let matching = glob::glob(pattern).map_err(|e| refuse("a pattern", format!("`{pattern}`: {}", e.msg)))?;
        let mut found: Vec<PathBuf> = matching.filter_map(std::result::Result::ok).collect();
        if found.is_empty() {
            return Err(refuse("a pattern that matches files", format!("`{pattern}`, which matches none")).into());
        }
        found.sort();
        all.append(&mut found);
    }
    Ok(all)
}

fn exists(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_become_sorted_names() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.csv", "a.csv", "c.txt", "[1].csv"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let names = |pattern: &str| -> Vec<String> {
            let all = expanded(&[folder.path().join(pattern)], "--observation").unwrap();
            all.iter().map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect()
        };
        assert_eq!(names("?.csv"), ["a.csv", "b.csv"]);
        assert_eq!(names("*.csv"), ["[1].csv", "a.csv", "b.csv"]);
        // A name that looks like a pattern, and one that is not there: whoever reads it says so.
        assert_eq!(names("[1].csv"), ["[1].csv"]);
        assert_eq!(names("none.csv"), ["none.csv"]);
        let refused = expanded(&[folder.path().join("*.mcap")], "--observation").unwrap_err().to_string();
        assert!(refused.starts_with("`--observation`: expected a pattern that matches files, found"), "{refused}");
    }
}
