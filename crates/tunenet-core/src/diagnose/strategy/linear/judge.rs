//! Whether what is left is noise; where it is not, whether it is little beside what the effects took away.

use super::choose::Chosen;
use super::fit::Fitted;
use super::logs::{Logs, Run};
use crate::Result;
use crate::diagnose::Test;
use crate::statistics::upper_chi_squared;

/// How far the residual may exceed the noise, as in tuning: the noise is an estimate.
const MARGIN: f64 = 0.1;
const LUCK: f64 = 6.0;
/// The portmanteau test fails only below this probability, and beyond this ratio: enough real data fail every test.
const PROBABLE: f64 = 1e-4;
const PORTMANTEAU: f64 = 1.15;
const LAGS: usize = 10;
/// Of what exceeds noise, effects have to take away this share (of squares), seen and unseen alike, to be named although
/// something is left ...
const TAKEN: f64 = 0.35;
/// ... and each of them this share of what was there without it.
const EACH: f64 = 0.1;

/// How the rest was judged.
pub(super) struct Judged {
    pub tests: Vec<Test>,
    pub adequate: bool,
    /// Whether the effects stand although something is left.
    pub practical: bool,
}

impl Logs<'_> {
    /// Residuals in units of the noise.
    pub fn in_noise(&self, run: &Run, point: &[Vec<f64>]) -> Result<Vec<f64>> {
        let mut plain = self.plain(run, &point.to_vec())?;
        plain.iter_mut().enumerate().for_each(|(i, r)| *r /= run.noise[i % run.width()]);
        Ok(plain)
    }

    /// Root mean square in the channels' unit, a sample of several channels counted once, of the runs that are (not) held out.
    pub fn rmse(&self, point: &[Vec<f64>], held_out: bool) -> Result<Option<f64>> {
        let (mut squares, mut samples) = (0.0, 0);
        for run in self.runs.iter().filter(|r| r.held_out == held_out) {
            squares += self.plain(run, &point.to_vec())?.iter().map(|r| r * r).sum::<f64>();
            samples += run.prepared.seen.len();
        }
        Ok((samples > 0).then(|| (squares / samples as f64).sqrt()))
    }

    /// The same of noise alone.
    pub fn noise_floor(&self, held_out: bool) -> f64 {
        let (mut squares, mut samples) = (0.0, 0);
        for run in self.runs.iter().filter(|r| r.held_out == held_out) {
            squares += run.prepared.seen.len() as f64 * run.noise.iter().map(|n| n * n).sum::<f64>();
            samples += run.prepared.seen.len();
        }
        (squares / f64::from(u32::try_from(samples).unwrap_or(u32::MAX)).max(1.0)).sqrt()
    }

    /// Tests of what `fit` leaves; all have to pass.
    fn adequacy(&self, fit: &Fitted) -> Result<Vec<Test>> {
        let (mut worst, mut limit) = (0.0f64, 1.0 + MARGIN);
        let (mut q, mut freedom) = (0.0, 0.0);
        for run in self.fitted() {
            let residuals = self.in_noise(run, &fit.point)?;
            let (width, samples) = (run.width(), run.prepared.seen.len());
            let unknowns = fit.active.len() as f64 / (self.fitted().count() * width) as f64;
            for channel in 0..width {
                let column: Vec<f64> = residuals.iter().skip(channel).step_by(width).copied().collect();
                let square: f64 = column.iter().map(|r| r * r).sum();
                let ratio = (square / (samples as f64 - unknowns).max(1.0)).sqrt();
                let most = 1.0 + MARGIN + LUCK / (2.0 * samples as f64).sqrt();
                if ratio / most > worst / limit {
                    (worst, limit) = (ratio, most);
                }
                let n = samples as f64;
                let mean = column.iter().sum::<f64>() / n;
                let spread: f64 = column.iter().map(|r| (r - mean).powi(2)).sum();
                for lag in 1..=LAGS.min(samples / 5) {
                    let product: f64 = column[lag..].iter().zip(&column).map(|(a, b)| (a - mean) * (b - mean)).sum();
                    let rho = if spread > 0.0 { product / spread } else { 0.0 };
                    q += n * (n + 2.0) / (n - lag as f64) * rho * rho;
                    freedom += 1.0;
                }
            }
        }
        // Each fitted number takes about one degree of freedom.
        let freedom = f64::max(freedom, 1.0);
        let probable = upper_chi_squared(q, freedom) >= PROBABLE;
        let value = q / freedom;
        Ok(vec![
            Test { name: "residual over noise", value: worst, threshold: limit, passed: worst <= limit },
            Test {
                name: "correlation from sample to sample",
                value,
                threshold: PORTMANTEAU,
                passed: probable || value <= PORTMANTEAU,
            },
        ])
    }

    pub fn judge(&self, chosen: &Chosen) -> Result<Judged> {
        let mut tests = self.adequacy(&chosen.best)?;
        let adequate = tests.iter().all(|t| t.passed);
        if adequate || chosen.effects.is_empty() {
            return Ok(Judged { tests, adequate, practical: false });
        }
        let mut practical = Vec::new();
        for (held_out, name) in [(false, "taken away of what exceeds noise"), (true, "the same, unseen")] {
            let (before, after) = (self.rmse(&chosen.base.point, held_out)?, self.rmse(&chosen.best.point, held_out)?);
            let (Some(before), Some(after)) = (before, after) else { continue };
            let floor = self.noise_floor(held_out);
            let value = (before * before - after * after) / (before * before - floor * floor).max(f64::MIN_POSITIVE);
            // As a test that passes below its threshold: what is left of it.
            practical.push(Test { name, value: 1.0 - value, threshold: 1.0 - TAKEN, passed: value >= TAKEN });
        }
        for stood in &chosen.effects {
            let without = super::choose::without(self, &chosen.best, &[stood.entry])?;
            let left = chosen.best.square / without.square.max(f64::MIN_POSITIVE);
            let name = "left of the squares by each effect";
            practical.push(Test { name, value: left, threshold: 1.0 - EACH, passed: left <= 1.0 - EACH });
        }
        let practical_passed = practical.iter().all(|t| t.passed);
        tests.extend(practical);
        Ok(Judged { tests, adequate, practical: practical_passed })
    }
}
