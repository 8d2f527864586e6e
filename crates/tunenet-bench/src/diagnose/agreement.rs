//! The hidden physics against the simulator's: two integrators that share nothing have to agree on every effect, or an
//! answer could be called wrong for meaning something else by a name.

use std::path::Path;

use tunenet_core::observation::Kind as Observed;
use tunenet_core::simulator::rollout;
use tunenet_sim::{Session, SimulationFile, simulator};

use super::blind::{BallWorld, BlindThrow, EffectKind, HiddenEffect, RADIUS_M, seen};

const RESTITUTION: f64 = 0.8;

/// The coefficients of a hidden effect in a simulation file.
fn coefficients(hidden: &HiddenEffect) -> Vec<(&'static str, f64)> {
    let (size, signed, [x, y]) = (hidden.size, hidden.signed(), hidden.level());
    match hidden.kind {
        EffectKind::QuadraticDrag => vec![("c_1_m", size)],
        EffectKind::LinearDrag => vec![("b_1_s", size)],
        EffectKind::Wind => vec![("ax_m_s2", x), ("ay_m_s2", y)],
        EffectKind::Magnus => {
            let (rise, across) = hidden.lift.sin_cos();
            vec![("sx_1_s", across * x), ("sy_1_s", across * y), ("sz_1_s", size * rise)]
        }
        EffectKind::EffectiveGravity => vec![("dg_m_s2", signed)],
        EffectKind::SpeedDependentRestitution => vec![("exponent", size)],
        EffectKind::SurfaceTilt => {
            let (sin, cos) = size.sin_cos();
            let (nx, ny) = (sin * hidden.turn.cos(), sin * hidden.turn.sin());
            vec![("about_x_rad", (-ny).atan2(cos)), ("about_y_rad", nx.asin())]
        }
        EffectKind::BounceFriction => vec![("mu", size)],
        EffectKind::TangentialRestitution => vec![("loss", size)],
        EffectKind::ContactTime => vec![("duration_s", size)],
        EffectKind::LengthScale | EffectKind::AspectRatio | EffectKind::TimeScale => vec![("factor", 1.0 + signed)],
        EffectKind::Perspective => vec![("k_1_m", signed)],
        EffectKind::LensDistortion => vec![("k1", signed)],
        EffectKind::RollingShutter => vec![("delay_s_m", size)],
        // A turn about one axis, so that the order of turns does not matter.
        EffectKind::CameraTilt => vec![("about_x_rad", x), ("about_y_rad", y)],
        EffectKind::ObservationBlur => vec![("exposure_s", size)],
        _ => vec![],
    }
}

#[test]
fn both_worlds_agree_on_every_effect() {
    let clock: Vec<f64> = (0..216).map(|i| f64::from(i) / 120.0).collect();
    let start = [0.1, -0.2, 1.2 + RADIUS_M, 1.5, 0.8, 0.6];
    let throw = BlindThrow {
        position_m: [start[0], start[1], start[2]],
        velocity_m_s: [start[3], start[4], start[5]],
        scatter: vec![],
    };
    for kind in EffectKind::CATALOGUE.into_iter().filter(|kind| *kind != EffectKind::BounceScatter) {
        let turn = if kind == EffectKind::CameraTilt { 0.0 } else { 0.7 };
        let hidden = HiddenEffect { kind, size: 0.2 * kind.greatest(), sign: 1.0, turn, lift: 0.5 };
        let world = BallWorld { restitution: RESTITUTION, hidden: vec![hidden] };
        let text = format!(
            "kind = \"ball\"\nball.radius_m = {RADIUS_M}\nsurface.height_m = 0.0\nrelease.time_s = 0.0\n\
             parameters.restitution = {{ value = {RESTITUTION}, min = 0.0, max = 1.0 }}\n"
        );
        let mut file = SimulationFile::parse(Path::new("agreement.toml"), &text).unwrap();
        file.add_effect(kind.name(), &coefficients(&hidden)).unwrap();
        let simulator = simulator(&file, Observed::Positions, &Session::default()).unwrap();
        let parameters: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let ours = rollout(simulator.as_ref(), &parameters, &start, &clock).unwrap();
        let theirs = seen(&world, &throw, &clock).concat();
        // Of an exposure that began before the throw each world makes its own.
        let whole = clock.iter().filter(|t| **t < 0.5 * hidden.size).count() * 3;
        let skipped = if kind == EffectKind::ObservationBlur { whole } else { 0 };
        let farthest = ours.iter().zip(&theirs).skip(skipped).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Exposures are sampled by both, and a bounce within one shows how finely.
        let near = if kind == EffectKind::ObservationBlur { 1e-3 } else { 1e-5 };
        eprintln!("{}: {farthest:.1e} m", kind.name());
        assert!(farthest < near, "{}: {farthest} m apart", kind.name());
    }
}
