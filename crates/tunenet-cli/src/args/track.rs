//! `tunenet track`.

use std::path::PathBuf;

use clap::Args;

use super::{Common, Writing};

pub const EXAMPLES: &str = "\
Examples:
  tunenet track drop.mp4 --out track.csv
  tunenet track drop.mp4 --out track.csv --report track.html --overlay drawn.mp4
  tunenet track drop.mp4 --bounces --out bounces.csv
  tunenet track drop.mp4 --ball-color green --radius 0.0335 --out track.csv
  tunenet track drop.mp4 --rate 60 --frames 400 --out track.csv
  tunenet track frames/ --camera-rate 120 --out track.csv
  tunenet track log.mcap --topic /camera/image_raw --out track.csv
`tune` and `diagnose` read videos directly; use `track` to see what the tracker found.";

/// `tunenet track`.
#[derive(Debug, Args)]
pub struct Track {
    /// Video (mp4, avi, mov, mkv), folder of images (png, jpg) or MCAP log with images
    pub video: PathBuf,
    /// Track to write
    #[arg(short, long, value_name = "TRACK.csv")]
    pub out: Option<PathBuf>,
    /// Write pixel coordinates instead of metres
    #[arg(long)]
    pub pixels: bool,
    /// Write only bounce times, which do not depend on the length scale: column `bounce_time_s`
    #[arg(long, requires = "out", conflicts_with_all = ["pixels", "rate"])]
    pub bounces: bool,
    /// Write an HTML report
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write the video with the track overlaid
    #[arg(long, value_name = "FILE.mp4")]
    pub overlay: Option<PathBuf>,
    /// Colour of the ball: red, orange, yellow, green, cyan, blue, purple, white, black, or an HSV window such as
    /// 170,90,60:8,255,255 on OpenCV's scales [default: detected]
    #[arg(long = "ball-color", visible_alias = "color", value_name = "COLOUR")]
    pub color: Option<String>,
    /// MCAP topic to read [default: the only suitable one]
    #[arg(long)]
    pub topic: Option<String>,
    /// True capture rate in frames per second, for slow-motion video or folders of images
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub camera_rate: Option<f64>,
    /// Sample rate of the track in Hz, from the release on, by linear interpolation; also the rate of a folder of images
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub rate: Option<f64>,
    /// Maximum number of frames to track [default: all]. With `--rate`: number of samples to write; the last one is repeated
    /// if the video is shorter
    #[arg(long, value_name = "N", value_parser = frames)]
    pub frames: Option<usize>,
    /// Radius of the ball in m, which gives the length scale [default: from the fall of the ball]
    #[arg(long, value_name = "M", conflicts_with = "length", value_parser = positive)]
    pub radius: Option<f64>,
    /// A length in m in the plane of the ball and its length in the image in pixels, such as 0.5=240
    #[arg(long, value_name = "M=PX", value_parser = length)]
    pub length: Option<(f64, f64)>,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}

fn frames(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 2..) => Ok(count),
        _ => Err("expected at least 2".into()),
    }
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|n| n.is_finite() && *n > 0.0);
    number.ok_or_else(|| "expected a number above 0".to_owned())
}

fn length(text: &str) -> Result<(f64, f64), String> {
    let expected = || "expected metres and pixels above 0, such as 0.5=240".to_owned();
    let (metres, pixels) = text.split_once('=').ok_or_else(expected)?;
    positive(metres).ok().zip(positive(pixels).ok()).ok_or_else(expected)
}
