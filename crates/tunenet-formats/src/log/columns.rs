//! Which of the numbers in a topic's messages are meant, where they are read as columns.

use tunenet_core::observation::{Channel, plain};

use super::topics::Topic;
use crate::csv::own_columns::scale_of;
use crate::joint_words::{self, JointQuantity, OfJoint};
use crate::quantity::{Meaning, Quantity, meaning};
use crate::recording::{ReadOptions, Role};
use crate::shown::list;
use crate::{Origin, Result};

/// How the columns of `topic` are read: with what follows from the names of joints, or from there being one column only.
pub(crate) fn reading(topic: &Topic, options: &ReadOptions) -> ReadOptions {
    let mut columns = options.columns.clone();
    for channel in &options.channels {
        let header = channel.header();
        if columns.iter().any(|(ours, _)| scale_of(ours, channel).is_some()) {
            continue;
        }
        let of_joint = of_joint(topic, channel).or_else(|| of_command(topic, options));
        let only = topic.columns.first().filter(|_| topic.columns.len() == 1 && options.role == Role::Driving);
        if let Some(theirs) = of_joint.or_else(|| only.cloned()) {
            columns.push((header, theirs));
        }
    }
    ReadOptions { columns, ..options.clone() }
}

/// The quantity of a joint that a channel is, and its array in a `JointState`.
fn quantity(channel: &Channel) -> Option<(JointQuantity, &'static str)> {
    match channel.unit.as_str() {
        "rad" | "m" => Some((JointQuantity::Position, "position")),
        "rad/s" | "m/s" => Some((JointQuantity::Velocity, "velocity")),
        "N·m" | "N" => Some((JointQuantity::Effort, "effort")),
        _ => None,
    }
}

/// The column of the joint that a channel is named after: `elbow` in rad is `position.elbow`, or `actual.positions.elbow`.
fn of_joint(topic: &Topic, channel: &Channel) -> Option<String> {
    let (quantity, array) = quantity(channel)?;
    let name = format!("{array}.{}", channel.name);
    if topic.columns.contains(&name) {
        return Some(name);
    }
    // A simulation file has joints by the nearest key: `wheel fl` is `wheel_fl`.
    let is_meant = |column: &&String| {
        let joint = column.strip_prefix(array).and_then(|rest| rest.strip_prefix('.'));
        joint.is_some_and(|joint| plain(joint) == channel.name.to_lowercase())
    };
    let by_words = |column: &&String| {
        let found = joint_words::of_joint(column, None, &channel.name);
        found == Some(OfJoint { quantity: Some(quantity), command: false })
    };
    only(topic.columns.iter().filter(is_meant)).or_else(|| only(topic.columns.iter().filter(by_words))).cloned()
}

/// The column of the commands to the joint that an input drives: `position.elbow` in a topic of commands, `desired.positions.elbow` in any.
fn of_command(topic: &Topic, options: &ReadOptions) -> Option<String> {
    let joint = options.commanded.as_ref().filter(|_| options.role == Role::Driving)?;
    let (wanted, _) = quantity(joint)?;
    let names_it = Some(topic.name.as_str()).filter(|_| topic.columns.len() == 1);
    let named = options.topic.as_deref() == Some(topic.name.as_str());
    let of = |column: &str| {
        let by_topic = || joint_words::of_joint(column, Some(names_it?), &joint.name);
        let found = joint_words::of_joint(column, None, &joint.name).or_else(by_topic)?;
        (found.command || topic.is_command() || named).then_some(found.quantity)
    };
    let stated = |column: &&String| of(column) == Some(Some(wanted));
    let bare = |column: &&String| of(column) == Some(None);
    only(topic.columns.iter().filter(stated)).or_else(|| only(topic.columns.iter().filter(bare))).cloned()
}

/// Whether `topic` has the commands to the joint that an input drives.
pub(crate) fn commands(topic: &Topic, options: &ReadOptions) -> bool {
    of_command(topic, options).is_some()
}

/// The only one there is.
fn only<T>(mut all: impl Iterator<Item = T>) -> Option<T> {
    all.next().filter(|_| all.next().is_none())
}

/// Whether what is asked for are columns of `topic`, rather than what its messages make by themselves.
pub(crate) fn asked(topic: &Topic, options: &ReadOptions) -> bool {
    let is_column = |theirs: &str| {
        let bare = theirs.strip_prefix('-').unwrap_or(theirs);
        let pattern = bare.split_once('*').is_some_and(|(start, end)| {
            topic.columns.iter().any(|name| name.starts_with(start) && name.ends_with(end))
        });
        pattern || topic.columns.iter().any(|name| name == bare)
    };
    let mapped = options.columns.iter().any(|(_, theirs)| is_column(theirs));
    let by_joint =
        options.channels.iter().any(|c| of_joint(topic, c).is_some()) || of_command(topic, options).is_some();
    !topic.columns.is_empty() && (topic.usable.is_err() || mapped || by_joint)
}

