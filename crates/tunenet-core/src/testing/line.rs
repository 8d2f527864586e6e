//! A straight line: y' = b, y(0) unknown.

use super::{ClosedForm, Values, effect};
use crate::Result;
use crate::observation::{Channel, Observation};
use crate::simulator::{Effect, Parameter};

/// `y = y₀ + b t + c t² + d t³`, of which the simulator knows the line alone.
#[derive(Debug, Clone, Copy)]
pub struct Line;

impl ClosedForm for Line {
    fn channel(&self) -> Channel {
        Channel::new("y", "m")
    }

    fn parameters(&self) -> Vec<Parameter> {
        Parameter::new("slope", "m/s", 0.5, -5.0, 5.0).into_iter().collect()
    }

    fn effects(&self) -> Vec<Effect> {
        vec![
            effect("curvature", "c_1_s2", "m/s²", (-3.0, 3.0), 0.01),
            effect("cubic", "d_1_s3", "m/s³", (-3.0, 3.0), 0.01),
        ]
    }

    fn nuisances(&self, seen: &Observation) -> Result<Vec<Parameter>> {
        let first = seen.row(0)[0];
        Ok(vec![Parameter::new("start.value", "m", first, first - 5.0, first + 5.0)?])
    }

    fn solution(&self, values: &Values, start: &[f64], t: f64) -> f64 {
        start[0] + t * (values("slope") + t * (values("curvature.c_1_s2") + t * values("cubic.d_1_s3")))
    }
}
