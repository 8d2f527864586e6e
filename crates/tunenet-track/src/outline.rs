//! Subpixel edges along rays from a ball's middle, and the least-squares circle through them (Kåsa 1976).
//!
//! Along each ray the colour goes from the ball's own, near the edge, to that of the background. How far towards the
//! ball each point is, summed over the ray, is where the edge lies: a lens, the coarser colour of a compressed video, and an
//! exposure all blur that step and none of them moves its middle. A mask does not know this: it is too large by what
//! its thresholds let in.

use crate::view::View;
use tunenet_core::statistics::median;

/// So many rays for each px of the radius, within these bounds.
const RAYS_PER_PX: f64 = 4.0;
const RAYS: (f64, f64) = (24.0, 64.0);
/// A guess this near, as a share of the radius, is good enough.
const NEAR: f64 = 0.1;
/// Fewer edges make no circle.
const FEWEST_EDGES: usize = 8;
/// Ball and background differ by so many grey levels along a ray that says where the edge is.
const LEAST_CONTRAST: f32 = 18.0;
/// Half the width of the blurred edge: so many px, and this share of the radius. Videos store colour at half the resolution.
const BLUR: (f64, f64) = (2.0, 0.06);
/// The same, px, where a picture keeps all of its colour and nothing blurs it.
const SHARP_BLUR_PX: f64 = 1.0;
/// Where the colours of ball and background are taken, px beyond the blurred edge. A ball's shade changes towards its edge,
/// so that a sharp picture is asked nearer to it.
const MARGIN_PX: f64 = 2.0;
const SHARP_MARGIN_PX: f64 = 1.0;
/// Points along a ray, px apart.
const STEP_PX: f64 = 0.5;
/// An edge this far from the circle, as a share of the radius and in px, belongs to something else.
const OFF: (f64, f64) = (0.06, 0.5);

/// How often each part of an ellipse is taken out of its outline.
const ROUNDS: usize = 3;

/// Whether a colour at a point may be the ball's.
pub(crate) type Own<'a> = dyn Fn([u8; 3], (f64, f64)) -> bool + 'a;

/// A circle, px from the centre of the first pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Circle {
    pub u: f64,
    pub v: f64,
    pub radius: f64,
    /// The share of all rays whose edges lie on it.
    pub share: f64,
    /// The median distance of all edges from an ellipse about its middle, as a share of the radius.
    pub off: f64,
    /// Whether rays leave the picture before they leave the ball.
    pub cut: bool,
    /// How gradual the edge is, px: the median over the rays of ∫ s (1 − s), where s goes from 1 in the ball to 0.
    pub softness_px: f64,
}

/// How an edge is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Edges {
    /// Half the length over which motion blurs it, px.
    pub smear_px: f64,
    /// Whether the picture is known to be sharp.
    pub sharp: bool,
}

/// The ball's outline about a first guess. `None` where no edge can be detected.
pub(crate) fn outline(view: &View<'_>, own: &Own<'_>, guess: (f64, f64, f64), edges: Edges) -> Option<Circle> {
    let first = around(view, own, guess, edges)?;
    // From a middle that was far off, rays meet the edge at a slant, or miss a part of it.
    let off = (first.u - guess.0).hypot(first.v - guess.1).max((first.radius - guess.2).abs());
    if off < NEAR * first.radius {
        return Some(first);
    }
    around(view, own, (first.u, first.v, first.radius), edges)
}

fn around(view: &View<'_>, own: &Own<'_>, (u, v, radius): (f64, f64, f64), how: Edges) -> Option<Circle> {
    let (blur, margin) = if how.sharp { (SHARP_BLUR_PX, SHARP_MARGIN_PX) } else { (BLUR.0, MARGIN_PX) };
    let blur = (blur + BLUR.1 * radius).max(how.smear_px).min(BLUR.0.max(0.7 * radius));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let rays = (RAYS_PER_PX * radius).clamp(RAYS.0, RAYS.1) as usize;
    let (mut edges, mut softness, mut outside) = (Vec::with_capacity(rays), Vec::with_capacity(rays), 0);
    for ray in 0..rays {
        let angle = std::f64::consts::TAU * (ray as f64 + 0.5) / rays as f64;
        let (across, down) = (angle.cos(), angle.sin());
        match edge(view, own, (u, v), (across, down), radius, (blur, margin)) {
            Edge::At(distance, soft) => {
                edges.push((u + distance * across, v + distance * down));
                softness.push(soft);
            }
            Edge::Outside => outside += 1,
            Edge::Faint => {}
        }
    }
    let mut found = circle(&edges)?;
    let mut kept = edges.clone();
    // A shadow, a reflection or a hand: the few worst edges go, and the circle is drawn afresh.
    for _ in 0..4 {
        let away = |p: &(f64, f64)| ((p.0 - found.0).hypot(p.1 - found.1) - found.2).abs();
        let limit = (2.5 * median(kept.iter().map(away))?).max(OFF.0 * found.2 + OFF.1).max(0.5 * how.smear_px);
        let better: Vec<(f64, f64)> = kept.iter().filter(|p| away(p) <= limit).copied().collect();
        if better.len() == kept.len() {
            break;
        }
        kept = better;
        found = circle(&kept)?;
    }
    let (u, v, radius) = found;
    let share = kept.len() as f64 / (rays - outside).max(1) as f64;
    let off = off_ellipse(&edges, found)?;
    let softness_px = median(softness)?;
    let cut = outside > 0;
    (radius.is_finite() && radius > 0.0).then_some(Circle { u, v, radius, share, off, cut, softness_px })
}

