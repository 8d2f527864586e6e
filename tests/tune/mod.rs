//! `tune` finds what a recording was made with, or says why not.

mod long_records;
mod measured;
mod model_choice;
mod pixels;
mod preflight;
mod recovery;
mod setups;
