//! A ball's positions cut into free flight, contacts and rest.

mod arcs;
mod contacts;
mod first_fall;
mod kinks;
mod lasting;
pub(crate) mod parabolas;
pub(crate) mod polynomial;
mod release;
mod rest;
mod stopped_fall;
mod turns;

use std::sync::Arc;

use tunenet_core::observation::Observation;
use tunenet_core::simulator::Segmentation;
use tunenet_core::statistics::range;

pub use arcs::Arcs;
pub use contacts::Contact;
pub use first_fall::FirstFall;
pub use kinks::Blows;
pub use turns::bounces;

use rest::before_rest;

/// Where the positions of a ball under this gravity are cut: at its contacts, and where it comes to rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallSegmentation {
    /// Gravity, m/s², downwards.
    pub gravity_m_s2: f64,
}

impl BallSegmentation {
    /// As a recording made ready carries it.
    #[must_use]
    pub fn shared(gravity_m_s2: f64) -> Option<Arc<dyn Segmentation>> {
        Some(Arc::new(Self { gravity_m_s2 }))
    }
}

impl Segmentation for BallSegmentation {
    fn moving(&self, seen: &Observation, noise: &[f64]) -> usize {
        before_rest(seen, noise.last().copied().unwrap_or(0.0))
    }

    fn events(&self, seen: &Observation) -> Vec<f64> {
        let arcs = Arcs::cut(seen, self.gravity_m_s2);
        arcs.map_or_else(Vec::new, |arcs| arcs.contacts.iter().map(|c| c.time_s).collect())
    }

    fn free_acceleration(&self) -> Option<f64> {
        Some(-self.gravity_m_s2)
    }
}

/// The greatest value less the least.
pub(crate) fn span(values: &[f64]) -> f64 {
    range(values.iter().copied())
}
