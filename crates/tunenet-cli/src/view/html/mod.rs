//! Pages that people read and pass on: one HTML file with its drawings inside, no script, nothing fetched.
//!
//! ```text
//! outcome and evidence → series, figures (drawn on panels) → sections of a page → one file
//! ```
//!
//! | file | what |
//! |---|---|
//! | `page` | the frame of every page: style, head, foot; writing |
//! | `svg`, `axis`, `panel`, `label`, `points` | drawing: shapes, round ticks, a frame with scales, labels on lines, fewer points |
//! | `series`, `figures` | what is drawn: a record with its residual below; ladders, bars, profiles, regions |
//! | `driving` | the inputs of a record, below its channels |
//! | `verdict`, `parameters`, `checks`, `provenance` | sections |
//! | `tune` | the page of `tunenet tune` |
//! | `track` | the page of `tunenet track` |
//! | `shot` | the page of `tunenet plan` |
//! | `diagnose` | the page of `tunenet diagnose`, and its own drawings and tables |

mod axis;
mod checks;
pub(crate) mod diagnose;
pub mod drawing;
mod driving;
mod figures;
mod label;
mod page;
mod panel;
mod parameters;
mod points;
mod provenance;
mod series;
pub(crate) mod shot;
pub mod svg;
pub(crate) mod track;
pub(crate) mod tune;
mod verdict;

pub(crate) use provenance::Provenance;
