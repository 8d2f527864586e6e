//! The messages of a log, in one file or in several that follow each other.

use std::path::{Path, PathBuf};
use std::sync::Arc;

#[cfg(feature = "logs")]
use crate::bag;
use crate::format::{Format, format};
use crate::mcap::reader;
use crate::ros::channel::{ChannelInfo, RawMessage};
use crate::ros::schema::Given;
use crate::ros::wanted::Wanted;
use crate::{Error, Result};

/// The messages of a log in the order of its files. Ends after the first error.
pub(crate) struct Messages {
    wanted: Wanted,
    given: Vec<(String, String)>,
    /// The files that follow, the next one last.
    later: Vec<PathBuf>,
    now: Option<One>,
    /// The channels of the files before.
    before: Vec<Arc<ChannelInfo>>,
    /// Profile and library of the first file that says so.
    writer: (String, String),
}

/// The messages of one file.
enum One {
    Mcap(Mcap),
    #[cfg(feature = "logs")]
    Bag(Box<bag::Messages>),
}

/// The messages of an MCAP file.
struct Mcap {
    messages: Box<reader::Messages>,
    /// Of a file that is compressed as a whole, the copy that they are read from, which goes away with them.
    #[cfg(feature = "logs")]
    _copy: Option<bag::Unpacked>,
}

impl One {
    #[cfg_attr(not(feature = "logs"), expect(unused_variables, reason = "only bags leave bytes unread"))]
    fn open(path: &Path, given: &Given, wanted: &Wanted) -> Result<Self> {
        match format(path)? {
            Format::Mcap => Ok(Self::Mcap(Mcap {
                messages: Box::new(reader::messages(path)?.with_definitions(given)),
                #[cfg(feature = "logs")]
                _copy: None,
            })),
            #[cfg(feature = "logs")]
            Format::PackedMcap => {
                let file = bag::unpacked(path)?;
                let messages = Box::new(reader::messages(file.path())?.of(path).with_definitions(given));
                Ok(Self::Mcap(Mcap { messages, _copy: Some(file) }))
            }
            #[cfg(feature = "logs")]
            Format::Bag => Ok(Self::Bag(Box::new(bag::Messages::open(path, given, wanted)?))),
            _ => Err(Error::file(path, "expected a log, found another file", "name the folder of the log")),
        }
    }

    fn next(&mut self) -> Option<Result<RawMessage>> {
        match self {
            Self::Mcap(mcap) => mcap.messages.next(),
            #[cfg(feature = "logs")]
            Self::Bag(messages) => messages.next(),
        }
    }

    fn channels(&self) -> Vec<Arc<ChannelInfo>> {
        match self {
            Self::Mcap(mcap) => mcap.messages.channels().cloned().collect(),
            #[cfg(feature = "logs")]
            Self::Bag(messages) => messages.channels().to_vec(),
        }
    }

    fn writer(&self) -> (String, String) {
        let (profile, library) = match self {
            Self::Mcap(mcap) => mcap.messages.writer(),
            #[cfg(feature = "logs")]
            Self::Bag(messages) => messages.writer(),
        };
        (profile.to_owned(), library.to_owned())
    }
}

/// The messages of a log in these files, with the bytes of those that are wanted; `given` defines types that they do not.
///
/// # Errors
/// Where the first file cannot be opened. The iterator returns an error once, as its last item, where a file is cut off or broken.
pub(crate) fn messages(files: &[PathBuf], given: &Given, wanted: Wanted) -> Result<Messages> {
    let mut later: Vec<PathBuf> = files.iter().rev().cloned().collect();
    let now = later.pop().map(|path| One::open(&path, given, &wanted)).transpose()?;
    Ok(Messages { wanted, given: given.to_vec(), later, now, before: Vec::new(), writer: Default::default() })
}

impl Messages {
    /// The channels met so far, with or without messages.
    pub fn channels(&self) -> Vec<Arc<ChannelInfo>> {
        let mut all = self.before.clone();
        all.extend(self.now.iter().flat_map(One::channels));
        all
    }

    /// Who wrote the log, as far as it says so: profile and library.
    pub fn writer(&self) -> (String, String) {
        let now = self.now.as_ref().map(One::writer).unwrap_or_default();
        if self.writer.1.is_empty() { now } else { self.writer.clone() }
    }
}

impl Iterator for Messages {
    type Item = Result<RawMessage>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(message) = self.now.as_mut()?.next() {
                return Some(message);
            }
            let ended = self.now.take()?;
            self.before.extend(ended.channels());
            if self.writer.1.is_empty() {
                self.writer = ended.writer();
            }
            let path = self.later.pop()?;
            match One::open(&path, &self.given, &self.wanted) {
                Ok(next) => self.now = Some(next),
                Err(error) => return Some(Err(error)),
            }
        }
    }
}
