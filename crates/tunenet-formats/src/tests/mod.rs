//! Whole files, good and bad.

#[cfg(feature = "logs")]
mod all_formats;
mod csv;
mod listing;
mod mcap;
mod measured;
mod round_trip;
