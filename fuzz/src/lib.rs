//! What the fuzz targets run.

mod readers;
mod robots;

pub use readers::*;
pub use robots::robot;
