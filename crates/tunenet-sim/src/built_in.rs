//! The network that comes with the tool: for any dropped ball with unknown release and floor.

use std::path::Path;

use tunenet_core::network::Model;
use tunenet_core::simulator::Prepared;
use tunenet_core::statistics::median;
use tunenet_formats::Result;
use tunenet_formats::model_from_bytes;

use crate::SimulationFile;
use crate::ball::Forces;
use crate::ball::effects::BallEffect;

/// Made by `make model`, and by nothing else.
const BYTES: &[u8] = include_bytes!("../../../assets/networks/ball.safetensors");

/// Heights of fall that it serves, m.
pub const FALL_M: (f64, f64) = (0.3, 10.0);
/// Rates that it is trained for, Hz. It sees means over intervals, so that more samples only make them surer.
pub const RATE_HZ: (f64, f64) = (24.0, 240.0);
/// Drag bends a fall of `h` by the share `c h / 2` or so; up to here the network's start is as good as without.
const GREATEST_DRAG: f64 = 0.3;

/// The network for any dropped ball; it estimates restitution from positions.
///
/// # Errors
/// [`File`](tunenet_formats::Error::File) where the program's own bytes are damaged.
pub fn ball() -> Result<Model> {
    model_from_bytes(Path::new("the built-in network"), BYTES)
}

/// Whether that network is made for `file` and this recording of its ball; where not, why.
///
/// # Errors
/// What is out of its range, in words.
pub fn serves(file: &SimulationFile, recording: &Prepared) -> std::result::Result<(), String> {
    let tuned = file.parameters().map_err(|e| e.to_string())?;
    let tuned: Vec<&str> = tuned.iter().filter(|p| p.tune).map(|p| p.name.as_str()).collect();
    if tuned != ["restitution"] {
        return Err(format!("it estimates restitution, not {}", tuned.join(" and ")));
    }
    let Some(scale) = recording.scale else { return Err("the recording has no height of fall".into()) };
    let within = |value: f64, (low, high): (f64, f64)| value >= low && value <= high;
    if !within(scale.length, FALL_M) {
        return Err(format!("{:.3} m of fall, expected {} to {} m", scale.length, FALL_M.0, FALL_M.1));
    }
    let rate = median_rate_hz(recording.seen.clock());
    // A clock of whole milliseconds may miss a rate by a little.
    if rate < RATE_HZ.0 * 0.98 {
        return Err(format!("{rate:.1} samples per second, expected {} or more", RATE_HZ.0));
    }
    let ball = file.ball().map_err(|e| e.to_string())?;
    let mut scene = ball.simulated();
    for present in file.effects() {
        if let Some(effect) = BallEffect::find(&present.name) {
            (effect.apply)(&mut scene, &present.values);
        }
    }
    let Forces { quadratic_drag_1_m, linear_drag_1_s, magnus_1_s, .. } = scene.flight;
    let bent = quadratic_drag_1_m * scale.length > GREATEST_DRAG || linear_drag_1_s * scale.time_s > GREATEST_DRAG;
    let level = ball.surface.tilt_about_x_rad == 0.0 && ball.surface.tilt_about_y_rad == 0.0;
    let formulas = file.effects().iter().any(|present| file.candidate(&present.name).is_some());
    if bent || formulas || magnus_1_s != [0.0; 3] {
        return Err("the scene's forces bend the flight".into());
    }
    if !level {
        return Err("the surface is tilted".into());
    }
    Ok(())
}

/// Samples per second in the middle of all intervals.
fn median_rate_hz(clock: &[f64]) -> f64 {
    1.0 / median(clock.windows(2).map(|w| w[1] - w[0])).unwrap_or(f64::NAN)
}
