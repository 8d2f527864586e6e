//! Which colours are the ball's: a window in hue, saturation and value, looked up in one step for each pixel.

use std::sync::LazyLock;

use crate::colour::Window;

/// Bits of each channel that are distinguished; the finest steps of a compressed video are noise.
const BITS: u32 = 6;
const DROPPED: u32 = 8 - BITS;

/// Hue, saturation and value of every step of a table. A video is searched with many windows.
static STEPS: LazyLock<Vec<[u8; 3]>> = LazyLock::new(|| {
    // The middle of each step of the table; its last step holds full white, its first full black.
    let level = |step: usize| u8::try_from((step << DROPPED) + (1 << DROPPED) / 2).unwrap_or(u8::MAX);
    let steps = 1usize << BITS;
    (0..steps.pow(3)).map(|i| hsv([level(i % steps), level(i / steps % steps), level(i / steps / steps)])).collect()
});

/// A [`Window`] as a table over blue, green and red.
#[derive(Debug, Clone)]
pub struct Lookup {
    table: Vec<bool>,
}

impl Lookup {
    /// The table of `window`.
    #[must_use]
    pub fn new(window: &Window) -> Self {
        Self { table: STEPS.iter().map(|hsv| window.holds(*hsv)).collect() }
    }

    /// Whether a pixel (blue, green, red) has the ball's colour.
    #[inline]
    #[must_use]
    pub fn holds(&self, [blue, green, red]: [u8; 3]) -> bool {
        let step = |value: u8| usize::from(value >> DROPPED);
        self.table[step(blue) | step(green) << BITS | step(red) << (2 * BITS)]
    }
}

/// Hue (0 to 179, two degrees each), saturation and value of a pixel (blue, green, red), as OpenCV defines them.
#[must_use]
pub fn hsv([blue, green, red]: [u8; 3]) -> [u8; 3] {
    let [b, g, r] = [blue, green, red].map(i32::from);
    let (high, low) = (b.max(g).max(r), b.min(g).min(r));
    let range = high - low;
    if range == 0 {
        return [0, 0, u8::try_from(high).unwrap_or(u8::MAX)];
    }
    // Sixths of the circle, by the channel that is the strongest.
    let (start, offset) = if high == r {
        (0, g - b)
    } else if high == g {
        (60, b - r)
    } else {
        (120, r - g)
    };
    let hue = (f64::from(start) + 30.0 * f64::from(offset) / f64::from(range)).round().rem_euclid(180.0);
    let saturation = (255.0 * f64::from(range) / f64::from(high)).round();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 0 to 255")]
    [hue as u8, saturation as u8, u8::try_from(high).unwrap_or(u8::MAX)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use opencv::core::{CV_8UC3, Mat, MatTraitConst, Scalar, Vec3b};
    use opencv::imgproc::{COLOR_BGR2HSV, cvt_color_def};

    #[test]
    fn validate_hue_saturation_and_value_are_those_of_opencv() {
        for [b, g, r] in
            [[0, 0, 0], [255, 255, 255], [40, 40, 220], [10, 200, 30], [250, 9, 120], [77, 76, 75], [1, 0, 2]]
        {
            let shade = Scalar::new(f64::from(b), f64::from(g), f64::from(r), 0.0);
            let pixel = Mat::new_rows_cols_with_default(1, 1, CV_8UC3, shade).unwrap();
            let mut out = Mat::default();
            cvt_color_def(&pixel, &mut out, COLOR_BGR2HSV).unwrap();
            assert_eq!(hsv([b, g, r]), out.at_2d::<Vec3b>(0, 0).unwrap().0, "{b} {g} {r}");
        }
    }

    #[test]
    fn the_table_holds_what_the_window_holds_up_to_its_steps() {
        let red = Window::parse("red").unwrap();
        let table = Lookup::new(&red);
        assert!(table.holds([40, 40, 220]) && table.holds([20, 30, 90]));
        assert!(!table.holds([40, 220, 40]) && !table.holds([120, 122, 125]) && !table.holds([255, 255, 255]));
    }
}
