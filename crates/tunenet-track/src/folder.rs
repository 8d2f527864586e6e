//! A folder of numbered pictures, as a video.

use std::path::{Path, PathBuf};

use opencv::core::{Mat, MatTraitConst};
use opencv::imgcodecs::{IMREAD_COLOR, imread};
use tunenet_formats::{Action, Error, Result};

use crate::frames::Pictures;

/// What pictures' names end in.
const ENDINGS: [&str; 6] = ["png", "jpg", "jpeg", "bmp", "tif", "tiff"];

/// The pictures of a folder, taken one after the other at one rate.
pub(crate) struct Folder {
    files: Vec<PathBuf>,
    rate_hz: f64,
    index: usize,
}

impl Folder {
    /// The pictures in `path`, in the order in which people number them: `frame2` before `frame10`.
    pub fn open(path: &Path, rate_hz: Option<f64>) -> Result<Self> {
        let failed = |e| Error::io(path, Action::Reading, e);
        let mut files = Vec::new();
        for entry in std::fs::read_dir(path).map_err(failed)? {
            let file = entry.map_err(failed)?.path();
            let hidden = file.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
            if !hidden && file.extension().is_some_and(|e| ENDINGS.iter().any(|known| e.eq_ignore_ascii_case(known))) {
                files.push(file);
            }
        }
        if files.is_empty() {
            let message = "expected a folder of pictures, found none in it";
            return Err(Error::file(path, message, "name the folder that contains the video's frames as PNG or JPEG"));
        }
        let Some(rate_hz) = rate_hz else {
            let message = format!("expected pictures of a known rate, found {} without one", files.len());
            return Err(Error::file(path, message, "say how many were taken each second, as in `--camera-rate 60`"));
        };
        alphanumeric_sort::sort_path_slice(&mut files);
        Ok(Self { files, rate_hz, index: 0 })
    }
}

impl Pictures for Folder {
    fn next(&mut self, image: &mut Mat) -> Result<Option<f64>> {
        let Some(file) = self.files.get(self.index) else { return Ok(None) };
        let refused = |found: &str| {
            Error::file(
                file,
                format!("expected a picture, found {found}"),
                "take it out of the folder, or save it again",
            )
        };
        let name = file.to_str().ok_or_else(|| refused("a name that is not in UTF-8"))?;
        *image = imread(name, IMREAD_COLOR).map_err(|e| refused(e.message.trim()))?;
        if image.empty() {
            return Err(refused("one that OpenCV cannot decode"));
        }
        let time_s = self.index as f64 / self.rate_hz;
        self.index += 1;
        Ok(Some(time_s))
    }

    fn promised(&self) -> Option<usize> {
        Some(self.files.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["e3.png", "f.png", "f1.png", "f9.png", "f10.png", "f010b.png"];
        for name in names.iter().rev() {
            std::fs::write(folder.path().join(name), [0; 9]).unwrap();
        }
        let pictures = Folder::open(folder.path(), Some(60.0)).unwrap();
        assert_eq!(pictures.files, names.map(|name| folder.path().join(name)));
    }

    #[test]
    fn what_is_missing_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |rate| Folder::open(folder.path(), rate).err().unwrap().to_string();
        assert!(refused(Some(60.0)).contains("found none in it"));
        std::fs::write(folder.path().join("1.png"), [0; 9]).unwrap();
        assert!(refused(None).contains("found 1 without one"));
        let mut pictures = Folder::open(folder.path(), Some(60.0)).unwrap();
        assert!(pictures.next(&mut Mat::default()).unwrap_err().to_string().contains("1.png: expected a picture"));
    }
}
