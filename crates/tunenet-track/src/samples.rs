//! Small pictures of a video, mostly of the part with motion: the input of colour detection.

use opencv::core::{Mat, MatTraitConst, Size};
use opencv::imgproc::{INTER_LINEAR, resize};

use super::view::View;

/// The longer side of the small pictures that are kept, px.
const SMALL_PX: i32 = 400;
/// Pictures that are kept of what changes ...
const MOST_CHANGING: usize = 48;
/// ... and evenly over the video.
const MOST_EVEN: usize = 24;
/// Fewer pictures with changes do not determine what moves.
const FEWEST_CHANGING: usize = 8;
/// So many pictures of a video are examined for changes.
const LOOKED_AT: usize = 400;
/// Points that are compared, along the longer side; each is the mean of four pixels.
const POINTS: usize = 128;
/// How far a point has to change to show something new, in grey levels of any channel ...
const CHANGED: u8 = 16;
/// ... and in medians of what noise changes in all points.
const CHANGED_NOISE: f64 = 5.0;
/// Fewer points than this share are noise.
const CHANGED_SHARE: f64 = 3e-4;

/// Reduces `frame` so that its longer side has at most [`SMALL_PX`].
pub(crate) fn reduced(frame: &Mat) -> opencv::Result<Mat> {
    let longer = frame.cols().max(frame.rows());
    if longer <= SMALL_PX {
        return frame.try_clone();
    }
    let factor = f64::from(SMALL_PX) / f64::from(longer);
    let mut small = Mat::default();
    resize(frame, &mut small, Size::default(), factor, factor, INTER_LINEAR)?;
    Ok(small)
}

/// Small pictures of a video, however long it is. A ball that lies still for most of it is in few of them, so that it is not
/// taken for background.
#[derive(Default)]
pub(crate) struct Samples {
    changing: Thinned,
    even: Thinned,
    /// What the last picture among the changing ones shows.
    last: Vec<[u8; 3]>,
}

impl Samples {
    /// Takes in picture `index`, where it is needed; `promised` pictures are to come in all.
    pub fn push(&mut self, index: usize, image: &Mat, promised: Option<usize>) -> opencv::Result<()> {
        let all = promised.unwrap_or(1);
        self.even.stride = self.even.stride.max(all.div_ceil(MOST_EVEN));
        let even = index.is_multiple_of(self.even.stride);
        let new = index.is_multiple_of((all / LOOKED_AT).max(1)) && self.shows_something_new(image)?;
        let new = new && self.changing.wants_next();
        if even || new {
            let small = reduced(image)?;
            if even {
                self.even.keep(index, small.clone(), MOST_EVEN);
            }
            if new {
                self.changing.keep(index, small, MOST_CHANGING);
            }
        }
        Ok(())
    }

    /// The most informative ones: those with changes, or all if there are hardly any.
    pub fn telling(&self) -> &[Mat] {
        if self.changing.kept.len() < FEWEST_CHANGING { &self.even.kept } else { &self.changing.kept }
    }

    /// All of them with their positions in the video, in order.
    pub fn placed(&self) -> Vec<(usize, &Mat)> {
        let mut all: Vec<(usize, &Mat)> = [&self.even, &self.changing]
            .into_iter()
            .flat_map(|kept| kept.places.iter().copied().zip(&kept.kept))
            .collect();
        all.sort_by_key(|(place, _)| *place);
        all.dedup_by_key(|(place, _)| *place);
        all
    }

    /// Whether `image` differs from the last one that did.
    fn shows_something_new(&mut self, image: &Mat) -> opencv::Result<bool> {
        let now = points(&View::of(image)?);
        let new = now.len() != self.last.len() || changed(&now, &self.last);
        if new {
            self.last = now;
        }
        Ok(new)
    }
}

/// Pictures of which every second goes when they are too many.
#[derive(Default)]
struct Thinned {
    kept: Vec<Mat>,
    places: Vec<usize>,
    stride: usize,
    passed: usize,
}

impl Thinned {
    /// Whether the picture that is offered now is one that is kept: every `stride`-th.
    fn wants_next(&mut self) -> bool {
        self.stride = self.stride.max(1);
        let wanted = self.passed.is_multiple_of(self.stride);
        self.passed += 1;
        wanted
    }

    fn keep(&mut self, index: usize, small: Mat, most: usize) {
        self.kept.push(small);
        self.places.push(index);
        if self.kept.len() > most {
            self.halve();
        }
    }

    fn halve(&mut self) {
        let mut place = 0;
        self.kept.retain(|_| {
            place += 1;
            place % 2 == 1
        });
        self.places = self.places.iter().copied().step_by(2).collect();
        self.stride *= 2;
    }
}

/// Means of four pixels each, on a grid over the picture.
fn points(view: &View<'_>) -> Vec<[u8; 3]> {
    let every = view.columns().max(view.rows()).div_ceil(POINTS).max(2);
    let (columns, rows) = (view.columns().saturating_sub(1), view.rows().saturating_sub(1));
    let mut points = Vec::with_capacity(columns.div_ceil(every) * rows.div_ceil(every));
    for row in (0..rows).step_by(every) {
        for column in (0..columns).step_by(every) {
            let [a, b] = [view.pixel(column, row), view.pixel(column + 1, row)];
            let [c, d] = [view.pixel(column, row + 1), view.pixel(column + 1, row + 1)];
            let mean = |i: usize| {
                let sum = u16::from(a[i]) + u16::from(b[i]) + u16::from(c[i]) + u16::from(d[i]);
                u8::try_from((sum + 2) / 4).unwrap_or(u8::MAX)
            };
            points.push([mean(0), mean(1), mean(2)]);
        }
    }
    points
}

/// Whether more differs than noise does.
fn changed(now: &[[u8; 3]], before: &[[u8; 3]]) -> bool {
    let mut counts = [0usize; 256];
    for (a, b) in now.iter().zip(before) {
        let most = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        counts[usize::from(most)] += 1;
    }
    let mut below = 0;
    let median = counts.iter().position(|count| {
        below += count;
        2 * below >= now.len()
    });
    let limit = f64::from(CHANGED).max(CHANGED_NOISE * median.unwrap_or(0) as f64);
    let beyond: usize = counts.iter().enumerate().filter(|(level, _)| *level as f64 > limit).map(|(_, n)| n).sum();
    beyond as f64 > CHANGED_SHARE * now.len() as f64
}
