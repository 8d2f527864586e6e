//! Pictures of a ball over a ground: synthetic videos to test the tracker.
//!
//! The ball is a shaded sphere, met by one ray through each pixel; at its edge a pixel is covered by as much as the ray
//! passes inside or outside, so that the outline has no steps. Of each picture only the ball's own box is drawn again.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use tunenet_core::camera::Pinhole;

/// Numbers of a table of noise, from whose random places every frame is taken. A power of two.
const NOISE_TABLE: usize = 1 << 18;
/// Instants within an exposure.
const EXPOSURES: usize = 5;
/// The sky above the horizon, and the ground near and far, each as blue, green, red.
const SKY: [f64; 3] = [205.0, 195.0, 185.0];
const NEAR: [f64; 3] = [120.0, 124.0, 128.0];
const FAR: [f64; 3] = [165.0, 165.0, 165.0];
/// At this distance the ground is as bright as it gets, m.
const FAR_M: f64 = 40.0;
/// How bright the ball's dark side is.
const AMBIENT: f64 = 0.35;

/// How the pictures look.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// The ball's colour: blue, green, red, 0 to 255.
    pub ball_bgr: [f64; 3],
    /// Where the light comes from; any length.
    pub light: [f64; 3],
    /// Brightness of the whole picture; 1 as it is.
    pub brightness: f64,
    /// Standard deviation of the noise on every channel of every pixel, 0 to 255.
    pub noise: f64,
}

impl Default for Look {
    fn default() -> Self {
        Self { ball_bgr: [30.0, 30.0, 220.0], light: [0.4, -0.3, 1.0], brightness: 1.0, noise: 0.0 }
    }
}

/// Draws one ball in front of one camera.
pub struct Renderer {
    camera: Pinhole,
    radius_m: f64,
    look: Look,
    light: [f64; 3],
    background: Vec<u8>,
    /// The picture without noise; equal to the background outside `drawn`.
    clean: Vec<u8>,
    /// What is given out, where it differs from `clean`.
    noisy: Vec<u8>,
    drawn: Option<Region>,
    noise: Vec<i16>,
    random: ChaCha8Rng,
}

/// Columns and rows of a picture, the last not included.
#[derive(Debug, Clone, Copy)]
struct Region {
    columns: (usize, usize),
    rows: (usize, usize),
}

impl Renderer {
    /// A ball of this radius over a ground at z = 0. `seed` decides the noise.
    #[must_use]
    pub fn new(camera: Pinhole, radius_m: f64, look: Look, seed: u64) -> Self {
        let background = background(&camera, look.brightness);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        #[expect(clippy::cast_possible_truncation, reason = "rounded and small")]
        let one = |n: f64| (look.noise * n).round().clamp(-255.0, 255.0) as i16;
        let count = if look.noise > 0.0 { NOISE_TABLE } else { 0 };
        let noise = (0..count).map(|_| one(random.sample(StandardNormal))).collect();
        let light = unit(look.light);
        let clean = background.clone();
        Self { camera, radius_m, light, look, clean, noisy: Vec::new(), background, drawn: None, noise, random }
    }

    /// The picture of a ball at `centre_m`: blue, green, red of each pixel, row after row.
    pub fn frame(&mut self, centre_m: [f64; 3]) -> &[u8] {
        self.restore();
        self.draw(centre_m);
        self.out()
    }

    /// The picture of an exposure during which the ball moves from one place to another, in a straight line.
    pub fn blurred(&mut self, from_m: [f64; 3], to_m: [f64; 3]) -> &[u8] {
        let mut sum = vec![0_u16; self.background.len()];
        for i in 0..EXPOSURES {
            let share = (i as f64 + 0.5) / EXPOSURES as f64;
            self.restore();
            self.draw([0, 1, 2].map(|k| from_m[k] + share * (to_m[k] - from_m[k])));
            sum.iter_mut().zip(&self.clean).for_each(|(sum, value)| *sum += u16::from(*value));
        }
        #[expect(clippy::cast_possible_truncation, reason = "a mean of bytes is a byte")]
        let mean = |sum: u16| ((sum + EXPOSURES as u16 / 2) / EXPOSURES as u16) as u8;
        self.clean.iter_mut().zip(&sum).for_each(|(value, sum)| *value = mean(*sum));
        let (width, height) = self.camera.size_px();
        self.drawn = Some(Region { columns: (0, width), rows: (0, height) });
        self.out()
    }

    /// The picture with its noise.
    fn out(&mut self) -> &[u8] {
        if self.noise.is_empty() {
            return &self.clean;
        }
        self.noisy.clone_from(&self.clean);
        for row in self.noisy.chunks_mut(3 * self.camera.size_px().0) {
            let start = self.random.random_range(0..NOISE_TABLE - row.len());
            for (value, noise) in row.iter_mut().zip(&self.noise[start..]) {
                #[expect(clippy::cast_sign_loss, reason = "clamped to a byte")]
                let noisy = (i16::from(*value) + noise).clamp(0, 255) as u8;
                *value = noisy;
            }
        }
        &self.noisy
    }

    /// Takes the ball away.
    fn restore(&mut self) {
        let Some(Region { columns, rows }) = self.drawn.take() else { return };
        let width = self.camera.size_px().0;
        for row in rows.0..rows.1 {
            let range = 3 * (row * width + columns.0)..3 * (row * width + columns.1);
            self.clean[range.clone()].copy_from_slice(&self.background[range]);
        }
    }

