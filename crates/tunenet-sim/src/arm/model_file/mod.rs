//! A model file of either format, URDF or MJCF, as a [`Model`].
//!
//! | module | what |
//! |---|---|
//! | `bodies` | from links, joints and couplings of the file to moving bodies |
//! | `keyed` | the names of its joints as keys of a simulation file |
//! | `left_out` | what the file holds and the model leaves out |

mod bodies;
mod keyed;
mod left_out;

use std::path::Path;

use tunenet_formats::{Action, Error, Result, read_text};
use tunenet_models::edit::{self, Edited};
use tunenet_models::urdf::Commands;
use tunenet_models::{Change, Format, Motion, Quantity, Robot};

pub use self::keyed::{key_of, keyed, named};
use self::left_out::Driven;
use super::Model;
use super::urdf;

/// Reads the arm that a URDF or an MJCF describes.
///
/// Of an MJCF, hinges and slides move; free and ball joints are held, and noted. What its bodies do not state is noted too:
/// see [`Model::notes`].
///
/// # Errors
/// As [`urdf::read`]; of an MJCF, what [`tunenet_models::Model::read`] refuses, and a moving body whose mass only a mesh knows.
pub fn read(path: &Path) -> Result<Model> {
    described(path, Driven::Torques).map(|(model, _)| model)
}

/// Reads the robot that a URDF or an MJCF describes, whose joints follow commands; of an MJCF also what it says of their motors.
///
/// # Errors
/// As [`read`].
pub fn read_driven(path: &Path) -> Result<(Model, Option<Robot>)> {
    described(path, Driven::Commands)
}

fn described(path: &Path, driven: Driven) -> Result<(Model, Option<Robot>)> {
    let text = read_text(path)?;
    if Format::of(&text) != Some(Format::Mjcf) {
        let commands = if driven == Driven::Commands { Some(commands_in(path, &text)?) } else { None };
        let mut model = urdf::parse_driven(path, &text, commands.as_ref())?;
        model.notes.extend(left_out::of_mimics(&model).filter(|_| driven == Driven::Commands));
        return Ok((model, None));
    }
    let file = tunenet_models::Model::parse(path, &text).map_err(in_formats)?;
    let model = bodies::model(path, file.robot(), driven)?;
    Ok((model, Some(file.robot().clone())))
}

/// What a URDF says of the commands to its joints; nothing of an MJCF, whose actuators say it.
///
/// # Errors
/// As [`read`]; of a URDF with transmissions, also what [`tunenet_models::Model::read`] refuses.
pub fn commands(path: &Path) -> Result<Commands> {
    let text = read_text(path)?;
    if Format::of(&text) == Some(Format::Mjcf) { Ok(Commands::default()) } else { commands_in(path, &text) }
}

fn commands_in(path: &Path, text: &str) -> Result<Commands> {
    if !text.contains("<transmission") && !text.contains("<ros2_control") {
        return Ok(Commands::default());
    }
    match tunenet_models::Model::parse_alone(path, text) {
        Ok(tunenet_models::Model::Urdf(file)) => Ok(file.commands().clone()),
        Ok(tunenet_models::Model::Mjcf(_)) => Ok(Commands::default()),
        // What no arm can be is refused as that.
        Err(error) => urdf::parse(path, text).and_then(|_| Err(in_formats(error))),
    }
}

/// The arm that an MJCF describes, which names no other file.
///
/// # Errors
/// As [`read`].
pub fn parse_mjcf(path: &Path, text: &str) -> Result<Model> {
    let model = tunenet_models::Model::parse_alone(path, text).map_err(in_formats)?;
    bodies::model(path, model.robot(), Driven::Torques)
}

/// Friction of one joint, as a model file has it.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFriction {
    /// Name of the joint.
    pub joint: String,
    /// Viscous friction, N·m·s/rad.
    pub damping: f64,
    /// Coulomb friction, N·m.
    pub friction: f64,
}

/// The text of the model file at `path` with this friction at its joints, everything else as it stands.
///
/// # Errors
/// As [`read`] and [`edited`].
pub fn with_friction(path: &Path, joints: &[JointFriction]) -> Result<String> {
    let change = |joint: &str, quantity, value| Change {
        joint: joint.to_owned(),
        motion: Motion::Revolute,
        quantity,
        value,
        interval: None,
    };
    let changes: Vec<Change> = joints
        .iter()
        .flat_map(|one| {
            let (viscous, coulomb) = (Quantity::ViscousFriction, Quantity::CoulombFriction);
            [change(&one.joint, viscous, one.damping), change(&one.joint, coulomb, one.friction)]
        })
        .collect();
    edited(path, &changes).map(|(text, _)| text)
}

/// The text of the model file at `path` with these numbers, everything else as it stands; and what became of each change. Where numbers
/// stand in files that it includes, the text holds these files in their places.
///
/// # Errors
/// What [`tunenet_models::Model::read`] and [`edit::edit`] refuse.
pub fn edited(path: &Path, changes: &[Change]) -> Result<(String, Edited)> {
    let model = tunenet_models::Model::read(path).map_err(in_formats)?;
    let mut edited = edit::edit(&model, changes).map_err(in_formats)?;
    if let Some(joined) = model.joined().filter(|_| edited.other_files().is_some()) {
        let whole = tunenet_models::Model::parse_alone(path, &joined).map_err(in_formats)?;
        edited = edit::edit(&whole, changes).map_err(in_formats)?;
        edited.notes.push("the copy holds what the model includes from other files, which are not changed".into());
    }
    // The named file comes first, and is always there.
    let text = std::mem::take(&mut edited.files).into_iter().next().map(|file| file.text).unwrap_or_default();
    Ok((text, edited))
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
