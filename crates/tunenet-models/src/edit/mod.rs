//! Numbers edited in place into the user's own text: comments, layout and everything else stay byte for byte.
//!
//! An attribute that the element has gets another value; one that it has from a class, or not at all, is added to the element
//! itself, so that other elements of the class keep theirs. What the format cannot express comes back with a reason, for a
//! [sidecar](crate::export::sidecar).

mod mjcf;
mod patch;
mod urdf;

use std::collections::HashSet;
use std::path::PathBuf;

use crate::xml::shown;
use crate::{Change, Error, Model, Result};

/// Why no format has an encoder's offset, and what to do. A servo compares its command with what the encoder reads: in the coordinates
/// of the model, both are less by the offset.
const NO_OFFSET_OF_READINGS: &str = "model files have no offset of a reading: subtract it from the recorded positions, and the same \
     amount from the commands of a position drive";

/// One number in its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Done {
    /// What was asked for.
    pub change: Change,
    /// The file.
    pub path: PathBuf,
    /// Line of the element in the old text, from 1.
    pub line: usize,
    /// The element and its attributes as they stand now, such as `<joint damping="0.5">`.
    pub written: String,
}

/// A number that the format cannot express.
#[derive(Debug, Clone, PartialEq)]
pub struct Left {
    /// What was asked for.
    pub change: Change,
    /// Why, and what to do instead.
    pub why: String,
}

/// A file with its numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EditedFile {
    /// The file that was read.
    pub path: PathBuf,
    /// Its new text.
    pub text: String,
}

/// A model with other numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Edited {
    /// The named file, then those that it includes and that changed.
    pub files: Vec<EditedFile>,
    /// What was written, in the order of the changes.
    pub done: Vec<Done>,
    /// What was not.
    pub left: Vec<Left>,
    /// What a user should know of the new text.
    pub notes: Vec<String>,
}

impl Edited {
    /// What to do where the numbers stand in other files than the named one; `None` where they do not.
    #[must_use]
    pub fn other_files(&self) -> Option<String> {
        let others: Vec<_> =
            self.files.iter().skip(1).map(|file| format!("`{}`", shown(&file.path.display().to_string()))).collect();
        (!others.is_empty()).then(|| {
            format!("numbers stand in {}, which the model includes: write these files as well", others.join(" and "))
        })
    }
}

/// The model's text with these numbers.
///
/// ```
/// use tunenet_models::{Change, Model, Motion, Quantity, edit};
/// let text = "<mujoco><worldbody><body><!-- the elbow --><joint name='elbow'  damping = '1'/>\
///   <geom size='0.1'/></body></worldbody></mujoco>";
/// let model = Model::parse("arm.xml".as_ref(), text)?;
/// let change = |quantity, value| Change { joint: "elbow".into(), motion: Motion::Revolute, quantity, value, interval: None };
/// let changes = [change(Quantity::ViscousFriction, 0.25), change(Quantity::DeadBand, 0.01)];
/// let edited = edit::edit(&model, &changes)?;
/// assert_eq!(edited.files[0].text, text.replace("'1'", "'0.25'"));
/// assert_eq!(edited.left[0].change.quantity, Quantity::DeadBand);
/// # Ok::<(), tunenet_models::Error>(())
/// ```
///
/// # Errors
/// [`Error::File`] where a change names no joint of the model, its value is none that the quantity can have, or a number is given twice.
pub fn edit(model: &Model, changes: &[Change]) -> Result<Edited> {
    let mut given = HashSet::new();
    let mut wanted = Vec::with_capacity(changes.len());
    for change in changes {
        wanted.push((check(model, change)?, change));
        if !given.insert((change.joint.as_str(), change.quantity)) {
            let (joint, name) = (shown(&change.joint), change.quantity.name());
            let message = format!("joint `{joint}`: expected {name} once, found it twice");
            return Err(Error::file(model.path(), message, "give each number of a joint once"));
        }
    }
    Ok(match model {
        Model::Mjcf(mjcf) => mjcf::edit(mjcf, &wanted),
        Model::Urdf(urdf) => urdf::edit(urdf, &wanted),
    })
}

/// The place of the joint of a change, where the change is possible.
fn check(model: &Model, change: &Change) -> Result<usize> {
    let path = model.path();
    let robot = model.robot();
    let Some(place) = robot.joint(&change.joint) else {
        let names: Vec<_> = robot.joints.iter().take(50).map(|joint| format!("`{}`", shown(&joint.name))).collect();
        let message = format!("expected a joint of the model ({}), found `{}`", names.join(", "), shown(&change.joint));
        return Err(Error::file(path, message, "correct the name of the joint"));
    };
    let least = if change.quantity.signed() { f64::NEG_INFINITY } else { 0.0 };
    let fits = |value: f64| value.is_finite() && value >= least;
    let ordered = change.interval.is_none_or(|[lower, upper]| lower <= upper && lower.is_finite() && upper.is_finite());
    if fits(change.value) && ordered {
        return Ok(place);
    }
    let expected = if change.quantity.signed() { "a finite number" } else { "a number of 0 or more" };
    let (name, joint, value) = (change.quantity.name(), shown(&change.joint), change.value);
    let message = format!("joint `{joint}`: expected {expected} as {name} with an ordered interval, found {value}");
    Err(Error::file(path, message, "correct the number"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Motion, Quantity};

    #[test]
    fn both_formats_say_what_to_do_about_an_encoder_offset() {
        let mjcf = "<mujoco><worldbody><body><joint name='a'/><geom size='0.1'/></body></worldbody></mujoco>";
        let urdf = "<robot name='r'><link name='l0'/><link name='l1'/>\
            <joint name='a' type='continuous'><parent link='l0'/><child link='l1'/></joint></robot>";
        let quantity = Quantity::ZeroOffset;
        let change = Change { joint: "a".into(), motion: Motion::Revolute, quantity, value: 0.1, interval: None };
        for text in [mjcf, urdf] {
            let model = Model::parse("model".as_ref(), text).unwrap();
            let left = edit(&model, std::slice::from_ref(&change)).unwrap().left;
            assert_eq!(left, [Left { change: change.clone(), why: NO_OFFSET_OF_READINGS.into() }]);
        }
    }

    /// Dry friction comes with numbers by which it holds, unless the joint has its own; none needs none.
    #[test]
    fn written_friction_holds_in_an_mjcf() {
        let friction = |value| {
            let quantity = Quantity::CoulombFriction;
            Change { joint: "a".into(), motion: Motion::Revolute, quantity, value, interval: None }
        };
        let holds = " solreffriction=\"0.004 1\" solimpfriction=\"0.9999 0.9999 0.001 0.5 2\"";
        let cases = [("", 3.0, holds), ("", 0.0, ""), (" solimpfriction='0.95 0.99'", 3.0, "")];
        for (own, value, added) in cases {
            let text = format!(
                "<mujoco><worldbody><body><joint name='a'{own}/><geom size='0.1'/></body></worldbody></mujoco>"
            );
            let model = Model::parse("model".as_ref(), &text).unwrap();
            let edited = edit(&model, &[friction(value)]).unwrap();
            let written = format!("<joint name='a'{own} frictionloss=\"{value}\"{added}/>");
            assert!(edited.files[0].text.contains(&written), "{written}\n{}", edited.files[0].text);
        }
    }
}
