//! A model file of either format, URDF or MJCF, as a [`Model`].
//!
//! | module | what |
//! |---|---|
//! | `bodies` | from links, joints and couplings of the file to moving bodies |
//! | `left_out` | what the file holds and the model leaves out |

mod bodies;
mod left_out;

use std::path::Path;

use tunenet_formats::{Action, Error, Result, read_text};
use tunenet_models::{Change, Format, Quantity, edit, read_file};

use super::Model;
use super::urdf::{self, JointFriction};

/// Reads the arm that a URDF or an MJCF describes.
///
/// Of an MJCF, hinges and slides move; free and ball joints are held, and noted. What its bodies do not state is noted too:
/// see [`Model::notes`].
///
/// # Errors
/// As [`urdf::read`]; of an MJCF, what [`tunenet_models::Model::read`] refuses, and a moving body whose mass only a mesh knows.
pub fn read(path: &Path) -> Result<Model> {
    let text = read_text(path)?;
    if Format::of(&text) == Some(Format::Mjcf) {
        let model = tunenet_models::Model::read(path).map_err(in_formats)?;
        return bodies::model(path, model.robot());
    }
    urdf::parse(path, &text)
}

/// The arm that an MJCF describes, which names no other file.
///
/// # Errors
/// As [`read`].
pub fn parse_mjcf(path: &Path, text: &str) -> Result<Model> {
    let model = tunenet_models::Model::parse_alone(path, text).map_err(in_formats)?;
    bodies::model(path, model.robot())
}

/// The text of the model file at `path` with this friction at its joints, everything else as it stands.
///
/// # Errors
/// As [`read`] and [`urdf::with_friction`]; [`Error::File`] where the joints stand in another file, which this one includes.
pub fn with_friction(path: &Path, joints: &[JointFriction]) -> Result<String> {
    let text = read_text(path)?;
    if Format::of(&text) != Some(Format::Mjcf) {
        return Ok(urdf::with_friction(&text, joints)?);
    }
    let whole = read_file(path).map_err(in_formats)?;
    let model = tunenet_models::Model::parse(path, &whole).map_err(in_formats)?;
    let change = |joint: &str, quantity, value| Change { joint: joint.to_owned(), quantity, value, interval: None };
    let changes: Vec<Change> = joints
        .iter()
        .flat_map(|one| {
            let (viscous, coulomb) = (Quantity::ViscousFriction, Quantity::CoulombFriction);
            [change(&one.joint, viscous, one.damping), change(&one.joint, coulomb, one.friction)]
        })
        .collect();
    let edited = edit::edit(&model, &changes).map_err(in_formats)?;
    if let Some(sentence) = edited.other_files() {
        let others: Vec<_> = edited.files.iter().skip(1).map(|file| file.path.display().to_string()).collect();
        let hint = format!("name the file that holds the joints ({}) as the arm's model", others.join(", "));
        return Err(Error::file(path, format!("expected the joints in this file, but {sentence}"), hint));
    }
    Ok(edited.files.into_iter().next().map(|file| file.text).unwrap_or(whole))
}

/// An error of the readers as one of files.
fn in_formats(error: tunenet_models::Error) -> Error {
    use tunenet_models::Error as Own;
    match error {
        Own::Text { path, line, column, width, source_line, message, hint } => {
            Error::Text { path, line, column, width, source_line, message, hint }
        }
        Own::File { path, message, hint } => Error::File { path, message, hint },
        Own::Io { path, source } => Error::io(path, Action::Reading, source),
        other => Error::file("", other.to_string(), other.hint().to_owned()),
    }
}
