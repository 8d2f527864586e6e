//! What a camera saw: the only crate of tunenet that knows OpenCV.
//!
//! A video is the cheapest measurement there is, but its header is a promise: it may count frames that do not decode, and
//! a phone turns the picture in a way that the header's width and height do not tell. So everything here starts from
//! frames that were really decoded.
//!
//! | module | what |
//! |---|---|
//! | [`video`] | a file becomes a [`video::Clip`]: how large, how fast, how many frames |
//! | [`render`] | films of a ball whose truth is known |
//!
//! Errors are those of [`tunenet_core`]: a file that is no video is a file that cannot be used, like any other.

pub mod render;
pub mod video;

pub use video::Clip;
