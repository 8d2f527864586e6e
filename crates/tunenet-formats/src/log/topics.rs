//! The topics of a log, and which one to read.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use super::files::files;
use super::source::messages;
use crate::joint_words::is_of_commands;
use crate::ros::cdr::Type;
use crate::ros::channel::{ChannelInfo, RawMessage};
use crate::ros::joints::Joints;
use crate::ros::message::{JointMessage, NOTHING, NUMBERS, Sample, Way};
use crate::ros::schema::{Given, Unread};
use crate::ros::wanted::{Wanted, first_of};
use crate::shown::counted;
use crate::{Error, Result};
use tunenet_core::observation::Kind;

/// Why a topic without messages cannot be used.
pub(super) const SILENT: &str = "has no messages";

/// One topic of a log.
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
    /// When the first and the last of them were recorded, in ns.
    pub span_ns: Option<(u64, u64)>,
    /// The kind of observation it makes, or why it makes none, to be read after the topic's name: "carries no positions".
    pub usable: std::result::Result<Kind, String>,
    /// The names of the numbers in its first messages, which `--columns` and the `column` of an input may take: `data`, `linear.x`,
    /// `position.elbow`. Empty where they are not known.
    pub columns: Vec<String>,
    /// The same by message, each layout once: several programs may publish on the topic, each some of the joints.
    pub layouts: Vec<Vec<String>>,
    /// The type that nothing defines, where that is why it is not read.
    pub undefined: Option<String>,
}

impl Topic {
    fn new(channel: &ChannelInfo) -> Self {
        Self {
            name: channel.topic.clone(),
            schema: channel.schema_name.clone(),
            encoding: channel.message_encoding.clone(),
            messages: 0,
            span_ns: None,
            usable: Err(SILENT.into()),
            columns: Vec::new(),
            layouts: Vec::new(),
            undefined: None,
        }
    }

    pub(crate) fn is(&self, channel: &ChannelInfo) -> bool {
        self.name == channel.topic && self.schema == channel.schema_name && self.encoding == channel.message_encoding
    }

    /// Its messages, all of them.
    pub(super) fn wanted(&self) -> Wanted {
        Wanted::Topic { name: self.name.clone(), schema: self.schema.clone(), encoding: self.encoding.clone() }
    }

    /// Counts a message; the first decides what the topic is good for, and several what joints it has.
    fn add(&mut self, message: &RawMessage) {
        let decoder = message.channel.decoder.as_ref();
        if self.messages < first_of(&self.schema, &self.encoding) {
            let rows = decoder.ok().and_then(|decoder| decoder.rows(&message.data, true).ok()).unwrap_or_default();
            let names = rows.into_iter().next().unwrap_or_default().names;
            for name in &names {
                if !self.columns.contains(name) {
                    self.columns.push(name.clone());
                }
            }
            if !names.is_empty() && !self.layouts.contains(&names) {
                self.layouts.push(names);
            }
        }
        if self.messages == 0 {
            if let Err(Unread::Undefined(name)) = decoder {
                self.undefined = Some(name.clone());
            }
            self.usable = decoder.map_err(ToString::to_string).and_then(|decoder| {
                let decoded = decoder.decode(&message.data, false)?;
                match &decoded.sample {
                    Sample::Joints(joints) => drop(Joints::new(joints, &[])?),
                    Sample::Way(way) => drop(Joints::new(&first(way)?, &[])?),
                    Sample::Numbers(_) => return Err(if self.columns.is_empty() { NOTHING } else { NUMBERS }.into()),
                    Sample::Position(_) | Sample::Bounce(_) => {}
                }
                Ok(decoded.sample.kind())
            });
        }
        self.messages += 1;
        let (at, known) = (message.log_time, self.span_ns.unwrap_or((message.log_time, message.log_time)));
        self.span_ns = Some((known.0.min(at), known.1.max(at)));
    }

    /// Messages per second between the first and the last one, by the times of recording; `None` where they have one time.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        let (first, last) = self.span_ns?;
        let span_s = last.saturating_sub(first) as f64 * 1e-9;
        (span_s > 0.0).then(|| self.messages.saturating_sub(1) as f64 / span_s)
    }

    /// Whether its messages state where joints are meant to be, not where they were: by its type, or by its name.
    #[must_use]
    pub fn is_command(&self) -> bool {
        Type::of(&self.schema) == Some(Type::JointTrajectory) || is_of_commands(&self.name)
    }

    pub(super) fn described(&self) -> String {
        let kind = self.schema.rsplit('/').next().filter(|name| !name.is_empty()).unwrap_or(&self.encoding);
        format!("`{}` ({kind}, {})", self.name, counted(self.messages, "message"))
    }
}

/// The first point of a way.
pub(crate) fn first(way: &Way) -> std::result::Result<JointMessage, String> {
    let (_, [position, velocity, effort]) = way.points.first().ok_or("holds a way without points")?.clone();
    Ok(JointMessage { name: way.name.clone(), position, velocity, effort })
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

/// Goes through the files of a log once and counts.
pub(crate) fn survey(path: &Path, given: &Given) -> Result<Survey> {
    let mut messages = messages(&files(path)?, given, Wanted::First)?;
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
    for channel in &messages.channels() {
        indices.of(&mut topics, channel);
    }
    topics.sort_by(|a, b| a.name.cmp(&b.name));
    let (profile, library) = messages.writer();
    Ok(Survey { topics, profile, library, log_ns, ended })
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
