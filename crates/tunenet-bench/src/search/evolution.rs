//! CMA-ES, by the crate `cmaes`, on the squared error.

use std::sync::{Arc, Mutex};

use anyhow::{Context, Result};
use cmaes::{CMAESOptions, DVector};

use super::{Course, Search};

/// The paper's population.
const POPULATION: usize = 10;
/// The first standard deviation: a few of them cover the range.
const SPREAD: f64 = 0.3;
/// What a value outside the range costs more, per distance: it is searched inside.
const OUTSIDE: f64 = 1e3;

/// The best estimate so far after every rollout, from the proposed start. With two dimensions the second changes nothing:
/// published code searches so, because it knows no search in one.
pub fn search(target: &Search, most: usize, dimensions: usize) -> Result<Course> {
    let tried: Arc<Mutex<Vec<(f64, f64)>>> = Arc::default();
    let record = Arc::clone(&tried);
    let (low, high) = target.bounds;
    let cost = move |x: &DVector<f64>| {
        let inside = x[0].clamp(low, high);
        // A rollout that fails is the worst there is; none does inside the range.
        let squares = (target.roll)(inside).map_or(f64::MAX, |rolled| target.squares(&rolled));
        if let Ok(mut record) = record.lock() {
            record.push((squares, inside));
        }
        squares + OUTSIDE * (x[0] - inside).abs()
    };
    let mut start = vec![0.0; dimensions];
    start[0] = target.proposed;
    let mut search = CMAESOptions::new(start, SPREAD)
        .population_size(POPULATION)
        .max_function_evals(most)
        .seed(target.seed)
        .build(cost)
        .map_err(|e| anyhow::anyhow!("CMA-ES cannot begin: {e:?}"))?;
    while tried.lock().ok().context("CMA-ES's record")?.len() < most {
        if search.next().is_some() {
            break;
        }
    }
    let tried = tried.lock().ok().context("CMA-ES's record")?;
    let mut course = vec![target.proposed];
    let mut best = (f64::INFINITY, target.proposed);
    for k in 0..most {
        // What it leaves of its budget changes nothing.
        if let Some(one) = tried.get(k).filter(|one| one.0 < best.0) {
            best = *one;
        }
        course.push(best.1);
    }
    Ok(course)
}
