//! What a camera saw: the only crate of tunenet that knows OpenCV.
//!
//! A video is the cheapest measurement there is, but its header is a promise: it may count frames that do not decode, and
//! a phone turns the picture in a way that the header's width and height do not state. So everything here starts from
//! frames that were really decoded.
//!
//! ```text
//! video or log → pictures with times → ball colour detection → tracker (where it is) → track → scale → observation
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`video`] | a file becomes a [`video::Clip`]: how large, how fast, how many frames |
//! | [`source`], [`frames`] | pictures one after the other, each with the instant at which it was taken |
//! | [`colour`], [`lookup`] | the window of hue, saturation and value by which a ball is known |
//! | [`ball_colour`] | ball colour detection: the saturated thing that moves before a static background |
//! | [`tracker`] | the ball in one frame, to a fraction of a pixel |
//! | [`track`](mod@track) | the ball in a whole video, and the findings |
//! | [`scale`] | pixels become metres |
//! | [`render`], [`synthetic`] | synthetic videos of a ball with known position |
//! | [`overlay`] | the track overlaid on its video |
//!
//! Errors are those of [`tunenet_formats`]: a file that is no video is a file that cannot be used, like any other.

pub mod ball_colour;
mod blob;
mod camera_motion;
mod changes;
mod clock;
pub mod colour;
mod container;
mod folder;
pub mod frames;
mod log;
pub mod lookup;
mod outline;
pub mod overlay;
mod parabola;
mod perspective;
pub mod render;
mod samples;
pub mod scale;
pub mod source;
mod stillness;
pub mod synthetic;
#[cfg(test)]
mod test_videos;
pub mod track;
mod track_findings;
pub mod tracker;
pub mod video;
pub mod view;

pub use source::Source;
pub use track::{Answer, Track, track};
pub use video::Clip;
