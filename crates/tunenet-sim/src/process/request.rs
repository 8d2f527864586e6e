//! What a program is asked: recordings, each announced once, and rollouts of them.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use tunenet_core::observation::Circumstances;
use tunenet_core::simulator::Run;

/// The circumstances of a recording under the number by which requests name it.
#[derive(Debug)]
pub(super) struct Recording {
    pub number: u64,
    /// What it is called in sentences for users; empty where it has no name.
    pub name: String,
    /// Which of the program's setups it has.
    pub setup: usize,
    /// Where its initial state holds, s.
    pub start_s: f64,
    /// What drove it, in the order of the program's inputs.
    pub inputs: Vec<tunenet_core::observation::Input>,
}

impl Recording {
    fn of(number: u64, known: &Circumstances) -> Self {
        Self {
            number,
            name: known.name.clone(),
            setup: known.setup,
            start_s: known.start_s,
            inputs: known.inputs.clone(),
        }
    }

    fn is(&self, known: &Circumstances) -> bool {
        let start = self.start_s.to_bits() == known.start_s.to_bits();
        self.setup == known.setup && start && self.inputs == known.inputs
    }
}

/// All recordings that were asked for, numbered from 1.
#[derive(Debug, Default)]
pub(super) struct Recordings(Vec<Arc<Recording>>);

impl Recordings {
    /// The recording with these circumstances.
    pub fn of(&mut self, known: &Circumstances) -> Arc<Recording> {
        if let Some(one) = self.0.iter().find(|one| one.is(known)) {
            return Arc::clone(one);
        }
        let new = Arc::new(Recording::of(self.0.len() as u64 + 1, known));
        self.0.push(Arc::clone(&new));
        new
    }
}

/// A rollout that is asked for. Two are equal where all that is sent is, to the last bit.
#[derive(Debug, Clone)]
pub(super) struct Request {
    pub recording: Arc<Recording>,
    /// The parameters, in the order of the file.
    pub parameters: Vec<f64>,
    /// The coefficients of all candidates, in the order of the file.
    pub coefficients: Vec<f64>,
    /// The initial state, in the order of the file.
    pub start: Vec<f64>,
    pub times_s: Vec<f64>,
}

impl Request {
    pub fn of(run: &Run, recording: Arc<Recording>) -> Self {
        Self {
            recording,
            parameters: run.parameters.to_vec(),
            coefficients: run.coefficients.to_vec(),
            start: run.start.to_vec(),
            times_s: run.times_s.to_vec(),
        }
    }

    /// How many numbers it holds.
    pub fn len(&self) -> usize {
        self.numbers().count()
    }

    fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let lists = [&self.parameters, &self.coefficients, &self.start, &self.times_s];
        lists.into_iter().flatten().copied()
    }
}

impl PartialEq for Request {
    fn eq(&self, other: &Self) -> bool {
        let lengths = |one: &Self| (one.recording.number, one.start.len(), one.times_s.len());
        lengths(self) == lengths(other) && self.numbers().map(f64::to_bits).eq(other.numbers().map(f64::to_bits))
    }
}

impl Eq for Request {}

impl Hash for Request {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.recording.number.hash(state);
        self.numbers().for_each(|number| number.to_bits().hash(state));
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn request(parameters: &[f64], times_s: &[f64]) -> Request {
        let recording = Recordings::default().of(&Circumstances::default());
        let (coefficients, start) = (Vec::new(), Vec::new());
        Request { recording, parameters: parameters.to_vec(), coefficients, start, times_s: times_s.to_vec() }
    }

    #[test]
    fn a_recording_keeps_its_number_and_a_request_is_equal_by_its_bits() {
        let mut all = Recordings::default();
        let late = Circumstances { start_s: 1.0, ..Circumstances::default() };
        let numbers = [&Circumstances::default(), &late, &Circumstances::default()].map(|known| all.of(known).number);
        assert_eq!(numbers, [1, 2, 1]);
        assert!(request(&[1.0], &[0.0]) == request(&[1.0], &[0.0]));
        assert!(
            request(&[0.0], &[0.0]) != request(&[-0.0], &[0.0]) && request(&[1.0], &[0.0]) != request(&[], &[1.0, 0.0])
        );
    }
}
