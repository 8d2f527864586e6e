//! Camera motion from background edges: they stay in place if the camera does, for any moving foreground.

use opencv::core::Mat;
use rayon::prelude::*;
use tunenet_core::statistics::median;

use crate::view::View;

/// How far a pixel has to differ from the background, in grey levels of any channel, to belong to something that moves.
pub(crate) const MOVED: u8 = 20;
/// An edge: neighbours of a pixel differ by more than so many grey levels.
const EDGE: u8 = 40;
/// The picture is looked at in so many by so many tiles.
const TILES: usize = 8;
/// Fewer edges in a tile say nothing.
const FEWEST_EDGES: usize = 12;
/// Fewer tiles with edges may be the ball and a hand before a plain wall, which looks alike from everywhere.
const FEWEST_TILES: usize = 12;
/// They have to lie in so many of the columns of tiles: a person who walks by has edges as well, but in few.
const FEWEST_COLUMNS: usize = 5;
/// A tile moves where this share of its edges looks different in the next picture.
const MOVED_EDGES: f64 = 0.4;
/// A camera moves where this share of the tiles does, in half of the pictures.
const MOVED_TILES: f64 = 0.5;

/// When a single picture shows the background displaced: what counts as an edge and as a change of one, in grey levels, and the
/// share of the tiles that moved.
#[derive(Clone, Copy)]
pub(crate) struct Doubt {
    edge: u8,
    moved: u8,
    tiles: f64,
}

/// Sure enough to leave pictures out.
pub(crate) const STRICT: Doubt = Doubt { edge: EDGE, moved: MOVED, tiles: 0.7 };
/// Enough to explain why no ball is found.
pub(crate) const LENIENT: Doubt = Doubt { edge: 24, moved: 10, tiles: MOVED_TILES };

/// Whether the camera moves between these pictures, all of one size.
pub(crate) fn moves(pictures: &[Mat]) -> opencv::Result<bool> {
    let shares: Vec<Option<f64>> =
        pictures.par_windows(2).map(|pair| moved_tiles(&pair[0], &pair[1])).collect::<opencv::Result<_>>()?;
    Ok(median(shares.into_iter().flatten()).is_some_and(|share| share > MOVED_TILES))
}

/// Which of these pictures show the background displaced from `reference`: the camera moved.
pub(crate) fn displaced(pictures: &[(usize, &Mat)], reference: &Mat, doubt: Doubt) -> opencv::Result<Vec<bool>> {
    pictures
        .par_iter()
        .map(|(_, picture)| Ok(shifted_tiles(reference, picture, doubt)?.is_some_and(|s| s > doubt.tiles)))
        .collect()
}

/// The share of the tiles of `before` whose edges look different in `after` beyond a change of light, which makes all of a
/// tile's edges brighter or darker alike; `None` where there are too few.
fn shifted_tiles(before: &Mat, after: &Mat, doubt: Doubt) -> opencv::Result<Option<f64>> {
    let (before, after) = (View::of(before)?, View::of(after)?);
    if (after.columns(), after.rows()) != (before.columns(), before.rows()) {
        return Ok(None);
    }
    let mut tiles = vec![Vec::<i16>::new(); TILES * TILES];
    on_edges(&before, &after, doubt.edge, |tile, change| tiles[tile].push(change));
    let enough = tiles.iter_mut().enumerate().filter(|(_, edges)| edges.len() >= FEWEST_EDGES);
    Ok(share(enough.map(|(tile, edges)| (tile, shifted(edges, doubt.moved)))))
}

/// The share of tiles, each by its number and whether it moved, that did; `None` where they are too few or too near together.
fn share(tiles: impl Iterator<Item = (usize, bool)>) -> Option<f64> {
    let (mut columns, mut count, mut moving) = ([false; TILES], 0usize, 0usize);
    for (tile, moved) in tiles {
        columns[tile % TILES] = true;
        count += 1;
        moving += usize::from(moved);
    }
    let wide = columns.iter().filter(|c| **c).count() >= FEWEST_COLUMNS;
    (wide && count >= FEWEST_TILES).then(|| moving as f64 / count as f64)
}

/// Whether the changes of a tile's edges differ among themselves.
fn shifted(changes: &mut [i16], least: u8) -> bool {
    let middle = changes.len() / 2;
    let light = *changes.select_nth_unstable(middle).1;
    let moved = changes.iter().filter(|change| (**change - light).abs() > i16::from(least)).count();
    moved as f64 > MOVED_EDGES * changes.len() as f64
}

/// The share of the tiles of `before` whose edges look different in `after`; `None` where there are too few.
fn moved_tiles(before: &Mat, after: &Mat) -> opencv::Result<Option<f64>> {
    let (before, after) = (View::of(before)?, View::of(after)?);
    let mut tiles = [(0usize, 0usize); TILES * TILES];
    on_edges(&before, &after, EDGE, |tile, change| {
        let (edges, moved) = &mut tiles[tile];
        *edges += 1;
        *moved += usize::from(change.unsigned_abs() > u16::from(MOVED));
    });
    let enough = tiles.iter().enumerate().filter(|(_, (edges, _))| *edges >= FEWEST_EDGES);
    Ok(share(enough.map(|(tile, (edges, moved))| (tile, *moved as f64 > MOVED_EDGES * *edges as f64))))
}

/// Calls `each` for every pixel of `before` that lies on an edge, with the number of its tile and by how much `after` is
/// brighter there. Green carries most of the brightness; every channel would only say the same again.
fn on_edges(before: &View<'_>, after: &View<'_>, edge: u8, mut each: impl FnMut(usize, i16)) {
    let (columns, rows) = (before.columns(), before.rows());
    let green = |view: &View<'_>, column: usize, row: usize| view.pixel(column, row)[1];
    for row in 1..rows - 1 {
        for column in 1..columns - 1 {
            let across = green(before, column - 1, row).abs_diff(green(before, column + 1, row));
            let down = green(before, column, row - 1).abs_diff(green(before, column, row + 1));
            if across.max(down) > edge {
                let change = i16::from(green(after, column, row)) - i16::from(green(before, column, row));
                each(row * TILES / rows * TILES + column * TILES / columns, change);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn somebody_who_walks_by_is_no_moving_camera() {
        let all_in =
            |columns: usize| (0..TILES * TILES).filter(move |tile| tile % TILES < columns).map(|tile| (tile, true));
        assert_eq!(share(all_in(2)), None);
        assert_eq!(share(all_in(6)), Some(1.0));
    }

    #[test]
    fn a_change_of_light_shifts_no_edges() {
        let mut brighter: Vec<i16> = (0..40).map(|i| 60 + i % 5).collect();
        let mut shifted_by_one: Vec<i16> = (0..40).map(|i| if i % 2 == 0 { 60 } else { -60 }).collect();
        assert!(!shifted(&mut brighter, MOVED) && shifted(&mut shifted_by_one, MOVED));
    }
}
