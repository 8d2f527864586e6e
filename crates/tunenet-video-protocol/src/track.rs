//! What tracking the ball in a video gives.

use serde::{Deserialize, Serialize};
use tunenet_core::observation::State;

use tunenet_core::finding::FindingKind;

use crate::finding::VideoFinding;
use crate::findings;
use crate::words::words;

/// All that the parent needs of a video. An error of the file or of a flag is an answer as well, so that the parent says it
/// once and in its own words.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "answer", rename_all = "snake_case")]
pub enum TrackAnswer {
    /// The ball was followed.
    Tracked(Box<Tracked>),
    /// No ball can be followed, and why.
    Untracked(Untracked),
    /// The file cannot be used.
    FileRefused {
        /// What was expected, and what was found.
        message: String,
        /// What to try.
        hint: String,
    },
    /// The value of a flag cannot be used.
    FlagRefused {
        /// The flag.
        flag: Flag,
        /// What it takes.
        expected: String,
        /// What it was given.
        found: String,
    },
}

words! {
    /// The flags that `tunenet-video track` may refuse, as people write them.
    Flag {
        /// The ball's colour.
        Colour = "--color",
        /// The camera's true frames per second.
        CameraRate = "--camera-rate",
        /// Samples per second of the answer.
        Rate = "--rate",
        /// The ball's radius.
        Radius = "--radius",
        /// A length in the picture.
        Length = "--length",
        /// The topic of a log.
        Topic = "--topic",
    }
}

/// A ball that was followed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tracked {
    /// The answer itself.
    pub facts: Facts,
    /// The ball, frame by frame or resampled.
    pub samples: Samples,
    /// Some frames with the track drawn in.
    pub pictures: Vec<Picture>,
}

/// A video in which no ball can be followed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Untracked {
    /// Why.
    pub reason: TrackFailure,
    /// The same for users, with what to try.
    pub finding: VideoFinding,
    /// Frames that decode.
    pub frames: usize,
    /// Some frames as they are.
    pub pictures: Vec<Picture>,
}

words! {
    /// Why no ball was found.
    TrackFailure {
        /// Nothing round and saturated moves.
        NoBall = "no_ball",
        /// Two things look alike.
        TwoBalls = "two_balls",
        /// What moves has no round outline.
        NotRound = "not_round",
        /// Most of the picture moves.
        CameraMoves = "camera_moves",
    }
}

impl TrackFailure {
    /// The finding that says it.
    #[must_use]
    pub fn kind(self) -> FindingKind {
        match self {
            Self::NoBall => findings::BALL_NONE,
            Self::TwoBalls => findings::BALL_TWO,
            Self::NotRound => findings::BALL_SHAPE,
            Self::CameraMoves => findings::CAMERA_MOVES,
        }
    }
}

/// What `tunenet track --json` prints of a track, key by key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Frames that decode.
    pub frames: usize,
    /// Frames in which the ball is seen.
    pub seen: usize,
    /// Frames in which all of it is seen.
    pub whole: usize,
    /// Frames per second, as they were taken.
    pub fps: f64,
    /// Frames that repeat the one before.
    pub duplicates: usize,
    /// Frames that are missing in between.
    pub dropped: usize,
    /// Width of a frame, px.
    pub width_px: usize,
    /// Height of a frame, px.
    pub height_px: usize,
    /// Radius of the ball in the picture, px.
    pub radius_px: f64,
    /// The colour that was looked for.
    pub color: Colour,
    /// Size of a pixel, where it is known.
    pub scale: Option<Scale>,
    /// When the ball bounces, s.
    pub bounces_s: Vec<f64>,
    /// Restitution from the flights alone, where they show it.
    pub restitution: Option<Estimate>,
    /// What the checks of the positions say.
    pub preflight: Vec<Check>,
    /// What a user should know.
    pub warnings: Vec<VideoFinding>,
}

impl Facts {
    /// The first check that rejects the positions.
    #[must_use]
    pub fn rejected(&self) -> Option<&Check> {
        self.preflight.iter().find(|check| check.state == State::Failed)
    }

    /// The restitution as it is shown: at most 1, since a bounce takes no speed from nowhere.
    #[must_use]
    pub fn rebound(&self) -> Option<Estimate> {
        self.restitution.map(|estimate| estimate.at_most(1.0))
    }

