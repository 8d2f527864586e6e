//! The task file: where plane, hoop and robot stand, and from which heights a ball may be released.

use std::path::Path;

use toml_edit::de::from_document;
use toml_edit::{Document, Item};
use tunenet_formats::read_text;
use tunenet_formats::{Error, Result};

use crate::scene::Task;
use crate::simulation_file::check::{Vocabulary, located, walk};
use crate::simulation_file::schema::{Key, Shape, key, lookup};

const FARTHEST_M: f64 = 1e3;
const STEEPEST_RAD: f64 = 1.5;
const TURN_RAD: f64 = 6.3;

/// The keys of a task file. Every place is in metres from the ball's centre when it touches the plane, z up.
pub const TASK_KEYS: &[Key] = &[
    key("kind", Shape::Word(&["shot"]), true, "the task that the file describes"),
    key("plane.tilt_about_x_rad", Shape::Number(-STEEPEST_RAD, STEEPEST_RAD), false, "tilt of the plane about x"),
    key("plane.tilt_about_y_rad", Shape::Number(-STEEPEST_RAD, STEEPEST_RAD), false, "tilt of the plane about y"),
    key("hoop.centre_m", Shape::Numbers(3, -FARTHEST_M, FARTHEST_M), true, "centre of the hoop"),
    key("hoop.radius_m", Shape::Number(1e-3, FARTHEST_M), true, "from its centre to the middle of its wire"),
    key("hoop.rim_radius_m", Shape::Number(0.0, FARTHEST_M), false, "half the wire's thickness (default: 0)"),
    key("hoop.tilt_about_x_rad", Shape::Number(-STEEPEST_RAD, STEEPEST_RAD), false, "tilt of the hoop about x"),
    key("hoop.tilt_about_y_rad", Shape::Number(-STEEPEST_RAD, STEEPEST_RAD), false, "tilt of the hoop about y"),
    key(
        "release.heights_m",
        Shape::Numbers(2, 1e-3, FARTHEST_M),
        true,
        "lowest and highest release of the ball's centre above the impact point",
    ),
    key(
        "release.position_sd_m",
        Shape::Number(0.0, 1.0),
        false,
        "standard deviation of the release position along each axis (default: 0)",
    ),
    key(
        "release.velocity_sd_m_s",
        Shape::Number(0.0, 10.0),
        false,
        "standard deviation of the release velocity along each axis (default: 0)",
    ),
    key("arm.urdf", Shape::Word(&[]), false, "robot that lets go; its path is seen from the task file"),
    key("arm.link", Shape::Word(&[]), false, "link that holds the ball"),
    key(
        "arm.grip_m",
        Shape::Numbers(3, -10.0, 10.0),
        false,
        "where that link holds the ball's centre, in its own frame",
    ),
    key("arm.tool_rpy_rad", Shape::Numbers(3, -TURN_RAD, TURN_RAD), false, "how that link is turned at the release"),
    key("arm.base_position_m", Shape::Numbers(3, -FARTHEST_M, FARTHEST_M), false, "where the robot's base stands"),
    key("arm.base_rpy_rad", Shape::Numbers(3, -TURN_RAD, TURN_RAD), false, "how it is turned"),
];

/// The keys of a task file, as a check of one needs them.
struct Keys;

impl Vocabulary for Keys {
    fn find(&self, path: &str) -> Option<Key> {
        TASK_KEYS.iter().find(|k| k.path == path).cloned()
    }

    fn has_table(&self, path: &str) -> bool {
        TASK_KEYS.iter().any(|k| k.path.starts_with(&format!("{path}.")))
    }

    fn siblings(&self, path: &str) -> Vec<String> {
        siblings(path)
    }

    fn unknown(&self, key: &str) -> String {
        format!("expected a key of a task file, found `{key}`")
    }

    fn passes_over(&self, _: &str) -> bool {
        false
    }
}

