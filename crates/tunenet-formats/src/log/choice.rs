//! Which topic of a log to read.

use std::path::Path;

use super::columns;
use super::topics::{SILENT, Topic};
use crate::recording::{ReadOptions, Role};
use crate::ros::message::{NOTHING, NUMBERS};
use crate::shown::{list, shell_word};
use crate::{Error, Result};
use tunenet_core::observation::Kind;

/// Most topics that a message names.
const MOST_NAMED: usize = 6;

/// The topic to read: the one asked for, or the only one that can be used, or the only one that has the columns asked for. What to
/// try depends on the role of its channels.
pub(crate) fn choose<'a>(path: &Path, topics: &'a [Topic], options: &ReadOptions) -> Result<&'a Topic> {
    let (asked, role) = (options.topic.as_deref(), options.role);
    let usable: Vec<&Topic> = topics.iter().filter(|topic| topic.usable.is_ok()).collect();
    let with_columns: Vec<&Topic> = topics.iter().filter(|topic| columns::asked(topic, options)).collect();
    let refuse = |message: String, hint: String| Err(Error::file(path, message, hint));
    let how = |topic: &&Topic| match role {
        Role::Predicted | Role::Starting => format!("try `--topic {}`", shell_word(&topic.name)),
        Role::Driving => format!("write `topic = {:?}` into the input's table", topic.name),
    };
    let likely =
        || if role == Role::Driving { likely_input(topics, options) } else { likely_measured(&usable, options) };
    let try_one = || likely().map_or(String::new(), |topic| how(&topic));
    if let Some(asked) = asked {
        if let Some(topic) = usable.iter().find(|topic| topic.name == asked) {
            return Ok(topic);
        }
        return match topics.iter().find(|topic| topic.name == asked) {
            Some(topic) if !topic.columns.is_empty() => Ok(topic),
            Some(Topic { usable: Err(why), undefined: Some(kind), .. }) => {
                let file = format!("{}.msg", kind.rsplit('/').next().unwrap_or_default());
                refuse(
                    format!("topic `{asked}` {why}"),
                    format!("give its definition: `--msg {file}`, the file that the program was built with"),
                )
            }
            Some(Topic { usable: Err(why), .. }) => refuse(format!("topic `{asked}` {why}"), try_one()),
            _ => refuse(format!("topic `{asked}` is not there: {}", overview(topics, role)), try_one()),
        };
    }
    let named: Vec<&Topic> = with_columns.iter().filter(|topic| columns::has_all(topic, options)).copied().collect();
    let fits = |topic: &&Topic| match role {
        Role::Driving => options.commanded.is_some() && columns::commands(topic, options),
        Role::Predicted | Role::Starting => !topic.is_command(),
    };
    let fitting: Vec<&Topic> = named.iter().copied().filter(fits).collect();
    if let ([topic], _) | (_, [topic]) = (&named[..], &fitting[..]) {
        return Ok(topic);
    }
    match usable.as_slice() {
        [topic] => Ok(topic),
        [] if !with_columns.is_empty() => refuse(
            format!("no topic carries positions, joints or bounces: {}", overview(topics, role)),
            numbers(&with_columns, options),
        ),
        [] => refuse(
            format!("no topic carries positions, joints or bounces: {}", overview(topics, role)),
            "record PointStamped, PoseStamped, Odometry or JointState in CDR or JSON".into(),
        ),
        _ => refuse(format!("several topics can be used: {}", overview(topics, role)), try_one()),
    }
}

/// The topic that most likely holds what was measured: of joints, that comes more often than what was commanded. A topic that an input
/// names is none.
fn likely_measured<'a>(usable: &[&'a Topic], options: &ReadOptions) -> Option<&'a Topic> {
    let free = || usable.iter().filter(|topic| !options.input_topics.contains(&topic.name));
    let joints = free().filter(|topic| topic.usable == Ok(Kind::Joints) && !topic.is_command());
    let often = joints.max_by_key(|topic| (topic.messages, std::cmp::Reverse(&topic.name)));
    often.or(free().next()).copied()
}

/// The topic that most likely holds an input: one that has the columns asked for, before others; commands and plain numbers, which nothing
/// else is made of, before what makes an observation by itself.
fn likely_input<'a>(topics: &'a [Topic], options: &ReadOptions) -> Option<&'a Topic> {
    let rank = |topic: &&Topic| {
        let named = columns::asked(topic, options) && columns::has_all(topic, options);
        (!named, !is_own(topic), topic.usable.is_ok() && !topic.is_command())
    };
    topics.iter().filter(|topic| can_drive(topic)).min_by_key(rank)
}

/// Whether an input may stand in a topic.
fn can_drive(topic: &Topic) -> bool {
    topic.usable.is_ok() || !topic.columns.is_empty()
}

/// Whether a user records it for itself: not what every node writes about itself.
fn is_own(topic: &Topic) -> bool {
    !topic.schema.starts_with("rcl_interfaces/") && !topic.schema.contains("/srv/")
}

