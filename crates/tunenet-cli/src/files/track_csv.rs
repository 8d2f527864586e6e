//! The track of a ball as a CSV file.

use std::path::Path;

use tunenet_formats::Result;
use tunenet_formats::write_atomically;
use tunenet_video_protocol::track::Samples;

/// Writes the samples in metres, or in pixels where nothing says how large one is, or where that is wanted.
pub fn write(out: &Path, samples: &Samples, pixels: bool) -> Result<()> {
    let (names, places) = match samples.metres.as_ref().filter(|_| !pixels) {
        Some(metres) => (["x_m", "z_m"], [&metres.x_m, &metres.z_m]),
        None => (["u_px", "v_px"], [&samples.u_px, &samples.v_px]),
    };
    let columns = [&samples.t_s, places[0], places[1], &samples.radius_px, &samples.confidence];
    write_atomically(out, |file| {
        writeln!(file, "t_s,{},{},radius_px,confidence", names[0], names[1])?;
        for i in 0..samples.t_s.len() {
            let row: Vec<String> = columns.iter().map(|column| format!("{:?}", rounded(column[i]))).collect();
            writeln!(file, "{}", row.join(","))?;
        }
        Ok(())
    })
}

/// Writes only the times of the bounces.
pub fn write_bounces(out: &Path, bounces_s: &[f64]) -> Result<()> {
    write_atomically(out, |file| {
        writeln!(file, "bounce_time_s")?;
        bounces_s.iter().try_for_each(|time_s| writeln!(file, "{:?}", rounded(*time_s)))
    })
}

/// Nanometres and nanoseconds are beyond any video.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}
