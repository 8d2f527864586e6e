//! Robot models that people have: MJCF and URDF in, one description of links, joints and actuators, tuned numbers back into
//! the user's own file.
//!
//! | module | content |
//! |---|---|
//! | [`Robot`] | the description that both formats become |
//! | [`mjcf`], [`urdf`] | the readers |
//! | [`Unused`] | what a file holds and the description leaves out |
//! | [`Change`], [`edit`] | numbers edited in place |
//! | [`export`] | what a model file cannot express, and other programs' formats |
//!
//! The crate knows no simulator. It opens the named file and what that includes, nothing else; it writes nothing: every
//! function returns text.

mod change;
pub mod edit;
mod error;
pub mod export;
mod given;
mod inertia;
pub mod mjcf;
mod model;
mod robot;
mod unused;
pub mod urdf;
mod xml;

pub use change::{Change, Quantity};
pub use error::{Error, Result};
pub use inertia::Inertia;
pub use model::{Format, Model};
pub use robot::{Actuator, Contacts, Coupling, Filter, Joint, Law, Link, Motion, Pose, Robot, Target, Tendon, Weight};
pub use unused::{Changes, Unused};
pub use xml::read_file;
