//! Brent's bounded search for a minimum (Brent, *Algorithms for Minimization without Derivatives*, 1973), by the crate `argmin`.

use std::cell::RefCell;

use anyhow::{Context, Result};
use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::brent::BrentOpt;

use super::{Course, Search};

/// Relative tolerance: the square root of the machine's precision, below which a minimum cannot be located by its value.
const RELATIVE: f64 = 1e-8;
/// Absolute tolerance, for estimates near 0; far below every error that a table shows.
const ABSOLUTE: f64 = 1e-10;

/// The sum of squares, and what each rollout of it has found so far.
struct Squares<'a> {
    search: &'a Search<'a>,
    best: RefCell<Best>,
}

/// The least sum of squares so far, where it lies, and where it lay after every rollout.
struct Best {
    squares: f64,
    at: f64,
    course: Course,
}

impl CostFunction for Squares<'_> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, at: &f64) -> Result<f64, Error> {
        let squares = self.search.squares(&(self.search.roll)(*at)?);
        let mut best = self.best.borrow_mut();
        if squares <= best.squares {
            (best.squares, best.at) = (squares, *at);
        }
        let at = best.at;
        best.course.push(at);
        Ok(squares)
    }
}

/// Brent's bounded search on the sum of squares over the range that the target was drawn from; the best so far after every
/// rollout. What it leaves of its budget once it has converged changes nothing.
pub fn search(target: &Search, most: usize) -> Result<Course> {
    let (low, high) = target.range;
    let start = Best { squares: f64::INFINITY, at: target.proposed, course: vec![target.proposed] };
    let solver = BrentOpt::new(low, high).set_tolerance(RELATIVE, ABSOLUTE);
    // The first rollout is no iteration, every other one is.
    let iterations = u64::try_from(most.saturating_sub(1))?;
    let found = Executor::new(Squares { search: target, best: RefCell::new(start) }, solver)
        .configure(|state| state.max_iters(iterations))
        .timer(false)
        .run()?;
    let squares = found.problem.problem.context("argmin gives the problem back")?;
    let Best { at, mut course, .. } = squares.best.into_inner();
    course.resize(most + 1, at);
    Ok(course)
}
