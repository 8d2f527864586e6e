//! Next experiment of a driven mechanism, by what each effect's torque follows: the motion in which confusable effects differ.
//!
//! Effects are distinguished by what their torque follows: speed, the rate at which motion changes, the pose, or the load. The
//! joint is the one in which the contested effect shows most, and speeds and poses are those that the recordings reach.

use crate::Result;
use crate::diagnose::answer::NextExperiment;
use crate::diagnose::evidence::recording::Set;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::observation::Input;

/// What a torque follows.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Follows {
    Speed,
    Rate,
    Pose,
    Load,
}

impl Follows {
    fn of(effect: &str) -> Self {
        match effect {
            "viscous_friction" | "coulomb_friction" | "stribeck_friction" => Self::Speed,
            "armature" | "time_delay" | "joint_elasticity" => Self::Rate,
            "payload_com_offset" | "torque_gain" => Self::Load,
            _ => Self::Pose,
        }
    }

    /// What it shows in the motion that is asked for.
    fn sign(effect: &str) -> &'static str {
        match effect {
            "viscous_friction" => "grows in proportion to speed",
            "coulomb_friction" => "is the same at every speed and turns with the direction",
            "stribeck_friction" => "is there at the slowest speed alone",
            "armature" => "grows fourfold at twice the speed",
            "time_delay" => "doubles where the torque changes twice as fast",
            "joint_elasticity" => "follows the torque and its slopes",
            "torque_bias" => "is the same in every pose",
            "joint_spring" => "grows from its rest in a straight line",
            "joint_offset" => "follows gravity as the joint alone turns",
            "base_tilt" => "turns with the direction in which the arm reaches",
            "payload_com_offset" => "is gone without the payload",
            "torque_gain" => "stays in proportion with the payload and without",
            _ => "comes apart there",
        }
    }
}

/// What the recordings reach in one joint.
struct Reach {
    joint: usize,
    low_rad: f64,
    high_rad: f64,
    fastest_rad_s: f64,
}

/// Where nothing usable was recorded.
pub(in crate::diagnose) fn first() -> NextExperiment {
    NextExperiment {
        text: "correct what is noted of each recording, or record half a minute or more in which every joint moves over its \
               range, with positions and torques"
            .into(),
        settings: vec![("duration_s".into(), 30.0)],
    }
}

/// The experiment that distinguishes the effect `contested` of `best` from `others`.
///
/// # Errors
/// Where a simulator refuses.
pub(in crate::diagnose) fn next(
    context: &Context,
    best: &Hypothesis,
    contested: usize,
    others: &[usize],
) -> Result<NextExperiment> {
    let position = best.structure.effects.iter().position(|&e| e == contested);
    let mut without = best.fit.point.clone();
    for g in position.map_or_else(Vec::new, |p| best.structure.of_effect(p)) {
        without.parameters[g] = best.structure.globals[g].absent.map_or(0.0, |(absent, _)| absent);
    }
    let joint = context.joint(&best.structure);
    let (there, gone) = (joint.plain_residuals(&best.fit.point)?, joint.plain_residuals(&without)?);
    let differences = there.iter().zip(&gone).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect());
    let joint = strongest(context.sets(), &differences.collect::<Vec<_>>());
    let names: Vec<&str> =
        std::iter::once(&contested).chain(others).map(|&entry| context.catalogue[entry].name.as_ref()).collect();
    Ok(apart(&names, &reach(context.sets(), joint)))
}

/// The experiment that shows more of what no known effect explains, in addition to `best`.
///
/// # Errors
/// Where a simulator refuses.
pub(in crate::diagnose) fn vary(context: &Context, best: &Hypothesis) -> Result<NextExperiment> {
    let plain = context.joint(&best.structure).plain_residuals(&best.fit.point)?;
    Ok(alone(&reach(context.sets(), strongest(context.sets(), &plain))))
}

/// The joint in which such values have the largest squares in units of the noise.
fn strongest(sets: &[Set], values: &[Vec<f64>]) -> usize {
    let mut sums = vec![0.0; sets.first().map_or(0, Set::width)];
    for (set, values) in sets.iter().zip(values) {
        let width = set.width();
        for (i, value) in values.iter().enumerate() {
            sums[i % width] += (value / set.noise[i % width]).powi(2);
        }
    }
    (0..sums.len()).max_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0)
}

/// How far and how fast the recordings move a joint, where their inputs name positions and speeds.
fn reach(sets: &[Set], joint: usize) -> Reach {
    let mut found = Reach { joint: joint + 1, low_rad: f64::INFINITY, high_rad: f64::NEG_INFINITY, fastest_rad_s: 0.0 };
    let inputs = sets.iter().filter_map(|set| set.prepared.circumstances.as_ref()).flat_map(|known| &known.inputs);
    for input in inputs.map(Input::series) {
        let column = |name: String| input.channels().iter().position(|c| c.name == name);
        if let Some(q) = column(format!("q{}", joint + 1)) {
            let ends = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
            (found.low_rad, found.high_rad) = input.column(q).fold((found.low_rad, found.high_rad), ends);
        }
        if let Some(dq) = column(format!("dq{}", joint + 1)) {
            found.fastest_rad_s = input.column(dq).fold(found.fastest_rad_s, |most, v| most.max(v.abs()));
        }
    }
    found
}

