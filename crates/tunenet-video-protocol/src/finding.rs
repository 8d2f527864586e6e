//! What a person should know of a video.

use serde::{Deserialize, Serialize};
use tunenet_core::observation::Note;

use crate::words::words;

words! {
    /// What was found, by its fixed code.
    FindingKind {
        /// The background holds the ball's colour.
        ColourInBackground = "ball.background",
        /// The border of the picture cuts the ball.
        CutByBorder = "ball.cut",
        /// The ball is not seen until the end.
        Gone = "ball.gone",
        /// The ball is not seen for a while in between.
        Lost = "ball.lost",
        /// No ball is seen.
        NoBall = "ball.none",
        /// The ball rolls and never leaves the ground.
        Rolls = "ball.rolls",
        /// What moves is not round.
        NotRound = "ball.shape",
        /// Two balls are seen.
        TwoBalls = "ball.two",
        /// The camera moved for a while.
        CameraBumped = "camera.bumped",
        /// The camera moves all the time.
        CameraMoves = "camera.moves",
        /// Frames are missing by the video's clock.
        FramesDropped = "film.dropped",
        /// Frames repeat the one before.
        FramesRepeated = "film.repeated",
        /// The file ends before its end.
        Truncated = "film.truncated",
        /// A flight falls otherwise than the others.
        OddFlight = "flight.odd",
        /// Fall and size of the ball do not go together.
        ScaleDisagrees = "scale.disagrees",
    }
}

/// What was found, in words, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VideoFinding {
    /// What it is.
    #[serde(rename = "code")]
    pub kind: FindingKind,
    /// One sentence: what was found and where.
    pub text: String,
    /// What to try.
    pub remedy: String,
}

impl VideoFinding {
    /// A finding from its three parts.
    pub fn new(kind: FindingKind, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind, text: text.into(), remedy: remedy.into() }
    }

    /// The same as a note of any recording.
    #[must_use]
    pub fn note(&self) -> Note {
        Note::new(self.kind.word(), &self.text, &self.remedy)
    }
}
