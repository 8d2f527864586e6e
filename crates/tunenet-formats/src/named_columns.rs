//! The columns of a recording in any format, as one names them, and what their numbers suggest.

use std::path::Path;

use tunenet_core::observation::Channel;
use tunenet_core::statistics::median;

use crate::contents::Contents;
use crate::joint_words::{OfJoint, of_joint};
use crate::recording::{ReadOptions, Recording};
use crate::{EpisodeColumn, Result, read};

/// A column of numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedColumn {
    /// Its name: `elbow_rad`, `position.elbow`.
    pub name: String,
    /// The topic of a log that it stands in.
    pub topic: Option<String>,
    /// Whether that topic holds commands, by its type or by its name.
    of_commands: bool,
    /// Whether it is the only one of its topic, whose name is then its own.
    alone: bool,
}

impl NamedColumn {
    /// What it holds of the joint of this name; `None` where its name has words of something else.
    #[must_use]
    pub fn of_joint(&self, joint: &str) -> Option<OfJoint> {
        let topic = self.topic.as_deref().filter(|_| self.alone);
        let by_topic = || of_joint(&self.name, Some(topic?), joint);
        let found = of_joint(&self.name, None, joint).or_else(by_topic)?;
        Some(OfJoint { command: found.command || self.of_commands, ..found })
    }

    /// Whether it is a number without a name, in a topic of commands: `data.0` of `/arm_controller/commands`.
    #[must_use]
    pub fn is_unnamed_command(&self) -> bool {
        let numbered = self.name.rsplit('.').next().is_some_and(|last| last.parse::<u32>().is_ok());
        self.of_commands && numbered
    }
}

impl Contents {
    /// Its columns of numbers, in their order; those of a log topic by topic.
    #[must_use]
    pub fn named_columns(&self) -> Vec<NamedColumn> {
        let plain = |name: &String| NamedColumn { name: name.clone(), topic: None, of_commands: false, alone: false };
        match self {
            Self::Table(table) => table.columns.iter().map(|c| plain(&c.name)).filter(|c| !c.name.is_empty()).collect(),
            Self::Episodes(found) => found.columns.iter().map(|column| plain(&column.name)).collect(),
            Self::Log(log) => {
                let of = |topic: &'_ crate::Topic| {
                    let (name, of_commands, alone) = (topic.name.clone(), topic.is_command(), topic.columns.len() == 1);
                    let one = move |column: &String| NamedColumn {
                        topic: Some(name.clone()),
                        of_commands,
                        alone,
                        ..plain(column)
                    };
                    topic.columns.iter().map(one).collect::<Vec<_>>()
                };
                log.topics.iter().flat_map(of).collect()
            }
        }
    }
}

/// What the numbers of these columns of a table, or of one topic, suggest, and how often they come, in rows per second. `options` name
/// the clock and the topic.
///
/// # Errors
/// As [`read`](crate::read()).
pub fn suggested_units(
    path: &Path,
    options: &ReadOptions,
    columns: &[String],
) -> Result<(Vec<EpisodeColumn>, Option<f64>)> {
    let name = |number: usize| format!("number{number}");
    let channels = (0..columns.len()).map(|number| Channel::new(name(number), "1")).collect();
    let own = columns.iter().enumerate().map(|(number, column)| (name(number), column.clone()));
    let columns_read = options.columns.iter().cloned().chain(own).collect();
    let Recording { observation, .. } =
        read(path, &ReadOptions { columns: columns_read, channels, ..options.clone() })?;
    let described = columns.iter().enumerate().map(|(number, column)| {
        EpisodeColumn::of(column, &observation.column(number).collect::<Vec<f64>>(), &options.units)
    });
    let rate_hz = median(observation.clock().windows(2).map(|pair| pair[1] - pair[0])).map(f64::recip);
    Ok((described.collect(), rate_hz))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contents_with;
    use crate::testing::{Made, bag, file, joints, made};

    #[test]
    fn columns_of_a_table_are_described_by_their_numbers() {
        let row =
            |i: u32| format!("{},{},{}\n", f64::from(i) / 50.0, f64::from(i * i * 7 % 911) * 360.0 / 4096.0, i % 3);
        let text: String = std::iter::once("time,elbow,action.elbow\n".to_owned()).chain((0..60).map(row)).collect();
        let (_folder, path) = file("a.csv", text);
        let options = ReadOptions::default();
        let columns = contents_with(&path, &options).unwrap().named_columns();
        let of: Vec<Option<bool>> = columns.iter().map(|c| c.of_joint("elbow").map(|of| of.command)).collect();
        assert_eq!(of, [None, Some(false), Some(true)]);
        let options = ReadOptions { columns: vec![("t_s".into(), "time".into())], ..options };
        let (found, rate_hz) = suggested_units(&path, &options, &["elbow".into()]).unwrap();
        assert_eq!((found[0].proposed.as_deref(), rate_hz.map(f64::round)), (Some("deg"), Some(50.0)));
    }

    #[test]
    fn columns_of_a_log_have_their_topic() {
        let state = |stamp: i64, z: f64| joints(stamp, &["pan"], &[z], &[]);
        let topics: [Made; 2] =
            ["/joint_states", "/odd_arm/cmd"].map(|topic| made(topic, "sensor_msgs/msg/JointState", 20, state));
        // A topic with a single joint has the words of its robot.
        assert!(topics.iter().all(|topic| !topic.topic.contains("pan")));
        let (_folder, path) = file("a.mcap", bag(None, &topics));
        let columns = contents_with(&path, &ReadOptions::default()).unwrap().named_columns();
        let found: Vec<_> =
            columns.iter().map(|c| (c.topic.as_deref(), c.of_joint("pan").map(|of| of.command))).collect();
        assert_eq!(found, [(Some("/joint_states"), Some(false)), (Some("/odd_arm/cmd"), Some(true))]);
    }
}