impl Task {
    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// As [`SimulationFile::read`](crate::SimulationFile::read).
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, &read_text(path)?)
    }

    /// Checks `text` as the content of `path`.
    ///
    /// ```
    /// use std::path::Path;
    /// use tunenet_sim::shot::Task;
    /// let text = "kind = \"shot\"\nrelease.heights_m = [0.3, 1.0]\nhoop = { centre_m = [0.8, 0, -0.3], radius_m = 0.11 }";
    /// assert_eq!(Task::parse(Path::new("shot.toml"), text)?.release.heights_m, (0.3, 1.0));
    /// let wrong = Task::parse(Path::new("shot.toml"), &text.replace("radius_m", "radius_cm")).unwrap_err();
    /// assert_eq!(wrong.to_string(), "shot.toml:3:37: expected a key of a task file, found `hoop.radius_cm`");
    /// # Ok::<(), tunenet_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Task::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let document = Document::parse(text).map_err(|e| {
            let hint = "a task file is TOML; assets/shot.toml is one to start from";
            located(path, text, e.span().unwrap_or(0..0), e.message().to_string(), hint)
        })?;
        let root = document.as_table();
        if root.get("kind").is_none() {
            let message = "expected `kind = \"shot\"`, found no `kind`";
            return Err(Error::file(path, message, "is this a task file? assets/shot.toml is one to start from"));
        }
        walk(&Keys, path, text, root, "")?;
        if let Some(key) = TASK_KEYS.iter().find(|k| k.required && lookup(root, &k.path).is_none()) {
            let message = format!("expected `{}` ({}), found none", key.path, key.meaning);
            let (table, name) = key.path.split_once('.').unwrap_or(("", &key.path));
            return Err(Error::file(path, message, format!("add `{name} = …` under [{table}]")));
        }
        if root.contains_key("arm") && lookup(root, "arm.urdf").is_none() {
            let message = "expected `arm.urdf` (robot that lets go), found none";
            return Err(Error::file(path, message, "add `urdf = \"robot.urdf\"` under [arm], or take [arm] away"));
        }
        let heights_span = lookup(root, "release.heights_m").and_then(Item::span).unwrap_or(0..0);
        let mut task: Self = from_document(document.clone().into_mut())
            .map_err(|e| Error::file(path, e.message(), "see docs/files.md for the keys and their values"))?;
        let (lowest, highest) = task.release.heights_m;
        if lowest >= highest {
            let message =
                format!("`release.heights_m`: expected the lowest before the highest, found [{lowest}, {highest}]");
            return Err(located(path, text, heights_span, message, "write [lowest, highest], in metres"));
        }
        if let Some(arm) = &mut task.arm {
            arm.urdf = path.parent().unwrap_or(Path::new("")).join(&arm.urdf);
        }
        Ok(task)
    }
}

/// The keys of the table that an unknown path is in; all tables where there is none.
fn siblings(path: &str) -> Vec<String> {
    let table = path.rsplit_once('.').map_or("", |(table, _)| table);
    let near =
        TASK_KEYS.iter().map(|k| k.path.to_string()).filter(|k| k.rsplit_once('.').map_or("", |(t, _)| t) == table);
    let near: Vec<String> = near.collect();
    if !table.is_empty() && !near.is_empty() {
        return near;
    }
    let mut heads: Vec<String> = TASK_KEYS.iter().filter_map(|k| Some(k.path.split('.').next()?.to_string())).collect();
    heads.dedup();
    heads
}

#[cfg(test)]
mod tests {
    use super::*;

    const TASK: &str =
        "kind = \"shot\"\n[hoop]\ncentre_m = [0.8, 0, -0.3]\nradius_m = 0.11\n[release]\nheights_m = [0.3, 1]\n";

    /// A list of keys and a struct are two descriptions of one file.
    #[test]
    fn every_key_is_a_field_of_the_task() {
        let parse = |text: &str| Task::parse(Path::new("shot.toml"), text).unwrap();
        let with_arm = format!("{TASK}[arm]\nurdf = \"a.urdf\"\n");
        let plain = parse(&with_arm);
        for key in TASK_KEYS.iter().filter(|key| key.path != "kind") {
            let value: toml_edit::Value = match key.shape {
                Shape::Number(low, high) => (low + 0.75 * (high - low)).into(),
                Shape::Numbers(count, ..) => (0..count).map(|i| 1.0 + i as f64).collect(),
                _ => "word".into(),
            };
            let mut document: toml_edit::DocumentMut = with_arm.parse().unwrap();
            let (table, name) = key.path.split_once('.').unwrap();
            document[table][name] = toml_edit::value(value);
            assert_ne!(parse(&document.to_string()), plain, "{} changes no field", key.path);
        }
    }

    #[test]
    fn what_is_left_out_has_its_default_and_the_urdf_is_found_next_to_the_file() {
        let task = Task::parse(Path::new("folder/shot.toml"), &format!("{TASK}[arm]\nurdf = \"a.urdf\"\n")).unwrap();
        assert_eq!((task.plane.tilt_rad(), task.hoop.rim_radius_m, task.release.position_sd_m), ([0.0; 2], 0.0, 0.0));
        let arm = task.arm.unwrap();
        assert_eq!((arm.urdf.as_path(), arm.tool_rpy_rad, arm.grip_m), (Path::new("folder/a.urdf"), None, [0.0; 3]));
        let refused = Task::parse(Path::new("shot.toml"), &format!("{TASK}[arm]\nlink = \"hand\"\n")).unwrap_err();
        assert!(refused.to_string().contains("expected `arm.urdf`"), "{refused}");
    }
}
