//! Words of a diagnosis for a ball that is thrown and bounces before a camera.

use tunenet_core::diagnose::Wording;

/// Words for a ball.
pub static WORDING: Wording = Wording {
    motion: "throw",
    single: "a single throw does not identify one effect",
    otherwise: "throw from other heights, in other directions, faster and slower",
    add: "add recordings of the same ball from other heights and in other directions",
    vary: "vary one thing at a time (height, direction, surface, ball, camera) and see with which of them it changes",
    inseparable: "no throw distinguishes",
    knowledge,
    segment: ["flight", "flights"],
    events: "contacts",
    event_count: "the count of bounces",
    level: "the height",
    hidden_segments: [
        "hidden flights' residual after over before",
        "hidden flights' residual over that of a wrong effect",
    ],
};

/// What a user can find out without a throw that settles whether an effect is there.
fn knowledge(name: &str) -> Option<&'static str> {
    Some(match name {
        "length_scale" | "aspect_ratio" | "perspective" | "lens_distortion" => {
            "put objects of known length in view, upright and lying, low and high"
        }
        "time_scale" => "record a clock on video, or look up the true frame rate",
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_is_settled_by_lengths_and_air_by_weight() {
        assert_eq!(knowledge("wind"), knowledge("magnus"));
        assert!(knowledge("perspective").is_some_and(|text| text.contains("known length")));
        assert_eq!(knowledge("payload"), None);
    }
}
