//! A fall read back from a picture, whose camera follows the rollouts.

use crate::camera::LineCamera;
use crate::observation::Observation;
use crate::simulator::Prepared;

/// Which channel of positions is the height, and which of pixels runs along it.
const HEIGHT: usize = 2;
const DOWN: usize = 1;

/// A recording beside the picture that it was read back from.
pub(super) struct Film<'a> {
    recording: &'a Prepared,
    v_px: Vec<f64>,
}

/// A rollout beside the picture, under the camera that suits both best.
pub(super) struct Beside {
    /// Where the rollout would appear, px.
    pub appears_px: Vec<f64>,
    /// The recording, read back once more.
    pub seen: Observation,
}

impl<'a> Film<'a> {
    /// `None` where the recording was never a picture.
    pub fn of(recording: &'a Prepared) -> Option<Self> {
        let pixels = recording.film.as_ref()?;
        Some(Self { recording, v_px: pixels.column(DOWN).collect() })
    }

    /// What was seen, px.
    pub fn v_px(&self) -> &[f64] {
        &self.v_px
    }

    /// Fits the camera to a rollout, as all of its heights are known: what stays different is not the camera's doing
    /// (variable projection, Golub and Pereyra 1973). `None` where no camera shows the rollout.
    pub fn beside(&self, rollout: &[f64]) -> Option<Beside> {
        let width = self.recording.seen.channels().len();
        let z_m: Vec<f64> = rollout[HEIGHT..].iter().step_by(width).copied().collect();
        let camera = LineCamera::fit(&z_m, &self.v_px)?;
        let appears_px = z_m.iter().map(|z| camera.project(*z)).collect();
        let mut values = self.recording.seen.values().to_vec();
        for (row, v) in values.chunks_exact_mut(width).zip(&self.v_px) {
            row[HEIGHT] = camera.height(*v);
        }
        let seen = &self.recording.seen;
        // A height that the picture cannot hold (beyond the horizon) makes no observation.
        let seen = Observation::new(seen.kind(), seen.channels().to_vec(), seen.clock().to_vec(), values);
        seen.ok().map(|seen| Beside { appears_px, seen })
    }
}
