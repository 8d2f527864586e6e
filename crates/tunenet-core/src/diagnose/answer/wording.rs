//! Words for what is diagnosed: a ball is thrown and bounces before a camera; anything else starts, is driven, and is seen by a
//! sensor.

use crate::diagnose::hypothesis::context::Context;
use crate::observation::Kind;
use crate::simulator::{Phase, Simulator};

/// What a text says where it depends on the thing.
pub(in crate::diagnose) struct Words {
    /// What a recording shows, where several show the same.
    pub motion: &'static str,
    /// Why one motion names nothing.
    pub single: &'static str,
    /// What to do where all recordings show one motion.
    pub otherwise: &'static str,
    /// What to add where effects are left together.
    pub add: &'static str,
    /// What to do where nothing known explains.
    pub vary: &'static str,
    /// What tells effects apart that no design separates.
    pub knowledge: fn(&str) -> Option<&'static str>,
}

const BALL: Words = Words {
    motion: "throw",
    single: "a single throw does not identify one effect",
    otherwise: "throw from other heights, in other directions, faster and slower",
    add: "add recordings of the same ball from other heights and in other directions",
    vary: "vary one thing at a time (height, direction, surface, ball, camera) and see with which of them it changes",
    knowledge: of_ball,
};

const OTHER: Words = Words {
    motion: "motion",
    single: "a single motion does not identify one effect",
    otherwise: "record motions that start otherwise or are driven otherwise, slower and faster",
    add: "add recordings that start otherwise or are driven otherwise",
    vary: "vary one thing at a time (start, inputs, parameters, sensor) and see with which of them it changes",
    knowledge: of_other,
};

/// Whether all that is diagnosed are balls, or anything else that flies and touches.
pub(in crate::diagnose) fn is_of_balls(context: &Context<'_>) -> bool {
    context.subjects.iter().all(|s| flies(s.simulator))
}

/// Why an effect is excluded in whose place what is fitted anyhow does the same.
pub(in crate::diagnose) fn done_already(context: &Context<'_>) -> &'static str {
    if is_of_balls(context) {
        "start states and parameters already do all that it could do here"
    } else if context.sets().iter().any(|set| !set.prepared.nuisances.is_empty()) {
        "the parameters, and what is fitted of each recording, already do all that it could do here"
    } else {
        "the parameters already do all that it could do here"
    }
}

/// The words for it.
pub(in crate::diagnose) fn words(context: &Context<'_>) -> &'static Words {
    if is_of_balls(context) { &BALL } else { &OTHER }
}

fn flies(simulator: &dyn Simulator) -> bool {
    let seen = matches!(simulator.kind(), Kind::Positions | Kind::Pixels | Kind::BounceTimes);
    seen || simulator.effects().iter().any(|effect| matches!(effect.phase, Phase::Flight | Phase::Contact))
}

/// What a person can find out beside any motion that settles whether an effect is there.
fn of_ball(name: &str) -> Option<&'static str> {
    Some(match name {
        "length_scale" | "aspect_ratio" | "perspective" | "lens_distortion" => {
            "put objects of known length in view, upright and lying, low and high"
        }
        "time_scale" => "film a clock, or look up the true frame rate",
        "time_offset" => "record the instant of release",
        "camera_tilt" => "hang a plumb line in view",
        "surface_tilt" => "lay a spirit level on the surface",
        "effective_gravity" => "weigh the ball and measure its size, or drop a dense ball before the same camera",
        "rolling_shutter" | "observation_blur" => "look up the camera's shutter and exposure",
        "quadratic_drag" | "linear_drag" | "magnus" | "wind" => {
            "repeat with a heavy ball of the same size before the same camera"
        }
        "contact_time" | "speed_dependent_restitution" | "tangential_restitution" | "bounce_friction" => {
            "repeat on another surface"
        }
        _ => return None,
    })
}

/// The same of anything else.
fn of_other(name: &str) -> Option<&'static str> {
    Some(match name {
        "length_scale" => "measure a known length with the same sensor",
        "time_scale" => "hold the recorder's clock against another",
        "time_offset" => "record the instant at which the motion starts",
        "observation_blur" => "look up over what time the sensor averages",
        _ => return None,
    })
}
