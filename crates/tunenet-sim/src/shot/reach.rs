//! From which places a ball can be released.

use tunenet_core::Result;

/// What holds the ball until it is released.
pub trait Reach {
    /// The joint positions (rad) that hold the ball's centre at `point_m` (m, from the impact point), near those of
    /// `before` where there are any; `None` where the place is out of reach. A device without joints returns an empty list.
    ///
    /// # Errors
    /// Where the robot's description cannot be used.
    fn joints(&self, point_m: [f64; 3], before: Option<&[f64]>) -> Result<Option<Vec<f64>>>;
}

/// A hand that reaches everywhere.
#[derive(Debug, Clone, Copy, Default)]
pub struct Anywhere;

impl Reach for Anywhere {
    fn joints(&self, _: [f64; 3], _: Option<&[f64]>) -> Result<Option<Vec<f64>>> {
        Ok(Some(Vec::new()))
    }
}
