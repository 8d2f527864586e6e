//! What simulates the recordings of one fit.

use anyhow::{Context, Result};
use tunenet_core::observation::Kind;
use tunenet_core::simulator::Simulator;
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{ObservedBall, Session, SimulationFile, observed};

use crate::args::Tune;
use crate::commands::load::Setups;

/// The simulator of recordings that `names` names; and the ball of every setup without measurement effects, where a ball
/// simulates them.
pub fn of(
    options: &Tune,
    setups: &Setups,
    kind: Kind,
    session: &Session,
    names: impl Fn() -> String,
) -> Result<(Box<dyn Simulator>, Vec<ObservedBall>)> {
    let domain = setups.common().domain();
    if domain != Domain::Ball || matches!(kind, Kind::Pixels | Kind::Joints) {
        let simulator = setups.simulator(kind, session);
        // What another one refuses is the simulation file's or the URDF's, and says so.
        let named = if domain == Domain::Ball { simulator.with_context(names)? } else { simulator? };
        return Ok((named, Vec::new()));
    }
    let ball = |file: &&SimulationFile| {
        let ball = ObservedBall::new(file, kind).with_context(&names)?;
        Ok(ball.forced(options.force).with_tuned_effects(file)?)
    };
    let files = setups.files();
    let balls = files.iter().map(ball).collect::<Result<Vec<_>>>()?;
    let each = files.iter().zip(&balls).map(|(file, ball)| observed::around(file, ball.clone()));
    let each = each.collect::<tunenet_formats::Result<_>>()?;
    Ok((observed::together(&files, each)?, balls))
}
