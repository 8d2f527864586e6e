//! The drops that the table is measured on.

use std::path::Path;

use anyhow::Result;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tunenet_core::camera::Pinhole;
use tunenet_core::observation::Observation;
use tunenet_core::simulator::Prepared;
use tunenet_core::tune::Point;
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::LeftOpen;
use tunenet_sim::video_drops::VideoDrops;

use super::super::super::tuning::closed_form;
use crate::scene::{EASY, PAPER_BALL, PAPER_CENTRE_M, seeds};
use tunenet_video_protocol::synthetic::Places;

/// A ball that is released in front of a camera.
pub struct RecordedDrop {
    pub top_m: f64,
    pub restitution: f64,
    /// What an iteration starts from.
    pub proposed: f64,
    pub camera: Pinhole,
    /// Heights of the centre, m.
    pub heights_m: Vec<f64>,
}

/// The paper's ball, and what sees it.
pub struct Drops {
    pub video: VideoDrops,
}

impl Drops {
    pub fn new() -> Result<Self> {
        let mut file = SimulationFile::parse(Path::new("ball_easy.toml"), PAPER_BALL)?;
        file.leave_open(&[LeftOpen::ReleaseHeight]);
        Ok(Self { video: VideoDrops::new(&file)? })
    }

    /// Drop number `number` of a seed; each depends on these two alone. Its motion is the closed form's.
    pub fn draw(&self, seed: u64, number: u64) -> Result<RecordedDrop> {
        let mut random = ChaCha8Rng::seed_from_u64(seeds::TABLE3_DROPS ^ seed.rotate_left(32));
        random.set_stream(number);
        let (top_m, restitution) = (random.random_range(PAPER_CENTRE_M), random.random_range(EASY.0..=EASY.1));
        let proposed = random.random_range(EASY.0..=EASY.1);
        let camera = self.video.camera(top_m, &mut random)?;
        let radius = self.video.radius_m();
        let lowest = closed_form::ClosedFormDrop { fall_m: top_m - radius, restitution }.heights(self.video.clock());
        let heights_m = lowest.into_iter().map(|z| z + radius).collect();
        Ok(RecordedDrop { top_m, restitution, proposed, camera, heights_m })
    }

    /// Heights of the centre in our simulator, m.
    pub fn roll(&self, restitution: f64, top_m: f64) -> Result<Vec<f64>> {
        Ok(self.video.roll(restitution, top_m)?.into_iter().skip(2).step_by(3).collect())
    }

    /// The drop as a tuner sees its positions.
    pub fn positions(&self, drop: &RecordedDrop) -> Result<Prepared> {
        let rows: Vec<[f64; 3]> = drop.heights_m.iter().map(|z| [0.0, 0.0, *z]).collect();
        let seen = Observation::positions(self.video.clock().to_vec(), &rows)?;
        Ok(self.video.known(drop.top_m, seen)?)
    }

    /// The drop as a tuner sees its video.
    pub fn video(&self, drop: &RecordedDrop, track: &Places) -> Result<Prepared> {
        Ok(self.video.prepared(drop.top_m, track.u_px.iter().zip(&track.v_px).flat_map(|(u, v)| [*u, *v]).collect())?)
    }

    pub fn start(&self, drop: &RecordedDrop, prepared: &Prepared) -> Point {
        let mut point = Point::start(self.video.ball(), std::slice::from_ref(prepared));
        point.parameters[0] = drop.proposed;
        point
    }
}
