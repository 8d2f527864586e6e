//! The folder in which the program that a simulation file names runs, and its path relative to another folder.

use std::path::{Path, PathBuf};

use toml_edit::value;

use super::{SimulationFile, table};
use crate::scene::{Process, ProcessScene, Scene};

impl SimulationFile {
    /// The folder in which the program runs: that of the file, and what `process.folder` adds to it.
    #[must_use]
    pub fn program_folder(&self) -> PathBuf {
        let base = folder_of(self.path());
        let added = self.process().ok().and_then(|process| process.folder.as_ref());
        added.map_or_else(|| base.to_path_buf(), |folder| base.join(folder))
    }

    /// Rewrites `process.folder` for a file that will be written to `out`: the program's folder relative to the folder of `out`.
    /// Does nothing to a file of another kind, or where one of the two folders does not exist.
    pub fn move_program(&mut self, out: &Path) {
        let (Ok(runs), Ok(there)) = (self.program_folder().canonicalize(), folder_of(out).canonicalize()) else {
            return;
        };
        let Scene::Process(ProcessScene { process: Process { folder, .. }, .. }) = &mut self.scene else { return };
        let now = folder.clone().unwrap_or_else(|| ".".into());
        if now.is_absolute() {
            return;
        }
        let Some(seen) = relative(&runs, &there) else { return };
        if now == seen || now == Path::new(".") && seen.as_os_str().is_empty() {
            return;
        }
        let process = table(self.document.root_mut(), "process", false);
        if seen.as_os_str().is_empty() {
            process.remove("folder");
            *folder = None;
        } else {
            process["folder"] = value(seen.to_string_lossy().into_owned());
            *folder = Some(seen);
        }
    }
}

/// The folder in which a file lies.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// `to` as seen from `from`, both absolute; `None` where they have no root in common.
fn relative(to: &Path, from: &Path) -> Option<PathBuf> {
    let (ours, theirs): (Vec<_>, Vec<_>) = (to.components().collect(), from.components().collect());
    let common = ours.iter().zip(&theirs).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n(Path::new("..").as_os_str(), theirs.len() - common);
    (common > 0).then(|| up.chain(ours[common..].iter().map(|c| c.as_os_str())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_named_from_another() {
        let seen = |to: &str, from: &str| relative(Path::new(to), Path::new(from)).unwrap();
        assert_eq!(seen("/a/b", "/a/b"), Path::new(""));
        assert_eq!(seen("/a/b", "/a/c/d"), Path::new("../../b"));
        assert_eq!(seen("/a/b", "/"), Path::new("a/b"));
    }
}
