//! The crate as its users see it.

mod driven;
mod examples;
mod measured;
mod serialised;
mod several;
mod words;
