//! Grid of profiled misfits: values of one parameter far from the fit, where another local minimum may lie.

use super::problem::Point;

/// A place far from the fit: one parameter there, everything else fitted to it.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    pub value: f64,
    pub cost: f64,
    pub point: Point,
}

/// For each free parameter, the places that were looked at.
pub(crate) type Elsewhere = Vec<Vec<Place>>;
