//! Memoisation (Michie 1968) of rollouts: equal requests are simulated once, and every other one is counted against an allowance.
//!
//! All rollouts of a tuning or a diagnosis go through one log. So its count is the number of recordings that were simulated, nothing is
//! simulated twice, and a caller can [keep](RolloutStore) the answers to go on after an interruption: the fit asks the same again, in the
//! same order, and is answered at once.

use std::collections::HashMap;
use std::fmt::Debug;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::simulator::{Prepared, Simulator, predict};
use crate::{Error, Origin, Result};

/// Numbers kept in memory at most, 64 MB; beyond, the log begins anew at the next fit.
const MOST_NUMBERS: usize = 8_000_000;
/// A diagnosis keeps rollouts of so many numbers at most: between two fits it makes some thousands of them.
const LARGEST_KEPT: usize = 4_096;

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

/// A hash of all, the same in every run.
fn digest<T: Hash>(all: impl Iterator<Item = T>) -> u64 {
    let mut hasher = DefaultHasher::new();
    all.for_each(|one| one.hash(&mut hasher));
    hasher.finish()
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

/// The rollouts of one tuning or diagnosis.
#[derive(Debug, Clone, Default)]
pub struct RolloutLog {
    shared: Arc<Shared>,
    /// Answers; nothing yet of a rollout that is running.
    answered: Arc<Mutex<HashMap<Request, Option<Vec<f64>>>>>,
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

    /// The same count and allowance for other simulators, whose answers differ.
    #[must_use]
    pub(crate) fn apart(&self) -> Self {
        Self { answered: Arc::default(), ..self.clone() }
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
        if answered.values().flatten().map(Vec::len).sum::<usize>() > MOST_NUMBERS {
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
        self.answer(request, |request| {
            if let Some(kept) = self.shared.store.as_ref().and_then(|store| store.recall(request)) {
                return Ok(kept);
            }
            let answer = predict(simulator, recording, parameters, nuisances, &recording.seen.clock()[..samples])?;
            if let Some(store) = &self.shared.store {
                store.keep(request, &answer);
            }
            Ok(answer)
        })
    }

    /// A rollout at the instants `clock` by a simulator of an object. Those of one object differ by their parameters' names alone, and a motion
    /// without circumstances depends on nothing else, so that it is simulated once. For a [strict](Self::strict) log.
    ///
    /// # Errors
    /// Where the simulator refuses, or where the allowance is spent.
    pub(crate) fn predict_of(
        &self,
        (object, simulator): (usize, &dyn Simulator),
        recording: &Prepared,
        (parameters, nuisances): (&[f64], &[f64]),
        clock: &[f64],
    ) -> Result<Vec<f64>> {
        if recording.circumstances.is_some() || clock.len() * simulator.channels().len() > LARGEST_KEPT {
            self.spend()?;
            return predict(simulator, recording, parameters, nuisances, clock);
        }
        let bits = |value: &f64| value.to_bits();
        let names = digest(simulator.parameters().iter().map(|parameter| &parameter.name));
        let values = [names, digest(clock.iter().map(bits))].into_iter().chain(parameters.iter().map(bits));
        let values = values.chain(nuisances.iter().map(bits)).collect();
        let request = Request { variant: object, recording: 0, samples: clock.len(), values };
        self.answer(request, |_| predict(simulator, recording, parameters, nuisances, clock))
    }

    /// The answer to a request that was made before, or else what `run` answers, which counts as a rollout. Two threads that ask the same at a
    /// time both run it, and it counts as with one thread: once, or as often as it is refused.
    fn answer(&self, request: Request, run: impl FnOnce(&Request) -> Result<Vec<f64>>) -> Result<Vec<f64>> {
        let mut answered = self.answered();
        let is_first = match answered.get(&request) {
            Some(Some(known)) => return Ok(known.clone()),
            running => running.is_none(),
        };
        if is_first {
            answered.insert(request.clone(), None);
        }
        drop(answered);
        let counted = match (is_first, self.strict) {
            (true, true) => self.spend(),
            (is_first, _) => {
                self.add(usize::from(is_first));
                Ok(())
            }
        };
        if let Some(watch) = self.shared.watch.as_ref().filter(|_| counted.is_ok()) {
            watch.rollouts(self.count());
        }
        match counted.and_then(|()| run(&request)) {
            Ok(answer) => {
                self.answered().insert(request, Some(answer.clone()));
                Ok(answer)
            }
            Err(refused) => {
                self.add(usize::from(!is_first));
                self.answered().remove(&request);
                Err(refused)
            }
        }
    }

    fn answered(&self) -> MutexGuard<'_, HashMap<Request, Option<Vec<f64>>>> {
        self.answered.lock().unwrap_or_else(PoisonError::into_inner)
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

    /// Objects and simulators with other parameters have answers of their own, and so has a log apart; all count together.
    #[test]
    fn a_motion_of_an_object_is_simulated_once() {
        let simulator = Exact::new(Line);
        let seen = simulator.observe(&[("slope", 2.0)], &[0.5], 0.01, 7).unwrap();
        let Preparation::Usable(mut prepared) = simulator.prepare(&seen).unwrap() else { panic!("refused") };
        let log = RolloutLog::new(Some(5), None, None).strict();
        let values: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let ask = |log: &RolloutLog, object: usize, prepared: &Prepared, samples: usize| {
            log.predict_of((object, &simulator), prepared, (&values, &[0.5]), &seen.clock()[..samples])
        };
        let first = ask(&log, 0, &prepared, 10).unwrap();
        assert_eq!((ask(&log, 0, &prepared, 10).unwrap(), log.count()), (first.clone(), 1));
        assert_eq!(ask(&log, 0, &prepared, 9).unwrap(), first[..9]);
        ask(&log, 1, &prepared, 10).unwrap();
        ask(&log.apart(), 0, &prepared, 10).unwrap();
        assert_eq!(log.count(), 4);
        // What drove a motion is not compared.
        prepared.circumstances = Some(Arc::default());
        let driven = |_| ask(&log, 0, &prepared, 10).is_ok();
        assert_eq!([0, 1].map(driven), [true, false], "the allowance is spent");
    }

    /// Two threads ask the same while it runs: an answer counts once, a refusal for each, as with one thread.
    #[test]
    fn requests_at_a_time_count_as_with_one_thread() {
        let request = || Request { variant: 0, recording: 0, samples: 1, values: vec![7] };
        for refused in [false, true] {
            let (log, both) = (RolloutLog::new(Some(9), None, None).strict(), std::sync::Barrier::new(2));
            let run = |_: &Request| {
                both.wait();
                if refused { Err(Error::SimulatorBroken { message: "it ended".into() }) } else { Ok(vec![3.0]) }
            };
            let answers = std::thread::scope(|scope| {
                let threads = [0, 1].map(|_| scope.spawn(|| log.answer(request(), run).ok()));
                threads.map(|thread| thread.join().unwrap())
            });
            assert_eq!(answers, if refused { [None, None] } else { [Some(vec![3.0]), Some(vec![3.0])] });
            assert_eq!(log.count(), if refused { 2 } else { 1 });
        }
    }
}
