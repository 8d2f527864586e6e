//! Where pictures come from, and how they get to the tracker: decoded by one thread, looked at by another.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{channel, sync_channel};

use opencv::core::{Mat, MatTraitConst};
use tunenet_core::Origin;
use tunenet_formats::{Error, Result};

use crate::folder::Folder;
use crate::frames::{Pictures, VideoFrames};
use crate::log::Log;
use crate::video::undecodable;

/// Decoded pictures that wait for the tracker; more would only take memory.
const AHEAD: usize = 4;

/// How far a stream of pictures went.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Streamed {
    /// Pictures that were decoded.
    pub count: usize,
    /// How many the file promises, where it says so.
    pub promised: Option<usize>,
    /// Why the next one could not be decoded, where that is the end of it.
    pub broken: Option<String>,
}

/// A video, a folder of pictures, or a topic of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    path: PathBuf,
    topic: Option<String>,
    log: bool,
    rate_hz: Option<f64>,
}

impl Source {
    /// The file at `path`; `topic` is for logs alone, which are known by their ending `.mcap`.
    #[must_use]
    pub fn new(path: &Path, topic: Option<&str>) -> Self {
        let log = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mcap"));
        Self { path: path.into(), topic: topic.map(Into::into), log, rate_hz: None }
    }

    /// Says how many pictures of a folder were taken each second; videos and logs contain it.
    #[must_use]
    pub fn at_rate(self, rate_hz: Option<f64>) -> Self {
        Self { rate_hz, ..self }
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Opens it at its start.
    ///
    /// # Errors
    /// As [`VideoFrames::open`]; for a folder, where it holds no pictures or their rate is not known; for a log, where it holds no pictures or several topics of them and none is named.
    pub fn open(&self) -> Result<Box<dyn Pictures>> {
        if self.log {
            return Ok(Box::new(Log::open(&self.path, self.topic.as_deref())?));
        }
        if let Some(topic) = &self.topic {
            let (expected, found) = ("a log in MCAP form".into(), format!("`{topic}` of a video"));
            return Err(
                tunenet_core::Error::Setting { origin: Origin::Caller, name: "--topic", expected, found }.into()
            );
        }
        if self.path.is_dir() {
            return Ok(Box::new(Folder::open(&self.path, self.rate_hz)?));
        }
        Ok(Box::new(VideoFrames::open(&self.path)?))
    }

    /// Calls `each` with every picture, at most `most` of them: its number from 0, when it was taken (s), and how many the
    /// file promises. Pictures that are given back are used again. Ends early where `each` returns an error, and where a
    /// picture after the first cannot be decoded: what came before it is as good as ever.
    ///
    /// # Errors
    /// Of opening, of decoding the first picture, and of `each`.
    pub fn stream(
        &self,
        most: usize,
        each: &mut dyn FnMut(usize, f64, Mat, Option<usize>) -> opencv::Result<Vec<Mat>>,
    ) -> Result<Streamed> {
        let mut pictures = self.open()?;
        let promised = pictures.promised();
        let (give, take) = sync_channel::<Result<(f64, Mat)>>(AHEAD);
        let (give_back, used) = channel::<Mat>();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                let mut spare: Vec<Mat> = Vec::new();
                loop {
                    // The one that came back last still lies in the processor's cache.
                    spare.extend(used.try_iter());
                    let mut image = spare.pop().unwrap_or_default();
                    let next = match pictures.next(&mut image) {
                        Ok(Some(time_s)) => Ok((time_s, image)),
                        Ok(None) => break,
                        Err(error) => Err(error),
                    };
                    let last = next.is_err();
                    // Nobody takes any more where the other side has failed.
                    if give.send(next).is_err() || last {
                        break;
                    }
                }
            });
            let (mut count, mut first, mut broken) = (0, None, None);
            // The channel has to be released before the thread is waited for.
            for picture in take.iter().take(most) {
                let (time_s, image) = match picture {
                    Ok(picture) => picture,
                    Err(error) if count == 0 => return Err(error),
                    Err(error) => {
                        broken = Some(error.to_string());
                        break;
                    }
                };
                let size = (image.cols(), image.rows());
                let (columns, rows) = *first.get_or_insert(size);
                if size != (columns, rows) {
                    let message = format!(
                        "expected pictures of one size, found {} × {} px after {columns} × {rows} px in frame {count}",
                        size.0, size.1
                    );
                    return Err(Error::file(&self.path, message, "cut the video where its size changes"));
                }
                for spare in each(count, time_s, image, promised).map_err(|e| undecodable(&self.path, &e))? {
                    let _ = give_back.send(spare);
                }
                count += 1;
            }
            drop(take);
            Ok(Streamed { count, promised, broken })
        })
    }
}