    fn draw(&mut self, centre_m: [f64; 3]) {
        let Some(disc) = self.camera.disc(centre_m, self.radius_m) else { return };
        let (width, height) = self.camera.size_px();
        // The ellipse is hardly longer than the circle; two pixels hold the rest and the soft edge.
        let reach = 1.1 * disc.radius_px + 2.0;
        let (columns, rows) = (within(disc.centre_px[0], reach, width), within(disc.centre_px[1], reach, height));
        self.drawn = Some(Region { columns, rows });
        let eye = self.camera.eye_m();
        let way = [0, 1, 2].map(|i| centre_m[i] - eye[i]);
        // How wide a pixel is at the ball, m.
        let pixel_m = self.radius_m / disc.radius_px;
        for row in rows.0..rows.1 {
            for column in columns.0..columns.1 {
                let ray = unit(self.camera.ray(column as f64, row as f64));
                let along = dot(way, ray);
                let nearest = [0, 1, 2].map(|i| ray[i] * along - way[i]);
                let off = dot(nearest, nearest).sqrt();
                let cover = ((self.radius_m - off) / pixel_m + 0.5).clamp(0.0, 1.0);
                if cover <= 0.0 {
                    continue;
                }
                let depth = (self.radius_m * self.radius_m - off * off).max(0.0).sqrt();
                let normal = [0, 1, 2].map(|i| (nearest[i] - ray[i] * depth) / self.radius_m);
                let shade = AMBIENT + (1.0 - AMBIENT) * dot(normal, self.light).max(0.0);
                let place = 3 * (row * width + column);
                for (value, ball) in self.clean[place..place + 3].iter_mut().zip(self.look.ball_bgr) {
                    let lit = ball * shade * self.look.brightness;
                    *value = byte(f64::from(*value) * (1.0 - cover) + lit * cover);
                }
            }
        }
    }
}

/// Sky and ground.
fn background(camera: &Pinhole, brightness: f64) -> Vec<u8> {
    let (width, height) = camera.size_px();
    let mut all = Vec::with_capacity(3 * width * height);
    for row in 0..height {
        for column in 0..width {
            let ray = camera.ray(column as f64, row as f64);
            let colour = if ray[2] < 0.0 {
                let away = (-camera.eye_m()[2] / ray[2]) * ray[0].hypot(ray[1]);
                let share = (away / FAR_M).clamp(0.0, 1.0);
                [0, 1, 2].map(|i| NEAR[i] + share * (FAR[i] - NEAR[i]))
            } else {
                SKY
            };
            all.extend(colour.map(|v| byte(v * brightness)));
        }
    }
    all
}

/// The pixels from `centre - reach` to `centre + reach` that a picture of this size has.
fn within(centre: f64, reach: f64, size: usize) -> (usize, usize) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the picture")]
    let pixel = |at: f64| at.clamp(0.0, size as f64) as usize;
    (pixel((centre - reach).floor()), pixel((centre + reach).ceil() + 1.0))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a byte")]
fn byte(value: f64) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt().max(f64::MIN_POSITIVE);
    v.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Pinhole {
        Pinhole::aimed([6.0, 3.0, 6.0], [0.0, 0.0, 2.0], std::f64::consts::FRAC_PI_3, (160, 120)).unwrap()
    }

    /// Red above the ground's grey, summed over the picture: how far a pixel belongs to the ball, were it lit evenly.
    #[test]
    fn the_ball_lies_where_it_is_projected() {
        let even = Look { light: [0.0; 3], ball_bgr: [0.0, 0.0, 600.0], ..Look::default() };
        let mut renderer = Renderer::new(camera(), 0.5, even, 1);
        for z in [0.5, 1.3, 2.0, 3.7, 4.4] {
            let disc = camera().disc([0.0, 0.0, z], 0.5).unwrap();
            let ground = renderer.background.clone();
            let frame = renderer.frame([0.0, 0.0, z]);
            let (mut weight, mut sum) = (0.0, [0.0; 2]);
            for (i, (pixel, ground)) in frame.chunks_exact(3).zip(ground.chunks_exact(3)).enumerate() {
                let cover = (f64::from(ground[0]) - f64::from(pixel[0])) / f64::from(ground[0]);
                weight += cover;
                sum = [sum[0] + cover * (i % 160) as f64, sum[1] + cover * (i / 160) as f64];
            }
            for (sum, centre) in sum.into_iter().zip(disc.centre_px) {
                assert!((sum / weight - centre).abs() < 0.03, "{} {disc:?}", sum / weight);
            }
            let radius = (weight / std::f64::consts::PI).sqrt();
            assert!((radius - disc.radius_px).abs() < 0.05, "{radius} {disc:?}");
        }
    }

    #[test]
    fn nothing_stays_of_the_frame_before() {
        let mut renderer = Renderer::new(camera(), 0.5, Look::default(), 1);
        let first = renderer.frame([0.0, 0.0, 1.0]).to_vec();
        renderer.frame([0.0, 0.0, 4.0]);
        renderer.blurred([0.0, 0.0, 4.0], [0.0, 0.0, 3.0]);
        assert!(renderer.frame([0.0, 0.0, 1.0]) == first);
    }

    #[test]
    fn noise_is_as_large_as_asked_and_follows_the_seed() {
        let look = Look { noise: 8.0, ..Look::default() };
        let picture = |seed| Renderer::new(camera(), 0.5, look.clone(), seed).frame([0.0, 0.0, 2.0]).to_vec();
        let clean = Renderer::new(camera(), 0.5, Look::default(), 1).frame([0.0, 0.0, 2.0]).to_vec();
        let noisy = picture(7);
        let squares: f64 = noisy.iter().zip(&clean).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
        let sd = (squares / clean.len() as f64).sqrt();
        assert!((sd - 8.0).abs() < 0.3, "{sd}");
        assert!(noisy == picture(7) && noisy != picture(8));
    }
}
