//! From a film to a track: one position of the ball for every frame in which it is seen.

use std::path::Path;

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};
use rayon::prelude::*;
use tunenet_core::observation::{Channel, Kind, Note, Observation};
use tunenet_core::{Error, Result};

use crate::colour::Window;
use crate::frames::Frames;
use crate::scout::{Scene, Unseen, scout};
use crate::tracker::{Sighting, look, reduced};
use crate::video::undecodable;

/// The longer side of the small pictures in which the ball is searched, px.
const SMALL_PX: i32 = 480;
/// Small pictures that are kept for scouting, evenly over the film.
const MOST_SCOUTED: usize = 64;
/// Whole frames up to this many bytes wait in memory, so that a short film is decoded only once.
const WAITING_BYTES: usize = 400 << 20;
/// Frames that are searched at once.
const BATCH: usize = 16;
/// A sighting this many times larger or smaller than usual is something else.
const OFF_SIZE: f64 = 1.8;
/// A ball is seen twice from this share of the frames on.
const TWO_BALLS: f64 = 0.3;
/// Two frames whose small pictures differ by less than this share of the usual change are one frame shown twice.
const SAME_SHARE: f64 = 0.1;

/// How to track.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// The ball's colour; found by itself where it is `None`.
    pub colour: Option<Window>,
}

/// The ball in a film.
#[derive(Debug, Clone)]
pub struct Track {
    /// How many frames decode.
    pub frames: usize,
    /// Width and height of a frame, px.
    pub size_px: (i32, i32),
    /// The rate of the frames as they were taken: the inverse of the median step, 1/s.
    pub rate_hz: f64,
    /// The colour that was looked for.
    pub colour: Window,
    /// The ball, in the order of the frames.
    pub sightings: Vec<Sighting>,
    /// Frames that repeat the one before, from 0.
    pub repeated: Vec<usize>,
    /// How many frames are missing in between, by the container's clock.
    pub dropped: usize,
    /// What was noticed.
    pub notes: Vec<Note>,
}

/// One frame with what is needed to judge it.
struct Seen {
    index: usize,
    time_s: f64,
    frame: Mat,
    small: Mat,
    factor: f64,
}

/// Tracks the ball in the film at `path`. `progress` is called with the number of frames done.
///
/// # Errors
/// [`Error::File`] where the film cannot be read, no ball is found, there are two, or the camera moves.
pub fn track(path: &Path, settings: &Settings, progress: &mut dyn FnMut(usize)) -> Result<Track> {
    let broken = |e: opencv::Error| undecodable(path, &e);
    let mut reader = Frames::open(path)?;
    let (mut waiting, mut samples, mut stride, mut bytes) = (Vec::new(), Vec::<Mat>::new(), 1, 0);
    let mut whole = true;
    let mut count = 0;
    loop {
        let mut frame = Mat::default();
        let Some(time_s) = reader.next(&mut frame)? else { break };
        let (small, factor) = reduced(&frame, SMALL_PX).map_err(broken)?;
        if count % stride == 0 {
            samples.push(small.clone());
        }
        if samples.len() > MOST_SCOUTED {
            let mut place = 0;
            samples.retain(|_| {
                place += 1;
                place % 2 == 1
            });
            stride *= 2;
        }
        bytes += frame.data_bytes().map_err(broken)?.len();
        whole = whole && bytes <= WAITING_BYTES;
        if whole {
            waiting.push(Seen { index: count, time_s, frame, small, factor });
        } else {
            waiting.clear();
        }
        count += 1;
        progress(count);
    }
    if count < crate::video::FEWEST_FRAMES {
        return Err(Error::file(
            path,
            format!("expected a video, found {count} frames that decode"),
            "record a longer one",
        ));
    }
    let scene = match scout(&samples, settings.colour).map_err(broken)? {
        Ok(scene) => scene,
        Err(reason) => return Err(unseen(path, reason, settings)),
    };
    let mut pass = Pass::new(&scene);
    if whole {
        pass.batch(&waiting).map_err(broken)?;
    } else {
        let mut reader = Frames::open(path)?;
        let mut batch = Vec::with_capacity(BATCH);
        for index in 0.. {
            let mut frame = Mat::default();
            let Some(time_s) = reader.next(&mut frame)? else { break };
            let (small, factor) = reduced(&frame, SMALL_PX).map_err(broken)?;
            batch.push(Seen { index, time_s, frame, small, factor });
            if batch.len() == BATCH {
                pass.batch(&batch).map_err(broken)?;
                batch.clear();
            }
            progress(count + index + 1);
        }
        pass.batch(&batch).map_err(broken)?;
    }
    pass.finish(path)
}

