//! The page of `tunenet plan`: the shot to scale with its spread, and what every height is worth.

use std::path::Path;

use maud::{Markup, html};
use tunenet_formats::Result;
use tunenet_sim::ball::State;
use tunenet_sim::shot::{Candidate, Flight, Rule};

use super::Provenance;
use super::axis::Axis;
use super::checks::warnings;
use super::page;
use super::panel::{ABOVE, BELOW, Panel, left_edge};
use super::svg::{Anchor, Svg};
use super::verdict::{CROSS, TICK, capital, shape};
use crate::answers::plan::Answer;
use crate::view::sentence;

/// Width of a drawing, in its own units, and height of a curve.
const WIDTH: f64 = 720.0;
const CURVE: f64 = 220.0;
/// Room around what is drawn to scale, m, and how far the plane is drawn on either side of the bounce.
const ROOM_M: f64 = 0.06;
const PLANE_M: f64 = 0.12;
/// Drawn balls that are shown.
const SHOWN: usize = 40;
/// How long a ball is shown after it has touched the rim, s.
const AFTERWARDS_S: f64 = 0.25;

/// Writes the page for the task `name`.
pub fn write(path: &Path, name: &str, answer: &Answer, provenance: &Provenance) -> Result<()> {
    let plan = &answer.plan;
    let (class, word) = if plan.reachable { ("verdict tuned", "Planned") } else { ("verdict not", "Out of reach") };
    let sign = if plan.reachable { TICK } else { CROSS };
    let sentence = sentence::plan(answer).sentence;
    let chance = |c: &Candidate| c.probability.map(|p| 100.0 * p);
    let rule = if answer.settings.rule == Rule::Nearest {
        "the path that passes closest to the hoop's centre"
    } else {
        "the highest success probability; among equals the largest distance from the rim"
    };
    let rollouts =
        format!("{} heights; balls drawn from what is uncertain: {}", plan.candidates.len(), answer.settings.draws);
    let body = html! {
        section class=(class) { (shape(sign, word)) div { p.word { (word) } p { (capital(&sentence)) "." } } }
        section {
            h2 { "Shot" }
            p.how { "To scale, seen from the side. The dark line is the ball's centre with the values of the file, the circles are that "
                "ball at the bounce and in the hoop; the pale lines are balls sampled from the uncertainty, and dashed ones "
                "touch the rim or miss." }
            figure { (shot(answer)) }
        }
        section {
            h2 { "Candidate heights" }
            p.how { "Chosen by " (rule) ". The upright line is the height that was chosen; where the curve of the miss distance "
                "is bold, the ball of the file goes in. Heights that the arm does not reach are left out." }
            figure { (curve(answer, "miss distance in cm", |c| Some(100.0 * c.pass.miss_m), |c| c.pass.goes_in())) }
            @if plan.candidates.iter().filter(|c| c.probability.is_some()).count() > 1 {
                figure { (curve(answer, "success probability in percent", chance, |_| true)) }
            }
        }
        section { h2 { "Release" } (release(answer)) }
        section { h2 { "Warnings and notes" } (warnings(&answer.notes)) }
        section { h2 { "Provenance" } (provenance.section(&rollouts)) }
    };
    page::write(path, &page::page("Shot", name, &body))
}

/// Along which way of the plane the picture is cut: towards the hoop.
fn along(answer: &Answer, x: [f64; 3]) -> (f64, f64) {
    let [hx, hy, _] = answer.scene.hoop.centre_m;
    let length = hx.hypot(hy);
    ((x[0] * hx + x[1] * hy) / length, x[2])
}

/// The places of a path, from the release on.
fn line(answer: &Answer, states: &[State]) -> Vec<(f64, f64)> {
    states.iter().map(|state| along(answer, state.position_m)).collect()
}

/// What becomes of a ball: through the hoop as it flew, or away from the rim.
fn ending(answer: &Answer, ball: &tunenet_sim::ball::Scene, flight: &Flight) -> Vec<State> {
    let end = flight.step_s * (flight.states.len() - 1 - flight.bounce) as f64;
    let touched = answer.scene.among_rim(ball, &flight.states[flight.bounce], (0.0, flight.step_s, end + AFTERWARDS_S));
    match touched {
        Ok((states, true)) => flight.states[..flight.bounce].iter().chain(&states).copied().collect(),
        _ => flight.states.clone(),
    }
}

