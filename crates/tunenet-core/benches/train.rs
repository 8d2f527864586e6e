//! How long training takes.
fn main() {}
