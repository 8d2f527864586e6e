//! A frame with two scales, to draw in.

use super::axis::Axis;
use super::svg::{Anchor, Spot, Svg, text_width};

/// Room for what stands below a frame: tick texts and the axis' name.
pub const BELOW: f64 = 42.0;
/// Room for the name of the vertical axis, which stands above the frame.
pub const ABOVE: f64 = 26.0;

/// A frame with two scales.
pub struct Panel {
    pub x: Axis,
    pub y: Axis,
}

impl Panel {
    /// Draws the frame, ticks and names; without a name for `x`, its ticks have no text, as above another panel with the same
    /// scale.
    pub fn frame(&self, svg: &mut Svg, x_name: Option<&str>, y_name: &str) {
        let ((left, right), (bottom, top)) = (self.x.places(), self.y.places());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few ticks")]
        let rows = ((bottom - top) / 24.0).clamp(2.0, 6.0) as u32;
        for (place, text) in self.y.ticks(rows) {
            svg.line("grid", (left, place), (right, place));
            svg.text("tick", (left - 7.0, place + 4.5), Anchor::End, &text);
        }
        for (place, text) in self.columns() {
            svg.line("grid", (place, bottom), (place, top));
            if x_name.is_some() {
                svg.line("axis", (place, bottom), (place, bottom + 5.0));
                svg.text("tick", (place, bottom + 19.0), Anchor::Middle, &text);
            }
        }
        svg.line("axis", (left, bottom), (right, bottom));
        svg.line("axis", (left, bottom), (left, top));
        if let Some(name) = x_name {
            svg.text("name", (right, bottom + 37.0), Anchor::End, name);
        }
        svg.text("name", (2.0, top - 12.0), Anchor::Start, y_name);
    }

    /// As many ticks along x as their texts leave room for.
    fn columns(&self) -> Vec<(f64, String)> {
        let (left, right) = self.x.places();
        for most in (2..=8).rev() {
            let ticks = self.x.ticks(most);
            let widest = ticks.iter().map(|t| text_width(&t.1)).fold(0.0, f64::max);
            // The outermost texts reach half their width beyond their ticks.
            if ticks.len() as f64 * (widest + 16.0) <= right - left {
                return ticks;
            }
        }
        self.x.ticks(1)
    }

    pub fn spot(&self, (x, y): (f64, f64)) -> Spot {
        (self.x.at(x), self.y.at(y))
    }

    pub fn spots(&self, points: &[(f64, f64)]) -> Vec<Spot> {
        points.iter().map(|p| self.spot(*p)).collect()
    }

    /// A horizontal line across the frame.
    pub fn level(&self, svg: &mut Svg, class: &str, value: f64) {
        let (left, right) = self.x.places();
        svg.line(class, (left, self.y.at(value)), (right, self.y.at(value)));
    }
}

/// The left edge of a frame whose vertical axis goes over `range`: as far in as its tick texts need.
pub fn left_edge(ranges: &[(f64, f64)]) -> f64 {
    let width = |range: &(f64, f64)| {
        let ticks = Axis::new(*range, (0.0, 1.0)).ticks(6);
        ticks.iter().map(|t| text_width(&t.1)).fold(0.0, f64::max)
    };
    ranges.iter().map(width).fold(20.0, f64::max) + 10.0
}
