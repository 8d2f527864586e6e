//! Memoisation (Michie 1968) of rollouts: equal requests are simulated once, and every other one is counted against an allowance.
//!
//! All rollouts of a tuning go through one log. So its count is the number of recordings that were simulated, nothing is simulated
//! twice, and a caller can [keep](RolloutStore) the answers to go on after an interruption: the fit asks the same again, in the
//! same order, and is answered at once.

use std::collections::HashMap;
use std::fmt::Debug;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::simulator::{Prepared, Simulator, predict};
use crate::{Error, Origin, Result};

/// Numbers kept in memory at most, 64 MB; beyond, the log begins anew at the next fit.
const MOST_NUMBERS: usize = 8_000_000;

/// One rollout as it is asked for: everything that its answer depends on.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Request {
    /// 0 for the simulator itself; others are the same simulator with an assumed constant at the end of its range.
    pub variant: usize,
    /// Number of the recording among those used, from 0.
    pub recording: usize,
    /// How many of its samples are predicted.
    pub samples: usize,
    /// The bits of all parameters, then of all nuisance parameters.
    pub values: Vec<u64>,
}

/// Where answered rollouts are kept beyond the life of a fit.
pub trait RolloutStore: Debug + Send + Sync {
    /// The answer to a request that was kept before.
    fn recall(&self, request: &Request) -> Option<Vec<f64>>;

    /// Keeps an answer.
    fn keep(&self, request: &Request, answer: &[f64]);
}

/// What is shown while a fit goes on.
pub trait Watch: Debug + Send + Sync {
    /// This part of the work begins.
    fn phase(&self, phase: Phase);

    /// So many rollouts were made.
    fn rollouts(&self, count: usize);

    /// The gap (root mean square) of the best point so far.
    fn gap(&self, gap: f64);
}

/// A part of the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// The first fit.
    Fit,
    /// Further starts and other local minima.
    Search,
    /// The intervals and the joint region.
    Intervals,
}

/// The rollouts of one tuning.
#[derive(Debug, Clone, Default)]
pub struct RolloutLog {
    shared: Arc<Shared>,
    variant: usize,
    /// Rollouts of the allowance that are kept for other work.
    reserved: usize,
    /// Whether a rollout beyond the allowance is refused; otherwise only what asks beforehand is ended.
    strict: bool,
}

#[derive(Debug, Default)]
struct Shared {
    allowance: Option<usize>,
    store: Option<Arc<dyn RolloutStore>>,
    watch: Option<Arc<dyn Watch>>,
    answered: Mutex<HashMap<Request, Vec<f64>>>,
    count: AtomicUsize,
    short: std::sync::atomic::AtomicBool,
}

impl RolloutLog {
    /// An empty log: at most `allowance` rollouts, answers kept in `store`, and `watch` notified, where there are any.
    #[must_use]
    pub fn new(allowance: Option<usize>, store: Option<Arc<dyn RolloutStore>>, watch: Option<Arc<dyn Watch>>) -> Self {
        Self { shared: Arc::new(Shared { allowance, store, watch, ..Shared::default() }), ..Self::default() }
    }

    /// The same log for another variant of the simulator, whose answers differ.
    #[must_use]
    pub(crate) fn variant(&self, variant: usize) -> Self {
        Self { variant, ..self.clone() }
    }

    /// The same log for work that has to leave this many rollouts of the allowance.
    #[must_use]
    pub(crate) fn reserving(&self, reserved: usize) -> Self {
        Self { reserved, ..self.clone() }
    }

    /// How many rollouts were made.
    #[must_use]
    pub fn count(&self) -> usize {
        self.shared.count.load(Ordering::Relaxed)
    }

    /// How many may be made; `None` where there is no limit.
    #[must_use]
    pub fn allowance(&self) -> Option<usize> {
        self.shared.allowance
    }

    /// Counts rollouts that were made without this log.
    pub(crate) fn add(&self, rollouts: usize) {
        self.shared.count.fetch_add(rollouts, Ordering::Relaxed);
    }

    /// Counts a rollout that is made without this log.
    ///
    /// # Errors
    /// [`Error::Setting`] where the allowance is spent: that rollout must not be made.
    pub(crate) fn spend(&self) -> Result<()> {
        let before = self.shared.count.fetch_add(1, Ordering::Relaxed);
        let Some(allowance) = self.shared.allowance.filter(|allowance| before >= *allowance) else { return Ok(()) };
        self.shared.count.fetch_sub(1, Ordering::Relaxed);
        self.shared.short.store(true, Ordering::Relaxed);
        let expected = "more rollouts than that".into();
        Err(Error::Setting { origin: Origin::Flag, name: "max_rollouts", expected, found: allowance.to_string() })
    }

    /// An empty log with what is left of the allowance and no rollout beyond it, for work without which the answer stands.
    pub(crate) fn remainder(&self) -> Self {
        let allowance = self.shared.allowance.map(|allowance| allowance.saturating_sub(self.count()));
        Self { shared: Arc::new(Shared { allowance, ..Shared::default() }), strict: true, ..Self::default() }
    }

    /// The same log, which refuses a rollout beyond the allowance.
    #[must_use]
    pub(crate) fn strict(&self) -> Self {
        Self { strict: true, ..self.clone() }
    }

