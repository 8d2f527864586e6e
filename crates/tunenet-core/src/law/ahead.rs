//! Held-out recordings of a law, of which only initial states are fitted: predictive tests (Chow 1960) of their size, of the constants that
//! they ask for, and of a force that is left, with the uncertainty of the law's constants counted in.

use nalgebra::{DMatrix, DVector};

use super::colour::Colour;
use super::evidence::{Shared, residual_force};
use super::gates::Gates;
use super::information::{said, scaled};
use super::outliers::Outliers;
use super::price::WIDER;
use super::refit::{Law, Session, independent, robust_squares};
use super::response::{Fitted, Response, inverse_root, root};
use crate::Result;
use crate::estimate::{Fit, GROWING_SHARES, Linearisation, Point, Problem, RolloutLog, residual_gap};
use crate::simulator::{Prepared, Simulator};
use crate::statistics::{upper_chi_squared, upper_f};

/// A start from another law's is searched anew where it leaves more than so many times the noise's variance.
const MUCH: f64 = 1.1;

/// Residuals that are smaller than so improbably small ones are not those of noise.
const CREDIBLE: f64 = 1.0 - 1e-3;
/// Rollouts are linear in the constants as long as the uncertainty of these explains at most so many times what noise leaves.
const LINEAR: f64 = 1.0;

/// Recordings that were kept out of the fit, and what was learned of them with a first law.
pub(super) struct Ahead<'a> {
    recordings: &'a [Prepared],
    noise: &'a [Vec<f64>],
    colour: Colour,
    /// The error of the base model, over the noise and as a gap.
    base: Option<(f64, f64)>,
    /// Initial states, and the answer to an acceleration.
    starts: Option<Vec<Vec<f64>>>,
    response: Option<Response>,
    /// The outliers that it leaves: densities of several laws are compared without the same samples.
    outliers: Option<Outliers>,
    /// The noise that it leaves: densities of several laws are compared with the same noise.
    scale: Option<f64>,
}

/// Held-out recordings with their initial states fitted.
struct Met {
    starts: Vec<Vec<f64>>,
    residuals: Vec<Vec<f64>>,
}

impl<'a> Ahead<'a> {
    pub fn new(recordings: &'a [Prepared], noise: &'a [Vec<f64>], colour: Colour) -> Self {
        Self { recordings, noise, colour, base: None, starts: None, response: None, outliers: None, scale: None }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.recordings.is_empty()
    }

    /// Measures what a law leaves of them.
    pub fn judge(&mut self, session: &Session, response: &Response, law: &Law, gates: &mut Gates) -> Result<()> {
        if self.is_empty() {
            return Ok(());
        }
        gates.held_out_ratio = Some(f64::INFINITY);
        let simulator = session.carrying(response, &law.terms, &law.numbers())?;
        let parameters = &law.fit.point.parameters;
        let met = self.met(simulator.as_ref(), parameters, session.log);
        let (base, base_gap) = self.base(session, met.as_ref())?;
        gates.held_out_base = Some(base);
        let Some(met) = met else { return Ok(()) };
        gates.held_out_gap = Some((base_gap, residual_gap(self.recordings, self.noise, &met.residuals)));
        gates.held_out_ratio = Some(self.rms(&met));
        let free: Vec<usize> = session.free.iter().copied().chain(law.first..parameters.len()).collect();
        let point = Point { parameters: parameters.clone(), nuisances: met.starts.clone() };
        let problem = Problem {
            simulator: simulator.as_ref(),
            recordings: self.recordings,
            noise: self.noise,
            free: &free,
            log: None,
        };
        let linear = problem.derivatives(&point, &met.residuals)?;
        session.log.add(linear.rollouts());
        // The noise is what the law leaves of the recordings that it was fitted to: more certain than what differences show.
        let (scale, below, above) = (session.scale(law), session.freedom(law), self.freedom(&met));
        let outliers = self.outliers.get_or_insert_with(|| Outliers::of(&met.residuals, session.width()));
        let residuals = scaled(&outliers.replaced(&met.residuals), scale);
        let covariance = &law.fit.covariance * (WIDER * WIDER);
        let asked = differ(&linear, &residuals, &covariance);
        gates.held_out_differ_p = Some(asked.p);
        let left = robust_squares(&residuals) - asked.explained;
        let p = upper_f(left / above, above, below);
        gates.held_out_p = Some(p);
        gates.held_out_left = Some((left / above).max(0.0).sqrt());
        // Where the constants' uncertainty explains more than noise leaves, rollouts are not linear in them, and the density is not known.
        let common = scale / *self.scale.get_or_insert(scale);
        gates.held_out_nats =
            is_linear(p, asked.explained, left).then(|| -0.5 * (left * common * common + asked.spread));
        if self.response.is_none() {
            let numbers = law.numbers();
            let carried = session.carried(response, &law.terms, &numbers);
            let fit = (&point, met.residuals.as_slice());
            let all = Fitted::each(self.recordings, self.noise, fit, (&carried, &numbers));
            self.response = Some(Response::measure(session.host, &all, &linear.of(&[]), session.log)?);
        }
        self.starts.get_or_insert(met.starts);
        if let Some(known) = &self.response {
            gates.held_out_force_nats =
                Some(residual_force(known, &residuals, linear.columns(), Shared::Known(&covariance)));
        }
        Ok(())
    }

