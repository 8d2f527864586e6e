//! Where a recording stands: a file, a folder, or an episode of one of these, which is named behind it as a file in a folder is:
//! `so101/episode_3`, `demos.hdf5/demo_0`.

use std::path::{Path, PathBuf};

use crate::format::is_hdf5;
#[cfg(feature = "logs")]
use crate::lerobot;
use crate::numbered::of_episode;

/// Where a recording stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Place {
    /// The file or folder that is there.
    pub path: PathBuf,
    /// The episode of it that is named.
    pub episode: Option<String>,
}

impl Place {
    /// What `path` names. What is not there as a file or a folder may be an episode of what it would stand in: of an HDF5 file any
    /// name, of a data set of LeRobot its number.
    pub fn of(path: &Path) -> Self {
        let whole = || Self { path: path.to_owned(), episode: None };
        if path.exists() {
            return whole();
        }
        let (Some(parent), Some(name)) = (path.parent(), path.file_name().and_then(|name| name.to_str())) else {
            return whole();
        };
        let numbered = || of_episode(name).is_some() && is_data_set(parent);
        let holds = if parent.is_dir() { numbered() } else { is_hdf5(parent) };
        if holds { Self { path: parent.to_owned(), episode: Some(name.to_owned()) } } else { whole() }
    }
}

/// Whether a folder is a data set of LeRobot, or holds one.
#[cfg(feature = "logs")]
pub(crate) fn is_data_set(folder: &Path) -> bool {
    lerobot::root(folder).is_some()
}

/// Whether a folder is a data set of LeRobot, by the file that describes it.
#[cfg(not(feature = "logs"))]
pub(crate) fn is_data_set(folder: &Path) -> bool {
    folder.join("meta").join("info.json").is_file()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{error_text, file};
    use crate::{ReadOptions, contents, read};

    #[test]
    fn a_file_that_is_missing_is_no_episode() {
        let (folder, path) = file("a.csv", "t_s,z_m\n0,1\n1,2\n2,3\n");
        for missing in [path.join("x"), path.join("episode_0"), folder.path().join("a.x")] {
            let name = missing.strip_prefix(folder.path()).unwrap().display().to_string();
            let (message, hint) = error_text(&contents(&missing).unwrap_err());
            assert_eq!((message, hint.as_str()), (format!("{name}: no such file"), "check the path"));
            let (message, _) = error_text(&read(&missing, &ReadOptions::default()).unwrap_err());
            assert_eq!(message, format!("{name}: no such file"));
        }
        let (message, hint) = error_text(&read(folder.path(), &ReadOptions::default()).unwrap_err());
        assert!(message.contains("found a folder that holds none"), "{message}");
        assert!(hint.starts_with("name one file in it, such as /") && hint.ends_with("/a.csv"), "{hint}");
        std::fs::create_dir(folder.path().join("meta")).unwrap();
        std::fs::write(folder.path().join("meta/info.json"), "{}").unwrap();
        assert_eq!(Place::of(&folder.path().join("b.csv")).episode, None);
        assert_eq!(Place::of(&folder.path().join("episode_7")).episode.as_deref(), Some("episode_7"));
    }
}
