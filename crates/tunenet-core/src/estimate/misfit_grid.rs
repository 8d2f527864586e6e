//! Grid of profiled misfits: values of one parameter far from the fit, where another local minimum may lie.

use super::problem::Point;

/// A point of the grid: one parameter at `value`, everything else fitted.
#[derive(Debug, Clone)]
pub(crate) struct GridPoint {
    pub value: f64,
    pub cost: f64,
    pub point: Point,
}

/// For each free parameter, the points of its grid.
pub(crate) type MisfitGrid = Vec<Vec<GridPoint>>;
