//! From pixels to metres: by the ball's radius, by a length in the picture, or by how fast the ball falls.

use tunenet_ball::preflight::{Expected, Preflight, examine};
use tunenet_core::camera::LineCamera;
use tunenet_core::observation::Observation;
use tunenet_core::{Error, Origin, Result};
use tunenet_video_protocol::track::ScaleSource;
use tunenet_video_protocol::{VideoFinding, findings};

use crate::parabola::Parabola;
use crate::perspective;
use crate::track::Track;
use tunenet_core::statistics::{median, range};

/// Gravity is first read off windows of so many seconds, and at least so many frames.
const WINDOW: (f64, usize) = (0.12, 5);
/// A window says something of gravity where the ball moves by this share of its radius.
const MOVES: f64 = 0.5;
/// Scales by radius and by gravity differ by more than this where one of them is wrong.
const DISAGREE: f64 = 0.2;
/// A flight falls otherwise than the others from this share on, and this many standard deviations.
const ODD: (f64, f64) = (0.1, 4.0);
/// Fewest samples of a flight whose fall is judged.
const FLIGHT_SAMPLES: usize = 5;
/// What lies this near a contact, in frames, is of neither flight.
const CONTACT_FRAMES: f64 = 0.75;
/// Contacts are found again in heights read back by a camera, and the camera by them.
const CAMERA_ROUNDS: usize = 3;

/// What is known of lengths in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Known {
    /// The ball's radius, m.
    Radius(f64),
    /// A length, m, between two points of the picture, px.
    Length {
        /// m.
        metres: f64,
        /// px.
        pixels: f64,
    },
    /// Nothing but gravity.
    Nothing,
}

/// A track in metres.
#[derive(Debug, Clone)]
pub struct Metric {
    /// m for each px, in the plane in which the ball moves.
    pub metres_per_px: f64,
    /// Where that comes from.
    pub by: ScaleSource,
    /// The camera by which heights were read back, where it does not look from the side; its height 0 is the ball's at
    /// contact.
    pub camera: Option<LineCamera>,
    /// x to the right, y = 0, z upwards from the surface (from the lowest point seen where there is no bounce), m.
    pub observation: Observation,
    /// What core's checks say of it.
    pub preflight: Preflight,
    /// What was noticed of the scale and the flights.
    pub notes: Vec<VideoFinding>,
}

impl Metric {
    /// The track in metres; `None` where nothing says how large a pixel is, since the ball does not fly freely.
    ///
    /// Gravity, where there is enough of it to see, is taken before the radius of a ball: it makes the flights what the
    /// simulation expects of them. A given length has priority, then a radius that is `Known`.
    ///
    /// # Errors
    /// [`Error::Observation`] where too few frames show the whole ball; [`Error::Setting`] for a length that is none.
    pub fn of(track: &Track, known: Known, expected: &Expected) -> Result<Option<Self>> {
        let gravity = expected.gravity_m_s2;
        let by_gravity = by_gravity(track, gravity);
        let positive = |value: f64, name: &'static str| {
            let refused = || Error::Setting {
                origin: Origin::Caller,
                name,
                expected: "a length above 0".into(),
                found: value.to_string(),
            };
            (value.is_finite() && value > 0.0).then_some(value).ok_or_else(refused)
        };
        let (metres_per_px, by) = match (known, by_gravity) {
            (Known::Length { metres, pixels }, _) => {
                (positive(metres, "--length")? / positive(pixels, "--length")?, ScaleSource::Length)
            }
            (Known::Radius(radius), _) => (positive(radius, "--radius")? / track.radius_px(), ScaleSource::Radius),
            (Known::Nothing, Some(scale)) => (scale, ScaleSource::Gravity),
            (Known::Nothing, None) => match expected.radius_m {
                Some(radius) => (radius / track.radius_px(), ScaleSource::Radius),
                None => return Ok(None),
            },
        };
        let radius_m = expected.radius_m.unwrap_or(metres_per_px * track.radius_px());
        let mut notes = Vec::new();
        let by_radius = expected.radius_m.map(|r| r / track.radius_px());
        if let (Some(a), Some(b)) = (by_gravity, by_radius.or((by != ScaleSource::Gravity).then_some(metres_per_px))) {
            notes.extend(disagreement(a, b));
        }
        let eye = Eye { metres_per_px, camera: None };
        let eye = if by == ScaleSource::Gravity { eye.turned(track, gravity) } else { eye };
        let (observation, preflight) = placed(track, &eye, radius_m, expected)?;
        notes.extend(odd_flights(&observation, &preflight));
        Ok(Some(Self { metres_per_px: eye.metres_per_px, by, camera: eye.camera, observation, preflight, notes }))
    }
}