/// What to type to read the numbers of a topic.
fn numbers(topics: &[&Topic], options: &ReadOptions) -> String {
    let free = |topic: &Topic| options.role == Role::Driving || !options.input_topics.contains(&topic.name);
    let Some(topic) = topics.iter().min_by_key(|topic| (!free(topic), !is_own(topic))) else { return String::new() };
    let columns = list(topic.columns.iter().map(String::as_str), MOST_NAMED);
    let name = shell_word(&topic.name);
    match options.role {
        Role::Driving => {
            format!("write `topic = {:?}` and `column` into the input's table; it has {columns}", topic.name)
        }
        Role::Predicted | Role::Starting => {
            let first = shell_word(topic.columns.first().map_or("", String::as_str));
            format!("name numbers, as in `--topic {name} --columns z_m={first}`; it has {columns}")
        }
    }
}

/// The topics that are usable in this role, with type and count, and the number of the others; all topics where nothing is usable.
fn overview(topics: &[Topic], role: Role) -> String {
    let shown = |topics: &[&Topic]| {
        let named: Vec<String> = topics.iter().take(MOST_NAMED).map(|topic| topic.described()).collect();
        match topics.len().saturating_sub(MOST_NAMED) {
            0 => named.join(", "),
            more => format!("{} and {more} more", named.join(", ")),
        }
    };
    let (usable, other): (Vec<&Topic>, Vec<&Topic>) =
        topics.iter().partition(|topic| if role == Role::Driving { can_drive(topic) } else { topic.usable.is_ok() });
    match (usable.as_slice(), other.as_slice()) {
        ([], []) => "the file has no topics".into(),
        ([], other) => {
            // A wrong encoding or a broken message is what a user can do something about.
            let reasons = other.iter().filter_map(|topic| Some((topic, topic.usable.as_ref().err()?)));
            let special = reasons.into_iter().find(|(_, why)| ![NOTHING, NUMBERS, SILENT].contains(&why.as_str()));
            let special = special.map_or(String::new(), |(topic, why)| format!("; `{}` {why}", topic.name));
            format!("found {}{special}", shown(other))
        }
        (usable, []) => format!("usable are {}", shown(usable)),
        (usable, other) => format!("usable are {}; {} more carry nothing to use", shown(usable), other.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::error_text;

    fn topic(name: &str, schema: &str, messages: u64, columns: &[&str]) -> Topic {
        let usable = if schema.contains("Joint") { Ok(Kind::Joints) } else { Err(NUMBERS.into()) };
        let columns = columns.iter().map(|name| (*name).to_owned()).collect();
        let (name, schema) = (name.into(), schema.into());
        Topic {
            name,
            schema,
            encoding: "cdr".into(),
            messages,
            span_ns: None,
            usable,
            columns,
            layouts: Vec::new(),
            undefined: None,
        }
    }

    fn refused(topics: &[Topic], options: &ReadOptions) -> (String, String) {
        error_text(&choose(Path::new("a.mcap"), topics, options).unwrap_err())
    }

    /// What measures is not proposed for what drives, where the log has commands.
    #[test]
    fn an_input_is_looked_for_where_commands_are() {
        let states = topic("/joint_states", "sensor_msgs/msg/JointState", 900, &["position.pan"]);
        let commands = topic("/cmd/commands", "std_msgs/msg/Float64MultiArray", 400, &["data.0"]);
        let events = topic("/parameter_events", "rcl_interfaces/msg/ParameterEvent", 1, &["stamp.sec"]);
        let columns = [("pan_goal_rad".to_owned(), "data.0".to_owned())];
        let options = |role, columns: &[(String, String)]| ReadOptions {
            topic: Some("/cmd/nope".into()),
            columns: columns.to_vec(),
            role,
            ..ReadOptions::default()
        };
        let topics = [events, states, commands];
        for columns in [&columns[..], &[]] {
            let (message, hint) = refused(&topics, &options(Role::Driving, columns));
            assert!(message.contains("`/cmd/commands` (Float64MultiArray, 400 messages)"), "{message}");
            assert!(!message.contains("nothing to use"), "{message}");
            assert_eq!(hint, "write `topic = \"/cmd/commands\"` into the input's table");
        }
        let (_, hint) = refused(&topics, &options(Role::Predicted, &[]));
        assert_eq!(hint, "try `--topic /joint_states`");
    }

    /// Commands may come as often as measurements, and in messages of the same type.
    #[test]
    fn a_topic_that_an_input_names_is_not_proposed_for_what_is_predicted() {
        let states = topic("/joint_states", "sensor_msgs/msg/JointState", 400, &["position.pan"]);
        let commands = topic("/arm/joints", "sensor_msgs/msg/JointState", 900, &["position.pan"]);
        let topics = [commands, states];
        let options = ReadOptions::default();
        assert_eq!(refused(&topics, &options).1, "try `--topic /arm/joints`");
        let options = ReadOptions { input_topics: vec!["/arm/joints".into()], ..options };
        assert_eq!(refused(&topics, &options).1, "try `--topic /joint_states`");
    }
}
