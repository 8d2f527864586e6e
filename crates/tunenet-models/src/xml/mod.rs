//! XML as it stands in its file: every element and attribute with its place, so that messages point at it and edits change
//! nothing else.

mod include;
mod source;
mod tree;

pub(crate) use include::{Document, Reach, load};
pub use source::read_file;
pub(crate) use source::{LONGEST, Open, SourceFile, shown};
pub(crate) use tree::{Attribute, Element, parse};
