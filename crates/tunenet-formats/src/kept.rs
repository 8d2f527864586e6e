//! What was read last from files that have not changed since: each episode of a data set needs the same index.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use crate::Result;
use crate::source::Version;

/// A value, and the files that it was read from, each as it was then.
struct Known<T> {
    files: Vec<(PathBuf, Version)>,
    value: Arc<T>,
}

/// The value that was read last.
pub(crate) struct Kept<T>(Mutex<Option<Known<T>>>);

impl<T> Kept<T> {
    pub const fn new() -> Self {
        Self(Mutex::new(None))
    }

    /// What `read` reads from `files`: as it was read before, where these are the same files and none has changed. A file that changed
    /// just now may change again at the same time of change, and is read each time.
    ///
    /// # Errors
    /// Where a file is not there, or as `read`.
    pub fn of(&self, files: &[PathBuf], read: impl FnOnce() -> Result<T>) -> Result<Arc<T>> {
        let versions = files.iter().map(|path| Ok((path.clone(), Version::at(path)?)));
        let versions = versions.collect::<Result<Vec<(PathBuf, Version)>>>()?;
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept.as_ref().filter(|known| known.files == versions) {
            return Ok(Arc::clone(&known.value));
        }
        let value = Arc::new(read()?);
        let settled = versions.iter().all(|(_, version)| version.settled());
        *kept = settled.then(|| Known { files: versions, value: Arc::clone(&value) });
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::time::{Duration, SystemTime};

    use super::*;
    use crate::testing::file;

    #[test]
    fn a_file_is_read_again_only_where_it_has_changed() {
        let (_folder, path) = file("a.json", "1");
        let (kept, files) = (Kept::new(), [path.clone()]);
        let read = || kept.of(&files, || Ok(std::fs::read_to_string(&path).unwrap())).unwrap();
        // What changed just now is not kept.
        assert!(!Arc::ptr_eq(&read(), &read()));
        let changed = |seconds: u64| {
            let then = SystemTime::now() - Duration::from_secs(seconds);
            File::options().write(true).open(&path).unwrap().set_modified(then).unwrap();
        };
        changed(60);
        let first = read();
        assert!(Arc::ptr_eq(&first, &read()));
        std::fs::write(&path, "2").unwrap();
        changed(50);
        assert_eq!(*read(), "2");
        std::fs::remove_file(&path).unwrap();
        assert!(kept.of(&files, || Ok(String::new())).is_err());
    }
}
