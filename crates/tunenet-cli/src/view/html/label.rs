//! Labels on lines: where there is room.

use super::panel::Panel;
use super::svg::{Anchor, Spot, Svg, bold_width};

/// Height of a label with its surroundings.
const HEIGHT: f64 = 17.0;
/// Places along a line that are tried.
const TRIES: usize = 48;
/// What another label in the way costs, in points of a line in the way ...
const OVERLAP: usize = 1000;
/// ... and what it costs to stand where another line runs within this distance, so that it is unclear which is meant.
const AMBIGUOUS: (usize, f64) = (400, 24.0);
/// Lines are felt at places this far apart.
const FEEL: f64 = 4.0;

/// Left, top, right, bottom.
type Area = (f64, f64, f64, f64);

/// Labels that keep clear of lines, dots and one another.
pub struct Labels {
    obstacles: Vec<Spot>,
    taken: Vec<Area>,
    frame: Area,
}

impl Labels {
    /// In a panel with these dots and lines drawn in it.
    pub fn new(panel: &Panel, dots: &[Spot], lines: &[&[Spot]]) -> Self {
        let obstacles = dots.iter().copied().chain(lines.iter().flat_map(|line| felt(line))).collect();
        let ((left, right), (bottom, top)) = (panel.x.places(), panel.y.places());
        Self { obstacles, taken: Vec::new(), frame: (left, top, right, bottom) }
    }

    /// Writes `text` next to `line`, at the place with the least in its way and far from `other`.
    pub fn on(&mut self, svg: &mut Svg, class: &str, text: &str, line: &[Spot], other: &[Spot]) {
        let (line, other) = (felt(line), felt(other));
        let (width, every) = (bold_width(text) + 6.0, line.len().div_ceil(TRIES).max(1));
        let mut best: Option<(usize, Area)> = None;
        for &(x, y) in line.iter().step_by(every) {
            let near = other.iter().any(|o| (o.0 - x).hypot(o.1 - y) < AMBIGUOUS.1);
            for (dx, dy) in [(8.0, 0.0), (-8.0 - width, 0.0), (-width / 2.0, -15.0), (-width / 2.0, 15.0)] {
                let area = (x + dx, y + dy - HEIGHT / 2.0, x + dx + width, y + dy + HEIGHT / 2.0);
                let outside = area.0 < self.frame.0 + 2.0
                    || area.1 < self.frame.1
                    || area.2 > self.frame.2
                    || area.3 > self.frame.3 - 10.0;
                if outside {
                    continue;
                }
                let cost = self.cost(area) + if near { AMBIGUOUS.0 } else { 0 };
                if best.is_none_or(|b| cost < b.0) {
                    best = Some((cost, area));
                }
            }
        }
        let Some((_, area)) = best else { return };
        self.taken.push(area);
        svg.text(&format!("label {class}"), (area.0 + 3.0, area.3 - 4.0), Anchor::Start, text);
    }

    fn cost(&self, area: Area) -> usize {
        let hit = |spot: &&Spot| (area.0..area.2).contains(&spot.0) && (area.1..area.3).contains(&spot.1);
        let crossed = |other: &&Area| area.0 < other.2 && other.0 < area.2 && area.1 < other.3 && other.1 < area.3;
        self.obstacles.iter().filter(hit).count() + OVERLAP * self.taken.iter().filter(crossed).count()
    }
}

/// The points of a line with as many between them as it takes to notice that it passes.
fn felt(line: &[Spot]) -> Vec<Spot> {
    let mut found: Vec<Spot> = line.first().copied().into_iter().collect();
    for pair in line.windows(2) {
        let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a length within a drawing")]
        let pieces = (dx.hypot(dy) / FEEL).ceil().clamp(1.0, 1000.0) as u32;
        found.extend((1..=pieces).map(|i| {
            let share = f64::from(i) / f64::from(pieces);
            (pair[0].0 + share * dx, pair[0].1 + share * dy)
        }));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::html::axis::Axis;

    #[test]
    fn a_label_keeps_clear_of_the_other_line() {
        let panel = Panel { x: Axis::new((0.0, 1.0), (0.0, 300.0)), y: Axis::new((0.0, 1.0), (200.0, 0.0)) };
        // Both lines run together on the left half and part on the right.
        let (low, high) = ([(0.0, 150.0), (300.0, 150.0)], [(0.0, 150.0), (150.0, 150.0), (300.0, 20.0)]);
        let (mut svg, mut labels) = (Svg::new(300.0, 200.0), Labels::new(&panel, &[], &[&low, &high]));
        labels.on(&mut svg, "", "tuned", &high, &low);
        let left = labels.taken[0].0;
        assert!(left > 100.0, "{left}");
        let other = Labels::new(&panel, &[], &[&low]);
        assert_eq!(other.cost(labels.taken[0]), 0, "the other line runs through it");
        assert_eq!(felt(&[(0.0, 0.0), (0.0, 8.0)]), [(0.0, 0.0), (0.0, 4.0), (0.0, 8.0)]);
    }
}
