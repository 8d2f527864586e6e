//! Permission to run the program that a simulation file names.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use toml_edit::value;
use tunenet_core::observation::Note;
use tunenet_core::{Error, Result};

use super::{SimulationFile, Tally, table};
use crate::scene::{Process, ProcessScene, Scene};

/// Permission to run the program that a simulation file names, given by the user and never by a file; and its outcome.
///
/// A rollout that fails only means that these values cannot be simulated, and a fit tries others. What cannot be
/// mended by other values (a program that ended, or hangs) is noted here, so that it is reported as such.
#[derive(Debug, Clone, Default)]
pub struct Permission {
    failure: Arc<Mutex<Option<Failed>>>,
    /// What runs by this leave.
    running: Arc<Mutex<Vec<Weak<dyn Settles>>>>,
    /// What they did not simulate.
    tally: Arc<Tally>,
}

/// Why the program cannot continue.
#[derive(Debug)]
struct Failed {
    message: String,
    hint: String,
    drift: bool,
}

/// Programs that run, and that can be held against what they answered early.
pub(crate) trait Settles: std::fmt::Debug + Send + Sync {
    /// Asks once more for what was asked early, and notes what is wrong.
    fn settle(&self, permission: &Permission);
}

impl Permission {
    /// Notes why the program cannot continue: a sentence, what to try, and whether it answers otherwise than it did. The first
    /// one counts.
    pub(crate) fn note(&self, message: &str, hint: &str, drift: bool) {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.get_or_insert_with(|| Failed { message: message.to_owned(), hint: hint.to_owned(), drift });
    }

    /// Programs that started by this leave, as long as they run.
    pub(crate) fn watch(&self, program: Weak<dyn Settles>) {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        running.retain(|other| other.strong_count() > 0);
        running.push(program);
    }

    /// Rollouts of programs that started by this leave are counted here.
    pub(crate) fn tally(&self) -> &Arc<Tally> {
        &self.tally
    }
}

impl SimulationFile {
    /// Gives permission to run the program that the file names. A file cannot give it.
    pub fn allow_process(&mut self) {
        self.permission.get_or_insert_default();
    }

    /// The leave, where it was given.
    #[must_use]
    pub fn permission(&self) -> Option<&Permission> {
        self.permission.as_ref()
    }

    /// Why the program of this file, or of a copy of it, could not continue.
    ///
    /// # Errors
    /// [`Error::File`] where it could not.
    pub fn program_failed(&self) -> Result<()> {
        let Some(permission) = &self.permission else { return Ok(()) };
        let failure = permission.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure
            .as_ref()
            .map_or(Ok(()), |failed| Err(Error::file(self.path(), failed.message.as_str(), failed.hint.as_str())))
    }

    /// Asks the programs of this file, or of a copy of it, that still run once more for an early rollout: one that keeps
    /// something from rollout to rollout answers otherwise in the end. Ask before they are let go of.
    ///
    /// # Errors
    /// [`Error::File`] where one answers otherwise, or as [`program_failed`](Self::program_failed).
    pub fn program_settled(&self) -> Result<()> {
        self.program_failed()?;
        if let Some(permission) = &self.permission {
            let running = permission.running.lock().unwrap_or_else(PoisonError::into_inner).clone();
            running.iter().filter_map(Weak::upgrade).for_each(|program| program.settle(permission));
        }
        self.program_failed()
    }

    /// The same file, whose programs are counted on their own: several recordings may be worked on at a time. What makes a
    /// program fail is still reported for every copy.
    #[must_use]
    pub fn counted_apart(&self) -> Self {
        let mut own = self.clone();
        if let Some(permission) = &mut own.permission {
            permission.tally = Arc::default();
        }
        own
    }

    /// How many rollouts the programs of this file were asked for, those that check them apart.
    #[must_use]
    pub fn program_rollouts(&self) -> u64 {
        self.permission.as_ref().map_or(0, |permission| permission.tally.rollouts())
    }

    /// A warning about rollouts that the programs of this file refused, or answered with numbers that cannot be
    /// used: how many, and which of them is nearest to the values of the file. The same for the same work, whatever
    /// the number of threads.
    #[must_use]
    pub fn program_notes(&self) -> Vec<Note> {
        self.permission.as_ref().map_or_else(Vec::new, |permission| permission.tally.notes())
    }

    /// Whether the program failed by answering otherwise than it did, so that nothing that it said can be relied on.
    #[must_use]
    pub fn program_drifted(&self) -> bool {
        let failure = self.permission.as_ref().map(|p| p.failure.lock().unwrap_or_else(PoisonError::into_inner));
        failure.is_some_and(|failure| failure.as_ref().is_some_and(|failed| failed.drift))
    }

    /// The folder in which the program runs: that of the file, and what `process.folder` adds to it.
    #[must_use]
    pub fn program_folder(&self) -> PathBuf {
        let beside = folder_of(self.path());
        let added = self.process().ok().and_then(|process| process.folder.as_ref());
        added.map_or_else(|| beside.to_path_buf(), |folder| beside.join(folder))
    }

    /// Where the file is to be written to `out`, in another folder: names the folder of the program as it is seen from there.
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
        let process = table(self.document.as_table_mut(), "process", false);
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
