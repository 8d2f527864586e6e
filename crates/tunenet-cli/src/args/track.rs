//! `tunenet track`.

use std::path::PathBuf;

use clap::Args;

use super::{Common, Writing};

pub const EXAMPLES: &str = "\
Examples:
  tunenet track drop.mp4 --out track.csv
  tunenet track drop.mp4 --out track.csv --report track.html --overlay drawn.mp4
  tunenet track drop.mp4 --bounces --out bounces.csv
  tunenet track drop.mp4 --color green --radius 0.0335 --out track.csv
  tunenet track drop.mp4 --rate 60 --frames 400 --out track.csv
  tunenet track frames/ --camera-rate 120 --out track.csv
  tunenet track log.mcap --topic /camera/image_raw --out track.csv
`tune` and `diagnose` take films as they are; track one to see what was seen.";

/// `tunenet track`.
#[derive(Debug, Args)]
pub struct Track {
    /// Film of a ball (mp4, avi, mov, mkv), folder of its frames (png, jpg), or log (MCAP) with pictures
    pub video: PathBuf,
    /// Where to write the track
    #[arg(long, value_name = "TRACK.csv")]
    pub out: Option<PathBuf>,
    /// Write pixels, also where the fall of the ball says how large they are
    #[arg(long)]
    pub pixels: bool,
    /// Write the instants of the bounces alone, which no wrong scale spoils: a column `bounce_time_s`
    #[arg(long, requires = "out", conflicts_with_all = ["pixels", "rate"])]
    pub bounces: bool,
    /// Write a page with frames in which the track is drawn here
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write the film with the track drawn in here
    #[arg(long, value_name = "FILE.mp4")]
    pub overlay: Option<PathBuf>,
    /// Colour of the ball: red, orange, yellow, green, cyan, blue, purple, white, or an HSV window such as
    /// 170,90,60:8,255,255 on OpenCV's scales; what moves and has one is found by itself
    #[arg(long, value_name = "COLOUR")]
    pub color: Option<String>,
    /// Which topic of a log
    #[arg(long)]
    pub topic: Option<String>,
    /// Frames per second at which the camera really took them: of a film that plays slower, or of a folder of frames
    #[arg(long, value_name = "1/S", value_parser = positive)]
    pub camera_rate: Option<f64>,
    /// Write samples at this rate, from the release on, by linear interpolation; also the rate of a folder of frames
    #[arg(long, value_name = "1/S", value_parser = positive)]
    pub rate: Option<f64>,
    /// Write so many samples with `--rate`, the last one repeated where the film is shorter; without it, track no more
    /// frames than this
    #[arg(long, value_name = "N", value_parser = frames)]
    pub frames: Option<usize>,
    /// The ball's radius, which says how large a pixel is; without it, the fall of the ball does
    #[arg(long, value_name = "M", conflicts_with = "length", value_parser = positive)]
    pub radius: Option<f64>,
    /// A length in the plane of the ball and how long it is in the picture, such as 0.5=240
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
