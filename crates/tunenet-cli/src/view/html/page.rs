//! The frame of every page.

use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::view::text::lines;
use tunenet_formats::Result;
use tunenet_formats::write_atomically;

const STYLE: &str = include_str!("style.css");
/// By this a page is known as one of ours, within its first lines.
const GENERATOR: &str = concat!("tunenet ", env!("CARGO_PKG_VERSION"));

/// A page of this kind ("Tuning report") and title, complete in itself.
pub fn page(kind: &str, title: &str, body: &Markup) -> String {
    let whole = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="generator" content=(GENERATOR);
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) " \u{b7} " (kind) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    p.kind { (kind) }
                    h1 { (title) }
                }
                main { (body) }
                footer {
                    p { "Written by tunenet " (env!("CARGO_PKG_VERSION")) ". This page is complete in itself: nothing in it is \
                         fetched or run." }
                }
            }
        }
    };
    // Names of a stranger's files, topics and objects come with whatever they hold.
    let mut text = lines(&whole.into_string());
    text.push('\n');
    text
}

/// Writes a page where it replaces an older one at once or not at all.
pub fn write(path: &Path, page: &str) -> Result<()> {
    write_atomically(path, |file| file.write_all(page.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::{STYLE, page};
    use crate::files::destination::is_page;

    /// The variables of the three schemes, in the order of the style sheet: light, dark, print.
    fn schemes() -> Vec<Vec<(String, String)>> {
        let blocks = STYLE.split(":root {").skip(1).map(|rest| rest.split('}').next().unwrap());
        let variable = |entry: &str| {
            let (name, value) = entry.split_once(':')?;
            name.trim().strip_prefix("--").map(|n| (n.to_string(), value.trim().to_string()))
        };
        blocks.map(|block| block.split(';').filter_map(variable).collect()).collect()
    }

    /// Relative luminance of `#rrggbb` or `#rgb`, by the Web Content Accessibility Guidelines 2.2.
    fn luminance(colour: &str) -> f64 {
        let digits = colour.trim_start_matches('#');
        let wide = digits.len() == 6;
        let channel = |i: usize| {
            let text = if wide { digits[2 * i..2 * i + 2].to_string() } else { digits[i..=i].repeat(2) };
            let value = f64::from(u8::from_str_radix(&text, 16).unwrap()) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2)
    }

    fn contrast(a: &str, b: &str) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn a_page_is_known_by_its_beginning() {
        let page = page("Tuning report", "drop", &maud::html! { "text" });
        assert!(is_page(&page[..1024]) && !is_page("<!DOCTYPE html><html><head><title>Mine</title>"));
    }

    #[test]
    fn text_and_marks_stand_out_in_every_scheme() {
        assert!((contrast("#fff", "#000000") - 21.0).abs() < 1e-9);
        let schemes = schemes();
        assert_eq!(schemes.len(), 3);
        for scheme in &schemes {
            let of = |name: &str| scheme.iter().find(|v| v.0 == name).unwrap().1.clone();
            for behind in ["paper", "card", "band"] {
                for text in ["ink", "soft", "before-text", "after-text"] {
                    let found = contrast(&of(text), &of(behind));
                    assert!(found >= 4.5, "{text} on {behind}: {found:.2}");
                }
                for mark in ["before", "after", "axis"] {
                    let found = contrast(&of(mark), &of(behind));
                    assert!(found >= 3.0, "{mark} on {behind}: {found:.2}");
                }
            }
        }
    }
}
