//! Brent's bounded search for a minimum.

use anyhow::Result;

use super::{Course, Search};

/// Brent's bounded search (1973) on the sum of squares, told the range that the target was drawn from; the best so far.
pub fn search(target: &Search, most: usize) -> Result<Course> {
    let cost = |x: f64| -> Result<f64> { Ok(target.squares(&(target.roll)(x)?)) };
    let golden = 0.5 * (3.0 - 5f64.sqrt());
    let (mut low, mut high) = target.range;
    let mut x = low + golden * (high - low);
    let mut at_x = cost(x)?;
    let mut course = vec![target.proposed, x];
    // The second and third best, and the last two steps.
    let ((mut w, mut at_w), (mut v, mut at_v)) = ((x, at_x), (x, at_x));
    let (mut step, mut before) = (0.0_f64, 0.0_f64);
    while course.len() <= most {
        let middle = 0.5 * (low + high);
        let tolerance = 1e-8 * x.abs() + 1e-10;
        let r = (x - w) * (at_x - at_v);
        let q = (x - v) * (at_x - at_w);
        let (p, q) = ((x - v) * q - (x - w) * r, 2.0 * (q - r));
        let (p, q) = if q > 0.0 { (-p, q) } else { (p, -q) };
        let last = std::mem::replace(&mut before, step);
        // A parabola through the three best, where it falls inside and shrinks; else a golden section.
        if p.abs() < (0.5 * q * last).abs() && p > q * (low - x) && p < q * (high - x) {
            step = p / q;
        } else {
            before = if x < middle { high - x } else { low - x };
            step = golden * before;
        }
        if step.abs() < tolerance {
            step = tolerance.copysign(middle - x);
        }
        let u = (x + step).clamp(low, high);
        let at_u = cost(u)?;
        if at_u <= at_x {
            if u < x {
                high = x;
            } else {
                low = x;
            }
            ((v, at_v), (w, at_w), (x, at_x)) = ((w, at_w), (x, at_x), (u, at_u));
        } else {
            if u < x {
                low = u;
            } else {
                high = u;
            }
            if at_u <= at_w || w == x {
                ((v, at_v), (w, at_w)) = ((w, at_w), (u, at_u));
            } else if at_u <= at_v || v == x || v == w {
                (v, at_v) = (u, at_u);
            }
        }
        course.push(x);
    }
    Ok(course)
}
