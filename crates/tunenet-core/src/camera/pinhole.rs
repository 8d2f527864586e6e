//! Pinhole camera (Hartley and Zisserman 2004, section 6.1), without lens distortion.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// A pinhole camera that stands upright and looks at a point.
///
/// Pictures have `u` to the right and `v` downwards, in px; the middle of the first pixel is (0, 0).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pinhole {
    eye_m: [f64; 3],
    /// Unit vectors along the picture's axes and the line of sight.
    right: [f64; 3],
    down: [f64; 3],
    forward: [f64; 3],
    focal_px: f64,
    size_px: (usize, usize),
}

/// The outline of a sphere in a picture, as a circle: the ellipse's middle, and the mean of its half axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// The middle, px.
    pub centre_px: [f64; 2],
    /// The radius, px.
    pub radius_px: f64,
}

impl Pinhole {
    /// A camera at `eye_m` that looks at `aim_m`; `field_of_view_rad` is that of the picture's height, `size_px` its width
    /// and height. `None` where it would look straight up or down, or at itself, or sees nothing.
    #[must_use]
    pub fn aimed(eye_m: [f64; 3], aim_m: [f64; 3], field_of_view_rad: f64, size_px: (usize, usize)) -> Option<Self> {
        let forward = (Point3::from(aim_m) - Point3::from(eye_m)).try_normalize(1e-9)?;
        let right = forward.cross(&Vector3::z()).try_normalize(1e-9)?;
        let focal_px = 0.5 * size_px.1 as f64 / (0.5 * field_of_view_rad).tan();
        let sees = focal_px.is_finite() && focal_px > 0.0 && size_px.0 > 0 && size_px.1 > 0;
        let down = forward.cross(&right).into();
        sees.then(|| Self { eye_m, right: right.into(), down, forward: forward.into(), focal_px, size_px })
    }

    /// Width and height of the picture, px.
    #[must_use]
    pub fn size_px(&self) -> (usize, usize) {
        self.size_px
    }

    /// Where a point appears, px; `None` behind the camera. It may lie outside the picture.
    #[must_use]
    pub fn project(&self, point_m: [f64; 3]) -> Option<[f64; 2]> {
        let [right, down, depth] = self.seen_from_here(point_m);
        let [u, v] = self.middle_px();
        (depth > 0.0).then(|| [u + self.focal_px * right / depth, v + self.focal_px * down / depth])
    }

    /// The outline of a sphere; `None` where the camera is not wholly in front of it.
    ///
    /// Its middle is not where the sphere's centre appears: the cone of sight that touches the sphere is cut obliquely away
    /// from the picture's middle, and the ellipse reaches farther outwards than inwards.
    #[must_use]
    pub fn disc(&self, centre_m: [f64; 3], radius_m: f64) -> Option<Disc> {
        let [right, down, depth] = self.seen_from_here(centre_m);
        let across = [right, down];
        let half_angle = (radius_m / right.hypot(down).hypot(depth)).asin();
        let angle = across[0].hypot(across[1]).atan2(depth);
        if !half_angle.is_finite() || angle + half_angle >= std::f64::consts::FRAC_PI_2 {
            return None;
        }
        let (outer, inner) = ((angle + half_angle).tan(), (angle - half_angle).tan());
        let (middle, along) = (0.5 * (outer + inner), 0.5 * (outer - inner));
        // The half axis across: Dandelin's spheres, or r/√(depth² − r²).
        let transverse = radius_m / (depth * depth - radius_m * radius_m).sqrt();
        let length = across[0].hypot(across[1]).max(f64::MIN_POSITIVE);
        let picture = self.middle_px();
        let at = |i: usize| picture[i] + self.focal_px * middle * across[i] / length;
        Some(Disc { centre_px: [at(0), at(1)], radius_px: 0.5 * self.focal_px * (along + transverse) })
    }

