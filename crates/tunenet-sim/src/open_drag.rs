//! The drag that recordings leave open: air brakes every ball, at any strength that they do not exclude.
//!
//! A diagnosis names an effect where there is evidence for it. To plan with, absence of evidence is not enough: a weak drag
//! that a few bounces cannot show still makes a shot fall short, and a restitution that was tuned without drag hides a part
//! of it. So everything is tuned again for each of a few strengths, and each counts by how well it then fits.

use tunenet_core::observation::Observation;
use tunenet_core::simulator::Simulator;
use tunenet_core::tune::{FixedValueFit, fit_at_fixed_values};
use tunenet_formats::Result;

use crate::SimulationFile;
use crate::ball::effects::{BallEffect, DRAG};
use crate::observed::simulator;
use crate::process::Session;
use crate::simulation_file::Domain;

/// Strengths that are tried in addition to zero, evenly in their logarithm.
const STRENGTHS: usize = 9;
/// One that counts less than this is left out.
const LEAST: f64 = 1e-3;
/// Its coefficient, as a parameter.
const NAME: &str = "quadratic_drag.c_1_m";

/// Every strength of drag (1/m) that is usual for a ball like that of `file`, whose values were tuned to `seen`, with how much
/// `seen` leaves of it; the coefficients of the physical effects `sure`, which the file holds, are fitted again with it like
/// its parameters. Empty for what is no ball in air, where the file holds drag already, and where no drag fits best by far.
///
/// # Errors
/// As [`simulator`] and [`fit_at_fixed_values`].
pub fn possible(file: &SimulationFile, sure: &[&str], seen: &[Observation]) -> Result<Vec<FixedValueFit>> {
    let there = file.effects().iter().any(|e| e.name == DRAG);
    if there || seen.is_empty() || file.domain() != Domain::Ball {
        return Ok(Vec::new());
    }
    let Some((low, high)) = file.ball()?.body().usual_drag_1_m() else { return Ok(Vec::new()) };
    let physical = sure.iter().copied().filter(|name| BallEffect::find(name).is_some());
    let names: Vec<&str> = physical.chain([DRAG]).collect();
    let ball = simulator(file, seen[0].kind(), &Session::default())?.with_effects(&names)?;
    let share = |i: usize| i as f64 / (STRENGTHS - 1) as f64;
    let coarse: Vec<f64> =
        std::iter::once(0.0).chain((0..STRENGTHS).map(|i| low * (high / low).powf(share(i)))).collect();
    let mut found = fit_at_fixed_values(&ball, seen, NAME, &coarse)?;
    let counts = |h: &FixedValueFit| h.share > LEAST;
    let (Some(first), Some(last)) = (found.iter().position(counts), found.iter().rposition(counts)) else {
        return Ok(Vec::new());
    };
    // Where few strengths are left, as many again between their neighbours.
    if 2 * (last - first + 1) <= STRENGTHS {
        let (from, to) = (coarse[first.saturating_sub(1)], coarse[(last + 1).min(STRENGTHS)]);
        let finer: Vec<f64> = (0..=STRENGTHS).map(|i| from + (to - from) * i as f64 / STRENGTHS as f64).collect();
        found = fit_at_fixed_values(&ball, seen, NAME, &finer)?;
    }
    found.retain(counts);
    let total: f64 = found.iter().map(|h| h.share).sum();
    for one in &mut found {
        one.share /= total;
    }
    Ok(if found.iter().all(|h| h.value == 0.0) { Vec::new() } else { found })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const G: f64 = 9.81;

    fn file(more: &str) -> SimulationFile {
        let text = format!(
            "kind = \"ball\"\nball.radius_m = 0.03\nrelease.height_m = 0.6\nworld.gravity_m_s2 = {G}\n{more}\
             [parameters.restitution]\nvalue = 0.7\nmin = 0.0\nmax = 1.0\n"
        );
        SimulationFile::parse(Path::new("ball.toml"), &text).unwrap()
    }

    /// When a ball of restitution `e` bounces in air of drag `c`: falls and rises against it have closed forms (tanh, tan).
    fn bounces(e: f64, c: f64, count: usize) -> Observation {
        let (terminal, fall) = ((G / c).sqrt(), 0.6_f64);
        let mut speed = terminal * (1.0 - (-2.0 * c * fall).exp()).sqrt();
        let mut now = (c * fall).exp().acosh() / (G * c).sqrt();
        let mut times = Vec::new();
        for _ in 0..count {
            times.push(now);
            let up = e * speed;
            let height = (1.0 + (up / terminal).powi(2)).ln() / (2.0 * c);
            now += (up / terminal).atan() / (G * c).sqrt() + (c * height).exp().acosh() / (G * c).sqrt();
            speed = terminal * (1.0 - (-2.0 * c * height).exp()).sqrt();
        }
        tunenet_ball::bounce_times(times).unwrap()
    }

    /// The true strength has the greatest share, and the restitution tuned with it is the true one; what drag costs is no longer
    /// taken for a softer ball.
    #[test]
    fn many_bounces_leave_the_true_drag_and_the_true_restitution() {
        for (e, c) in [(0.8, 0.05), (0.7, 0.1)] {
            let found = possible(&file(""), &[], &[bounces(e, c, 9)]).unwrap();
            let total: f64 = found.iter().map(|p| p.share).sum();
            let mean = found.iter().map(|p| p.share * p.value).sum::<f64>();
            let rebound = found.iter().map(|p| p.share * p.fitted[0].1).sum::<f64>();
            assert!((total - 1.0).abs() < 1e-9 && (mean / c - 1.0).abs() < 0.1, "{e} {c}: {found:?}");
            assert!((rebound - e).abs() < 2e-3, "{e} {c}: {rebound}");
        }
    }

    #[test]
    fn few_bounces_exclude_little() {
        let shaken: Vec<f64> =
            bounces(0.75, 0.03, 3).clock().iter().zip([0.004, -0.004, 0.004]).map(|(t, d)| t + d).collect();
        let found = possible(&file(""), &[], &[tunenet_ball::bounce_times(shaken).unwrap()]).unwrap();
        assert!(found.len() >= 5 && found.iter().all(|p| p.share < 0.6), "{found:?}");
    }

    #[test]
    fn none_where_there_is_no_air_or_drag_is_known() {
        let seen = [bounces(0.8, 0.05, 5)];
        assert!(possible(&file("world.medium = \"other\"\n"), &[], &seen).unwrap().is_empty());
        assert!(possible(&file("effects.quadratic_drag.c_1_m = 0.05\n"), &[], &seen).unwrap().is_empty());
        // A ball in a world without air shows that it has none.
        assert!(possible(&file(""), &[], &[bounces(0.8, 1e-9, 9)]).unwrap().is_empty());
        assert!(possible(&file(""), &[], &[]).unwrap().is_empty());
    }
}
