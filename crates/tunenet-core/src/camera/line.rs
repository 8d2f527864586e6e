//! Projective map of a line (Hartley and Zisserman 2004, section 2.5): heights on a vertical line, in any camera.

use nalgebra::{Matrix3, Vector3};

use crate::simulator::Scale;

/// Steps of Gauss and Newton after the linear estimate; each squares the relative error.
const REFINEMENTS: usize = 4;
/// Fewest samples of a first fall that say anything of three numbers.
const FEWEST: usize = 6;
/// A body is at rest where its last samples spread by less than this share of what the whole record spans.
const REST_SHARE: f64 = 0.02;
/// ... over at least this share of the record.
const REST_LENGTH: f64 = 0.05;

/// What any pinhole camera makes of heights on one vertical line: `v = (a z + b) / (c z + 1)`, with `v` in px and `z` in m.
///
/// Three numbers hold place, aim and focal length as far as they matter to a fall. They follow from samples of known height
/// alone: those of a first fall from rest, whose heights are known without the impacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineCamera {
    a_px_m: f64,
    b_px: f64,
    c_1_m: f64,
}

impl LineCamera {
    /// The camera that shows the heights `z_m` at `v_px`, by least squares in the picture. `None` where fewer than 3
    /// samples, or all of one height, are given, or no camera shows them.
    #[must_use]
    pub fn fit(z_m: &[f64], v_px: &[f64]) -> Option<Self> {
        // Around the middle and in units of the half range, or the squares lose their digits.
        let (low, high) = z_m.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(*z), h.max(*z)));
        let (middle, half) = (low.midpoint(high), 0.5 * (high - low));
        if z_m.len() < 3 || !half.is_finite() || half <= 0.0 {
            return None;
        }
        let samples = || z_m.iter().map(|z| (z - middle) / half).zip(v_px.iter().copied());
        // v = a z + b − c z v is linear; its error is weighted wrongly, which the steps mend.
        let mut found = least_squares(samples().map(|(z, v)| ([z, 1.0, -z * v], v)))?;
        for _ in 0..REFINEMENTS {
            let step = least_squares(samples().map(|(z, v)| {
                let depth = found[2] * z + 1.0;
                let seen = (found[0] * z + found[1]) / depth;
                ([z / depth, 1.0 / depth, -z * seen / depth], v - seen)
            }))?;
            found += step;
        }
        // Back from the scaled height: (a z' + b)/(c z' + 1) with z' = (z − middle)/half.
        let [a, b, c] = [found[0] / half, found[1], found[2] / half];
        let unit = 1.0 - c * middle;
        let camera = Self { a_px_m: a / unit, b_px: (b - a * middle) / unit, c_1_m: c / unit };
        let in_front = [low, high].iter().all(|z| camera.c_1_m * z + 1.0 > 0.0);
        (in_front && camera.a_px_m.is_finite() && camera.b_px.is_finite()).then_some(camera)
    }

    /// The camera from the first fall of this scale, and from the rest at the end where there is one. `clock` in
    /// s, `v_px` downwards. `None` where the fall is hardly seen.
    #[must_use]
    pub fn of_fall(clock: &[f64], v_px: &[f64], scale: &Scale) -> Option<Self> {
        let tau = |t: f64| (t - scale.start_s) / scale.time_s;
        let fall = clock.iter().zip(v_px).filter(|(t, _)| (0.0..2f64.sqrt()).contains(&tau(**t)));
        let height = |t: f64| scale.origin + scale.length * (1.0 - 0.5 * tau(t).powi(2));
        let (mut z_m, mut seen): (Vec<f64>, Vec<f64>) = fall.map(|(t, v)| (height(*t), *v)).unzip();
        if z_m.len() < FEWEST {
            return None;
        }
        let rest = at_rest(v_px);
        z_m.resize(z_m.len() + rest.len(), scale.origin);
        seen.extend(rest);
        Self::fit(&z_m, &seen)
    }

    /// Where a height appears, px.
    #[must_use]
    pub fn project(&self, z_m: f64) -> f64 {
        (self.a_px_m * z_m + self.b_px) / (self.c_1_m * z_m + 1.0)
    }

    /// How far away a height is, over the distance of height 0: the scale of the picture is that much smaller there.
    #[must_use]
    pub fn depth(&self, z_m: f64) -> f64 {
        self.c_1_m * z_m + 1.0
    }

    /// The height that appears here, m.
    #[must_use]
    pub fn height(&self, v_px: f64) -> f64 {
        (self.b_px - v_px) / (self.c_1_m * v_px - self.a_px_m)
    }
}

/// The samples at the end that do not move any more.
fn at_rest(v_px: &[f64]) -> &[f64] {
    let span = |values: &[f64]| {
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    };
    let still = REST_SHARE * span(v_px);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let moving = v_px.iter().rposition(|v| {
        (low, high) = (low.min(*v), high.max(*v));
        high - low > still
    });
    let rest = &v_px[moving.map_or(0, |i| i + 1)..];
    // The last small hops are among them; the later half is surely still.
    if rest.len() as f64 >= REST_LENGTH * v_px.len() as f64 { &rest[rest.len() / 2..] } else { &[] }
}

fn least_squares(rows: impl Iterator<Item = ([f64; 3], f64)>) -> Option<Vector3<f64>> {
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (row, value) in rows {
        let row = Vector3::from(row);
        normal += row * row.transpose();
        right += row * value;
    }
    let found = normal.cholesky()?.solve(&right);
    found.iter().all(|v| v.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::super::Pinhole;
    use super::*;

    #[test]
    fn any_pinhole_is_one() {
        let camera = Pinhole::aimed([3.0, 7.0, 6.0], [0.0, 0.0, 2.0], 1.0, (160, 120)).unwrap();
        let z: Vec<f64> = (0..40).map(|i| 0.5 + 0.1 * f64::from(i)).collect();
        let v: Vec<f64> = z.iter().map(|z| camera.project([0.0, 0.0, *z]).unwrap()[1]).collect();
        let line = LineCamera::fit(&z, &v).unwrap();
        for (z, v) in z.iter().zip(&v) {
            assert!((line.project(*z) - v).abs() < 1e-8);
            assert!((line.height(*v) - z).abs() < 1e-9);
        }
    }

    #[test]
    fn a_first_fall_is_enough() {
        // A fall of 4 m to rest on the floor at z = 0.5, seen by a line camera.
        let truth = LineCamera { a_px_m: -11.0, b_px: 70.0, c_1_m: -0.04 };
        let scale = Scale::new(0.5, 4.0, 0.1, (4.0 / 9.81f64).sqrt()).unwrap();
        let clock: Vec<f64> = (0..120).map(|i| 0.1 + f64::from(i) / 60.0).collect();
        let z = |t: f64| (4.5 - 4.905 * (t - 0.1).powi(2)).max(0.5);
        let v: Vec<f64> = clock.iter().map(|t| truth.project(z(*t))).collect();
        let found = LineCamera::of_fall(&clock, &v, &scale).unwrap();
        for z in [0.5, 2.0, 4.5] {
            assert!((found.project(z) - truth.project(z)).abs() < 1e-6, "{found:?}");
        }
        assert!(LineCamera::of_fall(&clock[60..], &v[60..], &scale).is_none());
        assert!(LineCamera::fit(&[1.0, 1.0, 1.0], &[3.0, 3.0, 3.0]).is_none());
    }
}
