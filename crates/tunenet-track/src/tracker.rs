//! Tracking by prediction: the ball is searched near its predicted position, or in the whole frame after it was lost.

use super::ball_colour::{ROUND, Scene};
use super::blob::{Blob, blobs};
use super::lookup::Lookup;
use super::outline::{Edges, outline};
use super::stillness::MOVED;
use super::view::View;
use tunenet_core::statistics::median;

/// The longer side of the coarse picture in which a lost ball is looked for, px.
const SEARCH_PX: usize = 480;
/// A followed ball is looked for in a coarse picture in which its radius is about so many px.
const FOLLOW_RADIUS_PX: f64 = 10.0;
/// After so many frames the whole picture is looked at again, so that a second ball is not missed.
const LOOK_AROUND: usize = 8;
/// A second patch of at least this share of the first one's area is a second ball.
const SECOND_BALL: f64 = 0.5;
/// ... where their middles lie farther apart than so many radii.
const SEPARATION: f64 = 2.0;
/// From frame to frame the ball's area changes by no more than this factor; beyond, it is looked for everywhere.
const SAME_AREA: f64 = 2.5;
/// A video whose edges are no more gradual than this is sharp, px: nothing but its pixels blurs it.
const SHARP_PX: f64 = 0.34;
/// So many frames determine whether it is.
const ASKED: usize = 9;
/// Fewer pixels of the coarse picture are crumbs.
const LEAST_AREA: f64 = 3.0;

/// The ball in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Which frame, from 0.
    pub frame: usize,
    /// When it was taken, s.
    pub time_s: f64,
    /// The centre, px to the right from the centre of the first pixel.
    pub u_px: f64,
    /// The centre, px downwards.
    pub v_px: f64,
    /// The radius, px.
    pub radius_px: f64,
    /// Whether the frame's border cuts the ball.
    pub cut: bool,
    /// How much it looks like the ball, 0 to 1: how much of its edge lies on a circle, and how near its size is to the
    /// usual one.
    pub confidence: f64,
    /// Whether something else in the frame looks alike; `None` if it was not examined.
    pub(crate) second: Option<bool>,
    /// How far its edge lies off the circle, as a share of the radius; `None` where it has no outline.
    pub(crate) off: Option<f64>,
}

/// Follows one ball.
#[derive(Debug)]
pub struct Tracker {
    scene: Scene,
    lookup: Lookup,
    last: Option<Last>,
    since_around: usize,
    mask: Vec<bool>,
    /// How gradual the ball's edge was in some of the frames, px.
    softness_px: Vec<f64>,
    /// From the patch to the outline in the last frame, as shares of the patch's radius: right, down, and how much larger.
    /// A ball's dark side may not have its colour.
    offset: (f64, f64, f64),
}

/// Where the ball was.
#[derive(Debug, Clone, Copy)]
struct Last {
    u: f64,
    v: f64,
    radius: f64,
    /// Motion from the frame before, px; `None` right after it was found.
    step: Option<(f64, f64)>,
}

/// A part of a picture, thinned: columns and rows of every `every`-th pixel from `left`, `top` on.
#[derive(Debug, Clone, Copy)]
struct Part {
    left: usize,
    top: usize,
    columns: usize,
    rows: usize,
    every: usize,
}

impl Part {
    fn whole(view: &View<'_>) -> Self {
        let every = view.columns().max(view.rows()).div_ceil(SEARCH_PX);
        Self { left: 0, top: 0, columns: view.columns().div_ceil(every), rows: view.rows().div_ceil(every), every }
    }

    /// Whether a box of the part lies at a border of the part, and at one of the picture.
    fn borders(&self, [left, top, width, height]: [usize; 4], view: &View<'_>) -> (bool, bool) {
        let (right, bottom) = (left + width, top + height);
        let part = [left == 0, top == 0, right >= self.columns, bottom >= self.rows];
        let last = |at: usize, count: usize| at + (count - 1) * self.every + self.every;
        let picture = [
            self.left == 0,
            self.top == 0,
            last(self.left, self.columns) >= view.columns(),
            last(self.top, self.rows) >= view.rows(),
        ];
        let (mut inner, mut outer) = (false, false);
        for (part, picture) in part.into_iter().zip(picture) {
            inner |= part && !picture;
            outer |= part && picture;
        }
        (inner, outer)
    }
}

