//! Connected patches of a mask.

use opencv::core::{CV_32S, Mat, MatTraitConst, ToInputArray};
use opencv::imgproc::{
    CC_STAT_AREA, CC_STAT_HEIGHT, CC_STAT_LEFT, CC_STAT_TOP, CC_STAT_WIDTH, connected_components_with_stats,
};

/// One connected patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blob {
    /// Its centroid, px from the centre of the first pixel.
    pub u: f64,
    /// Its centroid, px downwards.
    pub v: f64,
    /// How many pixels it has.
    pub area: f64,
    /// Left, top, width and height of its box, px.
    pub bounds: [i32; 4],
}

impl Blob {
    /// Its area over that of the ellipse in its box: 1 for a disc or a disc that is blurred along an axis.
    #[must_use]
    pub fn fill(&self) -> f64 {
        let [_, _, width, height] = self.bounds.map(f64::from);
        self.area / (std::f64::consts::FRAC_PI_4 * width * height)
    }
}

/// The patches of `mask` (8 bits, 0 is outside), the largest first.
pub(crate) fn blobs(mask: &impl ToInputArray) -> opencv::Result<Vec<Blob>> {
    let (mut labels, mut stats, mut centroids) = (Mat::default(), Mat::default(), Mat::default());
    let count = connected_components_with_stats(mask, &mut labels, &mut stats, &mut centroids, 8, CV_32S)?;
    let mut found = Vec::new();
    for i in 1..count {
        let stat = |column: i32| stats.at_2d::<i32>(i, column).copied();
        found.push(Blob {
            u: *centroids.at_2d::<f64>(i, 0)?,
            v: *centroids.at_2d::<f64>(i, 1)?,
            area: f64::from(stat(CC_STAT_AREA)?),
            bounds: [stat(CC_STAT_LEFT)?, stat(CC_STAT_TOP)?, stat(CC_STAT_WIDTH)?, stat(CC_STAT_HEIGHT)?],
        });
    }
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    Ok(found)
}
