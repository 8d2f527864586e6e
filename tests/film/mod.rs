//! Films made in code: a disc that falls and bounces by formulas alone, in an AVI file without compression, so that nothing
//! stands between the truth and the pixels.
#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "sizes of small pictures, and bytes")]

/// A drop before a grey wall.
pub struct Film {
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Metres for each pixel.
    pub m_per_px: f64,
    /// Radius of the ball, m.
    pub radius_m: f64,
    /// Height of fall, m.
    pub height_m: f64,
    /// Sideways speed, m/s.
    pub speed_m_s: f64,
    /// How long a hand holds the ball, s.
    pub held_s: f64,
    /// Colours of the balls (blue, green, red), 70 px apart.
    pub balls: Vec<[u8; 3]>,
    /// Frames per second, of the camera and of the file.
    pub rates_hz: (f64, u32),
    /// How many frames.
    pub frames: usize,
    /// Frames in whose place the one before stands again.
    pub repeat: Vec<usize>,
    /// How far a camera in a hand shakes, px.
    pub shake_px: f64,
    /// Standard deviation of the sensor's noise, grey levels.
    pub noise: f64,
}

impl Default for Film {
    fn default() -> Self {
        Self {
            restitution: 0.75,
            m_per_px: 0.005,
            radius_m: 0.04,
            height_m: 0.8,
            speed_m_s: 0.25,
            held_s: 0.1,
            balls: vec![[30, 40, 220]],
            rates_hz: (60.0, 60),
            frames: 120,
            repeat: Vec::new(),
            shake_px: 0.0,
            noise: 3.0,
        }
    }
}

use crate::common::Noise;

const WIDTH: usize = 240;
const HEIGHT: usize = 200;
/// Where the ball lies on its surface, px from the top.
const FLOOR_PX: f64 = 185.0;
const GRAVITY_M_S2: f64 = 9.81;

impl Film {
    /// Where the centre is (m to the right of the first place, m above the surface) at `time_s` after the first frame.
    pub fn place_m(&self, time_s: f64) -> (f64, f64) {
        let since = (time_s - self.held_s).max(0.0);
        let x = self.speed_m_s * since;
        let mut fall_s = (2.0 * self.height_m / GRAVITY_M_S2).sqrt();
        if since < fall_s {
            return (x, self.radius_m + self.height_m - GRAVITY_M_S2 / 2.0 * since * since);
        }
        let mut left = since - fall_s;
        for _ in 0..40 {
            fall_s *= self.restitution;
            if left < 2.0 * fall_s {
                return (x, self.radius_m + GRAVITY_M_S2 * left * (fall_s - left / 2.0));
            }
            left -= 2.0 * fall_s;
        }
        (x, self.radius_m)
    }

    /// The same in px of the picture, from the centre of its first pixel.
    pub fn place_px(&self, time_s: f64) -> (f64, f64) {
        let (x, z) = self.place_m(time_s);
        (40.0 + x / self.m_per_px, FLOOR_PX - z / self.m_per_px)
    }

    fn picture(&self, frame: usize) -> Vec<[u8; 3]> {
        let shake = self.shake_px * (2.3 * frame as f64).sin();
        let mut picture: Vec<[u8; 3]> = (0..WIDTH * HEIGHT)
            .map(|i| {
                // A camera that shakes needs a wall to be seen before.
                let stripe = ((i % WIDTH) as f64 + 200.0 - shake).rem_euclid(20.0) < 10.0;
                if self.shake_px > 0.0 && stripe { [60; 3] } else { [118, 122, 120] }
            })
            .collect();
        let (u, v) = self.place_px(frame as f64 / self.rates_hz.0);
        for (k, colour) in self.balls.iter().enumerate() {
            disc(&mut picture, (u + 70.0 * k as f64 + shake, v), self.radius_m / self.m_per_px, *colour);
        }
        let mut random = Noise(1 + frame as u64);
        for value in picture.iter_mut().flatten() {
            *value = (f64::from(*value) + self.noise * random.normal()).round().clamp(0.0, 255.0) as u8;
        }
        picture
    }

