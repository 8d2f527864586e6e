//! Drops as a camera sees them: what networks for uncalibrated video learn from.
//!
//! The camera is the appendix's (arXiv 1907.11200): at a random place 5 to 10 m from the drop's foot and 5 to 8 m high,
//! aimed 2 m above the foot. The paper says nothing of its lens and its picture; here the field of view is 60°, the picture
//! 160 × 120. A camera that would lose the ball is drawn afresh.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use tunenet_core::camera::{LineCamera, Pinhole};
use tunenet_core::network::Pair;
use tunenet_core::observation::{Channel, Kind, Observation};
use tunenet_core::simulator::{Parameter, Prepared, Scale, Simulator, rollout};
use tunenet_core::{Error, Result};

use crate::{ObservedBall, SimulationFile};

const DISTANCE_M: std::ops::Range<f64> = 5.0..10.0;
const HEIGHT_M: std::ops::Range<f64> = 5.0..8.0;
const AIM_M: [f64; 3] = [0.0, 0.0, 2.0];
const FIELD_OF_VIEW_RAD: f64 = std::f64::consts::FRAC_PI_3;
const PICTURE_PX: (usize, usize) = (160, 120);
/// What a tracker leaves of a ball six pixels in radius.
const NOISE_PX: f64 = 0.25;
const MOST_DRAWS: usize = 1000;

/// Drops of one ball from rest, each from a height of its own, in front of an uncalibrated camera.
#[derive(Debug, Clone)]
pub struct VideoDrops {
    ball: ObservedBall,
    radius_m: f64,
    floor_m: f64,
    clock: Vec<f64>,
}

impl VideoDrops {
    /// Drops of `file`'s ball, which is released at the record's first instant; the file has to leave the height of release
    /// open.
    ///
    /// # Errors
    /// As [`ObservedBall::new`].
    pub fn new(file: &SimulationFile) -> tunenet_formats::Result<Self> {
        let scene = file.ball()?;
        Ok(Self {
            ball: ObservedBall::new(file, Kind::Positions)?,
            radius_m: scene.ball.radius_m,
            floor_m: scene.surface.height_m.unwrap_or(0.0),
            clock: file.record().clock(),
        })
    }

    /// The ball, seen as positions.
    #[must_use]
    pub fn ball(&self) -> &ObservedBall {
        &self.ball
    }

    /// The ball's radius, m.
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// The instants of every record, s.
    #[must_use]
    pub fn clock(&self) -> &[f64] {
        &self.clock
    }

    /// What a picture is observed as.
    #[must_use]
    pub fn channels() -> Vec<Channel> {
        ["u", "v"].map(|name| Channel::new(name, "px")).to_vec()
    }

    /// A camera that sees a drop from this height of the centre all the way down.
    ///
    /// # Errors
    /// [`Error::Simulator`] where no camera does.
    pub fn camera(&self, top_m: f64, random: &mut ChaCha8Rng) -> Result<Pinhole> {
        for _ in 0..MOST_DRAWS {
            let (distance, turn) = (random.random_range(DISTANCE_M), std::f64::consts::TAU * random.random::<f64>());
            let eye = [distance * turn.cos(), distance * turn.sin(), random.random_range(HEIGHT_M)];
            let camera = Pinhole::aimed(eye, AIM_M, FIELD_OF_VIEW_RAD, PICTURE_PX);
            if let Some(camera) = camera.filter(|c| self.sees(c, top_m) && self.sees(c, self.floor_m + self.radius_m)) {
                return Ok(camera);
            }
        }
        let message = format!("no camera sees a drop from {top_m} m");
        Err(Error::Simulator { at: "the camera".into(), message })
    }

    fn sees(&self, camera: &Pinhole, z_m: f64) -> bool {
        let (width, height) = camera.size_px();
        camera.disc([0.0, 0.0, z_m], self.radius_m).is_some_and(|disc| {
            let inside = |at: f64, size: usize| at >= disc.radius_px && at <= size as f64 - 1.0 - disc.radius_px;
            inside(disc.centre_px[0], width) && inside(disc.centre_px[1], height)
        })
    }

    /// The heights of the centre after a fall from `top_m`, row-major positions, m.
    ///
    /// # Errors
    /// As [`rollout`].
    pub fn roll(&self, restitution: f64, top_m: f64) -> Result<Vec<f64>> {
        rollout(&self.ball, &[restitution, self.ball.parameters()[1].value], &[0.0, 0.0, top_m], &self.clock)
    }