    /// The error of the base model, over the noise and as a gap, with initial states from those of a law, which lie nearer to the true ones
    /// than guesses do.
    fn base(&mut self, session: &Session, law: Option<&Met>) -> Result<(f64, f64)> {
        if let Some(known) = self.base {
            return Ok(known);
        }
        let simulator = session.host.carrying(&[])?;
        let parameters = &session.base.point.parameters;
        let near = law.map(|law| Point { parameters: parameters.clone(), nuisances: law.starts.clone() });
        let fitted = near.and_then(|start| {
            let problem = Problem {
                simulator: simulator.as_ref(),
                recordings: self.recordings,
                noise: self.noise,
                free: &[],
                log: Some(session.log),
            };
            let fit = problem.fit(start, 1.0).ok()?;
            Some(Met { starts: fit.point.nuisances, residuals: fit.residuals })
        });
        let met = fitted.or_else(|| self.met(simulator.as_ref(), parameters, session.log));
        let gap = |met: &Met| residual_gap(self.recordings, self.noise, &met.residuals);
        let base = met.map_or((f64::INFINITY, f64::INFINITY), |met| (self.rms(&met), gap(&met)));
        self.base = Some(base);
        Ok(base)
    }

    /// Fits the initial states, each recording on its own; nothing where the simulator refuses.
    fn met(&self, simulator: &dyn Simulator, parameters: &[f64], log: &RolloutLog) -> Option<Met> {
        let (mut starts, mut residuals) = (Vec::new(), Vec::new());
        for (d, (recording, noise)) in self.recordings.iter().zip(self.noise).enumerate() {
            let (recordings, noise) = (std::slice::from_ref(recording), std::slice::from_ref(noise));
            let own = RolloutLog::default();
            let problem = Problem { simulator, recordings, noise, free: &[], log: Some(&own) };
            let start = || Point { parameters: parameters.to_vec(), ..Point::start(simulator, recordings) };
            // Laws that explain the recordings as well as a first one start where it does.
            let near = self.starts.as_ref().and_then(|all| {
                problem.fit(Point { parameters: parameters.to_vec(), nuisances: vec![all[d].clone()] }, 1.0).ok()
            });
            let is_poor =
                |fit: &Fit| robust_squares(&fit.residuals) > MUCH * independent(&fit.residuals, self.colour) as f64;
            let mut found: Vec<Fit> = near.into_iter().collect();
            if found.iter().all(is_poor) {
                found.extend(problem.fit(start(), 1.0).ok());
            }
            if found.iter().all(is_poor) {
                // A start that is guessed badly is found from the first samples on.
                let longer = |point: Point, horizon: &f64| Some(problem.fit(point, *horizon).ok()?.point);
                let grown = GROWING_SHARES.iter().try_fold(start(), longer);
                found.extend(grown.and_then(|point| problem.fit(point, 1.0).ok()));
            }
            let left = |fit: &Fit| robust_squares(&fit.residuals);
            let fit = found.into_iter().min_by(|a, b| left(a).total_cmp(&left(b)));
            log.add(own.count());
            let fit = fit?;
            starts.extend(fit.point.nuisances);
            residuals.extend(fit.residuals);
        }
        Some(Met { starts, residuals })
    }

