//! Recordings on several threads, their lines printed in order.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::Result;

use crate::args::pool;
use crate::view::answer;
use crate::view::text::note;

/// All of `mine`, at most so many at a time as there are threads; reported in their order.
pub fn spread<T: Send>(
    jobs: Option<usize>,
    json: bool,
    mine: &[usize],
    treat: &(dyn Fn(usize) -> Result<(T, String)> + Sync),
) -> Result<Vec<T>> {
    let pool = pool(jobs)?;
    // Without `--jobs` one after the other, each on all threads: then memory does not grow with the cores.
    let workers = jobs.unwrap_or(1).min(mine.len()).max(1);
    let next = AtomicUsize::new(0);
    let done = Mutex::new(InOrder { results: BTreeMap::new(), count: 0, json, printed: Ok(()) });
    let work = || loop {
        let number = next.fetch_add(1, Ordering::Relaxed);
        let Some(i) = mine.get(number) else { return };
        let result = pool.install(|| treat(*i));
        if let Ok(mut done) = done.lock() {
            done.add(number, result);
        }
    };
    std::thread::scope(|scope| {
        (1..workers).for_each(|_| drop(scope.spawn(work)));
        work();
    });
    let done = done.into_inner().map_err(|_| anyhow::anyhow!("a recording's thread broke down"))?;
    done.printed?;
    done.results.into_values().map(|result| result.map(|(value, _)| value)).collect()
}

/// Results as they come, their lines printed in order.
struct InOrder<T> {
    results: BTreeMap<usize, Result<(T, String)>>,
    count: usize,
    /// Whether standard output is for the one object.
    json: bool,
    printed: tunenet_formats::Result<()>,
}

impl<T> InOrder<T> {
    fn add(&mut self, number: usize, result: Result<(T, String)>) {
        self.results.insert(number, result);
        while let Some(result) = self.results.get(&self.count) {
            if let Ok((_, line)) = result {
                if self.json {
                    note(line);
                } else if self.printed.is_ok() {
                    self.printed = answer::line(line);
                }
            }
            self.count += 1;
        }
    }
}
