//! The tests of the tool as a process: one binary, a folder for each subject.

mod arm;
mod cli;
mod common;
mod diagnose;
mod docs;
mod equations;
mod files;
mod process;
mod regress;
mod robot;
mod tune;
#[cfg(feature = "video")]
mod video;
