//! The ball between two contacts: no surface, and a start of its own.

use tunenet_ball::findings;
use tunenet_ball::{Arcs, BallSegmentation};
use tunenet_core::Result;
use tunenet_core::observation::{Kind, Note, Observation};
use tunenet_core::simulator::{Parameter, Preparation, Prepared};
use tunenet_core::statistics;

use super::{ObservedBall, start_nuisances};
use crate::scene::Release;

/// A surface so far below is none.
const NOWHERE_M: f64 = -1e6;

impl ObservedBall {
    /// The same ball without a surface. `None` where contacts are all that is observed of it.
    pub(super) fn flight_only(&self) -> Option<Self> {
        let release = Release::default();
        let nuisances = start_nuisances(&release, Some(NOWHERE_M));
        let surface_height_m = Some(NOWHERE_M);
        let ball = Self { release, nuisances, surface_height_m, flight_only: true, ..self.clone() };
        (self.kind == Kind::Positions).then_some(ball)
    }

    /// A piece of a recording without contacts: all of it counts.
    pub(super) fn prepare_flight(&self, seen: &Observation) -> Result<Preparation> {
        let Some(arcs) = Arcs::cut(seen, self.scene.gravity_m_s2) else { return Err(self.wrong_kind(seen)) };
        let mut prepared = Prepared::whole(seen.clone(), self.parameters.len());
        let range_m = (0..3).map(|axis| statistics::range(seen.column(axis))).fold(0.1, f64::max);
        let fastest =
            (2.0 * self.scene.gravity_m_s2 * range_m).sqrt() + arcs.start_m_s.iter().map(|v| v.abs()).sum::<f64>();
        let guesses =
            (0..3).map(|axis| (arcs.start_m[axis], range_m)).chain((0..3).map(|axis| (arcs.start_m_s[axis], fastest)));
        let nuisances = self.nuisances.iter().zip(guesses).map(|(nuisance, (value, half_width))| {
            let (name, unit) = nuisance.name();
            Parameter::new(name, unit, value, value - half_width, value + half_width)
        });
        prepared.nuisances = nuisances.collect::<Result<_>>()?;
        prepared.segmentation = BallSegmentation::shared(self.scene.gravity_m_s2);
        prepared.silent.fill(Some(Note::new(findings::CONTACT_NONE, "a flight does not depend on contacts", "")));
        Ok(Preparation::Usable(Box::new(prepared)))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use tunenet_core::observation::{Kind, Observation};
    use tunenet_core::simulator::{Preparation, Segmented, Simulator, rollout};

    use crate::{ObservedBall, SimulationFile};

    /// A throw that passes the height of the file's surface falls on.
    #[test]
    fn nothing_is_touched() {
        let text = "kind = \"ball\"\nball.radius_m = 0.1\nsurface.height_m = 0.0\nrelease.time_s = 0.0\n\
                    parameters.restitution = { value = 0.5, min = 0.0, max = 1.0 }\n";
        let file = SimulationFile::parse(Path::new("ball.toml"), text).unwrap();
        let ball = ObservedBall::new(&file, Kind::Positions).unwrap().free_segment().unwrap();
        let clock: Vec<f64> = (0..40).map(|i| 3.0 + f64::from(i) * 0.02).collect();
        let at = |t: f64| [0.2 * (t - 3.0), 1.0, 0.5 + 1.5 * (t - 3.0) - 4.905 * (t - 3.0).powi(2)];
        let rows: Vec<[f64; 3]> = clock.iter().map(|t| at(*t)).collect();
        assert!(rows[39][2] < -1.0);
        let seen = Observation::positions(clock.clone(), &rows).unwrap();
        let Preparation::Usable(prepared) = ball.prepare(&seen).unwrap() else { panic!("refused") };
        assert_eq!(prepared.seen.len(), 40);
        let guess = prepared.nuisance_values();
        let values = rollout(ball.as_ref(), &[0.5, 0.0], &guess, &clock).unwrap();
        assert!(values.iter().zip(rows.concat()).all(|(a, b)| (a - b).abs() < 1e-6), "{guess:?}");
    }
}
