//! What MP4, MOV and AVI files are made of, as far as it says why they cannot be used.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use tunenet_formats::Error;

const HINT: &str = "copy it again from the camera, once the recording has ended and been saved. Where the original is cut off \
                    as well, no player shows it: `ffmpeg -i FILE -c copy NEW.mp4` mends only a file whose index is there";
/// Boxes that are looked at; a video has few on its outermost level.
const MOST_BOXES: usize = 10_000;

/// That the file is the beginning of a video (ISO 14496-12) whose index (`moov`) is missing or cut off; `None` where it is
/// something else. A camera writes the index last, so a copy that stops early, or a recording that was never ended, has none.
pub(crate) fn incomplete(path: &Path) -> Option<Error> {
    let mut file = File::open(path).ok()?;
    let size = file.metadata().ok()?.len();
    let (mut at, mut missing, mut index) = (0u64, 0u64, false);
    for i in 0..MOST_BOXES {
        if at + 8 > size {
            break;
        }
        let (length, kind) = head(&mut file, at, size)?;
        // Any file's first bytes can be read as a length; only a video begins with its type.
        if i == 0 && kind != *b"ftyp" {
            return None;
        }
        index |= kind == *b"moov" && at + length <= size;
        missing = (at + length).saturating_sub(size);
        at += length;
    }
    if index {
        return None;
    }
    let cut = if missing > 0 { format!(", {missing} bytes short") } else { String::new() };
    let found = format!(
        "expected a whole video, found one that is cut off: its index (`moov`), which is written last, is missing in {size} \
         bytes{cut}"
    );
    Some(Error::file(path, found, HINT))
}

/// Length, its head included, and kind of the box at `at`.
fn head(file: &mut File, at: u64, size: u64) -> Option<(u64, [u8; 4])> {
    let mut head = Vec::with_capacity(16);
    file.seek(SeekFrom::Start(at)).ok()?;
    file.take(16).read_to_end(&mut head).ok()?;
    let kind = *head[4..].first_chunk()?;
    let length = match u32::from_be_bytes(*head.first_chunk()?) {
        // To the end of the file.
        0 => size - at,
        1 if head.len() == 16 => u64::from_be_bytes(*head[8..].first_chunk()?),
        length => u64::from(length),
    };
    (8..1 << 60).contains(&length).then_some((length, kind))
}

/// So much of an AVI file holds the head of its first stream: lists and heads before it are short.
const AVI_START: u64 = 4096;

/// Whether the file is an AVI (RIFF) whose stream of pictures states no rate: its rate or its scale is 0. FFmpeg takes 25 frames a
/// second then, and says nothing.
pub(crate) fn states_no_rate(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = |file: File| file.take(AVI_START).read_to_end(&mut start);
    if File::open(path).and_then(read).is_err() || start.get(..4) != Some(b"RIFF") || start.get(8..12) != Some(b"AVI ")
    {
        return false;
    }
    // The head of a stream: its kind, codec, flags, priority and language, first frames, scale, rate.
    let head = start.windows(12).position(|part| &part[..4] == b"strh" && &part[8..] == b"vids");
    let number = |at: usize| start.get(at..at + 4).and_then(<[u8]>::first_chunk).map(|four| u32::from_le_bytes(*four));
    let Some((scale, rate)) = head.and_then(|at| Some((number(at + 28)?, number(at + 32)?))) else { return false };
    scale == 0 || rate == 0
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The start of a video: its type, and pictures that stop early.
    pub(crate) fn cut_before_index() -> Vec<u8> {
        let mut bytes = b"\0\0\0\x18ftypisom\0\0\x02\0isommp42\0\x10\0\0mdat".to_vec();
        bytes.resize(5000, 0x5A);
        bytes
    }

    #[test]
    fn only_a_video_without_its_index_is_incomplete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("video.mp4");
        let mut bytes = cut_before_index();
        std::fs::write(&path, &bytes).unwrap();
        let text = incomplete(&path).unwrap().to_string();
        // 24 bytes of type, 0x10_0000 of pictures, and 5000 are there.
        assert!(text.contains("1043600 bytes short"), "{text}");
        bytes.truncate(24);
        bytes.extend(b"\0\0\0\x08mdat\0\0\0\x08moov");
        std::fs::write(&path, &bytes).unwrap();
        assert!(incomplete(&path).is_none());
        std::fs::write(&path, [0x42; 300]).unwrap();
        assert!(incomplete(&path).is_none());
    }

    /// The start of an AVI whose stream of pictures has this scale and rate.
    fn avi(scale: u32, rate: u32) -> Vec<u8> {
        let mut bytes = b"RIFF\0\x10\0\0AVI LIST\xC0\0\0\0hdrlavih\x38\0\0\0".to_vec();
        bytes.resize(bytes.len() + 56, 0);
        bytes.extend(b"LIST\x74\0\0\0strlstrh\x38\0\0\0vidsMJPG");
        bytes.extend([0; 12]);
        bytes.extend(scale.to_le_bytes());
        bytes.extend(rate.to_le_bytes());
        bytes.resize(2000, 0x5A);
        bytes
    }

    #[test]
    fn an_avi_that_states_no_rate_is_recognised() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("video.avi");
        let stated = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            !states_no_rate(&path)
        };
        assert!(stated(&avi(1, 50)) && stated(&avi(1001, 30_000)));
        assert!(!stated(&avi(1, 0)) && !stated(&avi(0, 25)));
        assert!(stated(&cut_before_index()) && stated(&[]) && stated(&avi(1, 0)[..100]), "what is no AVI, or cut off");
        assert!(!states_no_rate(&folder.path().join("absent.avi")));
    }
}