fn shot(answer: &Answer) -> Markup {
    let height = answer.plan.best().height_m;
    let nominal = answer.belief.nominal();
    let release = State::at([0.0, 0.0, height]);
    let scene = &answer.scene;
    let path = scene.fly(&nominal, &release).map(|f| line(answer, &f.states)).unwrap_or_default();
    let mut spread = Vec::new();
    for draw in answer.belief.draws(SHOWN, answer.settings.seed) {
        let [x, y, z] = draw.offset.position_m;
        let from = State { position_m: [x, y, z + height], ..draw.offset };
        if let Ok(flight) = scene.fly(&draw.ball, &from) {
            let goes_in = tunenet_sim::shot::Pass::judge(&flight, &scene.hoop, scene.radius_m).goes_in();
            spread.push((goes_in, line(answer, &ending(answer, &draw.ball, &flight))));
        }
    }
    let (middle, level) = along(answer, scene.hoop.centre_m);
    let reach = scene.hoop.radius_m;
    let places = || path.iter().copied().chain([(middle - reach, level), (middle + reach, level), (-PLANE_M, 0.0)]);
    let range = |of: fn(&(f64, f64)) -> f64| {
        let (low, high) =
            places().map(|p| of(&p)).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        (low - ROOM_M, high + ROOM_M)
    };
    let (across, up) = (range(|p| p.0), range(|p| p.1));
    let left = left_edge(&[up]);
    // One scale for both.
    let unit = (WIDTH - 8.0 - left) / (across.1 - across.0);
    let tall = unit * (up.1 - up.0);
    let panel = Panel { x: Axis::new(across, (left, WIDTH - 8.0)), y: Axis::new(up, (ABOVE + tall, ABOVE)) };
    let mut svg = Svg::new(WIDTH, ABOVE + tall + BELOW);
    panel.frame(&mut svg, Some("towards the hoop in m"), "height in m");
    let inside = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        points
            .iter()
            .copied()
            .filter(|p| (across.0..=across.1).contains(&p.0) && (up.0..=up.1).contains(&p.1))
            .collect()
    };
    for (goes_in, points) in &spread {
        svg.path(if *goes_in { "line spread after" } else { "line thin before" }, &panel.spots(&inside(points)), false);
    }
    svg.path("event", &panel.spots(&inside(&path)), false);
    let in_hoop = path.windows(2).skip(1).find(|pair| pair[0].1 > level && pair[1].1 <= level).map(|pair| {
        let share = (pair[0].1 - level) / (pair[0].1 - pair[1].1);
        (pair[0].0 + share * (pair[1].0 - pair[0].0), level)
    });
    for (x, z) in [Some((0.0, 0.0)), in_hoop].into_iter().flatten() {
        let corner = |i: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 36.0).sin_cos();
            (x + scene.radius_m * cos, z + scene.radius_m * sin)
        };
        svg.path("event", &panel.spots(&inside(&(0..=36).map(corner).collect::<Vec<_>>())), false);
    }
    // The plane is a ball's radius below the centre of a ball that touches it.
    let [nx, ny, nz] = scene.plane_normal;
    let (tilt, _) = along(answer, [nx, ny, 0.0]);
    let on_plane = |s: f64| (s, -(scene.radius_m + tilt * s) / nz);
    svg.path("plane", &panel.spots(&inside(&[on_plane(-PLANE_M), on_plane(0.0), on_plane(PLANE_M)])), false);
    let rim = panel.spots(&[(middle - reach, level), (middle + reach, level)]);
    svg.line("limit", rim[0], rim[1]);
    svg.dots("knob after", &rim);
    svg.text("label", (rim[0].0, rim[0].1 - 9.0), Anchor::End, "hoop");
    let top = panel.spot((0.0, height));
    svg.text("label", (top.0 + 10.0, top.1 + 4.0), Anchor::Start, &format!("release, {height:.3} m"));
    svg.finish("curve", "the shot from the side, to scale, with plane, hoop and sampled balls")
}

/// A number of every height that is within reach, bold where `good` holds.
fn curve(
    answer: &Answer,
    name: &str,
    of: impl Fn(&Candidate) -> Option<f64>,
    good: impl Fn(&Candidate) -> bool,
) -> Markup {
    let reached = answer.plan.candidates.iter().filter(|c| c.joints_rad.is_some());
    let known: Vec<(bool, (f64, f64))> = reached.filter_map(|c| Some((good(c), (c.height_m, of(c)?)))).collect();
    let points: Vec<(f64, f64)> = known.iter().map(|k| k.1).collect();
    if points.len() < 2 {
        return html! {};
    }
    let most = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let (across, up) = ((points[0].0, points[points.len() - 1].0), (0.0, if most > 0.0 { 1.08 * most } else { 1.0 }));
    // Curves stand below one another: percents need the widest edge.
    let left = left_edge(&[up, (0.0, 100.0)]);
    let panel = Panel { x: Axis::new(across, (left, WIDTH - 8.0)), y: Axis::new(up, (CURVE - BELOW, ABOVE)) };
    let mut svg = Svg::new(WIDTH, CURVE);
    panel.frame(&mut svg, Some("height of release in m"), name);
    let best = answer.plan.best().height_m;
    svg.line("limit", panel.spot((best, up.0)), panel.spot((best, up.1)));
    svg.path("line thin after", &panel.spots(&points), false);
    for run in known.chunk_by(|a, b| a.0 == b.0).filter(|run| run[0].0 && run.len() > 1) {
        let run: Vec<(f64, f64)> = run.iter().map(|k| k.1).collect();
        svg.path("line after", &panel.spots(&run), false);
    }
    svg.finish("curve", &format!("{name} over the height of release"))
}

fn release(answer: &Answer) -> Markup {
    let best = answer.plan.best();
    let joints = best.joints_rad.as_deref().filter(|joints| !joints.is_empty());
    let chance = best.probability.map_or("-".into(), |p| format!("{:.1} %", 100.0 * p));
    html! {
        table { tbody {
            tr { th scope="row" { "height of the ball's centre above the impact point" } td { (format!("{:.4} m", best.height_m)) } }
            tr { th scope="row" { "distance from the hoop's centre" } td { (format!("{:.1} mm", 1e3 * best.pass.miss_m)) } }
            tr { th scope="row" { "distance from the rim" } td { (format!("{:.1} mm", 1e3 * best.pass.clearance_m)) } }
            tr { th scope="row" { "chance" } td { (chance) } }
            @if let (Some(joints), Some(arm)) = (joints, &answer.arm) {
                @for (name, q) in arm.joint_names().iter().zip(joints) {
                    tr { th scope="row" { (name) } td { (format!("{q:.5} rad")) } }
                }
            }
        } }
    }
}
