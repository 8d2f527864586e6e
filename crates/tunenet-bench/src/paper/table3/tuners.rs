//! Who tunes.

use anyhow::{Context, Result};
use tunenet_core::network::{Model, Preset, TrainOptions};
use tunenet_core::simulator::Prepared;
use tunenet_core::tune::{Loop, walk};
use tunenet_formats::{load_model, save_model, train_file};

use super::super::super::process;
use super::super::super::resume::Store;
use super::super::super::tuning::apex;
use super::drops::{Drops, RecordedDrop};
use crate::goals::{Distance, POSITIONS, VIDEO_FITTED, VIDEO_NETWORK};
use tunenet_video_protocol::synthetic::{Places, SyntheticTrack};

/// Rollouts that each may spend.
const ROLLOUTS: usize = 5;

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table3Title {
    pub key: &'static str,
    pub words: &'static str,
    /// Whether the video is degraded.
    pub degraded: bool,
    /// What the paper states, cm and percent.
    pub published: Option<(f64, Option<f64>)>,
    /// Greatest mean distance, cm, percent and error of the restitution that are aimed at.
    pub goal: Option<Distance>,
}

const fn row(key: &'static str, words: &'static str) -> Table3Title {
    Table3Title { key, words, degraded: false, published: None, goal: None }
}

/// What a tuner says of a drop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DropEstimate {
    Restitution(f64),
    /// Nothing is simulated at all.
    Nothing,
    /// No ball was found in the video, or no fall.
    Refused,
}

/// The networks of one seed.
pub struct DropTuners {
    gt_paper: Model,
    gt_default: Model,
    obs_paper: Model,
    obs_default: Model,
}

impl DropTuners {
    pub const ROWS: [Table3Title; 14] = [
        Table3Title { published: Some((97.0, Some(100.0))), ..row("zero", "zero: nothing is predicted") },
        Table3Title { published: Some((13.8, None)), ..row("untuned", "the proposed restitution") },
        Table3Title { published: Some((0.7, Some(1.08))), ..row("gt_paper", "positions, preset `paper`") },
        Table3Title { goal: Some(POSITIONS), ..row("gt_default", "positions, preset `default`") },
        Table3Title { published: Some((5.7, Some(6.03))), ..row("obs_paper", "video, preset `paper`") },
        Table3Title { goal: Some(VIDEO_NETWORK), ..row("obs_network", "video, preset `default`, the network alone") },
        Table3Title {
            goal: Some(VIDEO_FITTED),
            ..row("obs_default", "video, preset `default`, the camera fitted as well")
        },
        row("apex_pixels", "video, apex rule on raw pixels"),
        row("apex_camera", "video, apex rule after the camera of the first fall"),
        Table3Title { degraded: true, ..row("obs_paper_spoilt", "degraded video, preset `paper`") },
        Table3Title {
            degraded: true,
            ..row("obs_network_spoilt", "degraded video, preset `default`, the network alone")
        },
        Table3Title {
            degraded: true,
            ..row("obs_default_spoilt", "degraded video, preset `default`, the camera fitted as well")
        },
        Table3Title { degraded: true, ..row("apex_pixels_spoilt", "degraded video, apex rule on raw pixels") },
        Table3Title {
            degraded: true,
            ..row("apex_camera_spoilt", "degraded video, apex rule after the camera of the first fall")
        },
    ];

    pub fn make(store: &Store, seed: u64, quick: bool) -> Result<Self> {
        let model = |domain, preset: Preset, pairs, count| trained(store, domain, &preset, (pairs, count), seed, quick);
        Ok(Self {
            gt_paper: model("ball", Preset::paper(), "easy", "800")?,
            gt_default: model("ball", Preset::default(), "wide", "1000")?,
            obs_paper: model("ball-video", Preset::paper(), "easy", "800")?,
            obs_default: model("ball-video", Preset::default(), "wide", "2000")?,
        })
    }

