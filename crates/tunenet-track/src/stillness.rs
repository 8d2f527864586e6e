//! Whether the camera stood still: edges in the picture stay where they are, whatever moves before them.

use opencv::core::Mat;
use rayon::prelude::*;

use crate::scout::MOVED;
use crate::view::View;

/// An edge: neighbours of a pixel differ by more than so many grey levels.
const EDGE: u8 = 40;
/// The picture is looked at in so many by so many tiles.
const TILES: usize = 8;
/// Fewer edges in a tile say nothing.
const FEWEST_EDGES: usize = 12;
/// Fewer tiles with edges may be the ball and a hand before a plain wall, which looks alike from everywhere.
const FEWEST_TILES: usize = 12;
/// A tile moves where this share of its edges looks different in the next picture.
const MOVED_EDGES: f64 = 0.4;
/// A camera moves where this share of the tiles does, in half of the pictures.
const MOVED_TILES: f64 = 0.5;

/// Whether the camera moves between these pictures, all of one size.
pub(crate) fn moves(pictures: &[Mat]) -> opencv::Result<bool> {
    let mut shares: Vec<f64> = pictures
        .par_windows(2)
        .map(|pair| moved_tiles(&pair[0], &pair[1]))
        .collect::<opencv::Result<Vec<Option<f64>>>>()?
        .into_iter()
        .flatten()
        .collect();
    shares.sort_unstable_by(f64::total_cmp);
    Ok(shares.get(shares.len() / 2).is_some_and(|s| *s > MOVED_TILES))
}

/// The share of the tiles of `before` whose edges look different in `after`; `None` where there are too few.
fn moved_tiles(before: &Mat, after: &Mat) -> opencv::Result<Option<f64>> {
    let (before, after) = (View::of(before)?, View::of(after)?);
    let (columns, rows) = (before.columns(), before.rows());
    let mut tiles = [[(0usize, 0usize); TILES]; TILES];
    // Green carries most of the brightness; every channel would only say the same again.
    let green = |view: &View<'_>, column: usize, row: usize| view.pixel(column, row)[1];
    for row in 1..rows - 1 {
        for column in 1..columns - 1 {
            let across = green(&before, column - 1, row).abs_diff(green(&before, column + 1, row));
            let down = green(&before, column, row - 1).abs_diff(green(&before, column, row + 1));
            if across.max(down) > EDGE {
                let (edges, moved) = &mut tiles[row * TILES / rows][column * TILES / columns];
                *edges += 1;
                *moved += usize::from(green(&before, column, row).abs_diff(green(&after, column, row)) > MOVED);
            }
        }
    }
    let told: Vec<bool> = tiles
        .iter()
        .flatten()
        .filter(|(edges, _)| *edges >= FEWEST_EDGES)
        .map(|(edges, moved)| *moved as f64 > MOVED_EDGES * *edges as f64)
        .collect();
    let moving = told.iter().filter(|m| **m).count();
    Ok((told.len() >= FEWEST_TILES).then(|| moving as f64 / told.len() as f64))
}
