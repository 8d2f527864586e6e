//! A value that is computed when it is first needed, for runs that go on from kept pieces.

use std::sync::OnceLock;

use anyhow::Result;

/// Computed on the first [`get`](Self::get); an error is returned and nothing is kept, so the next call computes again. Threads
/// that need it at the same time each compute it: what they share is asked for before they start.
pub struct Lazy<'a, T> {
    value: OnceLock<T>,
    make: Box<dyn Fn() -> Result<T> + Send + Sync + 'a>,
}

impl<'a, T> Lazy<'a, T> {
    pub fn new(make: impl Fn() -> Result<T> + Send + Sync + 'a) -> Self {
        Self { value: OnceLock::new(), make: Box::new(make) }
    }

    /// # Errors
    /// The error of computing it.
    pub fn get(&self) -> Result<&T> {
        if let Some(value) = self.value.get() {
            return Ok(value);
        }
        let made = (self.make)()?;
        Ok(self.value.get_or_init(|| made))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn it_is_made_once_and_only_where_it_is_needed() {
        let calls = AtomicU32::new(0);
        let lazy = Lazy::new(|| {
            anyhow::ensure!(calls.fetch_add(1, Ordering::Relaxed) > 0, "not yet");
            Ok(7)
        });
        assert_eq!(calls.load(Ordering::Relaxed), 0);
        assert!(lazy.get().is_err());
        assert_eq!((*lazy.get().unwrap(), *lazy.get().unwrap()), (7, 7));
        assert_eq!(calls.load(Ordering::Relaxed), 2);
    }
}
