//! The outline of the largest patch of a mask: its filled centroid, and the circle through it.

use opencv::core::{Mat, Point, Vector};
use opencv::imgproc::{CHAIN_APPROX_NONE, RETR_EXTERNAL, contour_area_def, find_contours_def, moments_def};

/// An outline in the mask's own coordinates, px.
pub(crate) struct Outline {
    /// Centre and radius of the circle through the points that the frame's border does not cut.
    pub u: f64,
    pub v: f64,
    pub radius: f64,
    /// Centroid of the patch with its holes filled (a highlight is part of the ball), and the radius of its area.
    pub centroid_u: f64,
    pub centroid_v: f64,
    pub area_radius: f64,
}

/// The outline of the largest patch. The mask lies at `offset` in a frame of `(columns, rows)`.
pub(crate) fn circle_through(
    mask: &Mat,
    (columns, rows): (i32, i32),
    offset: (i32, i32),
) -> opencv::Result<Option<Outline>> {
    let mut contours: Vector<Vector<Point>> = Vector::new();
    find_contours_def(mask, &mut contours, RETR_EXTERNAL, CHAIN_APPROX_NONE)?;
    let mut largest: Option<(f64, Vector<Point>)> = None;
    for contour in &contours {
        let area = contour_area_def(&contour)?;
        if largest.as_ref().is_none_or(|l| area > l.0) {
            largest = Some((area, contour));
        }
    }
    let Some((area, contour)) = largest.filter(|l| l.0 > 0.0) else { return Ok(None) };
    let m = moments_def(&contour)?;
    if m.m00 <= 0.0 {
        return Ok(None);
    }
    // The contour runs through the centres of the outermost pixels, half a pixel inside the patch.
    let area_radius = (area / std::f64::consts::PI).sqrt() + 0.5;
    let free = |p: &Point| {
        let (x, y) = (p.x + offset.0, p.y + offset.1);
        x > 0 && y > 0 && x < columns - 1 && y < rows - 1
    };
    let points: Vec<(f64, f64)> = contour.iter().filter(free).map(|p| (f64::from(p.x), f64::from(p.y))).collect();
    let (u, v, radius) = circle(&points).unwrap_or((m.m10 / m.m00, m.m01 / m.m00, area_radius));
    Ok(Some(Outline { u, v, radius: radius + 0.5, centroid_u: m.m10 / m.m00, centroid_v: m.m01 / m.m00, area_radius }))
}

/// The circle that minimises Σ(x² + y² − 2ax − 2by − c)² over the points (Kåsa 1976): centre `(a, b)` and radius.
fn circle(points: &[(f64, f64)]) -> Option<(f64, f64, f64)> {
    let n = points.len() as f64;
    if points.len() < 5 {
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
    if determinant <= 1e-9 * xx * yy.max(f64::MIN_POSITIVE) {
        return None;
    }
    let a = 0.5 * (xz * yy - yz * xy) / determinant;
    let b = 0.5 * (yz * xx - xz * xy) / determinant;
    Some((a + mx, b + my, (a * a + b * b + z / n).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

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
