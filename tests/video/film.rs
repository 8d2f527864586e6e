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
    /// Squares in place of discs.
    pub square: bool,
    /// How far the camera turns from frame to frame, px.
    pub pan_px: f64,
    /// Frames in which the camera is bumped, and how far, px.
    pub bump: Option<(std::ops::Range<usize>, f64)>,
    /// Where a pinhole stands, m from the foot of the fall, that looks at the middle of it; far away at the side where none.
    pub eye_m: Option<[f64; 3]>,
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
            square: false,
            pan_px: 0.0,
            bump: None,
            eye_m: None,
        }
    }
}

use crate::common::{Folder, Noise};

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
        let bumped = self.bump.as_ref().filter(|(frames, _)| frames.contains(&frame)).map_or(0.0, |(_, px)| *px);
        let shake = self.shake_px * (2.3 * frame as f64).sin() - self.pan_px * frame as f64 + bumped;
        let mut picture: Vec<[u8; 3]> = (0..WIDTH * HEIGHT)
            .map(|i| {
                // A camera that shakes needs a wall to be seen before.
                let stripe = ((i % WIDTH) as f64 - shake).rem_euclid(20.0) < 10.0;
                if (self.shake_px + self.pan_px > 0.0 || self.bump.is_some()) && stripe {
                    [60; 3]
                } else {
                    [118, 122, 120]
                }
            })
            .collect();
        let (u, v) = self.place_px(frame as f64 / self.rates_hz.0);
        for (k, colour) in self.balls.iter().enumerate() {
            let (place, radius) = ((u + 70.0 * k as f64 + shake, v), self.radius_m / self.m_per_px);
            if let Some(eye) = self.eye_m {
                let (x, z) = self.place_m(frame as f64 / self.rates_hz.0);
                self.sphere(&mut picture, eye, [x, 0.0, z], *colour);
            } else if self.square {
                patch(&mut picture, place, (radius, 1.0), *colour, |x, y| x.abs().max(y.abs()));
            } else {
                patch(&mut picture, place, (radius, 1.0), *colour, f64::hypot);
            }
        }
        let mut random = Noise(1 + frame as u64);
        for value in picture.iter_mut().flatten() {
            *value = (f64::from(*value) + self.noise * random.normal()).round().clamp(0.0, 255.0) as u8;
        }
        picture
    }

    /// A ball whose every point is seen along a ray from `eye`: what a ray meets is the ball's.
    fn sphere(&self, picture: &mut [[u8; 3]], eye: [f64; 3], centre: [f64; 3], colour: [u8; 3]) {
        let unit = |v: [f64; 3]| {
            let length = dot(v, v).sqrt();
            v.map(|c| c / length)
        };
        let ahead = unit([-eye[0], -eye[1], 0.5 * self.height_m - eye[2]]);
        let right = unit(cross(ahead, [0.0, 0.0, 1.0]));
        let down = cross(ahead, right);
        let way = [0, 1, 2].map(|i| centre[i] - eye[i]);
        // So far away that the whole fall fills two thirds of the picture.
        let focal = 0.67 * HEIGHT as f64 / self.height_m * dot(eye, eye).sqrt();
        let off = |x: f64, y: f64| {
            let ray = unit([0, 1, 2].map(|i| ahead[i] + (x * right[i] + y * down[i]) / focal));
            let side = cross(way, ray);
            dot(side, side).sqrt() / self.radius_m
        };
        // A pixel is so large at the ball, in radii.
        let pixel = dot(way, way).sqrt() / focal / self.radius_m;
        patch(picture, (0.5 * WIDTH as f64 - 0.5, 0.5 * HEIGHT as f64 - 0.5), (1.0, pixel), colour, off);
    }

    fn pictures(&self) -> Vec<Vec<[u8; 3]>> {
        let shown = |frame| if self.repeat.contains(&frame) { frame - 1 } else { frame };
        (0..self.frames).map(|frame| self.picture(shown(frame))).collect()
    }

    /// The film as an AVI file.
    pub fn avi(&self) -> Vec<u8> {
        avi(&self.pictures(), self.rates_hz.1)
    }

    /// A folder with it as `drop.avi`, beside a scene.
    pub fn folder(&self) -> Folder {
        let folder = Folder::with_scene();
        folder.write("drop.avi", self.avi());
        folder
    }

    /// Every frame as a PNG file.
    pub fn pngs(&self) -> Vec<Vec<u8>> {
        self.pictures().iter().map(|p| png(p)).collect()
    }

    /// The film as messages of one topic of an MCAP log: `sensor_msgs/Image` in `rgb8`, or `CompressedImage` in PNG.
    pub fn mcap(&self, compressed: bool) -> Vec<u8> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let mut writer = mcap::Writer::new(&mut bytes).unwrap();
        let name = if compressed { "sensor_msgs/msg/CompressedImage" } else { "sensor_msgs/msg/Image" };
        let schema = writer.add_schema(name, "ros2msg", b"").unwrap();
        let channel = writer.add_channel(schema, "/camera/image", "cdr", &std::collections::BTreeMap::new()).unwrap();
        for (i, picture) in self.pictures().iter().enumerate() {
            let nanoseconds = (i as f64 / f64::from(self.rates_hz.1) * 1e9).round() as u64;
            let data = message(picture, 1_000_000_000 + nanoseconds, compressed);
            let header = mcap::records::MessageHeader {
                channel_id: channel,
                sequence: i as u32,
                log_time: nanoseconds,
                publish_time: nanoseconds,
            };
            writer.write_to_known_channel(&header, &data).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        bytes.into_inner()
    }
}

