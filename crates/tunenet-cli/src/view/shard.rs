//! What a finished shard answers.

use std::path::Path;

use serde_json::json;
use tunenet_core::network::Shard;
use tunenet_formats::Result;

use super::answer::Printout;
use super::json::warning;
use super::text::stage;
use crate::files::names;
use crate::shard::Share;

/// Prints that a shard is finished.
///
/// # Errors
/// As [`Printout::show`].
pub fn show(shard: Shard, at: &Path, share: Share, what: &str, as_json: bool) -> Result<()> {
    let Share { pieces, .. } = share;
    let note = share.noted(shard);
    let mut shown = Printout::default();
    stage("wrote", &format!("{}, shard {shard}, {pieces} {what}", at.display()));
    shown.warn_all(&note);
    shown.show(as_json, || {
        json!({
            "schema": "tunenet.shard/1", "file": names::file_name(at), "shard": shard.to_string(), "pieces": pieces,
            "warnings": note.iter().map(warning).collect::<Vec<_>>(),
        })
    })
}
