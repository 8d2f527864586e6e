//! The topics of an MCAP file, and which one to read.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use super::decoder::Decoder;
use super::joints::Joints;
use super::message::{NOTHING, Sample};
use super::records::{ChannelInfo, RawMessage, messages};
use crate::recording::Role;
use crate::shown::{counted, shell_word};
use crate::{Error, Result};
use tunenet_core::observation::Kind;

/// Most topics that a message names.
const MOST_NAMED: usize = 6;

/// Why a topic without messages cannot be used.
const SILENT: &str = "has no messages";

/// One topic of an MCAP file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    /// Its name: `/ball/point`.
    pub name: String,
    /// The name of its schema, empty where there is none: `geometry_msgs/msg/PointStamped`.
    pub schema: String,
    /// How its messages are written: `cdr`, `json`.
    pub encoding: String,
    /// How many messages it has.
    pub messages: u64,
    /// The kind of observation it makes, or why it makes none, to be read after the topic's name: "carries no positions".
    pub usable: std::result::Result<Kind, String>,
}

impl Topic {
    fn new(channel: &ChannelInfo) -> Self {
        Self {
            name: channel.topic.clone(),
            schema: channel.schema_name.clone(),
            encoding: channel.message_encoding.clone(),
            messages: 0,
            usable: Err(SILENT.into()),
        }
    }

    pub(crate) fn is(&self, channel: &ChannelInfo) -> bool {
        self.name == channel.topic && self.schema == channel.schema_name && self.encoding == channel.message_encoding
    }

    /// Counts a message; the first decides what the topic is good for.
    fn add(&mut self, message: &RawMessage) {
        if self.messages == 0 {
            self.usable = Decoder::of(&message.channel).and_then(|decoder| {
                let decoded = decoder.decode(&message.data)?;
                if let Sample::Joints(joints) = &decoded.sample {
                    Joints::new(joints, &[])?;
                }
                Ok(decoded.sample.kind())
            });
        }
        self.messages += 1;
    }

    fn described(&self) -> String {
        let kind = self.schema.rsplit('/').next().filter(|name| !name.is_empty()).unwrap_or(&self.encoding);
        format!("`{}` ({kind}, {})", self.name, counted(self.messages, "message"))
    }
}

/// All that a file says about itself.
#[derive(Debug)]
pub(crate) struct Survey {
    pub topics: Vec<Topic>,
    pub profile: String,
    pub library: String,
    /// When the first and the last message were recorded, in ns.
    pub log_ns: Option<(u64, u64)>,
    /// Where the file breaks off.
    pub ended: Option<Error>,
}

/// Goes through a file once and counts.
pub(crate) fn survey(path: &Path) -> Result<Survey> {
    let mut messages = messages(path)?;
    let mut topics: Vec<Topic> = Vec::new();
    let (mut ended, mut log_ns) = (None, None);
    let mut indices = Indices::default();
    let mut last: Option<(Arc<ChannelInfo>, usize)> = None;
    for message in messages.by_ref() {
        let message = match message {
            Ok(message) => message,
            Err(error @ Error::Io { .. }) => return Err(error),
            Err(error) => {
                ended = Some(error);
                break;
            }
        };
        let index = match &last {
            Some((channel, index)) if Arc::ptr_eq(channel, &message.channel) => *index,
            _ => indices.of(&mut topics, &message.channel),
        };
        topics[index].add(&message);
        let at = message.log_time;
        log_ns = log_ns.map_or(Some((at, at)), |(first, last): (u64, u64)| Some((first.min(at), last.max(at))));
        last = Some((message.channel, index));
    }
    for channel in messages.channels() {
        indices.of(&mut topics, channel);
    }
    topics.sort_by(|a, b| a.name.cmp(&b.name));
    let (profile, library) = messages.writer();
    Ok(Survey { profile: profile.to_owned(), library: library.to_owned(), topics, log_ns, ended })
}

/// Where a topic stands in a list, by its name, schema and encoding.
#[derive(Debug, Default)]
struct Indices(HashMap<(String, String, String), usize>);

impl Indices {
    /// That of the channel's topic, which is added where it is new.
    fn of(&mut self, topics: &mut Vec<Topic>, channel: &ChannelInfo) -> usize {
        let key = (channel.topic.clone(), channel.schema_name.clone(), channel.message_encoding.clone());
        *self.0.entry(key).or_insert_with(|| {
            topics.push(Topic::new(channel));
            topics.len() - 1
        })
    }
}

/// The topic to read: the one asked for, or the only one that can be used. What to try depends on the `role` of its channels.
pub(crate) fn choose<'a>(path: &Path, topics: &'a [Topic], asked: Option<&str>, role: Role) -> Result<&'a Topic> {
    let usable: Vec<&Topic> = topics.iter().filter(|topic| topic.usable.is_ok()).collect();
    let refuse = |message: String, hint: String| Err(Error::file(path, message, hint));
    let how = |topic: &&Topic| match role {
        Role::Predicted => format!("try `--topic {}`", shell_word(&topic.name)),
        Role::Driving => format!("write `topic = {:?}` into the input's table", topic.name),
    };
    let try_one = || usable.first().map_or(String::new(), how);
    if let Some(asked) = asked {
        if let Some(topic) = usable.iter().find(|topic| topic.name == asked) {
            return Ok(topic);
        }
        return match topics.iter().find(|topic| topic.name == asked) {
            Some(Topic { usable: Err(why), .. }) => refuse(format!("topic `{asked}` {why}"), try_one()),
            _ => refuse(format!("topic `{asked}` is not there: {}", overview(topics)), try_one()),
        };
    }
    match usable.as_slice() {
        [topic] => Ok(topic),
        [] => refuse(
            format!("no topic carries positions, joints or bounces: {}", overview(topics)),
            "record PointStamped, PoseStamped, Odometry or JointState in CDR or JSON".into(),
        ),
        _ => refuse(format!("several topics can be used: {}", overview(topics)), try_one()),
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
            let special = reasons.into_iter().find(|(_, why)| *why != NOTHING && *why != SILENT);
            let special = special.map_or(String::new(), |(topic, why)| format!("; `{}` {why}", topic.name));
            format!("found {}{special}", shown(other))
        }
        (usable, []) => format!("usable are {}", shown(usable)),
        (usable, other) => format!("usable are {}; {} more carry nothing to use", shown(usable), other.len()),
    }
}
