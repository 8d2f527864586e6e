//! How often each ball goes in, by who plans: a point with its standard error for each.

use super::share::Share;
use tunenet_cli::view::html::drawing;
use tunenet_cli::view::html::svg::{Anchor, Spot, Svg};

/// How many ways are drawn.
pub const WAYS: usize = 5;

const WIDTH: f64 = 880.0;
const HEIGHT: f64 = 420.0;
/// Left, top, width and height of the frame.
const FRAME: [f64; 4] = [60.0, 20.0, 800.0, 270.0];
const COLOURS: [&str; WAYS] = ["#2c6fbb", "#8a4fbf", "#b8860b", "#1a6e5a", "#444444"];
/// What the paper reports of a real robot (arXiv 1907.11200, experiment 3): all shots, and those after drops that stayed on
/// the table.
const PUBLISHED: [(f64, &str); 2] = [(0.62, "paper, all: 0.62"), (0.87, "paper, without drops off the table: 0.87")];

/// One ball, or all.
pub struct Group {
    pub name: &'static str,
    pub shares: [Share; WAYS],
}

/// The drawing as a file of its own.
pub fn draw(groups: &[Group], ways: &[&str; WAYS]) -> String {
    let mut svg = Svg::new(WIDTH, HEIGHT);
    let [left, top, width, height] = FRAME;
    let (right, bottom) = (left + width, top + height);
    let y = |share: f64| bottom - height * share;
    for fifth in 0..=5 {
        let share = f64::from(fifth) / 5.0;
        svg.line("g", (left, y(share)), (right, y(share)));
        svg.text("s", (left - 6.0, y(share) + 4.0), Anchor::End, &format!("{share:.1}"));
    }
    for (share, words) in PUBLISHED {
        svg.line("p", (left, y(share)), (right, y(share)));
        svg.text("s", (left + 4.0, y(share) - 4.0), Anchor::Start, words);
    }
    let room = width / groups.len().max(1) as f64;
    for (i, group) in groups.iter().enumerate() {
        let middle = left + room * (i as f64 + 0.5);
        svg.text("s", (middle, bottom + 18.0), Anchor::Middle, group.name);
        for (way, share) in group.shares.iter().enumerate().filter(|(_, share)| share.count > 0) {
            let x = middle + room * 0.15 * (way as f64 - (WAYS - 1) as f64 / 2.0);
            let ends = [-1.0, 1.0].map(|side| (x, y((share.value + side * share.error()).clamp(0.0, 1.0))));
            svg.line(&format!("w{way}"), ends[0], ends[1]);
            svg.dots(&format!("w{way} d"), &[(x, y(share.value))]);
        }
    }
    svg.path("f", &[(left, top), (right, top), (right, bottom), (left, bottom)], true);
    for (way, words) in ways.iter().enumerate() {
        let at: Spot = (left + 420.0 * (way % 2) as f64, bottom + 50.0 + 20.0 * (way / 2) as f64);
        svg.dots(&format!("w{way} d"), &[(at.0 + 6.0, at.1 - 4.0)]);
        svg.text("s", (at.0 + 18.0, at.1), Anchor::Start, words);
    }
    let colour = |(i, colour): (usize, &&str)| format!(".w{i}{{stroke:{colour};stroke-width:2;fill:none}}");
    let colours: Vec<String> = COLOURS.iter().enumerate().map(colour).collect();
    let style =
        format!("{}.d{{stroke-width:8;stroke-linecap:round}}.p{{stroke:#999;stroke-dasharray:5 4}}", colours.concat());
    drawing::file(svg, "Share of shots that go in, ball by ball", &style)
}