    /// From the eye through a place in the picture, not normalised: its share along the line of sight is 1.
    #[must_use]
    pub fn ray(&self, u_px: f64, v_px: f64) -> [f64; 3] {
        let [u, v] = self.middle_px();
        let along = |px: f64| px / self.focal_px;
        let (right, down) = (along(u_px - u), along(v_px - v));
        [0, 1, 2].map(|i| self.forward[i] + self.right[i] * right + self.down[i] * down)
    }

    /// Where it stands, m.
    #[must_use]
    pub fn eye_m(&self) -> [f64; 3] {
        self.eye_m
    }

    /// A point in the camera's own axes: right, down, ahead, m.
    fn seen_from_here(&self, point_m: [f64; 3]) -> [f64; 3] {
        let way = Point3::from(point_m) - Point3::from(self.eye_m);
        [self.right, self.down, self.forward].map(|axis| way.dot(&Vector3::from(axis)))
    }

    fn middle_px(&self) -> [f64; 2] {
        [0.5 * (self.size_px.0 as f64 - 1.0), 0.5 * (self.size_px.1 as f64 - 1.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Pinhole {
        Pinhole::aimed([7.0, -2.0, 6.0], [0.0, 0.0, 2.0], 1.0, (160, 120)).unwrap()
    }

    #[test]
    fn what_it_looks_at_is_in_the_middle_and_up_is_up() {
        let camera = camera();
        let [u, v] = camera.project([0.0, 0.0, 2.0]).unwrap();
        assert!((u - 79.5).abs() < 1e-9 && (v - 59.5).abs() < 1e-9);
        let [u, higher] = camera.project([0.0, 0.0, 3.0]).unwrap();
        assert!((u - 79.5).abs() < 1e-9 && higher < v);
        assert!(camera.project([20.0, -6.0, 14.0]).is_none());
    }

    #[test]
    fn a_ray_goes_through_what_is_projected_there() {
        let camera = camera();
        let point = [0.3, -0.4, 1.1];
        let [u, v] = camera.project(point).unwrap();
        let (ray, eye) = (Vector3::from(camera.ray(u, v)), Vector3::from(camera.eye_m()));
        let way = Vector3::from(point) - eye;
        assert!(ray.cross(&way).norm() < 1e-9 * way.norm());
    }

    /// The outline's points are those whose ray touches the sphere; found here by looking along many rays.
    #[test]
    fn the_outline_is_where_rays_touch_the_sphere() {
        let camera = camera();
        let (centre, radius) = ([0.0, 0.0, 4.5], 0.5);
        let disc = camera.disc(centre, radius).unwrap();
        let way = Vector3::from(centre) - Vector3::from(camera.eye_m());
        let hits = |u: f64, v: f64| {
            let ray = Vector3::from(camera.ray(u, v)).normalize();
            (way - ray * way.dot(&ray)).norm() < radius
        };
        let (mut count, mut sum) = (0.0, [0.0; 2]);
        let step = 0.02;
        let steps = (0..1500).map(|i| step * (f64::from(i) - 750.0));
        for du in steps.clone() {
            for dv in steps.clone() {
                let (u, v) = (disc.centre_px[0] + du, disc.centre_px[1] + dv);
                if hits(u, v) {
                    count += 1.0;
                    sum = [sum[0] + u, sum[1] + v];
                }
            }
        }
        assert!((sum[0] / count - disc.centre_px[0]).abs() < 0.005, "{} {disc:?}", sum[0] / count);
        assert!((sum[1] / count - disc.centre_px[1]).abs() < 0.005, "{} {disc:?}", sum[1] / count);
        let radius = (count * step * step / std::f64::consts::PI).sqrt();
        assert!((radius / disc.radius_px - 1.0).abs() < 0.002, "{radius} {disc:?}");
        // The projection of the sphere's centre is not the centre of the disc.
        assert!((camera.project(centre).unwrap()[1] - disc.centre_px[1]).abs() > 0.1);
    }
}
