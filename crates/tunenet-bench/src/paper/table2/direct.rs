//! Direct prediction: the paper's network, whose proposed side never changes. All that it can learn is the target's
//! restitution; it is asked once.

use anyhow::Result;
use rayon::prelude::*;
use tunenet_core::network::{
    Course, CoveredParameter, DatasetHeader, Model, Pair, Preset, Side, TrainOptions, train_on,
};
use tunenet_core::observation::{Channel, Observation};
use tunenet_core::simulator::Simulator;

use super::super::super::tuning::rows::Conditions;
use super::super::super::tuning::targets::{DropTarget, Simulation};
use crate::scene::{EASY, PAPER_RADIUS_M};

/// As many drops to learn from as the paper has pairs.
const LESSONS: u64 = 800;
/// Their draws are none of the targets'.
const LESSONS_STREAM: u64 = 0x2ff;
/// What is proposed throughout: the middle of training, in the middle of its heights.
const PROPOSED: f64 = 0.5;
const PROPOSED_FALL_M: f64 = 4.0;
const CONDITIONS: Conditions = Conditions { restitution: EASY, noise_m: 0.0 };

/// A trained network, and what it is always shown.
pub struct Direct {
    model: Model,
    proposed: Observation,
}

impl Direct {
    /// Learns from drops of the paper's training range. The same seed gives the same network.
    pub fn train(simulation: &Simulation, mut preset: Preset, seed: u64, quick: bool) -> Result<Self> {
        let proposed = positions(simulation, &simulation.roll_on(&simulation.clock, PROPOSED_FALL_M, PROPOSED)?)?;
        let all = simulation.ball.parameters();
        let covered = |p: &tunenet_core::simulator::Parameter| CoveredParameter {
            name: p.name.clone(),
            unit: p.unit.clone(),
            min: CONDITIONS.restitution.0,
            max: CONDITIONS.restitution.1,
            tuned: p.tune,
        };
        let parameters =
            |restitution: f64| -> Vec<f64> { all.iter().map(|p| if p.tune { restitution } else { p.value }).collect() };
        let header = DatasetHeader {
            preset: "direct".into(),
            seed,
            pairs: LESSONS,
            parameters: all.iter().map(covered).collect(),
            channels: Channel::positions(),
            target_channels: Vec::new(),
            clock: simulation.clock.clone(),
            scene: String::new(),
        };
        let lesson = |i| -> Result<Pair> {
            let target = simulation.target(CONDITIONS, seed, LESSONS_STREAM, i)?;
            Ok(Pair {
                proposed_parameters: parameters(PROPOSED),
                target_parameters: parameters(target.restitution),
                own: Vec::new(),
                scale: None,
                proposed: proposed.values().to_vec(),
                target: target.prepared.seen.values().to_vec(),
                clock: Vec::new(),
            })
        };
        let lessons = (0..LESSONS).into_par_iter().map(lesson).collect::<Result<Vec<_>>>()?;
        if quick && let Course::Epochs { epochs } = &mut preset.course {
            *epochs /= 4;
        }
        let options = TrainOptions::new(preset, seed);
        Ok(Self { model: train_on(&header, &lessons, &options, &mut |_| true)?, proposed })
    }

    /// The restitution of `target`.
    pub fn estimate(&self, target: &DropTarget) -> Result<f64> {
        let [proposed, target] =
            [&self.proposed, &target.prepared.seen].map(|observation| Side { observation, scale: None });
        Ok(PROPOSED + self.model.estimate_batch(&[(proposed, target)])?[0][0])
    }
}

fn positions(simulation: &Simulation, heights_m: &[f64]) -> Result<Observation> {
    let rows: Vec<[f64; 3]> = heights_m.iter().map(|z| [0.0, 0.0, z + PAPER_RADIUS_M]).collect();
    Ok(Observation::positions(simulation.clock.clone(), &rows)?)
}
