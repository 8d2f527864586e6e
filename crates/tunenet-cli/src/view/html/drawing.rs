//! A drawing that is a file of its own, with its style inside.

use super::svg::Svg;

/// What every such drawing shares: light ground, grid, frame, texts.
const STYLE: &str = "svg{background:#fff}text{font-family:sans-serif;fill:#222}.t{font-size:14px;font-weight:bold}\
                     .s{font-size:12px}.middle{text-anchor:middle}.end{text-anchor:end}.g{stroke:#ddd;fill:none}\
                     .f{stroke:#888;fill:none}";

/// The text of the file; `style` is added to what all share.
pub fn file(svg: Svg, label: &str, style: &str) -> String {
    let drawn = svg.finish("figure", label).into_string();
    let open = drawn.find('>').map_or(0, |i| i + 1);
    let head = drawn[..open].replacen("<svg ", "<svg xmlns=\"http://www.w3.org/2000/svg\" ", 1);
    format!("{head}<style>{STYLE}{style}</style>{}\n", &drawn[open..])
}
