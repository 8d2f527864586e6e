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
    // Of joints, what was measured comes more often than what was commanded.
    let likely = || {
        let joints = usable.iter().filter(|topic| topic.usable == Ok(Kind::Joints) && !topic.is_command());
        let often = joints.max_by_key(|topic| (topic.messages, std::cmp::Reverse(&topic.name)));
        often.filter(|_| role != Role::Driving).or(usable.first())
    };
    let try_one = || likely().map_or(String::new(), how);
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
            _ => refuse(format!("topic `{asked}` is not there: {}", overview(topics)), try_one()),
        };
    }
    let named: Vec<&Topic> = with_columns.iter().filter(|topic| columns::has_all(topic, options)).copied().collect();
    let measured: Vec<&Topic> = named.iter().filter(|topic| !topic.is_command()).copied().collect();
    if let ([topic], _) | (_, ([topic], Role::Predicted | Role::Starting)) = (&named[..], (&measured[..], role)) {
        return Ok(topic);
    }
    match usable.as_slice() {
        [topic] => Ok(topic),
        [] if !with_columns.is_empty() => refuse(
            format!("no topic carries positions, joints or bounces: {}", overview(topics)),
            numbers(&with_columns, options),
        ),
        [] => refuse(
            format!("no topic carries positions, joints or bounces: {}", overview(topics)),
            "record PointStamped, PoseStamped, Odometry or JointState in CDR or JSON".into(),
        ),
        _ => refuse(format!("several topics can be used: {}", overview(topics)), try_one()),
    }
}

/// What to type to read the numbers of a topic.
fn numbers(topics: &[&Topic], options: &ReadOptions) -> String {
    // What a user records is seldom what every node writes about itself.
    let own = |topic: &&&Topic| !topic.schema.starts_with("rcl_interfaces/") && !topic.schema.contains("/srv/");
    let Some(topic) = topics.iter().find(own).or(topics.first()) else { return String::new() };
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

/// The usable topics with type and count and the number of the others; all topics where nothing is usable.
fn overview(topics: &[Topic]) -> String {
    let shown = |topics: &[&Topic]| {
        let named: Vec<String> = topics.iter().take(MOST_NAMED).map(|topic| topic.described()).collect();
        match topics.len().saturating_sub(MOST_NAMED) {
            0 => named.join(", "),
            more => format!("{} and {more} more", named.join(", ")),
        }
    };
    let (usable, other): (Vec<&Topic>, Vec<&Topic>) = topics.iter().partition(|topic| topic.usable.is_ok());
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
