//! Figure 2: the error against the rollouts, both on logarithmic scales, one panel a set.

use super::methods::Method;
use super::results::{POINTS, Table2Results};
use super::{BUDGETS, SETS};
use tunenet_cli::view::html::drawing;
use tunenet_cli::view::html::svg::{Anchor, Spot, Svg};

const WIDTH: f64 = 880.0;
const HEIGHT: f64 = 640.0;
/// Inside of a panel.
const PANEL: (f64, f64) = (330.0, 220.0);
/// Errors below are drawn at the bottom: without noise they fall to rounding.
const LEAST: f64 = 1e-6;
const DECADES: f64 = 6.0;
/// The largest number of rollouts, as a power of ten.
const MOST: f64 = 2.0;
/// The methods drawn, each with the colour of its line; the others differ little from one of these.
const DRAWN: [(Method, &str); 7] = [
    (Method::Default, "#1a6e5a"),
    (Method::Paper, "#8a4fbf"),
    (Method::EntropySearch, "#8a8a8a"),
    (Method::EvolutionInTwo, "#b8860b"),
    (Method::Brent, "#c0392b"),
    (Method::Apex, "#2c6fbb"),
    (Method::Nearest, "#444444"),
];

/// The drawing as a file of its own.
pub fn draw(results: &Table2Results) -> String {
    let mut svg = Svg::new(WIDTH, HEIGHT);
    for (i, (set, conditions)) in SETS.iter().enumerate() {
        let corner = (80.0 + 420.0 * (i % 2) as f64, 40.0 + 275.0 * (i / 2) as f64);
        let noise =
            if conditions.noise_m > 0.0 { format!(", noise {} cm", 100.0 * conditions.noise_m) } else { String::new() };
        let (low, high) = conditions.restitution;
        svg.text("t", (corner.0, corner.1 - 10.0), Anchor::Start, &format!("restitution {low} to {high}{noise}"));
        panel(&mut svg, corner);
        // Ours last, so that nothing hides it.
        for (method, _) in DRAWN.into_iter().rev() {
            let Some(cell) = results.cells_of(set).find(|c| c.method == method) else { continue };
            let line: Vec<Spot> = (0..POINTS.len())
                .filter(|k| POINTS[*k] > 0)
                .map(|k| spot(corner, POINTS[k] as f64, cell.at(k)))
                .collect();
            svg.path(method.key(), &line, false);
        }
        let reported = BUDGETS.into_iter().filter_map(|k| Some((k, Method::Paper.published(set, k)?)));
        let reported: Vec<Spot> = reported.map(|(k, error)| spot(corner, k as f64, error)).collect();
        svg.dots("d", &reported);
    }
    for (i, (method, _)) in DRAWN.iter().enumerate() {
        let at = (80.0 + 270.0 * (i % 3) as f64, HEIGHT - 52.0 + 18.0 * (i / 3) as f64);
        svg.line(method.key(), (at.0, at.1 - 4.0), (at.0 + 22.0, at.1 - 4.0));
        let short = method.title().split(',').next().unwrap_or_default();
        let name = if matches!(method, Method::Default | Method::Paper) { method.title() } else { short };
        svg.text("s", (at.0 + 28.0, at.1), Anchor::Start, name);
    }
    svg.dots("d", &[(80.0 + 270.0 + 11.0, HEIGHT - 52.0 + 36.0 - 4.0)]);
    svg.text("s", (80.0 + 270.0 + 28.0, HEIGHT - 52.0 + 36.0), Anchor::Start, "the paper's own figures");
    let colour =
        |(method, colour): &(Method, &str)| format!(".{}{{stroke:{colour};stroke-width:2;fill:none}}", method.key());
    let colours = DRAWN.iter().map(colour).collect::<Vec<_>>().concat();
    let dots = ".d{stroke:#8a4fbf;stroke-width:7;stroke-linecap:round}";
    drawing::file(svg, "Error of the restitution against rollouts", &format!("{colours}{dots}"))
}

/// Frame, grid and ticks at whole powers of ten.
fn panel(svg: &mut Svg, corner: Spot) {
    for decade in 0..=6 {
        let error = LEAST * 10f64.powi(decade);
        let (_, y) = spot(corner, 1.0, error);
        svg.line("g", (corner.0, y), (corner.0 + PANEL.0, y));
        svg.text("s", (corner.0 - 6.0, y + 4.0), Anchor::End, &format!("{error:.0e}"));
    }
    for rollouts in [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0] {
        let (x, _) = spot(corner, rollouts, 1.0);
        svg.line("g", (x, corner.1), (x, corner.1 + PANEL.1));
        svg.text("s", (x, corner.1 + PANEL.1 + 15.0), Anchor::Middle, &format!("{rollouts}"));
    }
    let (right, bottom) = (corner.0 + PANEL.0, corner.1 + PANEL.1);
    svg.path("f", &[corner, (right, corner.1), (right, bottom), (corner.0, bottom)], true);
}

fn spot(corner: Spot, rollouts: f64, error: f64) -> Spot {
    let x = rollouts.log10() / MOST;
    let y = ((error.max(LEAST) / LEAST).log10() / DECADES).min(1.0);
    (corner.0 + PANEL.0 * x, corner.1 + PANEL.1 * (1.0 - y))
}
