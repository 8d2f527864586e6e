//! What has been learned: the two-branch network, its data, its training.
use crate::{Result, observation::Observation, simulator::Scale};
/// Stub.
#[derive(Debug)]
pub struct Model;
impl Model {
    /// Stub.
    pub fn parameter_names(&self) -> &[String] {
        &[]
    }
    /// Stub.
    pub fn estimate(&self, _: &Observation, _: Option<Scale>, _: &Observation, _: Option<Scale>) -> Result<Vec<f64>> {
        Ok(vec![])
    }
}