/// What lies within `radius` by its own measure of length, in which a pixel is so large; it covers each pixel by its area in
/// it (8 × 8 points).
fn patch(
    picture: &mut [[u8; 3]],
    (u, v): (f64, f64),
    (radius, pixel_size): (f64, f64),
    colour: [u8; 3],
    length: impl Fn(f64, f64) -> f64,
) {
    for (i, pixel) in picture.iter_mut().enumerate() {
        let (column, row) = ((i % WIDTH) as f64, (i / WIDTH) as f64);
        if length(column - u, row - v) > radius + pixel_size {
            continue;
        }
        let inside = (0..64).filter(|k| {
            let (x, y) = (f64::from(k % 8), f64::from(k / 8));
            length(column - 0.5 + (x + 0.5) / 8.0 - u, row - 0.5 + (y + 0.5) / 8.0 - v) < radius
        });
        let share = inside.count() as f64 / 64.0;
        for (value, ball) in pixel.iter_mut().zip(colour) {
            let mixed = f64::from(*value) + share * (f64::from(ball) - f64::from(*value));
            *value = mixed.round() as u8;
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
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

/// A PNG file (ISO/IEC 15948) without compression.
fn png(picture: &[[u8; 3]]) -> Vec<u8> {
    // Rows from the top, each after the number of its filter, red first.
    let rows = picture
        .chunks(WIDTH)
        .flat_map(|row| std::iter::once(0).chain(row.iter().flat_map(|[blue, green, red]| [*red, *green, *blue])));
    let rows: Vec<u8> = rows.collect();
    let mut zlib = vec![0x78, 0x01];
    let blocks: Vec<&[u8]> = rows.chunks(0xFFFF).collect();
    for (i, block) in blocks.iter().enumerate() {
        let length = block.len() as u16;
        zlib.push(u8::from(i + 1 == blocks.len()));
        zlib.extend([length.to_le_bytes(), (!length).to_le_bytes()].concat());
        zlib.extend(*block);
    }
    let (a, b) = rows.iter().fold((1u32, 0u32), |(a, b), byte| {
        let a = (a + u32::from(*byte)) % 65_521;
        (a, (b + a) % 65_521)
    });
    zlib.extend((b << 16 | a).to_be_bytes());
    let size = [WIDTH as u32, HEIGHT as u32].map(u32::to_be_bytes).concat();
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    for (name, body) in [(b"IHDR", [size, vec![8, 2, 0, 0, 0]].concat()), (b"IDAT", zlib), (b"IEND", Vec::new())] {
        let named = [name.as_slice(), &body].concat();
        file.extend((body.len() as u32).to_be_bytes());
        file.extend(&named);
        file.extend(crc32(&named).to_be_bytes());
    }
    file
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xEDB8_8320 } else { c >> 1 })
    })
}

/// A picture as a ROS 2 message in CDR, little-endian; every number stands at a multiple of its size after the mark.
fn message(picture: &[[u8; 3]], nanoseconds: u64, compressed: bool) -> Vec<u8> {
    let mut body = Vec::new();
    let number = |body: &mut Vec<u8>, value: u32| {
        body.resize(body.len().next_multiple_of(4), 0);
        body.extend(value.to_le_bytes());
    };
    let text = |body: &mut Vec<u8>, text: &str| {
        number(body, text.len() as u32 + 1);
        body.extend(text.bytes().chain([0]));
    };
    number(&mut body, (nanoseconds / 1_000_000_000) as u32);
    number(&mut body, (nanoseconds % 1_000_000_000) as u32);
    text(&mut body, "camera");
    let bytes = if compressed {
        text(&mut body, "png");
        png(picture)
    } else {
        number(&mut body, HEIGHT as u32);
        number(&mut body, WIDTH as u32);
        text(&mut body, "rgb8");
        body.push(0);
        number(&mut body, 3 * WIDTH as u32);
        picture.iter().flat_map(|[blue, green, red]| [*red, *green, *blue]).collect()
    };
    number(&mut body, bytes.len() as u32);
    [vec![0, 1, 0, 0], body, bytes].concat()
}
