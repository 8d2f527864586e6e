//! Permission to run programs, the programs that run by it, and what became of them.
//!
//! A simulation file is a plain value. What happens when its program runs is kept here, by the caller.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use tunenet_core::Origin;
use tunenet_core::observation::Note;
use tunenet_formats::Result;

use super::failure::{self, Failure};
use super::pool::Pool;
use super::program;
use super::tally::Tally;
use crate::SimulationFile;

/// Whether the program that a simulation file names may be run. The user decides, never a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Permission {
    /// No program is started.
    #[default]
    Denied,
    /// Programs are started with the permissions of the user.
    Granted,
}

/// Work with simulation files whose programs may run: permission, running programs, their first failure, and a tally of rollouts.
///
/// Clones share everything. A rollout that fails means only that its values cannot be simulated, and a fit tries others. A
/// program that ended or hangs cannot be helped by other values: its failure is kept here, and [`failed`](Self::failed) reports it.
///
/// The default session runs no program, and is all that a ball or an arm needs.
///
/// ```
/// use std::path::Path;
/// use tunenet_core::observation::Kind;
/// use tunenet_sim::{Session, SimulationFile, simulator};
/// let text = "kind = \"process\"\nprocess = { command = [\"./swing\"], channels = [\"angle_rad\"] }\n\
///             parameters.length = { value = 1, min = 0.2, max = 2 }";
/// let file = SimulationFile::parse(Path::new("swing.toml"), text)?;
/// let refused = simulator(&file, Kind::Other, &Session::default()).err().expect("no permission");
/// assert!(refused.to_string().contains("--allow-process"));
/// # Ok::<(), tunenet_core::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Session {
    permission: Permission,
    failure: Arc<Mutex<Option<Failed>>>,
    running: Arc<Mutex<Vec<Weak<Pool>>>>,
    tally: Arc<Tally>,
    rechecks: Arc<AtomicU64>,
}

/// Why a program cannot continue.
#[derive(Debug)]
struct Failed {
    /// The simulation file that names the program.
    file: PathBuf,
    failure: Failure,
}

impl Session {
    /// A session in which no program runs yet.
    #[must_use]
    pub fn new(permission: Permission) -> Self {
        Self { permission, ..Self::default() }
    }

    /// Whether programs may be run.
    #[must_use]
    pub fn permission(&self) -> Permission {
        self.permission
    }

    /// Refuses to run the program of `file` without permission.
    ///
    /// # Errors
    /// [`Setting`](tunenet_core::Error::Setting) where the permission is [denied](Permission::Denied).
    pub fn require_permission(&self, file: &SimulationFile) -> Result<()> {
        if self.permission == Permission::Granted {
            return Ok(());
        }
        let path = file.path().display();
        let (beginning, left_out) = failure::beginning(&program::line(&program::words(file)));
        let named = match left_out {
            0 => format!("`{beginning}`"),
            1 => format!("`{beginning}…` (1 more character, which `tunenet inspect {path}` shows)"),
            more => format!("`{beginning}…` ({more} more characters, which `tunenet inspect {path}` shows)"),
        };
        let expected = format!("permission to run the external program {named} of {path}, with all your rights");
        let found = "none; give this flag if you trust the file".into();
        Err(tunenet_core::Error::Setting { origin: Origin::Caller, name: "--allow-process", expected, found }.into())
    }

    /// Refuses to continue after a program of this session failed.
    ///
    /// # Errors
    /// [`File`](tunenet_formats::Error::File) with the first failure: the program ended, hung, or answered otherwise
    /// than before.
    pub fn failed(&self) -> Result<()> {
        let first = lock(&self.failure);
        first.as_ref().map_or(Ok(()), |Failed { file, failure }| Err(failure.clone().error(file)))
    }

    /// Whether a program failed by answering otherwise than before, so that none of its answers can be relied on.
    #[must_use]
    pub fn drifted(&self) -> bool {
        lock(&self.failure).as_ref().is_some_and(|first| first.failure.drift)
    }

    /// Asks every program that still runs once more for an early rollout: a program that keeps something from rollout to rollout
    /// answers otherwise in the end. Call it before the simulators are dropped.
    ///
    /// # Errors
    /// [`File`](tunenet_formats::Error::File) where one answers otherwise, or as [`failed`](Self::failed).
    pub fn settle(&self) -> Result<()> {
        self.failed()?;
        let running = lock(&self.running).clone();
        for pool in running.iter().filter_map(Weak::upgrade) {
            if let Err(failure) = pool.settle() {
                self.note(pool.file(), &failure);
            }
        }
        self.failed()
    }

    /// The same session with a tally of its own, for one of several recordings that are worked on at a time. A failure still
    /// counts for all of them.
    #[must_use]
    pub fn counted_separately(&self) -> Self {
        Self { tally: Arc::default(), rechecks: Arc::default(), ..self.clone() }
    }

    /// Number of rollouts that only checked programs: asked for again, or in another copy.
    #[must_use]
    pub fn rechecks(&self) -> u64 {
        self.rechecks.load(Ordering::Relaxed)
    }

    /// Where these are counted.
    pub(super) fn rechecked(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.rechecks)
    }

    /// Number of rollouts that programs simulated, without those that only check the programs. Equal ones are simulated once.
    #[must_use]
    pub fn rollouts(&self) -> u64 {
        self.tally.rollouts()
    }

    /// Counts rollouts that an earlier run simulated and that were not simulated again: reports are those of an uninterrupted run.
    pub fn recalled(&self, rollouts: u64) {
        self.tally.recalled(rollouts);
    }

    /// Warnings about rollouts that programs refused, or answered with numbers that cannot be used: how many, and which of them
    /// is nearest to the values of the file. It is the same for any number of threads.
    #[must_use]
    pub fn notes(&self) -> Vec<Note> {
        self.tally.notes()
    }

    /// Keeps why the program of `file` cannot continue; the first failure counts.
    pub(super) fn note(&self, file: &Path, failure: &Failure) {
        lock(&self.failure).get_or_insert_with(|| Failed { file: file.to_path_buf(), failure: failure.clone() });
    }

    /// Adds a program, which is [settled](Self::settle) as long as it runs.
    pub(super) fn watch(&self, pool: &Arc<Pool>) {
        let mut running = lock(&self.running);
        running.retain(|other| other.strong_count() > 0);
        running.push(Arc::downgrade(pool));
    }

    /// Where rollouts are counted.
    pub(super) fn tally(&self) -> &Tally {
        &self.tally
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