    /// That the ball never leaves the ground, where it does not.
    #[must_use]
    pub fn rolls(&self) -> Option<&VideoFinding> {
        self.warnings.iter().find(|finding| finding.kind == findings::BALL_ROLLS)
    }
}

/// A window of colours on OpenCV's scales: hue to 179, saturation and value to 255.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Colour {
    /// Middle hue.
    pub hue: i32,
    /// Half the width in hue.
    pub half_width: i32,
    /// Least and greatest saturation.
    pub saturation: (i32, i32),
    /// Least and greatest value.
    pub value: (i32, i32),
}

/// How large a pixel is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// m for each px.
    pub m_per_px: f64,
    /// Where that comes from.
    pub by: ScaleSource,
    /// The same for users.
    pub words: String,
    /// How much farther away a metre of height is, where the camera does not look from the side.
    pub depth_1_m: f64,
}

words! {
    /// Where a scale comes from.
    ScaleSource {
        /// The ball's radius.
        Radius = "radius",
        /// A length in the picture.
        Length = "length",
        /// How fast the ball falls.
        Gravity = "gravity",
    }
}

impl ScaleSource {
    /// For users.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Radius => "the ball's radius",
            Self::Length => "a length in the picture",
            Self::Gravity => "the fall of the ball",
        }
    }
}

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// The ends of the interval.
    pub interval95: [f64; 2],
}

impl Estimate {
    /// As it is shown where nothing above `most` is possible: noise carries an estimate there, and not the thing itself.
    #[must_use]
    pub fn at_most(self, most: f64) -> Self {
        let [low, high] = self.interval95;
        Self { value: self.value.min(most), interval95: [low.min(most), high.min(most)] }
    }
}

/// One check of the positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Its fixed code.
    pub code: String,
    /// How it ended.
    pub state: State,
    /// What was found.
    pub text: String,
    /// What to try.
    pub remedy: String,
}

/// The ball over time: columns of one length.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Samples {
    /// When, s.
    pub t_s: Vec<f64>,
    /// The centre, to the right, px.
    pub u_px: Vec<f64>,
    /// The centre, downwards, px.
    pub v_px: Vec<f64>,
    /// The radius, px.
    pub radius_px: Vec<f64>,
    /// How much it looks like the ball, 0 to 1.
    pub confidence: Vec<f64>,
    /// The centre in metres, where something says how large a pixel is.
    pub metres: Option<Metres>,
}

/// The ball's centre over time, m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metres {
    /// To the right.
    pub x_m: Vec<f64>,
    /// Upwards.
    pub z_m: Vec<f64>,
}

/// A frame for a page.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// Which frame, from 0.
    pub frame: usize,
    /// When it was taken, s.
    pub time_s: f64,
    /// px.
    pub width: i32,
    /// px.
    pub height: i32,
    /// The picture as JPEG, in base64.
    pub jpeg: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_read_as_they_were_written() {
        let finding = VideoFinding::new(TrackFailure::TwoBalls.kind(), "two", "leave one");
        let untracked = Untracked { reason: TrackFailure::TwoBalls, finding, frames: 3, pictures: Vec::new() };
        let refused = TrackAnswer::FlagRefused { flag: Flag::Radius, expected: "a length".into(), found: "-1".into() };
        for answer in [TrackAnswer::Untracked(untracked), refused] {
            let text = serde_json::to_string(&answer).unwrap();
            assert_eq!(serde_json::from_str::<TrackAnswer>(&text).unwrap(), answer, "{text}");
        }
        let text = serde_json::to_string(&TrackFailure::TwoBalls).unwrap();
        assert_eq!(text, format!("{:?}", TrackFailure::TwoBalls.word()));
    }

    #[test]
    fn what_is_shown_ends_at_what_is_possible() {
        let seen = Estimate { value: 1.02, interval95: [0.97, 1.07] };
        assert_eq!(seen.at_most(1.0), Estimate { value: 1.0, interval95: [0.97, 1.0] });
        let within = Estimate { value: 0.8, interval95: [0.7, 0.9] };
        assert_eq!(within.at_most(1.0), within);
    }

    #[test]
    fn an_answer_without_its_numbers_is_refused() {
        let text = r#"{"answer": "untracked", "reason": "no_ball", "frames": null, "pictures": []}"#;
        assert!(serde_json::from_str::<TrackAnswer>(text).is_err());
    }
}
