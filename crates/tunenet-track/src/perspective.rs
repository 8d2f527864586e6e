//! Self-calibration of a projective line camera from the hops of a bouncing ball, with unknown height of fall.
//!
//! Between two contacts a ball is in free flight, and its duration gives its height at every instant: `g/2` times the
//! time since the one and the time until the other. So the hops between contacts have known heights without a scale and
//! without the restitution, and say what any camera makes of heights: `v = (a z + b) / (c z + 1)`.

use tunenet_core::camera::LineCamera;

/// What lies this near a contact, in steps of the clock, is of neither flight.
const NEAR: f64 = 0.6;
/// Fewer samples of a hop say nothing of its bend; fewer of all hops say nothing of the camera.
const FEWEST_OF_HOP: usize = 5;
const FEWEST: usize = 10;
/// A camera that is not seen from the side must explain the samples better by this Bayes factor, as twice its logarithm.
const EVIDENCE: f64 = 20.0;
/// A ball does not come nearer than this over the hops, as a share of its distance.
const DEEPEST: f64 = 0.5;

/// The camera that shows the hops between `contacts` (s) at `v_px`; `None` where a camera from the side does as well.
pub(crate) fn of_hops(clock: &[f64], v_px: &[f64], contacts: &[f64], gravity_m_s2: f64) -> Option<LineCamera> {
    let step = (clock.last()? - clock.first()?) / (clock.len().max(2) - 1) as f64;
    let (mut heights, mut seen) = (Vec::new(), Vec::new());
    for hop in contacts.windows(2) {
        let begin = clock.partition_point(|t| *t < hop[0] + NEAR * step);
        let end = clock.partition_point(|t| *t <= hop[1] - NEAR * step).max(begin);
        if end - begin >= FEWEST_OF_HOP {
            heights.extend(clock[begin..end].iter().map(|t| 0.5 * gravity_m_s2 * (t - hop[0]) * (hop[1] - t)));
            seen.extend(&v_px[begin..end]);
        }
    }
    if heights.len() < FEWEST {
        return None;
    }
    let camera = LineCamera::fit(&heights, &seen)?;
    let top = heights.iter().copied().fold(0.0, f64::max);
    let squares =
        |at: &dyn Fn(f64) -> f64| -> f64 { heights.iter().zip(&seen).map(|(z, v)| (v - at(*z)).powi(2)).sum() };
    let (level, slope) = line(&heights, &seen);
    let (plain, bent) = (squares(&|z| level + slope * z), squares(&|z| camera.project(z)));
    let gain = heights.len() as f64 * (plain / bent.max(f64::MIN_POSITIVE)).ln();
    let plausible = (camera.depth(top) - 1.0).abs() < DEEPEST;
    (gain > EVIDENCE && plausible).then_some(camera)
}

/// Level and slope of the straight line through points.
fn line(x: &[f64], y: &[f64]) -> (f64, f64) {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let square: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
    let slope = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum::<f64>() / square;
    (my - slope * mx, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::camera::Pinhole;

    /// Hops of 1.1, 0.8 and 0.6 s by formulas alone.
    fn hops() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let contacts = vec![0.0, 1.1, 1.9, 2.5];
        let clock: Vec<f64> = (0..150).map(|i| f64::from(i) / 60.0).collect();
        let height = |t: f64| {
            let hop = contacts.windows(2).find(|h| t < h[1]).unwrap_or(&[2.5, 2.5]);
            0.5 * 9.81 * (t - hop[0]) * (hop[1] - t)
        };
        let heights = clock.iter().map(|t| height(*t)).collect();
        (clock, heights, contacts)
    }

    #[test]
    fn a_camera_that_looks_down_is_found_and_one_from_the_side_is_left_alone() {
        let (clock, heights, contacts) = hops();
        let down = Pinhole::aimed([5.0, 2.0, 6.0], [0.0, 0.0, 1.0], 1.0, (640, 480)).unwrap();
        let v: Vec<f64> = heights.iter().map(|z| down.project([0.0, 0.0, *z]).unwrap()[1]).collect();
        let camera = of_hops(&clock, &v, &contacts, 9.81).unwrap();
        for (z, v) in heights.iter().zip(&v) {
            assert!((camera.height(*v) - z).abs() < 1e-6);
        }
        let noise = |i: usize| 0.3 * ((i * 7919 % 101) as f64 / 101.0 - 0.5);
        let side: Vec<f64> = heights.iter().enumerate().map(|(i, z)| 400.0 - 150.0 * z + noise(i)).collect();
        assert!(of_hops(&clock, &side, &contacts, 9.81).is_none());
        assert!(of_hops(&clock, &v, &contacts[..1], 9.81).is_none());
    }
}
