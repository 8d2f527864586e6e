//! The file next to a written model, with what the model's format cannot express.

use anyhow::{Context, Result};
use tunenet_formats::shown_path;
use tunenet_models::export::is_sidecar;

use super::put;
use crate::args::Models;
use crate::view::text::stage;

/// Writes `text`, which holds what is `listed`; without any, removes what another run left there.
///
/// # Errors
/// Where the system refuses.
pub fn write(options: &Models, text: &str, listed: &str) -> Result<()> {
    let Some(path) = options.sidecar() else { return Ok(()) };
    if !text.is_empty() {
        put(&path, text)?;
        stage("effects", &format!("{}: the model cannot express {listed}", shown_path(&path)));
    } else if std::fs::read_to_string(&path).is_ok_and(|there| is_sidecar(&there)) {
        // It would say of this model what does not hold.
        std::fs::remove_file(&path).with_context(|| format!("removing {}", shown_path(&path)))?;
        stage("removed", &format!("{}: this model expresses everything", shown_path(&path)));
    }
    Ok(())
}