    /// Whether the allowance still holds so many rollouts; what does not fit is remembered, see [`was_short`](Self::was_short).
    pub(crate) fn affords(&self, rollouts: usize) -> bool {
        let needed = self.count() + rollouts + self.reserved;
        let affords = self.shared.allowance.is_none_or(|allowance| needed <= allowance);
        if !affords {
            self.shared.short.store(true, Ordering::Relaxed);
        }
        affords
    }

    /// Whether the allowance ended anything.
    #[must_use]
    pub fn was_short(&self) -> bool {
        self.shared.short.load(Ordering::Relaxed)
    }

    /// Announces a part of the work.
    pub(crate) fn phase(&self, phase: Phase) {
        if let Some(watch) = &self.shared.watch {
            watch.phase(phase);
        }
    }

    /// Announces the gap of an accepted point.
    pub(crate) fn gap(&self, gap: f64) {
        if let Some(watch) = &self.shared.watch {
            watch.gap(gap);
        }
    }

    /// Frees the memory of a long tuning. Called between fits, never among rollouts that run at a time: what is remembered must
    /// not depend on the number of threads.
    pub(crate) fn trim(&self) {
        let mut answered = self.answered();
        if answered.values().map(Vec::len).sum::<usize>() > MOST_NUMBERS {
            answered.clear();
        }
    }

    /// A rollout of `recording`, number `d`, over its first `samples` samples.
    ///
    /// # Errors
    /// Where the simulator refuses.
    pub(crate) fn predict(
        &self,
        simulator: &dyn Simulator,
        (d, recording): (usize, &Prepared),
        parameters: &[f64],
        nuisances: &[f64],
        samples: usize,
    ) -> Result<Vec<f64>> {
        let values = parameters.iter().chain(nuisances).map(|value| value.to_bits()).collect();
        let request = Request { variant: self.variant, recording: d, samples, values };
        if let Some(known) = self.answered().get(&request) {
            return Ok(known.clone());
        }
        if self.strict {
            self.spend()?;
        } else {
            self.add(1);
        }
        if let Some(watch) = &self.shared.watch {
            watch.rollouts(self.count());
        }
        let kept = self.shared.store.as_ref().and_then(|store| store.recall(&request));
        let answer = if let Some(kept) = kept {
            kept
        } else {
            let answer = predict(simulator, recording, parameters, nuisances, &recording.seen.clock()[..samples])?;
            if let Some(store) = &self.shared.store {
                store.keep(&request, &answer);
            }
            answer
        };
        self.answered().insert(request, answer.clone());
        Ok(answer)
    }

    fn answered(&self) -> MutexGuard<'_, HashMap<Request, Vec<f64>>> {
        self.shared.answered.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::Preparation;
    use crate::testing::{Exact, Line};

    #[derive(Debug, Default)]
    struct Kept(Mutex<HashMap<Request, Vec<f64>>>);

    impl RolloutStore for Kept {
        fn recall(&self, request: &Request) -> Option<Vec<f64>> {
            self.0.lock().unwrap().get(request).cloned()
        }

        fn keep(&self, request: &Request, answer: &[f64]) {
            self.0.lock().unwrap().insert(request.clone(), answer.to_vec());
        }
    }

    #[test]
    fn equal_requests_count_once_and_differing_ones_each() {
        let simulator = Exact::new(Line);
        let seen = simulator.observe(&[("slope", 2.0)], &[0.5], 0.01, 7).unwrap();
        let Preparation::Usable(prepared) = simulator.prepare(&seen).unwrap() else { panic!("refused") };
        let kept: Arc<Kept> = Arc::default();
        let log = RolloutLog::new(Some(3), Some(kept.clone()), None);
        let mut values: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let ask = |log: &RolloutLog, d: usize, values: &[f64]| {
            log.predict(&simulator, (d, &prepared), values, &[0.5], 10).unwrap()
        };
        let first = ask(&log, 0, &values);
        assert_eq!((ask(&log, 0, &values), log.count()), (first.clone(), 1));
        ask(&log, 1, &values);
        ask(&log.variant(1), 1, &values);
        assert!(log.count() == 3 && !log.was_short() && log.affords(0) && !log.affords(1) && log.was_short());
        let wider = RolloutLog::new(Some(3), None, None);
        let rest = wider.reserving(2);
        assert!(rest.affords(1) && !rest.affords(2) && wider.affords(3));
        assert_eq!((log.spend().is_err(), log.count()), (true, 3));
        // What is left of it allows nothing new.
        let rest = log.remainder();
        let refused = rest.predict(&simulator, (0, &prepared), &values, &[0.5], 10).is_err();
        assert!(refused && rest.was_short() && rest.count() == 0);
        values[0] += 1.0;
        assert_ne!(ask(&log, 0, &values), first);
        // A new log with the same store is answered from there, and counts as if it had simulated.
        let again = RolloutLog::new(None, Some(kept.clone()), None);
        kept.0.lock().unwrap().values_mut().for_each(|answer| answer[0] = 7.0);
        assert_eq!((ask(&again, 0, &values)[0], again.count()), (7.0, 1));
    }
}