/// That the fall and the size of the ball do not go together.
fn disagreement(by_gravity: f64, by_length: f64) -> Option<VideoFinding> {
    let factor = by_length / by_gravity;
    // A video that is played k times slower falls k² times slower, which makes pixels look k² times larger.
    let slower = (1.0 / factor).sqrt();
    ((factor - 1.0).abs() > DISAGREE).then(|| {
        let text = format!(
            "by its size a pixel is {:.3} mm, by its fall {:.3} mm: the frame rate in the file is then wrong by a factor of {slower:.2}",
            1e3 * by_length,
            1e3 * by_gravity
        );
        VideoFinding::new(findings::SCALE_DISAGREES,
            text,
            "correct `ball.radius_m` or `--length`, or give the camera's true rate with `--camera-rate` (slow motion)",
        )
    })
}

/// Metres for each pixel with which the ball falls as gravity has it.
fn by_gravity(track: &Track, gravity: f64) -> Option<f64> {
    let (times, heights): (Vec<f64>, Vec<f64>) = track.whole().map(|s| (s.time_s, s.v_px)).unzip();
    let span = times.last()? - times.first()?;
    let rate = (times.len() - 1) as f64 / span.max(f64::MIN_POSITIVE);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few frames")]
    let width = ((WINDOW.0 * rate).round().min(1e6) as usize).max(WINDOW.1);
    let least = MOVES * track.radius_px();
    let windows: Vec<Parabola> = (0..(times.len() + 1).saturating_sub(width))
        .filter_map(|i| {
            let part = &heights[i..i + width];
            let moves = range(part.iter().copied()) > least;
            Parabola::fit(&times[i..i + width], part).filter(|p| moves && p.acceleration > 0.0)
        })
        .collect();
    let usual = median(windows.iter().map(|p| p.residual))?;
    let fall = median(windows.iter().filter(|p| p.residual <= 2.0 * usual).map(|p| p.acceleration))?;
    let mut scale = gravity / fall;
    // Whole flights say it better than windows do.
    for _ in 0..2 {
        let expected = Expected { gravity_m_s2: gravity, ..Expected::default() };
        let seen = positions(track, &Eye { metres_per_px: scale, camera: None }, 0.0).ok()?;
        let Some(found) = examine(&seen, &expected).gravity else { break };
        let better = scale * gravity / found.value_m_s2;
        if !(0.3..3.0).contains(&(better / scale)) {
            break;
        }
        scale = better;
    }
    (scale.is_finite() && scale > 0.0).then_some(scale)
}

/// How pixels are read back.
#[derive(Debug, Clone, Copy)]
struct Eye {
    metres_per_px: f64,
    /// Where one scale does not do for all heights.
    camera: Option<LineCamera>,
}

impl Eye {
    /// With the camera that the hops between contacts show.
    fn turned(self, track: &Track, gravity_m_s2: f64) -> Self {
        let (clock, v_px): (Vec<f64>, Vec<f64>) = track.whole().map(|s| (s.time_s, s.v_px)).unzip();
        let expected = Expected { gravity_m_s2, ..Expected::default() };
        let mut eye = self;
        for _ in 0..CAMERA_ROUNDS {
            let seen = positions(track, &eye, 0.0).ok();
            let Some(arcs) = seen.and_then(|seen| examine(&seen, &expected).arcs) else { break };
            let contacts: Vec<f64> = arcs.contacts.iter().map(|c| c.time_s).collect();
            let Some(camera) = perspective::of_hops(&clock, &v_px, &contacts, gravity_m_s2) else { break };
            // All heights have to lie before it, those of the first fall too.
            let heights: Vec<f64> = v_px.iter().map(|v| camera.height(*v)).collect();
            if !heights.iter().all(|z| z.is_finite() && camera.depth(*z) > 0.0) {
                break;
            }
            let (low, high) =
                heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(*z), h.max(*z)));
            let px = (camera.project(high) - camera.project(low)).abs();
            eye = Self { metres_per_px: (high - low) / px.max(f64::MIN_POSITIVE), camera: Some(camera) };
        }
        eye
    }

    /// To the right and upwards, m. A camera shows widths as much smaller as they are farther away.
    fn place(&self, track: &Track, u_px: f64, v_px: f64) -> (f64, f64) {
        let Some(camera) = &self.camera else { return (self.metres_per_px * u_px, -self.metres_per_px * v_px) };
        let (z, middle) = (camera.height(v_px), 0.5 * (track.size_px.0 as f64 - 1.0));
        let offset_m = self.metres_per_px * (u_px - middle) * camera.depth(z) / camera.depth(0.0);
        (offset_m + self.metres_per_px * middle, z)
    }
}

