//! Cost of each unknown parameter of a ball at the hoop: plans of a planner that knows every parameter except that one.

use anyhow::Result;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tunenet_sim::shot::Rule;

use super::ball::ShotBall;
use super::estimate::{BallEstimate, known};
use super::share::Share;
use super::trial::{Planner, ShotTarget};
use super::world::shoot;

/// Shots of each plan: enough for a standard error below 0.01.
pub const SHOTS: u64 = 2000;

/// What a planner does not know, though it knows all else.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Lacking {
    Nothing,
    /// That the plane rubs.
    Friction,
    /// That air drags; the restitution is what an undisturbed drop shows of this ball in a vacuum.
    Drag,
    /// Standard deviation of the random deflection of a rebound.
    Scatter,
    /// All three: what is left is the restitution that an undisturbed drop shows.
    All,
}

impl Lacking {
    pub const EACH: [Self; 5] = [Self::Nothing, Self::Friction, Self::Drag, Self::Scatter, Self::All];

    pub fn words(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Friction => "friction",
            Self::Drag => "drag",
            Self::Scatter => "scatter",
            Self::All => "all three",
        }
    }

    fn hides(self, effect: &str) -> bool {
        let drag = effect == "quadratic_drag";
        match self {
            Self::Nothing => false,
            Self::Friction => effect == "bounce_friction",
            Self::Drag => drag,
            Self::Scatter => effect == "bounce_scatter",
            Self::All => true,
        }
    }

    /// Physical bounds of a ball of which an undisturbed drop shows this restitution.
    fn estimate(self, ball: &ShotBall, shown: f64) -> BallEstimate {
        let mut all = known(ball);
        all.effects.retain(|(name, _)| !self.hides(name));
        if self.hides("quadratic_drag") {
            all.restitution = (shown, (shown, shown));
        }
        all
    }
}

/// A plan, and how often it goes in.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct LackingCost {
    pub lacking: Lacking,
    pub height_m: f64,
    pub goes_in: f64,
}

impl LackingCost {
    pub fn share(self) -> Share {
        Share { value: self.goes_in, count: usize::try_from(SHOTS).unwrap_or(usize::MAX) }
    }
}

/// Plans and shoots. `random_stream` draws what happens to a shot of this number, the same for every plan.
pub fn costs(
    target: &ShotTarget,
    planner: &Planner,
    random_stream: &(dyn Fn(u64) -> ChaCha8Rng + Sync),
) -> Result<Vec<LackingCost>> {
    let ball = &target.ball;
    Lacking::EACH
        .into_iter()
        .map(|lacking| {
            let height_m = match lacking {
                Lacking::Nothing => target.known_m,
                _ => planner.height(&lacking.estimate(ball, target.shown), Rule::Probability)?,
            };
            let one = |n: u64| {
                let mut random = random_stream(n);
                let spin = ball.spin(&mut random);
                shoot(ball, height_m, spin, &mut random).goes_in
            };
            let hits = (0..SHOTS).into_par_iter().filter(|n| one(*n)).count();
            Ok(LackingCost { lacking, height_m, goes_in: hits as f64 / SHOTS as f64 })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    /// Of a ball without friction, drag and scatter nothing is lost by not knowing them; friction that nobody knows of brings
    /// the ball down short, so that who does not know of it lets go lower.
    #[test]
    fn only_what_is_there_costs() {
        let planner = Planner::new().unwrap();
        let smooth =
            ShotBall { friction: 0.0, drag_1_m: 1e-9, scatter_rad: 0.0, ..super::super::ball::FIXED[0].clone() };
        let rough = ShotBall { friction: 0.04, ..smooth.clone() };
        let random_stream = |n: u64| ChaCha8Rng::seed_from_u64(n);
        let of = |ball: ShotBall| {
            let shown = ball.restitution;
            costs(&ShotTarget::new(ball, shown, &planner).unwrap(), &planner, &random_stream).unwrap()
        };
        let (smooth, rough) = (of(smooth), of(rough));
        let height = smooth[0].height_m;
        assert!(smooth.iter().all(|c| c.goes_in == 1.0 && (c.height_m - height).abs() < 0.011), "{smooth:?}");
        let low = rough.iter().find(|c| c.lacking == Lacking::Friction).unwrap().height_m;
        assert!(rough[0].height_m > low + 0.015 && (low - height).abs() < 0.011, "{rough:?}");
    }
}
