//! Whole files, good and bad.

mod csv;
mod listing;
mod mcap;
mod measured;
mod round_trip;
