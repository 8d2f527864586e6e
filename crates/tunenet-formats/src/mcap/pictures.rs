//! Pictures in an MCAP log: `sensor_msgs/Image` and `sensor_msgs/CompressedImage` of ROS 2. They are handed on as they
//! stand; the caller decodes them.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::reader::{Messages, messages};
use crate::ros::cdr::{Header, fields};
use crate::ros::channel::ChannelInfo;
use crate::ros::stamps::{joined, to_s};
use crate::shown::shell_word;
use crate::{Error, Result};

/// Greatest plausible width and height, px.
const LARGEST_PX: u32 = 1 << 15;

/// One picture of a topic.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// When it was taken by its own stamp, s; when it was recorded, where it has none.
    pub time_s: f64,
    /// Its pixels.
    pub content: Content,
}

/// How a picture's pixels are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Content {
    /// Rows of pixels.
    Raw {
        /// px, 1 to 32768.
        width: u32,
        /// px, 1 to 32768.
        height: u32,
        /// ROS's name of the pixel's form: `rgb8`, `bgr8`, `mono8` …
        encoding: String,
        /// Bytes from one row to the next.
        step: usize,
        /// At least `step` × `height` bytes.
        bytes: Vec<u8>,
    },
    /// A file of its own, such as JPEG or PNG.
    Encoded(Vec<u8>),
}

/// How `sensor_msgs/msg/Image` begins; its bytes follow.
#[derive(Deserialize)]
struct ImageStart {
    header: Header,
    height: u32,
    width: u32,
    encoding: String,
    is_bigendian: u8,
    step: u32,
    length: u32,
}

/// How `sensor_msgs/msg/CompressedImage` begins.
#[derive(Deserialize)]
struct CompressedStart {
    header: Header,
    #[expect(dead_code, reason = "the bytes themselves identify the format")]
    format: String,
    length: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Raw,
    Compressed,
}

impl Form {
    fn of(channel: &ChannelInfo) -> Option<Self> {
        match (channel.message_encoding.as_str(), channel.schema_name.replace("/msg/", "/").as_str()) {
            ("cdr", "sensor_msgs/Image") => Some(Self::Raw),
            ("cdr", "sensor_msgs/CompressedImage") => Some(Self::Compressed),
            _ => None,
        }
    }
}

/// The pictures of one topic, in the order in which they stand there. Ends after the first error.
pub struct Pictures {
    path: PathBuf,
    messages: Messages,
    topic: String,
    count: u64,
    ended: bool,
}

/// The pictures of `topic`, or of the only topic with pictures, in the MCAP log at `path`.
///
/// # Errors
/// [`Error::Io`] where the file cannot be read; [`Error::File`] where it is no log, has no such topic, or has several with
/// pictures and none is named. The iterator returns [`Error::File`] once where a message cannot be used.
pub fn pictures(path: impl AsRef<Path>, topic: Option<&str>) -> Result<Pictures> {
    let path = path.as_ref();
    let mut found: Vec<String> = Vec::new();
    let mut reader = messages(path)?;
    for message in reader.by_ref() {
        // A log that is cut off still shows its topics; reading it says where it ends.
        let Ok(message) = message else { break };
        if Form::of(&message.channel).is_some() && !found.contains(&message.channel.topic) {
            found.push(message.channel.topic.clone());
        }
    }
    let listed = || found.iter().map(|t| format!("`{t}`")).collect::<Vec<_>>().join(", ");
    let chosen = match (topic, found.as_slice()) {
        (_, []) => {
            let message = "expected a topic of sensor_msgs/Image or CompressedImage in CDR, found none";
            return Err(Error::file(path, message, "`tunenet inspect` lists the topics"));
        }
        (Some(topic), _) if found.iter().any(|t| t == topic) => topic.to_owned(),
        (Some(topic), _) => {
            let message = format!("expected pictures in `{topic}`, found them in {}", listed());
            return Err(Error::file(path, message, format!("try `--topic {}`", shell_word(&found[0]))));
        }
        (None, [one]) => one.clone(),
        (None, _) => {
            let message = format!("expected one topic with pictures, found {}", listed());
            return Err(Error::file(path, message, format!("try `--topic {}`", shell_word(&found[0]))));
        }
    };
    Ok(Pictures { path: path.into(), messages: messages(path)?, topic: chosen, count: 0, ended: false })
}

impl Iterator for Pictures {
    type Item = Result<Picture>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.ended {
            let message = match self.messages.next()? {
                Ok(message) => message,
                Err(error) => {
                    self.ended = true;
                    return Some(Err(error));
                }
            };
            let Some(form) = Form::of(&message.channel).filter(|_| message.channel.topic == self.topic) else {
                continue;
            };
            self.count += 1;
            let log_s = to_s(i64::try_from(message.log_time).unwrap_or(i64::MAX));
            return Some(decode(form, &message.data, log_s).map_err(|why| {
                self.ended = true;
                let message = format!("picture {} of `{}` cannot be used: {why}", self.count, self.topic);
                Error::file(&self.path, message, "")
            }));
        }
        None
    }
}

