//! A few blind sets that every test run asks about. Their draws are no part of the bench.

use super::ask::Asked;
use super::blind::{EffectKind, Noise, Recipe, Trouble};
use super::rows::DiagnoseCell;
use super::trial::{BlindTrial, Mark};
use super::trials;
use crate::args::DiagnoseRow;

fn asked(hidden: &[EffectKind], noise: Noise, count: u64) -> Vec<BlindTrial> {
    let name = format!("{hidden:?}-{noise:?}");
    let recipe = Recipe { hidden: hidden.to_vec(), ratio: 10.0, drops: 3, held_out: 1, noise, trouble: Trouble::None };
    let cell = DiagnoseCell { row: DiagnoseRow::Ratio10, name, recipe, first: 0, count };
    trials(&Asked::new().unwrap(), &cell, 5, "test", false).unwrap()
}

#[test]
fn what_was_hidden_is_named() {
    for kind in [
        EffectKind::QuadraticDrag,
        EffectKind::Wind,
        EffectKind::SurfaceTilt,
        EffectKind::ContactTime,
        EffectKind::Perspective,
    ] {
        for trial in asked(&[kind], Noise::WHITE, 1) {
            assert_eq!(trial.mark(), Some(Mark::Exact), "{kind:?}: {trial:?}");
            let (answer, (floor, _)) = (trial.answer.unwrap(), trial.floor_m.unwrap());
            assert!(answer.held_out_m.unwrap() < 1.05 * floor, "{kind:?}: {answer:?}, floor {floor}");
        }
    }
}

#[test]
fn nothing_is_named_where_nothing_was_hidden() {
    for noise in [Noise::WHITE, Noise { colour: 0.5, ..Noise::WHITE }, Noise { dropped: 0.15, ..Noise::WHITE }] {
        for trial in asked(&[], noise, 2) {
            assert!(!trial.answer.as_ref().unwrap().names_something(), "{noise:?}: {trial:?}");
        }
    }
}