fn unseen(path: &Path, reason: Unseen, settings: &Settings) -> Error {
    match (reason, settings.colour) {
        (Unseen::CameraMoves, _) => Error::file(
            path,
            "expected a still camera, found most of the picture moving",
            "put the camera on a stand, or against something",
        ),
        (Unseen::NoBall, None) => Error::file(
            path,
            "expected a ball, found nothing round and coloured that moves",
            "name its colour, as in `--color white`, or record a saturated ball before a dull background",
        ),
        (Unseen::NoBall, Some(_)) => Error::file(
            path,
            "expected a ball of the given colour, found nothing round of it that moves",
            "leave `--color` out, so that the colour is found by itself",
        ),
    }
}

/// One pass over the frames.
struct Pass<'a> {
    scene: &'a Scene,
    sightings: Vec<Sighting>,
    times_s: Vec<f64>,
    changes: Vec<f64>,
    before: Option<Mat>,
    size_px: (i32, i32),
}

impl<'a> Pass<'a> {
    fn new(scene: &'a Scene) -> Self {
        Self { scene, sightings: Vec::new(), times_s: Vec::new(), changes: Vec::new(), before: None, size_px: (0, 0) }
    }

    fn batch(&mut self, frames: &[Seen]) -> opencv::Result<()> {
        let looked: Vec<opencv::Result<Option<Sighting>>> =
            frames.par_iter().map(|s| look(self.scene, &s.frame, &s.small, s.factor)).collect();
        for (seen, sighting) in frames.iter().zip(looked) {
            self.sightings.extend(sighting?.map(|s| Sighting { frame: seen.index, time_s: seen.time_s, ..s }));
            self.times_s.push(seen.time_s);
            self.size_px = (seen.frame.cols(), seen.frame.rows());
            let now = seen.small.data_bytes()?;
            let change = match &self.before {
                Some(before) => mean_difference(before.data_bytes()?, now),
                None => f64::INFINITY,
            };
            self.changes.push(change);
            self.before = Some(seen.small.clone());
        }
        Ok(())
    }

    fn finish(self, path: &Path) -> Result<Track> {
        let frames = self.times_s.len();
        let mut notes = Vec::new();
        let steps: Vec<f64> = self.times_s.windows(2).map(|w| w[1] - w[0]).collect();
        let step_s = median(steps.iter().copied()).unwrap_or(1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of frames")]
        let missing = |step: &f64| ((step / step_s).round() - 1.0).clamp(0.0, 1e6) as usize;
        let dropped = steps.iter().map(missing).sum();
        let usual = median(self.changes.iter().copied().filter(|c| c.is_finite())).unwrap_or(0.0);
        let repeated: Vec<usize> = (1..frames).filter(|&i| self.changes[i] < SAME_SHARE * usual).collect();
        let two = self.sightings.iter().filter(|s| s.second).count();
        if two as f64 > TWO_BALLS * self.sightings.len() as f64 {
            let message = format!("expected one ball, found two things alike in {two} of {frames} frames");
            return Err(Error::file(path, message, "leave one ball in view, or name its colour with `--color`"));
        }
        let radius = median(self.sightings.iter().filter(|s| !s.cut).map(|s| s.radius_px)).unwrap_or(1.0);
        let mut sightings = self.sightings;
        for s in sightings.iter_mut().filter(|s| !s.cut) {
            s.confidence *= (-((s.radius_px / radius).ln() / OFF_SIZE.ln()).powi(2)).exp();
        }
        // Something else of the ball's colour: far too large or too small, and in full view.
        sightings.retain(|s| s.cut || (1.0 / OFF_SIZE..OFF_SIZE).contains(&(s.radius_px / radius)));
        if !repeated.is_empty() {
            let text = format!("{} of {frames} frames repeat the one before", repeated.len());
            notes.push(Note::new("frames.repeated", text, "they are left out"));
        }
        if dropped > 0 {
            let text = format!("{dropped} frames are missing by the film's own clock");
            notes.push(Note::new("frames.dropped", text, "the gaps stay in the clock"));
        }
        let cut = sightings.iter().filter(|s| s.cut).count();
        if cut > 0 {
            let text =
                format!("the border of the picture cuts the ball in {cut} frames, which are left out of the track");
            notes.push(Note::new("view.border", text, "keep the whole flight in view"));
        }
        Ok(Track {
            frames,
            size_px: self.size_px,
            rate_hz: 1.0 / step_s,
            colour: self.scene.window,
            sightings,
            repeated,
            dropped,
            notes,
        })
    }
}

impl Track {
    /// The sightings in full view, in frames that are no repetition.
    pub fn whole(&self) -> impl Iterator<Item = &Sighting> {
        self.sightings.iter().filter(|s| !s.cut && !self.repeated.contains(&s.frame))
    }