impl Tracker {
    /// A tracker for the ball of `scene`.
    #[must_use]
    pub fn new(scene: Scene) -> Self {
        let lookup = Lookup::new(&scene.window);
        Self {
            scene,
            lookup,
            last: None,
            since_around: 0,
            mask: Vec::new(),
            softness_px: Vec::new(),
            offset: (0.0, 0.0, 0.0),
        }
    }

    /// What it looks for.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The ball in the next frame; its number and time are the caller's to fill in.
    ///
    /// # Errors
    /// Where OpenCV fails.
    pub fn look(&mut self, view: &View<'_>) -> opencv::Result<Option<Sighting>> {
        let around = self.last.is_none() || self.since_around + 1 >= LOOK_AROUND;
        let mut found = match self.last {
            Some(last) => self.follow(view, last)?,
            None => None,
        };
        let mut second = None;
        if found.is_none() || around {
            let anywhere = self.search(view)?;
            second = anywhere.map(|(.., second)| second);
            if let (None, Some((part, coarse, _))) = (found, anywhere) {
                found = Some(self.refine(view, part, &coarse));
            }
            self.since_around = 0;
        } else {
            self.since_around += 1;
        }
        self.last = found.map(|s| Last {
            u: s.u_px,
            v: s.v_px,
            radius: s.radius_px,
            step: self.last.map(|l| (s.u_px - l.u, s.v_px - l.v)),
        });
        Ok(found.map(|s| Sighting { second, ..s }))
    }

    /// Looks where the ball must be by now.
    fn follow(&mut self, view: &View<'_>, last: Last) -> opencv::Result<Option<Sighting>> {
        let (across, down) = last.step.unwrap_or_default();
        let (u, v) = (last.u + across, last.v + down);
        // As far again as it went, since it may have bounced; further where nothing is known of its speed.
        let reach = 1.6 * last.radius + 4.0 + if last.step.is_some() { across.hypot(down) } else { 3.0 * last.radius };
        let Some(part) = part(view, (u, v), reach, last.radius) else { return Ok(None) };
        let area = std::f64::consts::PI * (last.radius / part.every as f64).powi(2);
        let found = self.blobs(view, part)?;
        let alike = |b: &&Blob| {
            let (inner, outer) = part.borders(b.bounds, view);
            let same = b.area < SAME_AREA * area && (outer || b.area * SAME_AREA > area);
            same && !inner && (outer || ROUND.contains(&b.fill()))
        };
        let Some(coarse) = found.iter().find(alike) else { return Ok(None) };
        Ok(Some(self.refine(view, part, coarse)))
    }

    /// Looks everywhere; also whether there is a second one alike.
    fn search(&mut self, view: &View<'_>) -> opencv::Result<Option<(Part, Blob, bool)>> {
        let part = Part::whole(view);
        let mut found = self.blobs(view, part)?;
        let area =
            self.scene.area_share * view.columns() as f64 * view.rows() as f64 / (part.every * part.every) as f64;
        // Crumbs of noise are no ball, but a ball that is half out of view still is.
        found.retain(|b| b.area >= (0.05 * area).max(LEAST_AREA));
        let round = |b: &&Blob| ROUND.contains(&b.fill()) || part.borders(b.bounds, view).1;
        let Some(coarse) = found.iter().find(round).or(found.first()) else { return Ok(None) };
        // Two halves of one ball with a stripe lie nearer to each other than two balls can.
        let apart = SEPARATION * (coarse.area / std::f64::consts::PI).sqrt();
        let alike = |b: &&Blob| b.area > SECOND_BALL * coarse.area && (b.u - coarse.u).hypot(b.v - coarse.v) > apart;
        let second = found.iter().filter(round).any(|b| alike(&b));
        Ok(Some((part, *coarse, second)))
    }

    /// The patches of the ball's colour in a part of the picture, the largest first.
    fn blobs(&mut self, view: &View<'_>, part: Part) -> opencv::Result<Vec<Blob>> {
        let background = if self.scene.clutter { Some(View::of(&self.scene.background)?) } else { None };
        self.mask.clear();
        for row in 0..part.rows {
            let y = part.top + row * part.every;
            let pixels = view.thinned(y, part.left, part.every, part.columns);
            match background {
                None => self.mask.extend(pixels.map(|pixel| self.lookup.holds(pixel))),
                Some(behind) => self.mask.extend(pixels.enumerate().map(|(column, pixel)| {
                    let x = part.left + column * part.every;
                    self.lookup.holds(pixel) && moved(pixel, behind_at(&behind, view, x, y))
                })),
            }
        }
        Ok(blobs(&self.mask, part.columns))
    }

