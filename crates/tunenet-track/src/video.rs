//! Video files, through OpenCV's reader.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use opencv::core::{LogLevel, Mat, MatTraitConst, set_log_level};
use opencv::videoio::{
    CAP_ANY, CAP_FFMPEG, CAP_PROP_FPS, CAP_PROP_FRAME_HEIGHT, CAP_PROP_FRAME_WIDTH, VideoCapture, VideoCaptureAPIs,
    VideoCaptureTrait, VideoCaptureTraitConst, has_backend,
};
use tunenet_formats::{Action, Error, Result};

use crate::container::{incomplete, states_no_rate};

/// Fewest frames in which something can be seen to move.
pub const FEWEST_FRAMES: usize = 2;

/// Largest frame that is decoded, in pixels: 8K video has half as many. Each takes some ten bytes of memory.
const MOST_PIXELS: f64 = (1u32 << 26) as f64;

/// So much of a file's start distinguishes text from pictures.
const TEXT_BYTES: u64 = 512;
const HINT: &str = "give a video that a player shows, such as mp4 or avi, or convert it first";

/// A video file whose every frame was decoded once.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// The file.
    pub path: PathBuf,
    /// Width of a frame as it is shown, px, at least 1.
    pub width_px: u32,
    /// Height of a frame as it is shown, px, at least 1.
    pub height_px: u32,
    /// The file's nominal rate, 1/s, above 0. Limit: a phone's real rate varies around it.
    pub frames_per_s: f64,
    /// How many frames decode, at least [`FEWEST_FRAMES`]; a header may promise more.
    pub frames: usize,
}

/// Opens the video at `path` and decodes it once from start to end. Silences OpenCV's own log in the whole process: what
/// matters of it is in the error.
///
/// # Errors
/// [`Error::Io`] where the file cannot be reached; [`Error::File`] where it is not a video, holds fewer than
/// [`FEWEST_FRAMES`] frames that decode, or does not say how fast they follow each other.
pub fn open(path: &Path) -> Result<Clip> {
    let (mut reader, frames_per_s) = reader(path)?;
    let broken = |e: opencv::Error| undecodable(path, &e);
    let (mut frame, mut frames, mut size) = (Mat::default(), 0, None);
    while reader.read(&mut frame).map_err(broken)? {
        // The decoded picture decides: a header gives the size before the phone's rotation.
        size = size.or(Some((frame.cols(), frame.rows())));
        frames += 1;
    }
    let size = size.and_then(|(w, h)| Some((u32::try_from(w).ok()?, u32::try_from(h).ok()?)));
    let Some((width_px, height_px)) = size.filter(|_| frames >= FEWEST_FRAMES) else {
        return Err(refuse(path, &format!("{frames} frames that decode (at least {FEWEST_FRAMES} are needed)")));
    };
    Ok(Clip { path: path.to_path_buf(), width_px, height_px, frames_per_s, frames })
}

/// OpenCV's reader of the video at `path`, and its nominal rate (1/s), before any frame is decoded.
///
/// # Errors
/// As [`open`], but for what shows only when frames are decoded.
pub(crate) fn reader(path: &Path) -> Result<(VideoCapture, f64)> {
    let facts = std::fs::metadata(path).map_err(|source| Error::io(path, Action::Reading, source))?;
    if !facts.is_file() {
        return Err(refuse(path, "a folder or a device"));
    }
    if facts.len() == 0 {
        return Err(refuse(path, "an empty file"));
    }
    if text(path)? {
        return Err(refuse(path, "a text"));
    }
    // OpenCV takes names as text; the file exists, so it can be renamed.
    let Some(name) = path.to_str() else {
        return Err(Error::file(path, "expected a name in UTF-8, found other bytes", "rename the file"));
    };
    let broken = |e: opencv::Error| undecodable(path, &e);
    set_log_level(LogLevel::LOG_LEVEL_SILENT).map_err(broken)?;
    // FFmpeg alone where it is built in: the other readers take numbered pictures and devices for videos.
    let with = if has_backend(VideoCaptureAPIs::CAP_FFMPEG).map_err(broken)? { CAP_FFMPEG } else { CAP_ANY };
    let reader = VideoCapture::from_file(name, with).map_err(broken)?;
    if !reader.is_opened().map_err(broken)? {
        return Err(incomplete(path).unwrap_or_else(|| refuse(path, "a file that OpenCV cannot open as one")));
    }
    let pixels =
        reader.get(CAP_PROP_FRAME_WIDTH).map_err(broken)? * reader.get(CAP_PROP_FRAME_HEIGHT).map_err(broken)?;
    if pixels > MOST_PIXELS {
        return Err(refuse(path, &format!("one of {pixels} pixels a frame (at most {MOST_PIXELS} are read)")));
    }
    let frames_per_s = reader.get(CAP_PROP_FPS).map_err(broken)?;
    if !(frames_per_s.is_finite() && frames_per_s > 0.0) {
        return Err(refuse(path, &format!("one without a usable rate ({frames_per_s} frames per second)")));
    }
    if states_no_rate(path) {
        let remedy = "convert it with its true rate: `ffmpeg -r RATE -i FILE NEW.mp4`";
        return Err(Error::file(path, "expected a video that states its frames per second, found a rate of 0", remedy));
    }
    Ok((reader, frames_per_s))
}

