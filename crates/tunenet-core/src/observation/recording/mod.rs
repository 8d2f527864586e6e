//! The files that observations come in: CSV and MCAP.
