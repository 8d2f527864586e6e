//! Values before and after, side by side on one scale.

use maud::Markup;

use crate::view::html::axis::Axis;
use crate::view::html::series::Size;
use crate::view::html::svg::{Anchor, Svg, bold_width, text_width};

const ROW: f64 = 46.0;
/// From this ratio between greatest and least on, the scale goes by powers of ten.
const WIDE_RATIO: f64 = 12.0;

/// One row: a mark before, a dot after, both in words.
pub struct Pair {
    pub name: String,
    pub before: Option<f64>,
    pub after: f64,
    pub shown: String,
}

/// The rows, with a line that what is left should come near.
pub fn pairs(rows: &[Pair], floor: Option<(f64, &str)>, label: &str) -> Markup {
    let width = Size::Narrow.width();
    let values = || rows.iter().flat_map(|r| r.before.into_iter().chain([r.after])).chain(floor.map(|f| f.0));
    let least = values().filter(|v| *v > 0.0).fold(f64::INFINITY, f64::min);
    let most = values().fold(0.0, f64::max);
    let logarithmic = most > WIDE_RATIO * least;
    let of = |value: f64| if logarithmic { value.max(least).log10() } else { value };
    let low = if logarithmic { of(least) - 0.1 } else { 0.0 };
    let x = Axis::new((low, of(most)), (1.0, width - 8.0));
    let bottom = 4.0 + ROW * rows.len() as f64;
    let mut svg = Svg::new(width, bottom + 26.0);
    for (i, row) in rows.iter().enumerate() {
        let y = 4.0 + ROW * i as f64;
        let room = width - bold_width(&row.shown) - 14.0;
        svg.text("row", (0.0, y + 14.0), Anchor::Start, &fitting(&row.name, room));
        svg.text("value", (width, y + 14.0), Anchor::End, &row.shown);
        let line = y + 31.0;
        svg.line("grid", (x.places().0, line), (x.places().1, line));
        let after = x.at(of(row.after));
        if let Some(before) = row.before.map(|b| x.at(of(b))) {
            svg.line("rung after", (before, line), (after, line));
            svg.line("mark line before", (before, line - 9.0), (before, line + 9.0));
        }
        svg.dots("knob after", &[(after, line)]);
        if let Some((value, _)) = floor {
            svg.line("limit", (x.at(of(value)), line - 11.0), (x.at(of(value)), line + 11.0));
        }
    }
    let scale = if logarithmic { "log scale" } else { "linear scale from 0" };
    let text = floor.map_or_else(|| scale.into(), |(_, name)| format!("{scale}; dotted: {name}"));
    svg.text("name", (0.0, bottom + 18.0), Anchor::Start, &text);
    svg.finish("small", label)
}

/// As much of the end of a name as there is room for.
pub fn fitting(name: &str, room: f64) -> String {
    if text_width(name) <= room {
        return name.into();
    }
    let from = |&(start, _): &(usize, char)| text_width(&name[start..]) + text_width("\u{2026}") <= room;
    let start = name.char_indices().find(from).map_or(name.len(), |(start, _)| start);
    format!("\u{2026}{}", &name[start..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_keep_their_ends() {
        assert_eq!(fitting("short", 200.0), "short");
        let long = fitting("a_very_long_name_äöü_0001.csv", 90.0);
        assert!(long.starts_with('\u{2026}') && long.ends_with("01.csv") && text_width(&long) <= 90.0, "{long}");
        assert_eq!(fitting("name", 0.0), "\u{2026}");
    }
}