/// The numbers of `topic` that are asked for: a message without one of them is another program's.
pub(crate) fn needed(topic: &Topic, options: &ReadOptions) -> Vec<String> {
    let bare = |(_, theirs): (String, String)| theirs.strip_prefix('-').map(str::to_owned).unwrap_or(theirs);
    let asked = reading(topic, options).columns.into_iter().map(bare);
    let named = topic.columns.iter().filter(|name| options.channels.iter().any(|c| scale_of(name, c).is_some()));
    let mut all: Vec<String> = asked.filter(|name| topic.columns.contains(name)).chain(named.cloned()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Refuses `--columns` that no message of `topic` has, where its messages make an observation by themselves.
pub(crate) fn refuse_unused(topic: &Topic, options: &ReadOptions) -> Result<()> {
    let Some((_, theirs)) = options.columns.first().filter(|_| options.channels.is_empty()) else { return Ok(()) };
    let numbers = list(topic.columns.iter().map(String::as_str), 6);
    let (expected, found) = (format!("numbers of `{}` ({numbers})", topic.name), format!("`{theirs}`"));
    Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: "columns", expected, found }.into())
}

/// Whether `topic` has a column for everything that is asked for, its clock apart.
pub(crate) fn has_all(topic: &Topic, options: &ReadOptions) -> bool {
    let read = reading(topic, options);
    let mapped = |is: &dyn Fn(&str) -> bool| {
        read.columns.iter().any(|(ours, theirs)| {
            let bare = theirs.strip_prefix('-').unwrap_or(theirs);
            is(ours) && topic.columns.iter().any(|name| name == bare)
        })
    };
    let named = |channel: &Channel| {
        mapped(&|ours| scale_of(ours, channel).is_some()) || topic.columns.contains(&channel.header())
    };
    let is_time = |ours: &str| matches!(meaning(ours), Meaning::Known(Quantity::Time, _));
    match options.channels.as_slice() {
        [] => {
            !options.columns.is_empty()
                && options.columns.iter().all(|(ours, _)| is_time(ours) || mapped(&|other| other == ours))
        }
        channels => channels.iter().all(named),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::observation::Kind;

    fn topic(columns: &[&str], usable: bool) -> Topic {
        Topic {
            name: "/a".into(),
            schema: String::new(),
            encoding: "cdr".into(),
            messages: 9,
            span_ns: None,
            usable: if usable { Ok(Kind::Joints) } else { Err("no".into()) },
            columns: columns.iter().map(|name| (*name).to_owned()).collect(),
            layouts: Vec::new(),
            undefined: None,
        }
    }

    fn options(channels: &[&str], columns: &[(&str, &str)], role: Role) -> ReadOptions {
        ReadOptions {
            channels: channels.iter().map(|header| Channel::from_header(header).unwrap()).collect(),
            columns: columns.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect(),
            role,
            ..ReadOptions::default()
        }
    }

    #[test]
    fn joints_are_found_by_their_names_and_a_single_number_by_itself() {
        let joints = topic(&["position.elbow", "velocity.elbow"], true);
        let by_name = options(&["elbow_rad", "elbow_rad_s"], &[], Role::Predicted);
        assert!(asked(&joints, &by_name));
        let renamed = topic(&["position.Wheel fl", "position.wheel.rr"], true);
        let of = |header| of_joint(&renamed, &Channel::from_header(header).unwrap());
        assert_eq!(of("wheel_fl_rad").as_deref(), Some("position.Wheel fl"));
        assert_eq!((of("wheel_rr_rad").as_deref(), of("wheel_rad")), (Some("position.wheel.rr"), None));
        let pairs = reading(&joints, &by_name).columns;
        assert_eq!(pairs[1], ("elbow_rad_s".into(), "velocity.elbow".into()));
        assert!(!asked(&joints, &options(&["q1_rad"], &[], Role::Predicted)));
        let in_degrees = options(&["elbow_rad"], &[("elbow_deg", "position.elbow")], Role::Predicted);
        assert!(has_all(&joints, &in_degrees));
        assert_eq!(reading(&joints, &in_degrees).columns, in_degrees.columns);
        let single = topic(&["data"], false);
        let input = options(&["force_n"], &[], Role::Driving);
        assert_eq!(reading(&single, &input).columns, [("force_n".to_owned(), "data".to_owned())]);
        assert_eq!(reading(&single, &ReadOptions { role: Role::Predicted, ..input }).columns, []);
    }

    #[test]
    fn columns_that_are_named_are_read_as_columns() {
        let joints = topic(&["position.elbow"], true);
        for theirs in ["position.elbow", "-position.elbow", "position.*"] {
            assert!(asked(&joints, &options(&[], &[("q1_rad", theirs)], Role::Predicted)), "{theirs}");
        }
        assert!(!asked(&joints, &options(&[], &[("q1_rad", "other")], Role::Predicted)));
    }
}
