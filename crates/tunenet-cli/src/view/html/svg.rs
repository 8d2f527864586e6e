//! Shapes as text. Colours, widths and dashes are the style sheet's; here are only classes and places.

use std::fmt::Write;

use maud::{Markup, PreEscaped, html};

/// A point of a drawing, in its own units, y downwards.
pub type Spot = (f64, f64);

/// Where a text stands from its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// It begins there.
    Start,
    /// It is centred there.
    Middle,
    /// It ends there.
    End,
}

/// A drawing that grows.
pub struct Svg {
    /// Units across.
    pub width: f64,
    /// Units down.
    pub height: f64,
    body: String,
}

impl Svg {
    /// An empty drawing.
    #[must_use]
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    /// A straight line.
    pub fn line(&mut self, class: &str, from: Spot, to: Spot) {
        self.path(class, &[from, to], false);
    }

    /// Straight pieces from point to point.
    pub fn path(&mut self, class: &str, points: &[Spot], closed: bool) {
        let mut d = String::new();
        let mut before = (0, 0);
        for (i, point) in points.iter().enumerate() {
            let (x, y) = (tenths(point.0), tenths(point.1));
            // Points that fall together are drawn once.
            if i == 0 {
                write(&mut d, format_args!("M{} {}", shown(x), shown(y)));
            } else if (x, y) != before || points.len() == 2 {
                write(&mut d, format_args!("l{} {}", shown(x - before.0), shown(y - before.1)));
            }
            before = (x, y);
        }
        if closed {
            d.push('z');
        }
        write(&mut self.body, format_args!(r#"<path class="{class}" d="{d}"></path>"#));
    }

    /// Round dots: strokes without length whose ends are round.
    pub fn dots(&mut self, class: &str, points: &[Spot]) {
        let mut d = String::new();
        for point in points {
            write(&mut d, format_args!("M{} {}h0", shown(tenths(point.0)), shown(tenths(point.1))));
        }
        write(&mut self.body, format_args!(r#"<path class="{class}" d="{d}"></path>"#));
    }

    /// A filled rectangle.
    pub fn area(&mut self, class: &str, (left, top): Spot, (right, bottom): Spot) {
        let (x, y) = (tenths(left.min(right)), tenths(top.min(bottom)));
        let (w, h) = (tenths((right - left).abs()), tenths((bottom - top).abs()));
        let (x, y, w, h) = (shown(x), shown(y), shown(w), shown(h));
        write(
            &mut self.body,
            format_args!(r#"<rect class="{class}" x="{x}" y="{y}" width="{w}" height="{h}"></rect>"#),
        );
    }

    /// A line of text.
    pub fn text(&mut self, class: &str, at: Spot, anchor: Anchor, text: &str) {
        let (x, y) = (shown(tenths(at.0)), shown(tenths(at.1)));
        let class = match anchor {
            Anchor::Start => class.to_string(),
            Anchor::Middle => format!("{class} middle"),
            Anchor::End => format!("{class} end"),
        };
        let element = html! { text class=(class.trim_start()) x=(x) y=(y) { (text) } };
        self.body.push_str(&element.0);
    }

    /// The drawing, with a sentence for those who cannot see it.
    pub fn finish(self, class: &str, label: &str) -> Markup {
        let size = format!("0 0 {} {}", shown(tenths(self.width)), shown(tenths(self.height)));
        html! { svg class=(class) viewBox=(size) role="img" aria-label=(label) { (PreEscaped(self.body)) } }
    }
}

/// How wide a text is at most, in fonts that are no wider than common ones (`DejaVu Sans` at 13 units).
pub fn text_width(text: &str) -> f64 {
    let width = |c: char| match c {
        '.' | ',' | ':' | ' ' | '\u{a0}' | 'i' | 'j' | 'l' | '|' | '\'' => 4.6,
        'm' | 'w' | 'M' | 'W' | '%' | '+' | '\u{2212}' | '\u{2026}' => 12.7,
        _ => 8.3,
    };
    text.chars().map(width).sum()
}

/// How wide a text in bold type is at most.
pub fn bold_width(text: &str) -> f64 {
    1.12 * text_width(text)
}

#[expect(clippy::cast_possible_truncation, reason = "a place in a drawing; the cast saturates")]
fn tenths(value: f64) -> i64 {
    (value * 10.0).round() as i64
}

fn shown(tenths: i64) -> String {
    let sign = if tenths < 0 { "-" } else { "" };
    let size = tenths.unsigned_abs();
    if size.is_multiple_of(10) { format!("{sign}{}", size / 10) } else { format!("{sign}{}.{}", size / 10, size % 10) }
}

fn write(text: &mut String, what: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    let _ = text.write_fmt(what);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_texts_escaped() {
        let mut svg = Svg::new(10.0, 10.0);
        svg.path("a", &[(0.04, 0.0), (0.5, -0.26), (0.5, -0.26), (3.0, 1.0)], false);
        svg.dots("b", &[(-0.04, 2.0)]);
        svg.text("", (1.0, 1.0), Anchor::End, "<img>");
        let text = svg.finish("c", "\"quoted\"").0;
        assert!(text.contains(r#"d="M0 0l0.5 -0.3l2.5 1.3""#), "{text}");
        assert!(
            text.contains("M0 2h0") && text.contains("&lt;img&gt;") && text.contains("&quot;quoted&quot;"),
            "{text}"
        );
    }
}