/// The median distance of edges from an ellipse, as a share of the radius: blur makes a disc longer, but gives it no corners.
fn off_ellipse(edges: &[(f64, f64)], (u, v, radius): (f64, f64, f64)) -> Option<f64> {
    // About a circle, an ellipse is a wave that goes round twice: of an edge's direction, the constant, cosine and sine
    // once and twice round.
    let waves = |p: &(f64, f64)| {
        let (x, y) = (p.0 - u, p.1 - v);
        let away = x.hypot(y);
        let (cos, sin) = (x / away, y / away);
        ([1.0, cos, sin, cos * cos - sin * sin, 2.0 * sin * cos], away / radius - 1.0)
    };
    let mut polar: Vec<([f64; 5], f64)> = edges.iter().map(waves).collect();
    // Each part is taken out until nothing changes.
    for part in (0..5).cycle().take(ROUNDS * 5) {
        let (product, square) = polar.iter().fold((0.0, 0.0), |(p, s), (w, r)| (p + r * w[part], s + w[part].powi(2)));
        for (w, r) in &mut polar {
            *r -= product / square * w[part];
        }
    }
    median(polar.iter().map(|(_, r)| r.abs())).filter(|off| off.is_finite())
}

enum Edge {
    /// Distance from the middle, and how gradual it is, px.
    At(f64, f64),
    /// The ray leaves the picture before the ball.
    Outside,
    /// Ball and background look alike, or the ball is not met at all.
    Faint,
}

