//! The answer of `tunenet track` for readers.

use tunenet_core::observation::{Note, State};
use tunenet_video_protocol::track::{Estimate, Facts};

use crate::view::answer::Printout;

/// The answer for readers.
pub fn printout(name: &str, facts: &Facts, notes: &[Note]) -> Printout {
    let mut shown = Printout::default();
    let Facts { width_px, height_px, frames, fps, seen, whole, radius_px, .. } = facts;
    shown.row("video", &format!("{name}, {width_px} × {height_px} px, {frames} frames, {fps:.2} a second"));
    shown.row("ball", &format!("seen in {seen} frames, whole in {whole}, radius {radius_px:.1} px"));
    match &facts.scale {
        None => shown.row("scale", "none: the ball does not fly freely, and no length is given"),
        Some(scale) => shown.row("scale", &format!("{:.4} mm a pixel, by {}", 1e3 * scale.m_per_px, scale.words)),
    }
    let bounces: Vec<String> = facts.bounces_s.iter().map(|t| format!("{t:.3}")).collect();
    if !bounces.is_empty() {
        shown.row("bounces", &format!("{} s", bounces.join(", ")));
    }
    if let Some(Estimate { value, interval95: [low, high] }) = facts.rebound() {
        shown.row("rebound", &format!("{value:.3} of the speed (95 %: {low:.3}–{high:.3}), before any simulation"));
    }
    for check in facts.preflight.iter().filter(|check| check.state == State::Failed) {
        shown.row("unusable", &check.text);
    }
    shown.warn_all(notes);
    shown
}