    /// The track as an observation in pixels.
    ///
    /// # Errors
    /// [`Error::Observation`] where too few frames show the whole ball.
    pub fn observation(&self) -> Result<Observation> {
        let clock = self.whole().map(|s| s.time_s).collect();
        let values = self.whole().flat_map(|s| [s.u_px, s.v_px]).collect();
        Observation::new(Kind::Pixels, vec![Channel::new("u", "px"), Channel::new("v", "px")], clock, values)
    }
}

fn mean_difference(a: &[u8], b: &[u8]) -> f64 {
    let sum: u64 = a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len().max(1) as f64
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use opencv::core::{CV_8UC3, Point, Scalar, Size};
    use opencv::imgproc::{FILLED, LINE_AA, circle};
    use opencv::videoio::{VideoWriter, VideoWriterTrait};

    /// A film of a disc that falls and bounces before a grey wall: where its centre is in each frame, px.
    fn film(path: &Path, colours: &[Scalar]) -> Vec<(f64, f64)> {
        let codec = VideoWriter::fourcc('M', 'J', 'P', 'G').unwrap();
        let mut writer = VideoWriter::new(path.to_str().unwrap(), codec, 60.0, Size::new(320, 240), true).unwrap();
        let mut centres = Vec::new();
        for i in 0..60 {
            let t = f64::from(i) / 60.0;
            let (u, v) = (60.3 + 150.0 * t, 40.0 + 160.0 * (1.0 - (3.0 * t).cos().abs()));
            let wall = Scalar::new(120.0, 125.0, 122.0, 0.0);
            let mut frame = Mat::new_rows_cols_with_default(240, 320, CV_8UC3, wall).unwrap();
            for (k, colour) in colours.iter().enumerate() {
                // Sixteenths of a pixel.
                #[expect(clippy::cast_possible_truncation, reason = "small numbers")]
                let at = Point::new((16.0 * (u + 60.0 * k as f64)).round() as i32, (16.0 * v).round() as i32);
                circle(&mut frame, at, 16 * 12, *colour, FILLED, LINE_AA, 4).unwrap();
            }
            writer.write(&frame).unwrap();
            centres.push((u, v));
        }
        writer.release().unwrap();
        centres
    }

    #[test]
    fn a_drawn_disc_is_found_to_a_fraction_of_a_pixel() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film.avi");
        let centres = film(&path, &[Scalar::new(40.0, 40.0, 220.0, 0.0)]);
        for colour in [None, Some(Window::parse("red").unwrap())] {
            let track = track(&path, &Settings { colour }, &mut |_| {}).unwrap();
            assert_eq!((track.frames, track.sightings.len()), (60, 60));
            assert!((track.rate_hz - 60.0).abs() < 1e-6, "{}", track.rate_hz);
            for s in &track.sightings {
                let (u, v) = centres[s.frame];
                assert!((s.u_px - u).hypot(s.v_px - v) < 0.2, "frame {}: {} {} for {u} {v}", s.frame, s.u_px, s.v_px);
                assert!((s.radius_px - 12.0).abs() < 1.0 && !s.cut, "{s:?}");
            }
            assert_eq!(track.observation().unwrap().len(), track.whole().count());
        }
    }

    #[test]
    fn no_ball_two_balls_and_a_wrong_colour_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (grey, two, one) =
            (folder.path().join("grey.avi"), folder.path().join("two.avi"), folder.path().join("one.avi"));
        film(&grey, &[]);
        let green = Scalar::new(40.0, 220.0, 40.0, 0.0);
        film(&two, &[green, green]);
        film(&one, &[green]);
        let refusal = |path: &Path, settings: &Settings| track(path, settings, &mut |_| {}).unwrap_err().to_string();
        assert!(refusal(&grey, &Settings::default()).contains("nothing round and coloured that moves"));
        assert!(refusal(&two, &Settings::default()).contains("two things alike"));
        let red = Settings { colour: Some(Window::parse("red").unwrap()) };
        assert!(refusal(&one, &red).contains("of the given colour"));
    }

    /// Frames with a ball in them, as counted by eye and told beside the films, one more or less at the border.
    #[test]
    fn balls_in_real_films_are_seen() {
        let Some(root) = std::env::var_os("TUNENET_MEASURED") else {
            eprintln!("skipped: TUNENET_MEASURED does not name a folder of measured files");
            return;
        };
        let films = [
            ("video-redball/RedBall.mp4", 57..=60),
            ("video-throws/PV_1.mp4", 51..=53),
            ("video-throws/PV_2.mp4", 37..=39),
            ("video-tennis-throw/ball.mp4", 27..=27),
        ];
        for (name, expected) in films {
            let path = Path::new(&root).join(name);
            if !path.exists() {
                eprintln!("skipped: {} is not there", path.display());
                continue;
            }
            let found = track(&path, &Settings::default(), &mut |_| {}).unwrap();
            assert!(expected.contains(&found.sightings.len()), "{name}: {} frames", found.sightings.len());
        }
    }
}
