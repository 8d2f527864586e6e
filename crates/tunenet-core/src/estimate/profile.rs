//! Profile likelihood of one parameter (Venzon and Moolgavkar 1988): the misfit over its values, everything else fitted again.

use super::interval::{ScaleEstimate, fit_with_fixed};
use super::output_error::{Fit, Problem};

/// Values on either side of the best.
const STEPS: u32 = 12;

/// A profile likelihood.
///
/// The misfit is twice the robust cost above its least, divided by the variance of the residuals and by what their
/// correlation widens it: 0 at the best value, and near it the squared distance in standard deviations.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Position of the parameter among the simulator's.
    pub parameter: usize,
    /// `(value, misfit)`, values rising.
    pub curve: Vec<(f64, f64)>,
    /// The misfit that the 50 % interval is cut at: the squared quantile of Student's t.
    pub cut50: f64,
    /// The misfit that the 95 % interval is cut at.
    pub cut95: f64,
}

impl Profile {
    /// The values whose misfit is at most `cut`, as the stretch around the best one; it ends where the curve ends at the
    /// latest.
    #[must_use]
    pub fn inside(&self, cut: f64) -> (f64, f64) {
        let best = self.curve.iter().enumerate().min_by(|a, b| a.1.1.total_cmp(&b.1.1)).map_or(0, |(i, _)| i);
        let edge = |path: &mut dyn Iterator<Item = &(f64, f64)>| {
            let mut before: Option<(f64, f64)> = None;
            for &(value, misfit) in path {
                if let (Some((near, low)), true) = (before, misfit > cut) {
                    // The root of the misfit is straight where the likelihood is normal.
                    let share = (cut.sqrt() - low.sqrt()) / (misfit.sqrt() - low.sqrt());
                    return near + share * (value - near);
                }
                before = Some((value, misfit));
            }
            before.map_or(f64::NAN, |(value, _)| value)
        };
        (edge(&mut self.curve[..=best].iter().rev()), edge(&mut self.curve[best..].iter()))
    }
}

/// The profile of the free parameter number `i` over `range` (cut to its bounds, and to where the simulator refuses) around
/// `fit`, and the rollouts it took.
#[must_use]
pub fn profile(problem: &Problem, fit: &Fit, scale: &ScaleEstimate, i: usize, range: (f64, f64)) -> (Profile, usize) {
    let position = problem.free[i];
    let p = &problem.simulator.parameters()[position];
    let best = fit.point.parameters[position];
    let (mut costs, mut rollouts) = (vec![(best, fit.cost)], 0);
    for end in [range.0.max(p.min).min(best), range.1.min(p.max).max(best)] {
        if end == best {
            continue;
        }
        let mut point = fit.point.clone();
        for step in 1..=STEPS {
            point.parameters[position] = best + (end - best) * f64::from(step) / f64::from(STEPS);
            // The curve ends where the simulator refuses.
            let Ok(there) = fit_with_fixed(problem, point, &[position], scale) else { break };
            rollouts += there.rollouts;
            costs.push((there.point.parameters[position], there.cost));
            point = there.point;
        }
    }
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let least = costs.iter().map(|c| c.1).fold(f64::INFINITY, f64::min);
    let curve = costs.into_iter().map(|(value, cost)| (value, scale.excess(cost - least))).collect();
    (Profile { parameter: position, curve, cut50: cut(scale, 0.5), cut95: cut(scale, 0.95) }, rollouts)
}

fn cut(scale: &ScaleEstimate, level: f64) -> f64 {
    scale.one_sided(0.5 + level / 2.0).powi(2)
}

#[cfg(test)]
mod tests {
    use super::Profile;

    #[test]
    fn a_parabola_is_cut_at_its_closed_form() {
        // misfit ((v − 2) / 0.5)²: cut at 4 it holds 1 to 3.
        let curve = (0..=20).map(|i| 0.2 * f64::from(i)).map(|v| (v, ((v - 2.0) / 0.5).powi(2))).collect();
        let profile = Profile { parameter: 0, curve, cut50: 0.45, cut95: 4.0 };
        let (low, high) = profile.inside(profile.cut95);
        assert!((low - 1.0).abs() < 1e-12 && (high - 3.0).abs() < 1e-12, "{low} {high}");
        let (low, high) = profile.inside(1e9);
        assert!(low == 0.0 && high == 4.0, "open on both sides: {low} {high}");
    }
}