    /// A coarse patch, measured in the whole picture.
    fn refine(&mut self, view: &View<'_>, part: Part, coarse: &Blob) -> Sighting {
        let every = part.every as f64;
        let [_, _, width, height] = coarse.bounds.map(|n| n as f64);
        let (u, v) = (part.left as f64 + coarse.u * every, part.top as f64 + coarse.v * every);
        let by_area = (coarse.area / std::f64::consts::PI).sqrt() * every;
        let (_, outer) = part.borders(coarse.bounds, view);
        // A smeared disc is longer than wide.
        let smear = if outer { 0.0 } else { 0.5 * every * (width - height).abs() };
        let guess = if outer { by_area.max(0.5 * every * width.max(height)) } else { by_area };
        let seen = |u: f64, v: f64, radius: f64, cut: bool, confidence: f64| Sighting {
            frame: 0,
            time_s: 0.0,
            u_px: u,
            v_px: v,
            radius_px: radius,
            cut,
            confidence,
            second: None,
            off: None,
        };
        let background = if self.scene.clutter { View::of(&self.scene.background).ok() } else { None };
        let own = |colour: [u8; 3], (u, v): (f64, f64)| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the picture")]
            let place = (u as usize, v as usize);
            self.lookup.holds(colour)
                && background.is_none_or(|behind| moved(colour, behind_at(&behind, view, place.0, place.1)))
        };
        if self.softness_px.len() < ASKED && (self.last.is_none() || self.since_around == 0) {
            let found = outline(view, &own, (u, v, guess), Edges { smear_px: smear, sharp: false });
            self.softness_px.extend(found.filter(|c| !c.cut).map(|c| c.softness_px));
        }
        let sharp = median(self.softness_px.clone()).is_some_and(|soft| soft < SHARP_PX);
        // A sharp ball lies to its patch as it did before. A blurred one's patch is too rough for that.
        let known = sharp && !outer && self.last.is_some();
        let (right, down, larger) = if known { self.offset } else { (0.0, 0.0, 0.0) };
        let start = (u + right * guess, v + down * guess, guess + larger * guess);
        let circle = outline(view, &own, start, Edges { smear_px: smear, sharp });
        // A circle far from its patch is drawn through something else.
        let near = circle.filter(|c| {
            let room = if outer { 2.0 } else { 0.5 };
            (c.u - u).hypot(c.v - v) < room * guess + 2.0 && (0.5..2.0).contains(&(c.radius / guess))
        });
        let Some(c) = near else {
            // Too small or too faint for an outline.
            self.offset = (0.0, 0.0, 0.0);
            return seen(u, v, by_area, outer, 0.25);
        };
        let cut = c.cut || outer;
        self.offset = ((c.u - u) / guess, (c.v - v) / guess, (c.radius - guess) / guess);
        let confidence = if cut { 0.5 * c.share } else { c.share };
        Sighting { off: Some(c.off), ..seen(c.u, c.v, c.radius, cut, confidence) }
    }
}

/// A part of the picture about a point, thinned so that a ball of `radius` stays small in it.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "pixels of a picture, clamped")]
fn part(view: &View<'_>, (u, v): (f64, f64), reach: f64, radius: f64) -> Option<Part> {
    let every = (radius / FOLLOW_RADIUS_PX).floor().max(1.0) as usize;
    let low = |at: f64| (at - reach).floor().max(0.0) as usize;
    let high = |at: f64, most: usize| ((at + reach).ceil().max(0.0) as usize + 1).min(most);
    let (left, top) = (low(u), low(v));
    let (right, bottom) = (high(u, view.columns()), high(v, view.rows()));
    (right > left + 1 && bottom > top + 1).then(|| Part {
        left,
        top,
        columns: (right - left).div_ceil(every),
        rows: (bottom - top).div_ceil(every),
        every,
    })
}

/// Whether a pixel differs from the one behind.
fn moved(pixel: [u8; 3], behind: [u8; 3]) -> bool {
    pixel.iter().zip(behind).any(|(a, b)| a.abs_diff(b) > MOVED)
}

/// The pixel of the small background behind a place in the whole picture.
fn behind_at(small: &View<'_>, view: &View<'_>, x: usize, y: usize) -> [u8; 3] {
    let column = (x * small.columns() / view.columns()).min(small.columns() - 1);
    let row = (y * small.rows() / view.rows()).min(small.rows() - 1);
    small.pixel(column, row)
}
