//! The task file: where plane, hoop and robot stand, and from which heights a ball may be let go.

use std::path::{Path, PathBuf};

use toml_edit::{Document, Item, Table};
use tunenet_core::{Error, Result};
use tunenet_formats::read_text;

use crate::simulation_file::check::{Vocabulary, located, walk};
use crate::simulation_file::schema::{Key, Shape, item_number, key, number};

const FARTHEST_M: f64 = 1e3;
const STEEPEST_RAD: f64 = 1.5;
const TURN_RAD: f64 = 6.3;

/// The keys of a task file. Every place is in metres from the ball's centre when it touches the plane, z up.
pub const TASK_KEYS: &[Key] = &[
    key("kind", Shape::Word(&["shot"]), true, "what is to be done"),
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

/// A bounce shot.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Tilt of the plane about x and y, rad.
    pub plane_tilt_rad: [f64; 2],
    /// Centre of the hoop, m.
    pub hoop_centre_m: [f64; 3],
    /// Tilt of the hoop about x and y, rad; level at 0.
    pub hoop_tilt_rad: [f64; 2],
    /// From its centre to the middle of its wire, m.
    pub hoop_radius_m: f64,
    /// Half the wire's thickness, m.
    pub hoop_rim_radius_m: f64,
    /// Lowest and highest release of the ball's centre, m.
    pub heights_m: (f64, f64),
    /// Standard deviation of the place of a release on each axis, m.
    pub release_position_sd_m: f64,
    /// Standard deviation of its velocity on each axis, m/s.
    pub release_velocity_sd_m_s: f64,
    /// What holds the ball; a hand that reaches everywhere where there is none.
    pub arm: Option<ArmTask>,
}

/// A robot that lets the ball go.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmTask {
    /// Its URDF.
    pub urdf: PathBuf,
    /// The link that holds the ball; the last one where the file does not say.
    pub link: Option<String>,
    /// Where that link holds the ball's centre, in its own frame, m.
    pub grip_m: [f64; 3],
    /// Roll, pitch and yaw of that link at the release, rad; any where the file does not say.
    pub tool_rpy_rad: Option<[f64; 3]>,
    /// Where the base stands, m.
    pub base_position_m: [f64; 3],
    /// Roll, pitch and yaw of the base, rad.
    pub base_rpy_rad: [f64; 3],
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
    /// assert_eq!(Task::parse(Path::new("shot.toml"), text)?.heights_m, (0.3, 1.0));
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
        if let Some(key) = TASK_KEYS.iter().find(|k| k.required && at(root, &k.path).is_none()) {
            let message = format!("expected `{}` ({}), found none", key.path, key.meaning);
            let (table, name) = key.path.split_once('.').unwrap_or(("", &key.path));
            return Err(Error::file(path, message, format!("add `{name} = …` under [{table}]")));
        }
        let single = |path: &str| at(root, path).and_then(item_number).unwrap_or(0.0);
        let tilt = |table: &str| ["x", "y"].map(|axis| single(&format!("{table}.tilt_about_{axis}_rad")));
        let heights: [f64; 2] = numbers(root, "release.heights_m").unwrap_or_default();
        if heights[0] >= heights[1] {
            let span = at(root, "release.heights_m").and_then(Item::span).unwrap_or(0..0);
            let message = format!(
                "`release.heights_m`: expected the lowest before the highest, found [{}, {}]",
                heights[0], heights[1]
            );
            return Err(located(path, text, span, message, "write [lowest, highest], in metres"));
        }
        Ok(Self {
            plane_tilt_rad: tilt("plane"),
            hoop_centre_m: numbers(root, "hoop.centre_m").unwrap_or_default(),
            hoop_tilt_rad: tilt("hoop"),
            hoop_radius_m: single("hoop.radius_m"),
            hoop_rim_radius_m: single("hoop.rim_radius_m"),
            heights_m: (heights[0], heights[1]),
            release_position_sd_m: single("release.position_sd_m"),
            release_velocity_sd_m_s: single("release.velocity_sd_m_s"),
            arm: arm(path, root)?,
        })
    }
}

fn arm(path: &Path, root: &Table) -> Result<Option<ArmTask>> {
    if root.get("arm").is_none() {
        return Ok(None);
    }
    let word = |key: &str| at(root, key).and_then(Item::as_str).map(str::to_owned);
    let Some(urdf) = word("arm.urdf") else {
        let message = "expected `arm.urdf` (robot that lets go), found none";
        return Err(Error::file(path, message, "add `urdf = \"robot.urdf\"` under [arm], or take [arm] away"));
    };
    Ok(Some(ArmTask {
        urdf: path.parent().unwrap_or(Path::new("")).join(urdf),
        link: word("arm.link"),
        grip_m: numbers(root, "arm.grip_m").unwrap_or_default(),
        tool_rpy_rad: numbers(root, "arm.tool_rpy_rad"),
        base_position_m: numbers(root, "arm.base_position_m").unwrap_or_default(),
        base_rpy_rad: numbers(root, "arm.base_rpy_rad").unwrap_or_default(),
    }))
}

fn numbers<const N: usize>(root: &Table, path: &str) -> Option<[f64; N]> {
    let values: Vec<f64> = at(root, path)?.as_array()?.iter().filter_map(number).collect();
    values.try_into().ok()
}

fn at<'a>(root: &'a Table, path: &str) -> Option<&'a Item> {
    let mut parts = path.split('.');
    let mut item = root.get(parts.next()?)?;
    for part in parts {
        item = item.as_table_like()?.get(part)?;
    }
    Some(item)
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