fn apart(contested: &[&str], reach: &Reach) -> NextExperiment {
    let Reach { joint, low_rad, high_rad, fastest_rad_s } = *reach;
    let follows: Vec<Follows> = contested.iter().map(|name| Follows::of(name)).collect();
    let count = |what: Follows| follows.iter().filter(|f| **f == what).count();
    let mut steps = Vec::new();
    let mut settings = vec![("joint".to_owned(), joint as f64)];
    let moving = fastest_rad_s > 0.0 && high_rad > low_rad;
    let (slow, fast) = (0.1 * fastest_rad_s, fastest_rad_s);
    let speeds = count(Follows::Speed) > 0 && (count(Follows::Rate) + count(Follows::Pose) + count(Follows::Load) > 0)
        || count(Follows::Speed) > 1;
    if speeds {
        let how = if moving {
            settings.extend([("slow_rad_s".to_owned(), slow), ("fast_rad_s".to_owned(), fast)]);
            format!("at constant {slow:.2}, {:.2} and {fast:.2} rad/s", (slow * fast).sqrt())
        } else {
            "at three constant speeds, the fastest ten times the slowest".into()
        };
        steps.push(format!("when the arm is warm, move joint {joint} alone to and fro {how}"));
    }
    if count(Follows::Rate) > 0 {
        let how = if moving {
            settings.push(("twice_rad_s".to_owned(), 2.0 * fast));
            format!(", up to {:.2} rad/s where the arm may", 2.0 * fast)
        } else {
            String::new()
        };
        steps.push(format!("repeat the same motion of joint {joint} twice as fast{how}"));
    }
    if count(Follows::Pose) > 0 {
        let how = if moving {
            settings.extend([("low_rad".to_owned(), low_rad), ("high_rad".to_owned(), high_rad)]);
            format!("six poses from {low_rad:.2} to {high_rad:.2} rad or beyond")
        } else {
            "six poses over its range".into()
        };
        let turned = if contested.contains(&"base_tilt") && joint != 1 {
            ", then the same with joint 1 turned by half a turn"
        } else {
            ""
        };
        steps.push(format!("hold joint {joint} still for 3 s in each of {how}, approached from both sides{turned}"));
    }
    if count(Follows::Load) > 0 {
        steps.push("record the same motion once with and once without the payload".into());
    }
    let signs: Vec<String> = contested.iter().map(|name| format!("{name} {}", Follows::sign(name))).collect();
    NextExperiment { text: format!("{}: {}", steps.join("; "), signs.join(", ")), settings }
}

/// Where no known effect will do: one joint alone, so that what its torque follows can be seen.
fn alone(reach: &Reach) -> NextExperiment {
    let Reach { joint, low_rad, high_rad, fastest_rad_s } = *reach;
    let mut settings = vec![("joint".to_owned(), joint as f64)];
    let how = if fastest_rad_s > 0.0 && high_rad > low_rad {
        let slow = 0.1 * fastest_rad_s;
        settings.extend([
            ("slow_rad_s".to_owned(), slow),
            ("low_rad".to_owned(), low_rad),
            ("high_rad".to_owned(), high_rad),
        ]);
        format!("from {low_rad:.2} to {high_rad:.2} rad and back at constant {slow:.2} rad/s")
    } else {
        "over its range and back, slowly".into()
    };
    let text = format!(
        "move joint {joint} alone, in which most is left, {how}, once cold and once warm: ripple repeats with its position, play shows \
         where it turns round, what grease does fades with warmth"
    );
    NextExperiment { text, settings }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::tests::zoo::{LEVER_FRICTION, entry, in_levers};
    use crate::testing::Levers;

    /// Friction of the lever that swings is asked of that one, within what the recording reaches.
    #[test]
    fn the_joint_that_shows_the_effect_is_asked_for() {
        in_levers(&Levers::new().unwrap(), &[(LEVER_FRICTION, 0.5)], |context| {
            let base = fit_without_effects(context).unwrap();
            let contested = entry(context, "viscous_friction");
            let best = context.fit_near(&[contested], &base).unwrap();
            let asked = next(context, &best, contested, &[entry(context, "torque_bias")]).unwrap();
            assert!(asked.settings.contains(&("joint".to_owned(), 1.0)), "{asked:?}");
            let fastest = asked.settings.iter().find(|(name, _)| name == "fast_rad_s").unwrap().1;
            assert!((2.5..3.3).contains(&fastest), "{asked:?}");
            assert!(vary(context, &base).unwrap().text.starts_with("move joint 1 alone"));
        });
    }

    const REACH: Reach = Reach { joint: 3, low_rad: -1.5, high_rad: 0.5, fastest_rad_s: 0.8 };

    /// What is asked for follows from what is left together, with joint, speeds and poses of the recordings.
    #[test]
    fn each_set_has_a_motion_of_its_own() {
        let friction = apart(&["viscous_friction", "coulomb_friction"], &REACH);
        assert!(
            friction.text.contains("joint 3 alone to and fro at constant 0.08, 0.25 and 0.80 rad/s"),
            "{friction:?}"
        );
        assert!(friction.text.contains("coulomb_friction is the same at every speed"), "{friction:?}");
        assert!(friction.settings.contains(&("fast_rad_s".to_owned(), 0.8)));
        let rate = apart(&["armature", "time_delay"], &REACH);
        assert!(rate.text.starts_with("repeat the same motion of joint 3 twice as fast, up to 1.60 rad/s"), "{rate:?}");
        let pose = apart(&["joint_offset", "base_tilt"], &REACH);
        assert!(
            pose.text.contains("six poses from -1.50 to 0.50 rad") && pose.text.contains("joint 1 turned"),
            "{pose:?}"
        );
        let load = apart(&["torque_bias", "payload_com_offset"], &REACH);
        assert!(
            load.text.contains("once with and once without the payload") && load.text.contains("hold joint 3 still")
        );
        let texts = [friction.text, rate.text, pose.text, load.text, alone(&REACH).text];
        assert!(texts.iter().all(|t| t.contains("joint") || t.contains("arm")), "{texts:?}");
    }
}
