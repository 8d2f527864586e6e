//! Rollouts of a program in the circumstances of recordings, each of which a pair names.

use tunenet_core::observation::{Channel, Circumstances};
use tunenet_core::simulator::{Parameter, Prepared, RolloutResult, Simulator};

/// A program whose rollouts are driven as recordings were: the one nuisance parameter is the number of the recording.
pub struct UnderRecordings {
    pub inner: Box<dyn Simulator>,
    pub recordings: Vec<Prepared>,
}

impl Simulator for UnderRecordings {
    fn parameters(&self) -> &[Parameter] {
        self.inner.parameters()
    }

    fn channels(&self) -> &[Channel] {
        self.inner.channels()
    }

    fn rollout(&self, parameters: &[f64], recording: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        let is = |(i, _): &(usize, &Prepared)| Some(&(*i as f64)) == recording.first();
        let numbered = self.recordings.iter().enumerate().find(is).map(|(_, recording)| recording);
        let recording = numbered.unwrap_or(&self.recordings[0]);
        let bare = Circumstances::default();
        let known = recording.circumstances.as_deref().unwrap_or(&bare);
        self.inner.rollout_driven(parameters, &recording.nuisance_values(), known, clock, values)
    }
}
