//! How a camera sees a point, and how heights are read back from what it saw.

mod line;
mod pinhole;

pub use line::LineCamera;
pub use pinhole::{Disc, Pinhole};
