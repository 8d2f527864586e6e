//! Where a recording stands: a file, a folder, or an episode of one of these, which is named behind it as a file in a folder is:
//! `so101/episode_3`, `demos.hdf5/demo_0`.

use std::path::{Path, PathBuf};

#[cfg(feature = "logs")]
use crate::lerobot;

/// Where a recording stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Place {
    /// The file or folder that is there.
    pub path: PathBuf,
    /// The episode of it that is named.
    pub episode: Option<String>,
}

impl Place {
    /// What `path` names. What is not there as a file or a folder may be an episode of what it would stand in.
    pub fn of(path: &Path) -> Self {
        let whole = || Self { path: path.to_owned(), episode: None };
        if path.exists() {
            return whole();
        }
        let (Some(parent), Some(name)) = (path.parent(), path.file_name().and_then(|name| name.to_str())) else {
            return whole();
        };
        let holds = parent.is_file() || parent.is_dir() && is_data_set(parent);
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
