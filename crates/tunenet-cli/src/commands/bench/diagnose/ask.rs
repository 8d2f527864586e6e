//! The code under test, asked about recordings. Nothing but the recordings goes in.