    /// The restitution, after at most [`ROLLOUTS`].
    pub fn estimate(
        &self,
        key: &str,
        drops: &Drops,
        drop: &RecordedDrop,
        video: &SyntheticTrack,
    ) -> Result<DropEstimate> {
        let whole = Loop { iterations: ROLLOUTS, clamp: true, secant: true, best: true, library: true };
        let alone = Loop { secant: false, best: false, library: false, ..whole };
        match key {
            "zero" => return Ok(DropEstimate::Nothing),
            "untuned" => return Ok(DropEstimate::Restitution(drop.proposed)),
            "gt_paper" => return along(drops, drop, &self.gt_paper, &drops.positions(drop)?, alone),
            "gt_default" => return along(drops, drop, &self.gt_default, &drops.positions(drop)?, whole),
            _ => {}
        }
        let SyntheticTrack::Tracked(track) = video else { return Ok(DropEstimate::Refused) };
        if key.starts_with("apex_pixels") {
            return Ok(DropEstimate::Restitution(apex_of_pixels(drops, drop, track)));
        }
        // A track in which no camera could see the fall is refused as a video without a ball is.
        let Ok(seen) = drops.video(drop, track) else { return Ok(DropEstimate::Refused) };
        match key.trim_end_matches("_spoilt") {
            "obs_paper" => along(drops, drop, &self.obs_paper, &seen, alone),
            "obs_network" => along(drops, drop, &self.obs_default, &seen, alone),
            "obs_default" => along(drops, drop, &self.obs_default, &seen, whole),
            "apex_camera" => {
                let radius_m = drops.video.radius_m();
                let heights: Vec<f64> = seen.seen.column(2).map(|z| z - radius_m).collect();
                Ok(DropEstimate::Restitution(apex(drop.top_m - radius_m, drops.video.clock(), &heights)))
            }
            other => anyhow::bail!("`{other}` is no row of this table"),
        }
    }
}

/// Where a network's loop ends.
fn along(drops: &Drops, drop: &RecordedDrop, model: &Model, seen: &Prepared, how: Loop) -> Result<DropEstimate> {
    let walk = walk(drops.video.ball(), seen, model, &drops.start(drop, seen), how)?;
    Ok(DropEstimate::Restitution(walk.point.parameters[0]))
}

/// The apex rule as if pixels were heights: the deepest place seen is the floor, the first the top.
fn apex_of_pixels(drops: &Drops, drop: &RecordedDrop, track: &Places) -> f64 {
    let fall_m = drop.top_m - drops.video.radius_m();
    let floor = track.v_px.iter().copied().fold(f64::MIN, f64::max);
    let unit = fall_m / (floor - track.v_px[0]);
    let heights: Vec<f64> = track.v_px.iter().map(|v| (floor - v) * unit).collect();
    apex(fall_m, drops.video.clock(), &heights)
}

/// A model of a seed, from disk where it has been trained already.
fn trained(
    store: &Store,
    domain: &str,
    preset: &Preset,
    (pairs, count): (&str, &str),
    seed: u64,
    quick: bool,
) -> Result<Model> {
    let name = format!("{domain}-{}-{seed}", preset.name);
    let path = store.room("models")?.join(format!("{name}.safetensors"));
    store.keep(&format!("training-{name}"), || {
        let mut preset = preset.clone();
        if quick && let tunenet_core::network::Course::Remixed { steps, .. } = &mut preset.course {
            *steps /= 4;
        }
        let data = path.with_extension("mcap");
        let out = data.to_str().context("the folder's name is not Unicode")?;
        // Files that another program left there must not be resumed.
        let _ = std::fs::remove_file(&data);
        let seed_text = seed.to_string();
        process::run(&["gen", domain, "--preset", pairs, "--pairs", count, "--seed", &seed_text, "--out", out])?;
        save_model(&train_file(&data, &TrainOptions::new(preset, seed), None, &mut |_| true)?, &path)?;
        std::fs::remove_file(&data).with_context(|| format!("removing {}", data.display()))
    })?;
    Ok(load_model(&path)?)
}
