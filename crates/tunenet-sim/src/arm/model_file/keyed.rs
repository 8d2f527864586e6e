//! The names of a model's joints as keys of a simulation file.

use tunenet_core::text::visible;
use tunenet_formats::{Error, Result};

use super::super::Model;
use crate::SimulationFile;
use crate::simulation_file::is_name;

/// The name of a joint as a key: every other character than letters, digits and `_` becomes `_`, and `j` goes before a digit in front.
/// `left/elbow-1` is `left_elbow_1`.
#[must_use]
pub fn key_of(name: &str) -> String {
    let key: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if key.starts_with(|c: char| c.is_ascii_digit()) { format!("j{key}") } else { key }
}

/// The model with the keys of its joints for their names. A joint whose key another one has keeps its name, which is no key then.
#[must_use]
pub fn keyed(mut model: Model) -> Model {
    let names: Vec<String> = model.joints().into_iter().map(|joint| joint.name.clone()).collect();
    let taken = |key: &str| names.iter().filter(|name| *name == key || key_of(name) == key).count();
    for body in &mut model.bodies {
        let key = key_of(&body.joint.name);
        if !is_name(&body.joint.name) && is_name(&key) && taken(&key) == 1 {
            body.joint.name = key;
        }
    }
    model
}

/// The name in the model of the joint that the file calls `key`.
///
/// # Errors
/// [`Error::File`] where the model has no such joint.
pub fn named<'m>(file: &SimulationFile, whole: &'m Model, key: &str) -> Result<&'m str> {
    let (own, keys) = (whole.joints(), keyed(whole.clone()));
    let at = keys.joints().iter().position(|joint| joint.name == key);
    if let Some(joint) = at.and_then(|at| own.get(at)) {
        return Ok(&joint.name);
    }
    let names: Vec<String> = keys.joints().iter().map(|joint| visible(&joint.name)).collect();
    let message = format!("`joints.{key}`: expected a joint of the model ({}), found none", names.join(", "));
    Err(Error::file(file.path(), message, "name the table as the model names the joint"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::arm::model_file::parse_mjcf;

    fn keys(names: [&str; 3]) -> Vec<String> {
        let [a, b, c] = names;
        let text = format!(
            "<mujoco><worldbody><body><joint name='{a}'/><geom size='0.1'/><body><joint name='{b}'/><geom size='0.1'/>\
             <body><joint name='{c}'/><geom size='0.1'/></body></body></body></worldbody></mujoco>"
        );
        let model = keyed(parse_mjcf(Path::new("m.xml"), &text).unwrap());
        model.joints().into_iter().map(|joint| joint.name.clone()).collect()
    }

    #[test]
    fn every_character_that_no_key_has_becomes_a_line() {
        assert_eq!(keys(["hip", "left/elbow-1", "2.knee"]), ["hip", "left_elbow_1", "j2_knee"]);
        // Which of both would be meant, nobody can say.
        assert_eq!(keys(["a-b", "a.b", "c"]), ["a-b", "a.b", "c"]);
        assert_eq!(keys(["a-b", "a_b", "c"]), ["a-b", "a_b", "c"]);
    }
}
