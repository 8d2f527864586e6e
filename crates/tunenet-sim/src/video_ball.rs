//! A ball released from rest at a known height, seen by an uncalibrated camera.

use tunenet_core::camera::LineCamera;
use tunenet_core::observation::{Channel, Kind, Note, Observation};
use tunenet_core::simulator::{Effect, Parameter, Preparation, Rejected, RolloutResult, Simulator};
use tunenet_core::{Error, Result};
use tunenet_formats::kind_name;

use crate::findings;
use crate::scene::BallScene;
use crate::{ObservedBall, SimulationFile};

/// Nuisance parameters of the camera, behind those of the ball.
const CAMERA: usize = 3;

/// A dropped ball, observed as pixels.
///
/// The first fall, whose heights are known without the restitution, says what camera saw it ([`LineCamera::of_fall`]); by
/// that camera the track is read back to metres, and metres are what rollouts and residuals are in. What the first fall
/// leaves uncertain of the camera is fitted with the rest: three nuisance parameters of each recording, which bring the simulated
/// heights to `(f z + o) / (p z + 1)`. A camera that sees the ball move sideways is none for this.
#[derive(Debug, Clone)]
pub struct VideoBall {
    ball: ObservedBall,
    start_s: f64,
}

impl VideoBall {
    /// The ball of `file`.
    ///
    /// # Errors
    /// [`Error::Observation`] where the file leaves the height or the instant of the release, or the surface, to the data,
    /// or throws the ball; as [`ObservedBall::new`].
    pub fn new(file: &SimulationFile) -> tunenet_formats::Result<Self> {
        let BallScene { release, surface, .. } = file.ball()?;
        let dropped = release.velocity_m_s.is_none_or(|v| v == [0.0; 3]);
        let (Some(start_s), Some(_), Some(_), true) = (release.time_s, release.height_m, surface.height_m, dropped)
        else {
            return Err(Error::Observation {
                what: "pixels".into(),
                expected: "a simulation that says when and from what height above what surface the ball is let go \
                           (`release.height_m`, `release.time_s`, `surface.height_m`)"
                    .into(),
                found: "one that leaves it to the data".into(),
            }
            .into());
        };
        Ok(Self { ball: ObservedBall::new(file, Kind::Positions)?, start_s })
    }
}

impl Simulator for VideoBall {
    fn parameters(&self) -> &[Parameter] {
        self.ball.parameters()
    }

    fn channels(&self) -> &[Channel] {
        self.ball.channels()
    }

    fn kind(&self) -> Kind {
        Kind::Pixels
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        if seen.kind() != Kind::Pixels {
            let (expected, found) = (Kind::Pixels.name().into(), kind_name(seen.kind()).into());
            return Err(Error::Observation { what: "the observation".into(), expected, found });
        }
        let scale = self.ball.scale(&self.ball.nuisances_at_rest(self.start_s), self.start_s);
        let v_px: Vec<f64> = seen.column(1).collect();
        let Some(camera) = LineCamera::of_fall(seen.clock(), &v_px, &scale) else {
            let note = Note::new(
                findings::CAMERA_UNKNOWN,
                format!("no camera shows a fall of {:.2} m like this from {} s on", scale.length, scale.start_s),
                "correct `release.height_m` and `release.time_s`, or leave both out and give metres",
            );
            return Ok(Preparation::Rejected(Box::new(Rejected { note, checks: Vec::new() })));
        };
        let rows: Vec<[f64; 3]> = v_px.iter().map(|v| [0.0, 0.0, camera.height(*v)]).collect();
        let metres = Observation::positions(seen.clock().to_vec(), &rows)?;
        let mut prepared = match self.ball.prepare(&metres)? {
            Preparation::Usable(prepared) => prepared,
            rejected @ Preparation::Rejected(_) => return Ok(rejected),
        };
        let first = seen.clock().partition_point(|t| *t < prepared.seen.clock()[0]);
        prepared.video = seen.slice(first..(first + prepared.seen.len()).min(seen.len())).ok();
        let reach = scale.length;
        for (name, unit, value, low, high) in [
            ("camera.stretch", "1", 1.0, 0.5, 2.0),
            ("camera.rise", "m", 0.0, -reach, reach),
            ("camera.perspective", "1/m", 0.0, -0.4 / reach, 0.4 / reach),
        ] {
            prepared.nuisances.push(Parameter::new(name, unit, value, low, high)?);
        }
        Ok(Preparation::Usable(prepared))
    }

    fn effects(&self) -> Vec<Effect> {
        Vec::new()
    }

    fn rollout(&self, p: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        let Some((ball, [stretch, rise, perspective])) = nuisances.split_last_chunk::<CAMERA>() else {
            return Err(format!("{} nuisance parameters are too few", nuisances.len()).into());
        };
        self.ball.rollout(p, ball, clock, values)?;
        for row in values.chunks_exact_mut(3) {
            let depth = perspective * row[2] + 1.0;
            if depth <= 0.0 {
                return Err(format!("a ball at {} m is behind the camera", row[2]).into());
            }
            row[2] = (stretch * row[2] + rise) / depth;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation_file::LeftOpen;
    use crate::video_drops::VideoDrops;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use std::path::Path;
    use tunenet_core::tune::{Settings, Verdict, tune};

    fn file(height: f64) -> SimulationFile {
        let text = include_str!("../../../assets/ball_easy.toml");
        let mut file = SimulationFile::parse(Path::new("ball_easy.toml"), text).unwrap();
        file.set(&format!("release.height_m={height}")).unwrap();
        file
    }

    /// The drop is the closed form's, seen through a pinhole; what is tuned knows neither.
    #[test]
    fn restitution_comes_out_of_pixels_without_a_scale() {
        let mut open = file(4.0);
        open.leave_open(&[LeftOpen::ReleaseHeight]);
        let drops = VideoDrops::new(&open).unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(11);
        for restitution in [0.35, 0.6] {
            let positions = drops.roll(restitution, 4.5).unwrap();
            let camera = drops.camera(4.5, &mut random).unwrap();
            let pixels = drops.appears(&camera, &positions, &mut random).unwrap();
            let seen = Observation::new(Kind::Pixels, VideoDrops::channels(), drops.clock().to_vec(), pixels).unwrap();
            let ball = VideoBall::new(&file(4.0)).unwrap();
            let outcome = tune(&ball, &[seen], None, &Settings::default()).unwrap();
            assert_eq!(outcome.verdict, Verdict::Tuned, "{:?}", outcome.notes);
            let found = &outcome.parameters[0];
            assert!((found.value - restitution).abs() < 0.002, "{found:?}");
        }
    }

    #[test]
    fn a_release_left_to_the_data_is_refused() {
        let mut open = file(4.0);
        open.leave_open(&[LeftOpen::ReleaseHeight]);
        assert!(VideoBall::new(&open).unwrap_err().to_string().contains("release.height_m"));
    }
}