fn decode(form: Form, data: &[u8], log_s: f64) -> std::result::Result<Picture, String> {
    match form {
        Form::Raw => {
            let (start, bytes) = start::<ImageStart>(data, |s| s.length)?;
            let ImageStart { header, height, width, encoding, step, is_bigendian, .. } = start;
            if !(1..=LARGEST_PX).contains(&width) || !(1..=LARGEST_PX).contains(&height) {
                return Err(format!("expected a size of at most {LARGEST_PX} px, found {width} × {height}"));
            }
            if is_bigendian != 0 && encoding.ends_with("16") {
                return Err(format!("expected pixels of 8 bits, found `{encoding}`"));
            }
            let step = step as usize;
            if bytes.len() < step * height as usize {
                return Err(format!("expected {} bytes, found {}", step * height as usize, bytes.len()));
            }
            let content = Content::Raw { width, height, encoding, step, bytes: bytes.to_vec() };
            Ok(Picture { time_s: stamp(&header, log_s), content })
        }
        Form::Compressed => {
            let (start, bytes) = start::<CompressedStart>(data, |s| s.length)?;
            Ok(Picture { time_s: stamp(&start.header, log_s), content: Content::Encoded(bytes.to_vec()) })
        }
    }
}

/// The fields before a message's bytes, and these.
fn start<T: for<'a> Deserialize<'a>>(
    data: &[u8],
    length: impl Fn(&T) -> u32,
) -> std::result::Result<(T, &[u8]), String> {
    let (fields, rest) = fields::<T>(data)?;
    let length = length(&fields) as usize;
    let bytes = rest.get(..length).ok_or_else(|| format!("expected {length} bytes, found {}", rest.len()))?;
    Ok((fields, bytes))
}

/// A stamp of zero counts as missing.
fn stamp(header: &Header, log_s: f64) -> f64 {
    let (sec, nanosec) = (i64::from(header.stamp.sec), i64::from(header.stamp.nanosec));
    if (sec, nanosec) == (0, 0) { log_s } else { joined(sec, nanosec).map_or(log_s, to_s) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Made, bag, file};

    /// A message by hand: stamp, frame, size, form, order, step, bytes.
    fn image(sec: i32, bytes: &[u8]) -> Vec<u8> {
        let mut data = vec![0, 1, 0, 0];
        data.extend(sec.to_le_bytes());
        data.extend(500_000_000u32.to_le_bytes());
        data.extend([4, 0, 0, 0, b'c', b'a', b'm', 0]);
        data.extend(1u32.to_le_bytes());
        data.extend(2u32.to_le_bytes());
        data.extend([5, 0, 0, 0, b'b', b'g', b'r', b'8', 0]);
        data.push(0);
        data.extend([0, 0]);
        data.extend(6u32.to_le_bytes());
        data.extend(6u32.to_le_bytes());
        data.extend(bytes);
        data
    }

    fn made(topic: &'static str, data: Vec<u8>) -> Made {
        Made { topic, schema: "sensor_msgs/msg/Image", definition: "text", encoding: "cdr", messages: vec![(7, data)] }
    }

    #[test]
    fn validate_a_raw_picture_by_hand() {
        let (_folder, path) = file("a.mcap", bag(None, &[made("/camera", image(3, &[1, 2, 3, 4, 5, 6]))]));
        let all: Vec<Picture> = pictures(&path, None).unwrap().collect::<Result<_>>().unwrap();
        let content =
            Content::Raw { width: 2, height: 1, encoding: "bgr8".into(), step: 6, bytes: vec![1, 2, 3, 4, 5, 6] };
        assert_eq!(all, [Picture { time_s: 3.5, content }]);
    }

    #[test]
    fn wrong_topics_and_short_messages_are_refused() {
        let (_folder, path) =
            file("a.mcap", bag(None, &[made("/a", image(1, &[1; 6])), made("/b", image(1, &[1, 2]))]));
        let error = |topic| pictures(&path, topic).err().unwrap().to_string();
        assert!(error(None).contains("expected one topic with pictures, found `/a`, `/b`"));
        assert!(error(Some("/c")).contains("expected pictures in `/c`"));
        let short = pictures(&path, Some("/b")).unwrap().next().unwrap().unwrap_err().to_string();
        assert!(short.contains("picture 1 of `/b` cannot be used: expected 6 bytes, found 2"), "{short}");
    }
}
