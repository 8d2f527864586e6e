//! What the programs `tunenet` and `tunenet-video` say to each other, as JSON on a pipe.
//!
//! A crate of its own: `tunenet-video` alone links OpenCV, and features of one crate are the same for both programs.
//!
//! | module | question on the command line or on standard input | answer on standard output |
//! |---|---|---|
//! | [`track`] | `tunenet-video track FILE` | [`track::TrackAnswer`] |
//! | [`synthetic`] | `tunenet-video film`, with a [`synthetic::Order`] | a list of [`synthetic::SyntheticTrack`] |
//! | [`speed`] | `tunenet-video speed FOLDER` | [`speed::VideoSpeed`] |
//! | [`finding`] | | what a user should know of a video, in the answers |

pub mod finding;
pub mod findings;
pub mod speed;
pub mod synthetic;
pub mod track;
mod words;

pub use finding::VideoFinding;
pub use track::TrackAnswer;
