//! Next experiment of a driven mechanism: the motion in which confusable effects differ.
//!
//! Effects are distinguished by what their torque [`Follows`]: speed, the rate at which motion changes, the pose, or the load. The
//! joint is the one in which the contested effect shows most, and speeds and poses are those that the recordings reach.

use crate::Result;
use crate::diagnose::answer::NextExperiment;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::observation::Input;
use crate::simulator::{Effect, Excitation, Follows};
use crate::statistics::extent;

/// An effect of those that the experiment has to distinguish.
struct Contested<'a> {
    name: &'a str,
    follows: Follows,
    signature: &'a str,
}

impl<'a> Contested<'a> {
    /// Where nothing is known of an effect, poses are what recordings vary least.
    fn of(effect: &'a Effect) -> Self {
        let unknown = Excitation { follows: Follows::Pose, signature: "differs there" };
        let Excitation { follows, signature } = effect.excitation.unwrap_or(unknown);
        Self { name: effect.name.as_ref(), follows, signature }
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
    for column in position.map_or_else(Vec::new, |p| best.structure.of_effect(p)) {
        without.parameters[column] = best.structure.shared[column].absent.map_or(0.0, |(absent, _)| absent);
    }
    let joint = context.joint(&best.structure);
    let (there, gone) = (joint.plain_residuals(&best.fit.point)?, joint.plain_residuals(&without)?);
    let differences = there.iter().zip(&gone).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect());
    let joint = strongest(context.recordings(), &differences.collect::<Vec<_>>());
    let entries: Vec<Contested> = std::iter::once(&contested)
        .chain(others)
        .map(|&entry| Contested::of(&context.catalogue[entry].of[0]))
        .collect();
    Ok(distinguishing(&entries, &reach(context.recordings(), joint)))
}

/// The experiment that shows more of what no known effect explains, in addition to `best`.
///
/// # Errors
/// Where a simulator refuses.
pub(in crate::diagnose) fn vary(context: &Context, best: &Hypothesis) -> Result<NextExperiment> {
    let plain = context.joint(&best.structure).plain_residuals(&best.fit.point)?;
    Ok(alone(&reach(context.recordings(), strongest(context.recordings(), &plain))))
}

/// The joint in which such values have the largest squares in units of the noise.
fn strongest(recordings: &[PreparedRecording], values: &[Vec<f64>]) -> usize {
    let mut sums = vec![0.0; recordings.first().map_or(0, PreparedRecording::width)];
    for (recording, values) in recordings.iter().zip(values) {
        let width = recording.width();
        for (i, value) in values.iter().enumerate() {
            sums[i % width] += (value / recording.noise[i % width]).powi(2);
        }
    }
    (0..sums.len()).max_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0)
}

/// How far and how fast the recordings move a joint, where their inputs hold angles and speeds of every joint in order.
fn reach(recordings: &[PreparedRecording], joint: usize) -> Reach {
    let mut found = Reach { joint: joint + 1, low_rad: f64::INFINITY, high_rad: f64::NEG_INFINITY, fastest_rad_s: 0.0 };
    let inputs = recordings
        .iter()
        .filter_map(|recording| recording.prepared.circumstances.as_ref())
        .flat_map(|known| &known.inputs);
    for input in inputs.map(Input::series) {
        let column = |unit: &str| {
            let of_unit = input.channels().iter().enumerate().filter(|(_, channel)| channel.unit == unit);
            of_unit.map(|(column, _)| column).nth(joint)
        };
        if let Some(angle) = column("rad") {
            let (low, high) = extent(input.column(angle));
            (found.low_rad, found.high_rad) = (found.low_rad.min(low), found.high_rad.max(high));
        }
        if let Some(speed) = column("rad/s") {
            found.fastest_rad_s = input.column(speed).fold(found.fastest_rad_s, |most, v| most.max(v.abs()));
        }
    }
    found
}

