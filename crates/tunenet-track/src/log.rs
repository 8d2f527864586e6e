//! The pictures of a camera in a ROS 2 log (MCAP).

use std::path::{Path, PathBuf};

use opencv::core::{Mat, MatTraitConst, Vector};
use opencv::imgcodecs::{IMREAD_COLOR, imdecode};
use opencv::imgproc::{
    COLOR_BGRA2BGR, COLOR_BayerBG2BGR, COLOR_BayerGB2BGR, COLOR_BayerGR2BGR, COLOR_BayerRG2BGR, COLOR_GRAY2BGR,
    COLOR_RGB2BGR, COLOR_RGBA2BGR, cvt_color_def,
};
use tunenet_formats::pictures::{self, Content};
use tunenet_formats::{Error, Result};

use crate::frames::Pictures;

/// A topic of pictures that is being read.
pub(crate) struct Log {
    path: PathBuf,
    pictures: pictures::Pictures,
    first_s: Option<f64>,
    last_s: f64,
}

impl Log {
    /// Opens a topic of the log at `path`, the only one with pictures where none is named.
    pub fn open(path: &Path, topic: Option<&str>) -> Result<Self> {
        Ok(Self {
            path: path.into(),
            pictures: pictures::pictures(path, topic)?,
            first_s: None,
            last_s: f64::NEG_INFINITY,
        })
    }
}

impl Pictures for Log {
    /// Times count from the first picture.
    fn next(&mut self, image: &mut Mat) -> Result<Option<f64>> {
        let Some(picture) = self.pictures.next().transpose()? else { return Ok(None) };
        let broken = |e: opencv::Error| {
            let message = format!("expected pictures, found one that OpenCV cannot decode ({})", e.message.trim());
            Error::file(&self.path, message, "record sensor_msgs/Image in `bgr8`, or CompressedImage in JPEG or PNG")
        };
        match &picture.content {
            Content::Encoded(bytes) => {
                *image = imdecode(&Vector::<u8>::from_slice(bytes), IMREAD_COLOR).map_err(broken)?;
            }
            Content::Raw { width, height, encoding, step, bytes } => {
                raw(image, (*width, *height), encoding, *step, bytes).map_err(broken)?;
            }
        }
        if image.empty() {
            let message = "expected pictures, found one that is no JPEG or PNG";
            return Err(Error::file(&self.path, message, "record CompressedImage in JPEG or PNG"));
        }
        let time_s = picture.time_s - *self.first_s.get_or_insert(picture.time_s);
        if time_s <= self.last_s {
            let message = format!("expected stamps that rise, found {time_s:.6} s after {:.6} s", self.last_s);
            return Err(Error::file(&self.path, message, "record the camera's own stamps"));
        }
        self.last_s = time_s;
        Ok(Some(time_s))
    }

    fn promised(&self) -> Option<usize> {
        None
    }
}

/// Rows of pixels in one of ROS's forms, as blue, green, red.
fn raw(image: &mut Mat, (width, height): (u32, u32), encoding: &str, step: usize, bytes: &[u8]) -> opencv::Result<()> {
    let (channels, conversion) = match encoding {
        "bgr8" | "8UC3" => (3, None),
        "rgb8" => (3, Some(COLOR_RGB2BGR)),
        "bgra8" | "8UC4" => (4, Some(COLOR_BGRA2BGR)),
        "rgba8" => (4, Some(COLOR_RGBA2BGR)),
        "mono8" | "8UC1" => (1, Some(COLOR_GRAY2BGR)),
        // ROS names the first two pixels of the first row, OpenCV those of the second row from the second on.
        "bayer_rggb8" => (1, Some(COLOR_BayerBG2BGR)),
        "bayer_bggr8" => (1, Some(COLOR_BayerRG2BGR)),
        "bayer_gbrg8" => (1, Some(COLOR_BayerGR2BGR)),
        "bayer_grbg8" => (1, Some(COLOR_BayerGB2BGR)),
        other => {
            let message = format!("its pixels are `{other}`: bgr8, rgb8, bgra8, rgba8, mono8 and bayer_*8 are read");
            return Err(opencv::Error::new(opencv::core::StsUnsupportedFormat, message));
        }
    };
    let row = width as usize * channels;
    if step < row {
        let message = format!("a row of {width} px takes {row} bytes, and rows are said to have {step}");
        return Err(opencv::Error::new(opencv::core::StsBadSize, message));
    }
    let packed: Vec<u8> = bytes.chunks_exact(step).take(height as usize).flat_map(|r| &r[..row]).copied().collect();
    let flat = Mat::from_slice(&packed)?;
    let shaped = flat.reshape(i32::try_from(channels).unwrap_or(1), i32::try_from(height).unwrap_or(1))?;
    match conversion {
        Some(code) => cvt_color_def(&shaped, image, code),
        None => shaped.copy_to(image),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::View;

    fn pixel(encoding: &str, step: usize, bytes: &[u8]) -> opencv::Result<[u8; 3]> {
        let mut image = Mat::default();
        raw(&mut image, (1, 2), encoding, step, bytes)?;
        Ok(View::of(&image)?.pixel(0, 1))
    }

    #[test]
    fn pixels_of_every_form_become_blue_green_red() {
        assert_eq!(pixel("bgr8", 3, &[9, 9, 9, 1, 2, 3]).unwrap(), [1, 2, 3]);
        assert_eq!(pixel("rgb8", 3, &[9, 9, 9, 1, 2, 3]).unwrap(), [3, 2, 1]);
        // Rows may be padded.
        assert_eq!(pixel("rgb8", 5, &[9, 9, 9, 0, 0, 1, 2, 3, 0, 0]).unwrap(), [3, 2, 1]);
        assert_eq!(pixel("bgra8", 4, &[9, 9, 9, 9, 1, 2, 3, 255]).unwrap(), [1, 2, 3]);
        assert_eq!(pixel("mono8", 1, &[9, 7]).unwrap(), [7, 7, 7]);
        assert!(pixel("yuv422", 2, &[0; 4]).unwrap_err().message.contains("`yuv422`"));
        assert!(pixel("rgb8", 2, &[0; 4]).unwrap_err().message.contains("takes 3 bytes"));
    }

    #[test]
    fn a_red_pattern_of_a_raw_sensor_becomes_red() {
        // RGGB: red at even rows and columns, all else dark.
        let bytes: Vec<u8> = (0..64).map(|i| if i / 8 % 2 == 0 && i % 2 == 0 { 200 } else { 0 }).collect();
        let mut image = Mat::default();
        raw(&mut image, (8, 8), "bayer_rggb8", 8, &bytes).unwrap();
        let [blue, green, red] = View::of(&image).unwrap().pixel(4, 4);
        assert!(red > 150 && blue < 50 && green < 50, "{blue} {green} {red}");
    }
}