    /// The film as an AVI file.
    pub fn avi(&self) -> Vec<u8> {
        let mut pictures = Vec::new();
        for frame in 0..self.frames {
            pictures.push(self.picture(if self.repeat.contains(&frame) { frame - 1 } else { frame }));
        }
        avi(&pictures, self.rates_hz.1)
    }
}

/// A disc that covers each pixel by its area in it (8 × 8 points).
fn disc(picture: &mut [[u8; 3]], (u, v): (f64, f64), radius: f64, colour: [u8; 3]) {
    for (i, pixel) in picture.iter_mut().enumerate() {
        let (column, row) = ((i % WIDTH) as f64, (i / WIDTH) as f64);
        if (column - u).hypot(row - v) > radius + 1.0 {
            continue;
        }
        let inside = (0..64).filter(|k| {
            let (x, y) = (f64::from(k % 8), f64::from(k / 8));
            (column - 0.5 + (x + 0.5) / 8.0 - u).hypot(row - 0.5 + (y + 0.5) / 8.0 - v) < radius
        });
        let share = inside.count() as f64 / 64.0;
        for (value, ball) in pixel.iter_mut().zip(colour) {
            let mixed = f64::from(*value) + share * (f64::from(ball) - f64::from(*value));
            *value = mixed.round() as u8;
        }
    }
}

fn chunk(name: [u8; 4], body: &[u8]) -> Vec<u8> {
    let mut bytes = name.to_vec();
    bytes.extend((body.len() as u32).to_le_bytes());
    bytes.extend(body);
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    bytes
}

fn list(name: [u8; 4], parts: &[Vec<u8>]) -> Vec<u8> {
    chunk(*b"LIST", &[name.as_slice(), &parts.concat()].concat())
}

fn numbers(all: &[u32]) -> Vec<u8> {
    all.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// Pictures without compression in Microsoft's AVI container.
fn avi(pictures: &[Vec<[u8; 3]>], rate_hz: u32) -> Vec<u8> {
    let size = (3 * WIDTH * HEIGHT) as u32;
    let (width, height, count) = (WIDTH as u32, HEIGHT as u32, pictures.len() as u32);
    // Microseconds a frame, bytes a second, padding, flags (has an index), frames, …, streams, buffer, size, reserved.
    let main = numbers(&[1_000_000 / rate_hz, size * rate_hz, 0, 0x10, count, 0, 1, size, width, height, 0, 0, 0, 0]);
    let mut stream = b"vidsDIB ".to_vec();
    stream.extend(numbers(&[0, 0, 0, 1, rate_hz, 0, count, size, u32::MAX, 0]));
    stream.extend([0u16, 0, WIDTH as u16, HEIGHT as u16].iter().flat_map(|n| n.to_le_bytes()));
    let mut form = numbers(&[40, width, height]);
    form.extend([1u16, 24].iter().flat_map(|n| n.to_le_bytes()));
    form.extend(numbers(&[0, size, 0, 0, 0, 0]));
    let head =
        list(*b"hdrl", &[chunk(*b"avih", &main), list(*b"strl", &[chunk(*b"strh", &stream), chunk(*b"strf", &form)])]);
    let frames: Vec<Vec<u8>> = pictures
        .iter()
        // Rows from the bottom upwards; WIDTH is a multiple of four, so they need no padding.
        .map(|p| chunk(*b"00db", &p.chunks(WIDTH).rev().flatten().flatten().copied().collect::<Vec<u8>>()))
        .collect();
    let index: Vec<u8> =
        (0..count).flat_map(|i| [b"00db".to_vec(), numbers(&[0x10, 4 + i * (size + 8), size])].concat()).collect();
    chunk(*b"RIFF", &[b"AVI ".to_vec(), head, list(*b"movi", &frames), chunk(*b"idx1", &index)].concat())
}