/// The motions in which the contested effects differ.
fn distinguishing(contested: &[Contested], reach: &Reach) -> NextExperiment {
    let Reach { joint, low_rad, high_rad, fastest_rad_s } = *reach;
    let count = |what: Follows| contested.iter().filter(|one| one.follows == what).count();
    let poses = count(Follows::Pose) + count(Follows::Base);
    let mut steps = Vec::new();
    let mut settings = vec![("joint".to_owned(), joint as f64)];
    let moving = fastest_rad_s > 0.0 && high_rad > low_rad;
    let (slow, fast) = (0.1 * fastest_rad_s, fastest_rad_s);
    let speeds = count(Follows::Speed) > 0 && (count(Follows::Rate) + poses + count(Follows::Load) > 0)
        || count(Follows::Speed) > 1;
    if speeds {
        let how = if moving {
            settings.extend([("slow_rad_s".to_owned(), slow), ("fast_rad_s".to_owned(), fast)]);
            format!("at constant {slow:.2}, {:.2} and {fast:.2} rad/s", (slow * fast).sqrt())
        } else {
            "at three constant speeds, the fastest ten times the slowest".into()
        };
        steps.push(format!("when the mechanism is warm, move joint {joint} alone to and fro {how}"));
    }
    if count(Follows::Rate) > 0 {
        let how = if moving {
            settings.push(("twice_rad_s".to_owned(), 2.0 * fast));
            format!(", up to {:.2} rad/s where it may", 2.0 * fast)
        } else {
            String::new()
        };
        steps.push(format!("repeat the same motion of joint {joint} twice as fast{how}"));
    }
    if poses > 0 {
        let how = if moving {
            settings.extend([("low_rad".to_owned(), low_rad), ("high_rad".to_owned(), high_rad)]);
            format!("six poses from {low_rad:.2} to {high_rad:.2} rad or beyond")
        } else {
            "six poses over its range".into()
        };
        let turned = if count(Follows::Base) > 0 && joint != 1 {
            ", then the same with joint 1 turned by half a turn"
        } else {
            ""
        };
        steps.push(format!("hold joint {joint} still for 3 s in each of {how}, approached from both sides{turned}"));
    }
    if count(Follows::Load) > 0 {
        steps.push("record the same motion once with and once without the load".into());
    }
    let signs: Vec<String> = contested.iter().map(|one| format!("{} {}", one.name, one.signature)).collect();
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
        "move joint {joint} alone, whose residual is largest, {how}, once cold and once warm: ripple repeats with its position, \
         backlash shows where it turns round, and friction of a lubricant falls with warmth"
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

    const fn one<'a>(name: &'a str, follows: Follows, signature: &'a str) -> Contested<'a> {
        Contested { name, follows, signature }
    }

    const VISCOUS: Contested<'_> = one("viscous_friction", Follows::Speed, "grows in proportion to speed");
    const COULOMB: Contested<'_> = one("coulomb_friction", Follows::Speed, "is the same at every speed");
    const INERTIA: Contested<'_> = one("armature", Follows::Rate, "grows fourfold at twice the speed");
    const OFFSET: Contested<'_> = one("joint_offset", Follows::Pose, "follows gravity");
    const TILT: Contested<'_> = one("base_tilt", Follows::Base, "turns with the base");
    const GAIN: Contested<'_> = one("torque_gain", Follows::Load, "stays in proportion");

    /// What is asked for follows from the effects that remain, with joint, speeds and poses of the recordings.
    #[test]
    fn each_set_has_a_motion_of_its_own() {
        let friction = distinguishing(&[VISCOUS, COULOMB], &REACH);
        let (text, speeds) = (&friction.text, "joint 3 alone to and fro at constant 0.08, 0.25 and 0.80 rad/s");
        assert!(text.contains(speeds) && text.contains("coulomb_friction is the same at every speed"), "{text}");
        assert!(friction.settings.contains(&("fast_rad_s".to_owned(), 0.8)));
        let rate = distinguishing(&[INERTIA], &REACH).text;
        assert!(rate.starts_with("repeat the same motion of joint 3 twice as fast, up to 1.60 rad/s"), "{rate}");
        let pose = distinguishing(&[OFFSET, TILT], &REACH).text;
        assert!(pose.contains("six poses from -1.50 to 0.50 rad") && pose.contains("joint 1 turned"), "{pose}");
        assert!(!distinguishing(&[OFFSET], &REACH).text.contains("joint 1 turned"));
        let load = distinguishing(&[OFFSET, GAIN], &REACH).text;
        assert!(load.contains("once with and once without the load") && load.contains("hold joint 3 still"), "{load}");
        assert!(alone(&REACH).text.starts_with("move joint 3 alone"));
    }

    /// Of an effect of which no motion is known, poses are asked for.
    #[test]
    fn an_effect_without_a_known_motion_is_sought_in_poses() {
        let effect = Effect::new("sag", crate::simulator::Phase::Joint, "", Vec::new());
        let asked = distinguishing(&[Contested::of(&effect)], &REACH).text;
        assert!(asked.starts_with("hold joint 3 still") && asked.ends_with("sag differs there"), "{asked}");
    }
}