    /// Where the middle of the ball's outline appears, row-major pixels, with a tracker's noise.
    ///
    /// # Errors
    /// [`Error::Simulator`] where the ball comes too near to the camera.
    pub fn appears(&self, camera: &Pinhole, positions_m: &[f64], random: &mut ChaCha8Rng) -> Result<Vec<f64>> {
        let mut pixels = Vec::with_capacity(positions_m.len() / 3 * 2);
        for row in positions_m.chunks_exact(3) {
            let disc = camera.disc([row[0], row[1], row[2]], self.radius_m).ok_or_else(|| Error::Simulator {
                at: "the camera".into(),
                message: format!("the ball at {} m is not in front of it", row[2]),
            })?;
            pixels.extend(disc.centre_px.map(|v| v + NOISE_PX * random.sample::<f64, _>(StandardNormal)));
        }
        Ok(pixels)
    }

    /// A target as pixels, and a proposed rollout from the same height as metres.
    ///
    /// # Errors
    /// As [`camera`](Self::camera) and [`roll`](Self::roll).
    pub fn pair(&self, proposed: f64, target: f64, top_m: f64, random: &mut ChaCha8Rng) -> Result<Pair> {
        let friction = self.ball.parameters()[1].value;
        let nuisances = vec![0.0, 0.0, top_m];
        let camera = self.camera(top_m, random)?;
        Ok(Pair {
            proposed_parameters: vec![proposed, friction],
            target_parameters: vec![target, friction],
            scale: Some(self.scale(top_m)),
            own: nuisances,
            proposed: self.roll(proposed, top_m)?,
            target: self.appears(&camera, &self.roll(target, top_m)?, random)?,
            clock: Vec::new(),
        })
    }

    /// A tracked drop from a known height, read back to metres by the camera of its first fall.
    ///
    /// # Errors
    /// [`Error::Observation`] where the track is no such drop.
    pub fn prepared(&self, top_m: f64, pixels: Vec<f64>) -> Result<Prepared> {
        let video = Observation::new(Kind::Pixels, Self::channels(), self.clock.clone(), pixels)?;
        let v_px: Vec<f64> = video.column(1).collect();
        let scale = self.scale(top_m);
        let camera = LineCamera::of_fall(&self.clock, &v_px, &scale).ok_or_else(|| Error::Observation {
            what: "the track".into(),
            expected: format!("a fall from rest of {} m", scale.length),
            found: "none that a camera could see".into(),
        })?;
        let rows: Vec<[f64; 3]> = v_px.iter().map(|v| [0.0, 0.0, camera.height(*v)]).collect();
        let seen = Observation::positions(self.clock.clone(), &rows)?;
        Ok(Prepared { video: Some(video), ..self.known(top_m, seen)? })
    }

    /// Positions of a drop from a known height.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a height that is not finite.
    pub fn known(&self, top_m: f64, seen: Observation) -> Result<Prepared> {
        let mut prepared = Prepared::whole(seen, self.ball.parameters().len());
        // Known, so the bounds say nothing; a parameter needs some.
        let known = [0.0, 0.0, top_m].into_iter().zip(["x", "y", "z"]);
        prepared.nuisances = known
            .map(|(v, axis)| Parameter::new(format!("release.{axis}"), "m", v, v - 1.0, v + 1.0))
            .collect::<Result<_>>()?;
        prepared.scale = Some(self.scale(top_m));
        Ok(prepared)
    }

    fn scale(&self, top_m: f64) -> Scale {
        self.ball.scale(&[0.0, 0.0, top_m], 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation_file::LeftOpen;
    use rand::SeedableRng;
    use std::path::Path;

    fn drops() -> VideoDrops {
        let text = include_str!("../../../assets/ball_easy.toml");
        let mut file = SimulationFile::parse(Path::new("ball_easy.toml"), text).unwrap();
        file.leave_open(&[LeftOpen::ReleaseHeight]);
        VideoDrops::new(&file).unwrap()
    }

    #[test]
    fn a_track_is_read_back_to_within_its_noise() {
        let (drops, mut random) = (drops(), ChaCha8Rng::seed_from_u64(5));
        for _ in 0..5 {
            let positions = drops.roll(0.5, 4.5).unwrap();
            let camera = drops.camera(4.5, &mut random).unwrap();
            let pixels = drops.appears(&camera, &positions, &mut random).unwrap();
            let prepared = drops.prepared(4.5, pixels).unwrap();
            let off = prepared.seen.column(2).zip(positions[2..].iter().step_by(3)).map(|(seen, z)| (seen - z).abs());
            // A pixel is 5 to 10 cm here.
            let mean = off.sum::<f64>() / 400.0;
            assert!(mean < 0.05, "{mean}");
        }
    }

    #[test]
    fn a_pair_has_its_target_in_pixels() {
        let pair = drops().pair(0.4, 0.6, 4.2, &mut ChaCha8Rng::seed_from_u64(1)).unwrap();
        assert_eq!((pair.proposed.len(), pair.target.len()), (1200, 800));
        assert!(pair.target.iter().all(|v| (0.0..160.0).contains(v)));
    }
}
