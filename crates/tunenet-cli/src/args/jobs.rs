//! `--jobs`.

use anyhow::Context;

/// A number of threads from the command line.
///
/// # Errors
/// Where it is none, or unreasonably many.
pub fn jobs(text: &str) -> Result<usize, String> {
    let count: Option<usize> = text.parse().ok().filter(|count| (1..=1024).contains(count));
    count.ok_or_else(|| format!("expected 1 to 1024 threads, found `{text}`"))
}

/// A pool of so many threads; of as many as the machine has cores where nothing is said.
///
/// # Errors
/// Where the system starts no threads.
pub fn pool(jobs: Option<usize>) -> anyhow::Result<rayon::ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.unwrap_or(0));
    pool.build().context("starting threads")
}
