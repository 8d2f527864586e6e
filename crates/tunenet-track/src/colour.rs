//! A window of hue, saturation and value: the colour by which a ball is known.

use tunenet_core::{Error, Origin, Result};

/// Degrees of hue on OpenCV's 8-bit circle.
pub const HUES: i32 = 180;

/// A window in OpenCV's 8-bit HSV space: hue 0–179 (two degrees each), saturation and value 0–255.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Middle hue.
    pub hue: i32,
    /// Half the width in hue; 90 takes every hue.
    pub half_width: i32,
    /// Least and greatest saturation.
    pub saturation: (i32, i32),
    /// Least and greatest value.
    pub value: (i32, i32),
}

/// The colours that have a name.
pub const NAMES: [(&str, Window); 9] = [
    ("red", Window::saturated(0, 12)),
    ("orange", Window::saturated(12, 8)),
    ("yellow", Window::saturated(28, 10)),
    ("green", Window::saturated(60, 22)),
    ("cyan", Window::saturated(92, 12)),
    ("blue", Window::saturated(112, 14)),
    ("purple", Window::saturated(140, 15)),
    ("white", WHITE),
    ("black", BLACK),
];

/// Bright without a hue.
pub(crate) const WHITE: Window = Window { hue: 90, half_width: 90, saturation: (0, 60), value: (170, 255) };
/// Dark, of any hue.
pub(crate) const BLACK: Window = Window { hue: 90, half_width: 90, saturation: (0, 255), value: (0, 70) };

impl Window {
    const fn saturated(hue: i32, half_width: i32) -> Self {
        Self { hue, half_width, saturation: (80, 255), value: (40, 255) }
    }

    /// Reads a colour's name, or a window `hue-,saturation-,value-:hue+,saturation+,value+` on OpenCV's scales; a hue that
    /// begins above its end goes round through 0, so that `170,90,60:8,255,255` is red.
    ///
    /// # Errors
    /// [`Error::Setting`] for anything else.
    pub fn parse(text: &str) -> Result<Self> {
        if let Some((_, window)) = NAMES.iter().find(|(name, _)| name.eq_ignore_ascii_case(text.trim())) {
            return Ok(*window);
        }
        let names: Vec<&str> = NAMES.iter().map(|(name, _)| *name).collect();
        let refused = || Error::Setting {
            origin: Origin::Caller,
            name: "--color",
            expected: format!("{} or an HSV window such as 170,90,60:8,255,255", names.join(", ")),
            found: format!("`{text}`"),
        };
        let corner = |part: &str| -> Option<[i32; 3]> {
            let numbers: Vec<i32> = part.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
            let [h, s, v] = <[i32; 3]>::try_from(numbers).ok()?;
            ((0..HUES).contains(&h) && (0..=255).contains(&s) && (0..=255).contains(&v)).then_some([h, s, v])
        };
        let (low, high) = text.split_once(':').ok_or_else(refused)?;
        let (low, high) = (corner(low).ok_or_else(refused)?, corner(high).ok_or_else(refused)?);
        if low[1] > high[1] || low[2] > high[2] {
            return Err(refused());
        }
        let width = (high[0] - low[0]).rem_euclid(HUES);
        Ok(Self {
            hue: (low[0] + width / 2).rem_euclid(HUES),
            half_width: (width + 1) / 2,
            saturation: (low[1], high[1]),
            value: (low[2], high[2]),
        })
    }

    /// Whether a colour lies within.
    #[must_use]
    pub fn holds(&self, [hue, saturation, value]: [u8; 3]) -> bool {
        let away = (i32::from(hue) - self.hue + HUES / 2).rem_euclid(HUES) - HUES / 2;
        away.abs() <= self.half_width
            && (self.saturation.0..=self.saturation.1).contains(&i32::from(saturation))
            && (self.value.0..=self.value.1).contains(&i32::from(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_windows_are_read() {
        assert_eq!(Window::parse("Red").unwrap().hue, 0);
        let red = Window::parse("170,90,60:8,255,255").unwrap();
        assert!(red.holds([175, 100, 100]) && red.holds([3, 100, 100]) && red.holds([170, 90, 60]));
        assert!(!red.holds([20, 100, 100]) && !red.holds([0, 80, 100]) && !red.holds([165, 100, 100]));
        for wrong in ["", "pink-ish", "1,2,3", "1,2,3:4,5", "200,0,0:10,255,255", "0,90,0:9,10,255"] {
            assert!(Window::parse(wrong).is_err(), "{wrong}");
        }
    }
}