fn refuse(path: &Path, found: &str) -> Error {
    Error::file(path, format!("expected a video, found {found}"), HINT)
}

pub(crate) fn undecodable(path: &Path, error: &opencv::Error) -> Error {
    refuse(path, &format!("one that OpenCV cannot decode ({})", error.message.trim()))
}

/// Whether the file starts as text. FFmpeg draws any text as the picture of a terminal and calls that a video.
fn text(path: &Path) -> Result<bool> {
    let mut start = Vec::new();
    let read = |file: File| file.take(TEXT_BYTES).read_to_end(&mut start);
    File::open(path).and_then(read).map_err(|source| Error::io(path, Action::Reading, source))?;
    // Every container has bytes among its first that no text has: lengths, versions, zeros.
    Ok(!start.iter().any(|byte| matches!(byte, 0..=8 | 14..=26 | 28..=31 | 127 | 0xF8..)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::tests::cut_before_index;
    use opencv::core::{CV_8UC3, Scalar, Size};
    use opencv::videoio::{VideoWriter, VideoWriterTrait, VideoWriterTraitConst};

    /// A small video that gets brighter: Motion JPEG needs no codec beyond OpenCV itself.
    fn write_video(path: &Path, frames: u32) {
        let codec = VideoWriter::fourcc('M', 'J', 'P', 'G').unwrap();
        let mut writer = VideoWriter::new(path.to_str().unwrap(), codec, 50.0, Size::new(64, 48), true).unwrap();
        assert!(writer.is_opened().unwrap());
        for i in 0..frames {
            let shade = Scalar::all(f64::from(10 * i));
            writer.write(&Mat::new_rows_cols_with_default(48, 64, CV_8UC3, shade).unwrap()).unwrap();
        }
        writer.release().unwrap();
    }

    fn refusal(name: &str, bytes: &[u8]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let text = open(&path).unwrap_err().to_string();
        assert!(text.starts_with(&path.display().to_string()), "{text}");
        text[path.display().to_string().len()..].to_owned()
    }

    #[test]
    fn a_written_video_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("video.avi");
        write_video(&path, 12);
        let clip = open(&path).unwrap();
        assert_eq!(clip, Clip { path, width_px: 64, height_px: 48, frames_per_s: 50.0, frames: 12 });
    }

    /// OpenCV itself says 25 of such a file.
    #[test]
    fn a_video_without_a_rate_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("video.avi");
        write_video(&path, 12);
        let mut bytes = std::fs::read(&path).unwrap();
        let head = bytes.windows(12).position(|part| &part[..4] == b"strh" && &part[8..] == b"vids").unwrap();
        bytes[head + 32..head + 36].fill(0);
        std::fs::write(&path, bytes).unwrap();
        let text = open(&path).unwrap_err().to_string();
        assert!(text.contains("found a rate of 0"), "{text}");
    }

    #[test]
    fn only_frames_that_decode_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let (whole, cut) = (folder.path().join("video.avi"), folder.path().join("cut.avi"));
        write_video(&whole, 20);
        let bytes = std::fs::read(&whole).unwrap();
        std::fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
        match open(&cut) {
            Ok(clip) => assert!(clip.frames < 20, "{}", clip.frames),
            Err(error) => assert!(error.to_string().contains("expected a video"), "{error}"),
        }
    }

    #[test]
    fn what_is_no_video_is_refused() {
        assert_eq!(refusal("a.csv", b"t_s,z_m\n0,1\n"), ": expected a video, found a text");
        assert_eq!(refusal("a.mp4", b""), ": expected a video, found an empty file");
        assert!(refusal("a.txt", &b"t_s,z_m\n0,1\n".repeat(500)).starts_with(": expected a video, found"));
        assert!(refusal("b.mp4", &[0x42; 4000]).starts_with(": expected a video, found"));
        let folder = tempfile::tempdir().unwrap();
        assert!(open(folder.path()).unwrap_err().to_string().ends_with("found a folder or a device"));
        assert!(matches!(open(&folder.path().join("absent.mp4")), Err(Error::Io { .. })));
    }

    #[test]
    fn a_video_without_its_index_is_said_to_be_cut_off() {
        let text = refusal("cut.mp4", &cut_before_index());
        assert!(text.contains("cut off") && text.contains("index"), "{text}");
    }

    #[test]
    fn a_single_frame_is_no_video() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("video.avi");
        write_video(&path, 1);
        assert!(open(&path).unwrap_err().to_string().contains("found 1 frames that decode"));
    }

    #[test]
    fn a_phone_video_is_counted() {
        let Some(root) = std::env::var_os("TUNENET_MEASURED") else {
            eprintln!("skipped: TUNENET_MEASURED does not name a folder of measured files");
            return;
        };
        let path = Path::new(&root).join("video-redball/RedBall.mp4");
        if !path.exists() {
            eprintln!("skipped: {} is not there", path.display());
            return;
        }
        let clip = open(&path).unwrap();
        assert_eq!((clip.frames, clip.width_px, clip.height_px), (65, 1080, 1920));
        assert!(clip.frames_per_s > 20.0 && clip.frames_per_s < 130.0, "{}", clip.frames_per_s);
    }
}