    /// How many values there are beyond the initial states.
    fn freedom(&self, met: &Met) -> f64 {
        let own: usize = self.recordings.iter().map(|r| r.nuisances.len()).sum();
        independent(&met.residuals, self.colour).saturating_sub(own).max(1) as f64
    }

    /// The root mean square of the residuals in units of the noise.
    fn rms(&self, met: &Met) -> f64 {
        (met.residuals.iter().flatten().map(|r| r * r).sum::<f64>() / self.freedom(met)).sqrt()
    }
}

/// Whether a law's constants may be taken to act linearly on held-out recordings: what their uncertainty explains of the squares is not most
/// of them, and what is left is not less than noise would be (with this probability of as much or more by chance).
fn is_linear(p: f64, explained: f64, left: f64) -> bool {
    p < CREDIBLE && explained <= LINEAR * left
}

/// What recordings that were not fitted ask of the constants of a law.
struct Asked {
    /// The probability that they ask for so different constants by chance.
    p: f64,
    /// The squares that the uncertainty of the constants explains.
    explained: f64,
    /// By how much that uncertainty spreads the prediction: ln det(1 + Σ S).
    spread: f64,
}

/// The slope s of held-out residuals by the constants has the covariance S + S Σ S, where S is their information and Σ the constants'
/// covariance; of the squares sᵀ (Σ⁻¹ + S)⁻¹ s are due to it.
fn differ(linear: &Linearisation, residuals: &[Vec<f64>], covariance: &DMatrix<f64>) -> Asked {
    let shared = covariance.nrows();
    let (mut information, mut slope) = (DMatrix::zeros(shared, shared), DVector::zeros(shared));
    for (columns, residual) in linear.columns().iter().zip(residuals) {
        let (more, by) = said(columns, residual);
        information += more;
        slope += by;
    }
    let spread = &information + &information * covariance * &information;
    let inverse = inverse_root(&spread);
    let p = match inverse.ncols() {
        0 => 1.0,
        freedom => upper_chi_squared((inverse.transpose() * &slope).norm_squared(), freedom as f64),
    };
    let root = root(covariance);
    let own = DMatrix::identity(shared, shared) + root.transpose() * &information * &root;
    let along = inverse_root(&own).transpose() * (root.transpose() * slope);
    let spread = own.symmetric_eigenvalues().iter().map(|value| value.max(1.0).ln()).sum();
    Asked { p, explained: along.norm_squared(), spread }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::jacobian::Columns;

    #[test]
    fn constants_are_not_linear_where_they_explain_most_or_leave_less_than_noise() {
        assert!(is_linear(0.5, 30.0, 400.0) && is_linear(1e-6, 400.0, 400.0));
        assert!(!is_linear(0.5, 401.0, 400.0) && !is_linear(0.9999, 30.0, 100.0));
    }

    /// One constant with derivative 1 at four samples, known to ±½: S = 4, Σ = ¼. Residuals of 1 have s = ∓4 of variance 8, so χ² = 2,
    /// and 16/(4 + 4) = 2 of their squares are explained; the prediction's determinant is 1 + 4/4 = 2.
    #[test]
    fn the_uncertainty_of_a_constant_explains_its_share() {
        let columns = Columns { indices: vec![0], shared: vec![vec![-1.0; 4]], nuisances: vec![] };
        let linear = Linearisation::known(vec![columns]);
        let asked = differ(&linear, &[vec![1.0; 4]], &DMatrix::from_element(1, 1, 0.25));
        assert!((asked.p - upper_chi_squared(2.0, 1.0)).abs() < 1e-12, "{}", asked.p);
        assert!((asked.explained - 2.0).abs() < 1e-12, "{}", asked.explained);
        assert!((asked.spread - 2.0_f64.ln()).abs() < 1e-12, "{}", asked.spread);
    }
}