fn edge(
    view: &View<'_>,
    own: &Own<'_>,
    from: (f64, f64),
    along: (f64, f64),
    radius: f64,
    (blur, margin): (f64, f64),
) -> Edge {
    let at = |distance: f64| (from.0 + distance * along.0, from.1 + distance * along.1);
    let own = |distance: f64| {
        let (u, v) = at(distance);
        view.holds(u, v).then(|| own(view.colour(u, v).map(level), (u, v)))
    };
    // Beyond most highlights, outwards as long as the colour is the ball's; a gap of a few pixels is noise.
    let (step, gap, most) = ((0.02 * radius).max(STEP_PX), 0.1 * radius + 1.0, 1.6 * radius + 2.0);
    let (mut rough, mut distance) = (None, 0.55 * radius);
    while distance < most && distance - rough.unwrap_or(0.9 * radius) <= gap {
        match own(distance) {
            None => return Edge::Outside,
            Some(true) => rough = Some(distance),
            Some(false) => {}
        }
        distance += step;
    }
    let Some(rough) = rough else { return Edge::Faint };
    let (inner, outer) = ((rough - blur).max(0.0), rough + blur);
    let (last_u, last_v) = at(outer + MARGIN_PX);
    if !view.holds(last_u, last_v) {
        return Edge::Outside;
    }
    let mean = |start: f64, end: f64| -> [f32; 3] {
        let colour = |distance: f64| {
            let (u, v) = at(distance);
            view.colour(u, v)
        };
        let (a, b, c) = (colour(start), colour(f64::midpoint(start, end)), colour(end));
        [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0, (a[2] + b[2] + c[2]) / 3.0]
    };
    let (ball, behind) = (mean((inner - margin).max(0.0), inner), mean(outer, outer + MARGIN_PX));
    let towards = [ball[0] - behind[0], ball[1] - behind[1], ball[2] - behind[2]];
    let contrast = towards[0] * towards[0] + towards[1] * towards[1] + towards[2] * towards[2];
    if contrast < LEAST_CONTRAST * LEAST_CONTRAST {
        return Edge::Faint;
    }
    // The edge lies where a sharp step would have to be to cover as much.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few points")]
    let count = ((outer - inner) / STEP_PX).ceil().max(1.0) as usize;
    let width = (outer - inner) / count as f64;
    let (mut covered, mut soft) = (0.0, 0.0);
    for i in 0..count {
        let (u, v) = at(inner + (i as f64 + 0.5) * width);
        let colour = view.colour(u, v);
        let along: f32 = (0..3).map(|c| (colour[c] - behind[c]) * towards[c]).sum();
        let share = f64::from((along / contrast).clamp(-0.5, 1.5));
        covered += share;
        soft += share * (1.0 - share);
    }
    Edge::At(inner + (covered * width).clamp(0.0, outer - inner), soft * width)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a mean of bytes")]
fn level(value: f32) -> u8 {
    (value + 0.5) as u8
}

/// The circle that minimises Σ(x² + y² − 2ax − 2by − c)² over the points (Kåsa 1976): centre `(a, b)` and radius.
pub(crate) fn circle(points: &[(f64, f64)]) -> Option<(f64, f64, f64)> {
    let n = points.len() as f64;
    if points.len() < FEWEST_EDGES {
        return None;
    }
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let [mut xx, mut xy, mut yy, mut xz, mut yz, mut z] = [0.0; 6];
    for (x, y) in points {
        let (x, y) = (x - mx, y - my);
        let square = x * x + y * y;
        xx += x * x;
        xy += x * y;
        yy += y * y;
        xz += x * square;
        yz += y * square;
        z += square;
    }
    let determinant = xx * yy - xy * xy;
    // Points on a line have no circle.
    if determinant <= 1e-9 * (xx * yy).max(f64::MIN_POSITIVE) {
        return None;
    }
    let a = 0.5 * (xz * yy - yz * xy) / determinant;
    let b = 0.5 * (yz * xx - xz * xy) / determinant;
    Some((a + mx, b + my, (a * a + b * b + z / n).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::Window;
    use crate::lookup::Lookup;
    use opencv::core::{CV_8UC3, Mat, Scalar};

    const SOFT: Edges = Edges { smear_px: 0.0, sharp: false };

    fn disc(u: f64, v: f64, radius: f64) -> Mat {
        let mut picture = Mat::new_rows_cols_with_default(60, 80, CV_8UC3, Scalar::all(120.0)).unwrap();
        crate::test_videos::disc(&mut picture, (u, v), radius, [40.0, 40.0, 220.0]);
        picture
    }

    #[test]
    fn a_disc_is_measured_to_a_few_hundredths_of_a_pixel() {
        let lookup = Lookup::new(&Window::parse("red").unwrap());
        for (u, v, radius) in [(30.3, 25.7, 12.0), (40.0, 30.0, 5.0), (22.25, 31.5, 8.4)] {
            let picture = disc(u, v, radius);
            let view = View::of(&picture).unwrap();
            let found =
                outline(&view, &|colour, _| lookup.holds(colour), (u + 1.3, v - 0.8, 0.8 * radius), SOFT).unwrap();
            assert!((found.u - u).hypot(found.v - v) < 0.03, "{found:?} for {u} {v}");
            assert!((found.radius - radius).abs() < 0.08, "{found:?} for {radius}");
            assert!(found.share > 0.95 && !found.cut);
        }
    }

    #[test]
    fn a_disc_that_the_border_cuts_keeps_its_centre() {
        let lookup = Lookup::new(&Window::parse("red").unwrap());
        let picture = disc(4.0, 30.0, 10.0);
        let found =
            outline(&View::of(&picture).unwrap(), &|colour, _| lookup.holds(colour), (6.0, 30.0, 9.0), SOFT).unwrap();
        assert!(found.cut && (found.u - 4.0).abs() < 0.15 && (found.radius - 10.0).abs() < 0.15, "{found:?}");
    }

    #[test]
    fn a_part_of_a_circle_gives_the_whole() {
        let arc: Vec<(f64, f64)> = (0..20)
            .map(|i| (30.0 + 8.0 * (0.1 * f64::from(i)).cos(), 12.0 + 8.0 * (0.1 * f64::from(i)).sin()))
            .collect();
        let (u, v, radius) = circle(&arc).unwrap();
        assert!((u - 30.0).abs() < 1e-9 && (v - 12.0).abs() < 1e-9 && (radius - 8.0).abs() < 1e-9);
        let line: Vec<(f64, f64)> = (0..20).map(|i| (f64::from(i), 2.0 * f64::from(i))).collect();
        assert!(circle(&line).is_none() && circle(&arc[..4]).is_none());
    }
}
