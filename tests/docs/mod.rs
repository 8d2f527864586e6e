//! What README and docs say is held against the tool.

mod documented;
mod findings;
mod glossary;
mod layers;
mod links;
pub mod page;
mod readme;
mod results;
