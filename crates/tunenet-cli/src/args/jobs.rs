//! `--jobs`.

use anyhow::Context;
use tunenet_core::Origin;

/// Most threads that a command starts.
const MOST_THREADS: usize = 1024;

/// A number of threads from the command line.
///
/// # Errors
/// Where it is none, or unreasonably many.
pub fn jobs(text: &str) -> Result<usize, String> {
    let count: Option<usize> = text.parse().ok().filter(|count| (1..=MOST_THREADS).contains(count));
    count.ok_or_else(|| format!("expected 1 to {MOST_THREADS} threads, found `{text}`"))
}

/// The variable that sets the number of threads where no flag does.
const THREADS: &str = "RAYON_NUM_THREADS";

/// Refuses a number of threads in the environment that the machine would spend its time on starting.
///
/// # Errors
/// [`Error::Setting`](tunenet_core::Error::Setting) where it exceeds what `--jobs` allows. What is no number is ignored, as by
/// rayon.
pub fn check_threads() -> anyhow::Result<()> {
    let asked = std::env::var(THREADS).unwrap_or_default();
    if asked.parse::<u64>().is_ok_and(|threads| threads > MOST_THREADS as u64) {
        let expected = format!("at most {MOST_THREADS} threads");
        return Err(
            tunenet_core::Error::Setting { origin: Origin::Caller, name: THREADS, expected, found: asked }.into()
        );
    }
    Ok(())
}

/// A pool of so many threads; of as many as the machine has cores where nothing is said.
///
/// # Errors
/// Where the system starts no threads.
pub fn pool(jobs: Option<usize>) -> anyhow::Result<rayon::ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.unwrap_or(0));
    pool.build().context("starting threads")
}
