//! The result of tracking a video.

use tunenet_core::Result;
use tunenet_core::observation::{Channel, Kind, Observation};
use tunenet_video_protocol::VideoFinding;
use tunenet_video_protocol::track::TrackFailure;

use crate::colour::Window;
use crate::tracker::Sighting;
use tunenet_core::statistics::median;

/// The ball in a video.
#[derive(Debug, Clone)]
pub struct Track {
    /// How many frames decode.
    pub frames: usize,
    /// Width and height of a frame, px.
    pub size_px: (usize, usize),
    /// The rate of the frames as they were taken: the inverse of the median step, 1/s.
    pub rate_hz: f64,
    /// The colour that was looked for.
    pub colour: Window,
    /// The ball, in the order of the frames.
    pub sightings: Vec<Sighting>,
    /// Frames that repeat the one before, from 0.
    pub repeated: Vec<usize>,
    /// How many frames are missing in between, by the container's clock.
    pub dropped: usize,
    /// What was noticed.
    pub notes: Vec<VideoFinding>,
}

/// The result of a video.
#[derive(Debug, Clone)]
pub enum Answer {
    /// A track.
    Tracked(Box<Track>),
    /// None, and why.
    Untracked {
        /// Why.
        reason: TrackFailure,
        /// How many frames decode.
        frames: usize,
        /// The same for users, with what to try.
        finding: VideoFinding,
    },
}

impl Track {
    /// The sightings in full view, in frames that are no repetition.
    pub fn whole(&self) -> impl Iterator<Item = &Sighting> {
        self.sightings.iter().filter(|s| !s.cut && self.repeated.binary_search(&s.frame).is_err())
    }

    /// The ball's radius in the picture, px: the median.
    #[must_use]
    pub fn radius_px(&self) -> f64 {
        median(self.whole().map(|s| s.radius_px)).unwrap_or(1.0)
    }

    /// The track as an observation in pixels.
    ///
    /// # Errors
    /// [`tunenet_core::Error::Observation`] where too few frames show the whole ball.
    pub fn observation(&self) -> Result<Observation> {
        let clock = self.whole().map(|s| s.time_s).collect();
        let values = self.whole().flat_map(|s| [s.u_px, s.v_px]).collect();
        Observation::new(Kind::Pixels, vec![Channel::new("u", "px"), Channel::new("v", "px")], clock, values)
    }
}
