//! Trained networks and checkpoints as files.

mod file;
mod safetensors;
#[cfg(test)]
mod tests;
mod training;

pub use file::{load_model, model_from_bytes, model_to_bytes, save_model};
pub use training::train_file;