fn positions(track: &Track, eye: &Eye, lift_m: f64) -> Result<Observation> {
    let (times, places): (Vec<f64>, Vec<[f64; 3]>) = track
        .whole()
        .map(|s| {
            let (x, z) = eye.place(track, s.u_px, s.v_px);
            (s.time_s, [x, 0.0, lift_m + z])
        })
        .unzip();
    Observation::positions(times, &places)
}

/// Positions with the surface at z = 0.
fn placed(track: &Track, eye: &Eye, radius_m: f64, expected: &Expected) -> Result<(Observation, Preflight)> {
    let raw = positions(track, eye, 0.0)?;
    let free = Expected { radius_m: None, surface_height_m: None, release_height_m: None, ..*expected };
    let contacts = examine(&raw, &free).arcs.map(|arcs| arcs.contacts).unwrap_or_default();
    let lowest = raw.column(2).fold(f64::INFINITY, f64::min);
    let level = median(contacts.iter().map(|c| c.height_m)).unwrap_or(lowest);
    let place = expected.surface_height_m.unwrap_or(0.0) + radius_m - level;
    let seen = positions(track, eye, place)?;
    let preflight = examine(&seen, &Expected { radius_m: Some(radius_m), ..*expected });
    Ok((seen, preflight))
}

/// Flights that fall otherwise than the rest: a hand still holds the ball, or it comes nearer.
fn odd_flights(seen: &Observation, preflight: &Preflight) -> Vec<VideoFinding> {
    let Some(arcs) = &preflight.arcs else { return Vec::new() };
    let clock = seen.clock();
    let heights: Vec<f64> = seen.column(2).collect();
    let frame = median(clock.windows(2).map(|w| w[1] - w[0])).unwrap_or(0.0);
    let bounds: Vec<f64> = [clock[0] - frame]
        .into_iter()
        .chain(arcs.contacts.iter().map(|c| c.time_s))
        .chain([clock[clock.len() - 1] + frame])
        .collect();
    let flights: Vec<(f64, f64, Parabola)> = bounds
        .windows(2)
        .filter_map(|w| {
            let begin = clock.partition_point(|t| *t < w[0] + CONTACT_FRAMES * frame);
            let end = clock.partition_point(|t| *t <= w[1] - CONTACT_FRAMES * frame);
            let enough = end >= begin + FLIGHT_SAMPLES;
            let fit = enough.then(|| Parabola::fit(&clock[begin..end], &heights[begin..end]))??;
            Some((clock[begin], clock[end - 1], fit))
        })
        .collect();
    if flights.len() < 3 {
        return Vec::new();
    }
    let usual = median(flights.iter().map(|f| f.2.acceleration)).unwrap_or(0.0);
    flights
        .iter()
        .filter(|(_, _, f)| {
            let away = (f.acceleration - usual).abs();
            away > ODD.0 * usual.abs() && away > ODD.1 * f.acceleration_sd
        })
        .map(|(begin, end, f)| {
            let text = format!(
                "from {begin:.3} to {end:.3} s the ball falls with {:.2} of the acceleration of the other flights",
                f.acceleration / usual
            );
            VideoFinding::new(
                findings::FLIGHT_ODD,
                text,
                "release it cleanly, and record from the side, level and far away",
            )
        })
        .collect()
}
