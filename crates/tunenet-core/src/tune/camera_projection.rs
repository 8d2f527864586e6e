//! Variable projection (Golub and Pereyra 1973) of the camera: a track in a video whose camera is fitted again to every rollout.

use crate::camera::LineCamera;
use crate::observation::Observation;
use crate::simulator::Prepared;

/// Which channel of positions is the height, and which of pixels runs along it.
const HEIGHT: usize = 2;
const DOWN: usize = 1;

/// A recording and the track, in pixels, that it was computed from.
pub(super) struct VideoTrack<'a> {
    recording: &'a Prepared,
    v_px: Vec<f64>,
}

/// A rollout in the picture, for the camera that fits rollout and track best.
pub(super) struct ProjectedRollout {
    /// Where the rollout would appear, px.
    pub appears_px: Vec<f64>,
    /// The recording, read back once more.
    pub seen: Observation,
}

impl<'a> VideoTrack<'a> {
    /// `None` if the recording is not from a video.
    pub fn of(recording: &'a Prepared) -> Option<Self> {
        let pixels = recording.video.as_ref()?;
        Some(Self { recording, v_px: pixels.column(DOWN).collect() })
    }

    /// The track, px.
    pub fn v_px(&self) -> &[f64] {
        &self.v_px
    }

    /// Fits the camera to a rollout, all of whose heights are known: the remaining residual is not due to the camera. `None` if
    /// no camera shows the rollout.
    pub fn project(&self, rollout: &[f64]) -> Option<ProjectedRollout> {
        let width = self.recording.seen.channels().len();
        let z_m: Vec<f64> = rollout[HEIGHT..].iter().step_by(width).copied().collect();
        let camera = LineCamera::fit(&z_m, &self.v_px)?;
        let appears_px = z_m.iter().map(|z| camera.project(*z)).collect();
        let mut values = self.recording.seen.values().to_vec();
        for (row, v) in values.chunks_exact_mut(width).zip(&self.v_px) {
            row[HEIGHT] = camera.height(*v);
        }
        // A height outside the picture (beyond the horizon) makes no observation.
        self.recording.seen.with_values(values).ok().map(|seen| ProjectedRollout { appears_px, seen })
    }
}
