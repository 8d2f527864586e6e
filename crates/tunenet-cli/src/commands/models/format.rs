//! That the copy of a model bears the ending of its own format: a copy changes numbers, not the format.

use std::path::Path;

use anyhow::Result;
use tunenet_core::{Error, Origin};
use tunenet_formats::{read_text, shown_path};
use tunenet_models::Format;

/// Refuses a name for the copy of `model` that says it were of the other format. A model may have that ending itself.
///
/// # Errors
/// [`Error::Setting`] with the ending that is expected; where the model cannot be read.
pub fn check(out: &Path, model: &Path) -> Result<()> {
    let ends = |path: &Path, endings: &[&str]| {
        path.extension().is_some_and(|own| endings.iter().any(|ending| own.eq_ignore_ascii_case(ending)))
    };
    let same = out.extension() == model.extension();
    let (ending, format) = match Format::of(&read_text(model)?) {
        Some(Format::Mjcf) if ends(out, &["urdf", "xacro"]) && !same => ("xml", "an MJCF"),
        Some(Format::Urdf) if ends(out, &["xml"]) && !ends(model, &["xml"]) => ("urdf", "a URDF"),
        _ => return Ok(()),
    };
    let expected = format!("a name that ends in .{ending}, since {} is {format}", shown_path(model));
    Err(Error::Setting { origin: Origin::Flag, name: "--out-model", expected, found: shown_path(out) }.into())
}
