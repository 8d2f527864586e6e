//! From a file of robot joints to a simulator that core can tune and diagnose.

mod motors;

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use tunenet_core::observation::{Channel, Note, with_decimals};
use tunenet_core::simulator::{Declared, Effect, Parameter, StartState, StartValue};
use tunenet_formats::{Error, Result};

use crate::arm::{Joint, JointKind, Model, model_file};
use crate::formula_effect::joint::JointOf;
use crate::formula_effect::{Acts, FormulaEffect};
use crate::robot::effects::{RobotEffect, in_units_of_joints};
use crate::robot::layout::{Layout, Reading, Role, Start, Wiring};
use crate::robot::numbers::{JointNumbers, NO_RANGE, Number};
use crate::robot::rig::{Mass, Rig};
use crate::robot::trajectory::Quantity;
use crate::robot::{Acting, Drive, RobotModel, StatedGravity, stated_gravity};
use crate::scene::{JointScene, RobotScene};
use crate::simulation_file::robot_schema::role;
use crate::{SimulationFile, declared, findings};

/// The effect that scales the gain, and that which adds to the damping.
const GAIN: &str = "firmware_gain";
const DAMPING: &str = "firmware_damping";

/// What recordings with one gain and one load cannot distinguish from parameters of a servo.
const ONE_SETUP: [&str; 3] = [GAIN, "load_offset", "joint_spring"];

/// Gravity of places on Earth differs by as much.
const SAME_GRAVITY_M_S2: f64 = 0.05;

/// What is simulated at a single joint only.
const SINGLE_JOINT: [&str; 2] = ["joint_elasticity", "backlash"];

/// Robot joints as a simulator, with the inputs and states that their file declares.
pub type RobotSimulator = Declared<RobotModel>;

/// The robot of `files`, a file for each setup of the recordings
/// ([`Circumstances::setup`](tunenet_core::observation::Circumstances::setup) is a position among them): they differ in loads, gains,
/// drives and initial states.
///
/// # Errors
/// [`Error::File`] where a file describes no robot, its model cannot be read or has no such joints and links, or files differ in what
/// they predict or in their parameters.
///
/// # Panics
/// Where `files` is empty.
pub fn robot(files: &[&SimulationFile]) -> Result<RobotSimulator> {
    let file = files[0];
    let scene = file.robot()?;
    let (whole, described) = model_file::read_driven(&model_path(file)?)?;
    let model = chain(file, &whole)?;
    let order = order(file, &model)?;
    let motors = motors::of_joints(file, &whole, described.as_ref(), &order)?;
    let mut parameters = file.parameters()?;
    let starts = starts(scene, &order);
    let follows: Vec<bool> = order.iter().map(|(_, joint)| joint.drive == Drive::Position).collect();
    let one_setup = files.len() == 1 && follows.contains(&true);
    let present = file.robot_effects()?;
    let given = |name: &str| present.iter().find(|one| one.effect.name == name);
    let absent = |names: &[&'static str]| -> Vec<&'static str> {
        names.iter().copied().filter(|name| given(name).is_none()).collect()
    };
    let roles = roles(&parameters, &order);
    let scaled = roles.iter().zip(&parameters).any(|(role, one)| role.number == Number::StallTorque && one.tune);
    // The gain alone scales nothing that is tuned where the stall torque is not.
    let same = |name: &&str| scaled || *name != GAIN;
    let same_as_parameters = if one_setup { absent(&ONE_SETUP).into_iter().filter(same).collect() } else { Vec::new() };
    let beyond = if order.len() > 1 { absent(&SINGLE_JOINT) } else { Vec::new() };
    let looked_for =
        |effect: &RobotEffect| !same_as_parameters.contains(&effect.name) && !beyond.contains(&effect.name);
    let effects: Vec<RobotEffect> = crate::robot::effects::all().into_iter().filter(looked_for).collect();
    let tuned = |number: Number| {
        let is =
            |(role, parameter): (&Role, &Parameter)| (role.number == number && parameter.tune).then_some(role.joint);
        let joints: Vec<usize> = roles.iter().zip(&parameters).filter_map(is).collect();
        (0..order.len()).all(|joint| joints.contains(&joint))
    };
    let names: Vec<&str> = order.iter().map(|(name, _)| *name).collect();
    let slides: Vec<bool> = names.iter().map(|name| is_slide(&model, name)).collect();
    let damping = least_damping(files, &names)?;
    let entry = |effect: &RobotEffect| {
        let entry = in_units_of_joints(effect.entry(&names, tuned), &slides);
        motors::with_limits_reached(with_damping_left(entry, &damping), &motors)
    };
    let mut entries: Vec<Effect> = effects.iter().map(entry).collect();
    let each = order.iter().zip(&slides);
    let joints = each.map(|((name, joint), &slides)| {
        let command_unit = Some(joint.drive.command_unit(slides));
        JointOf { name, slides, command_unit }
    });
    let joints: Vec<JointOf> = joints.collect();
    let formulas = file.robot_formulas(&joints)?;
    let zero = |joint: usize| {
        let mut all = roles.iter().zip(&parameters);
        let own = all.find(|(role, _)| role.joint == joint && role.number == Number::Zero);
        own.map_or(0.0, |(_, parameter)| parameter.value)
    };
    let layout = Layout {
        zeros: (0..order.len()).map(zero).collect(),
        command_ranges: motors::command_ranges(&motors, &order, &roles, &parameters),
        roles,
        effects: acting(&effects, &formulas),
        readings: readings(scene, &order),
        starts: starts.iter().map(|(start, _)| *start).collect(),
        wiring: order.iter().map(|(_, joint)| wiring(scene, joint)).collect(),
        follows,
        model_step_s: described.as_ref().and_then(|robot| robot.step_s).unwrap_or(0.0),
        limits: model.joints().into_iter().map(limits).collect(),
        notes: said_of_one_setup(&same_as_parameters)
            .into_iter()
            .chain(said_of_several_joints(&beyond))
            .chain(said_of_formulas(&formulas, file))
            .collect(),
    };
    let mut rigs = Vec::with_capacity(files.len());
    let mut states = Vec::with_capacity(files.len());
    for other in files {
        let same = other.headers() == file.headers() && other.robot()?.joints.keys().eq(scene.joints.keys());
        if !same || other.robot()?.robot != scene.robot {
            let message = "recordings of one object: expected the same model, joints and channels in every setup";
            return Err(Error::file(other.path(), message, "give recordings that differ in them another `object`"));
        }
        rigs.push(rig(other, &model)?);
        states.push(states_of(other, &starts)?);
    }
    let channels = declared::channels(file)?;
    let of_joint = |joint: usize| channels_of(&layout.readings, joint);
    for (parameter, role) in parameters.iter_mut().zip(&layout.roles) {
        parameter.channels = of_joint(role.joint);
    }
    for coefficient in entries.iter_mut().flat_map(|entry| &mut entry.coefficients) {
        coefficient.channels = coefficient.number.and_then(|number| of_joint(number.checked_sub(1)?));
    }
    entries.extend(formulas.iter().map(|formula| of_its_joint(formula, of_joint)));
    let mut simulator = Declared::new(RobotModel::new(rigs, layout), parameters, channels).setups(states);
    let present = file.effects();
    for entry in entries {
        simulator = match present.iter().find(|one| one.name == entry.name) {
            Some(one) => simulator.present(entry, &one.values)?,
            None => simulator.candidate(entry),
        };
    }
    Ok(simulator)
}

/// What may act on the joints: effects of the catalogue, then formulas.
fn acting(effects: &[RobotEffect], formulas: &[FormulaEffect]) -> Vec<Acting> {
    let built_in = effects.iter().cloned().map(Acting::BuiltIn);
    built_in.chain(formulas.iter().cloned().map(|formula| Acting::Formula(Box::new(formula)))).collect()
}

/// The entry of a formula. Where it acts at one joint alone, its numbers show in the channels of that one.
fn of_its_joint(formula: &FormulaEffect, channels_of: impl Fn(usize) -> Option<Vec<usize>>) -> Effect {
    let mut entry = formula.effect.clone();
    if let Acts::Joint(torque) = &formula.acts
        && let (1, Some(joint)) = torque.acts_at()
    {
        for coefficient in &mut entry.coefficients {
            coefficient.channels = channels_of(joint);
        }
    }
    entry
}

/// The damping in the firmware of each joint, s/rad or s/m: the least of all setups.
fn least_damping(files: &[&SimulationFile], names: &[&str]) -> Result<Vec<f64>> {
    let mut least = vec![f64::INFINITY; names.len()];
    for file in files {
        let scene = file.robot()?;
        for (least, name) in least.iter_mut().zip(names) {
            *least = least.min(scene.joints.get(*name).map_or(0.0, |joint| joint.kd));
        }
    }
    Ok(least)
}

/// The effect on the damping takes no more away than there is.
fn with_damping_left(mut entry: Effect, damping: &[f64]) -> Effect {
    if entry.name == DAMPING {
        for coefficient in &mut entry.coefficients {
            let joint = coefficient.number.and_then(|number| number.checked_sub(1));
            let there = joint.and_then(|joint| damping.get(joint)).copied().unwrap_or(0.0);
            coefficient.min = coefficient.min.max(-there);
        }
    }
    entry
}

/// The channels that are read of a joint; `None` where nothing is: what moves it shows in others alone.
fn channels_of(readings: &[Reading], joint: usize) -> Option<Vec<usize>> {
    let of = |(channel, reading): (usize, &Reading)| (reading.joint == joint).then_some(channel);
    let own: Vec<usize> = readings.iter().enumerate().filter_map(of).collect();
    (!own.is_empty()).then_some(own)
}

/// Which number of which joint each parameter is.
pub(crate) fn roles(parameters: &[Parameter], order: &[(&str, &JointScene)]) -> Vec<Role> {
    let one = |parameter: &Parameter| {
        // Reading the file refuses other names.
        let (joint, number) = role(&parameter.name).unwrap_or(("", Number::Zero));
        Role { joint: order.iter().position(|(name, _)| *name == joint).unwrap_or(0), number }
    };
    parameters.iter().map(one).collect()
}

fn said_of_one_setup(effects: &[&str]) -> Option<Note> {
    let text = format!("all recordings have one gain and one load: {} not looked for", are(effects)?);
    Some(Note::new(findings::ROBOT_ONE_SETUP, text, "record at another gain and with another load"))
}

fn said_of_several_joints(effects: &[&str]) -> Option<Note> {
    let text = format!("the robot has several joints: {} not looked for", are(effects)?);
    let remedy = "to look for them, keep one joint in [joints]; the others are held";
    Some(Note::new(findings::ROBOT_SEVERAL_JOINTS, text, remedy))
}

/// What a user should know of the formulas that act.
fn said_of_formulas(formulas: &[FormulaEffect], file: &SimulationFile) -> Vec<Note> {
    let present = file.effects();
    let acts = |formula: &&FormulaEffect| present.iter().any(|one| one.name == formula.effect.name);
    formulas.iter().filter(acts).flat_map(FormulaEffect::notes).collect()
}

/// `a, b are`; `None` where there are none.
fn are(names: &[&str]) -> Option<String> {
    let verb = if names.len() == 1 { "is" } else { "are" };
    (!names.is_empty()).then(|| format!("{} {verb}", names.join(", ")))
}

/// The names of the file's joints, in the order of the numbers of effects.
///
/// # Errors
/// As [`robot`].
pub fn joint_names(file: &SimulationFile) -> Result<Vec<String>> {
    Ok(order(file, &model(file)?)?.into_iter().map(|(name, _)| name.to_owned()).collect())
}

/// Where the model of a robot's file lies: next to the file, unless its path is absolute.
///
/// # Errors
/// [`Error::File`] where the file describes no robot.
pub fn model_path(file: &SimulationFile) -> Result<PathBuf> {
    Ok(file.path().parent().unwrap_or(Path::new("")).join(&file.robot()?.robot.model))
}

/// What the model says and the simulation leaves out.
///
/// # Errors
/// As [`robot`].
pub fn notes(file: &SimulationFile) -> Result<Vec<Note>> {
    let (whole, described) = model_file::read_driven(&model_path(file)?)?;
    let mut notes = chain(file, &whole)?.notes;
    notes.extend(
        described.as_ref().and_then(stated_gravity).and_then(|stated| other_gravity(file.robot().ok()?, stated)),
    );
    Ok(notes)
}

/// That the model states another gravity than the file. A base that the file alone turns is no contradiction.
fn other_gravity(scene: &RobotScene, stated: StatedGravity) -> Option<Note> {
    let own = scene.world.gravity_m_s2;
    let turned = scene.robot.base_tilt_rad == [0.0; 2] && stated.base_tilt_rad != [0.0; 2];
    if (own - stated.size_m_s2).abs() <= SAME_GRAVITY_M_S2 && !turned {
        return None;
    }
    let size = with_decimals(stated.size_m_s2, 3);
    let [x, y] = stated.base_tilt_rad.map(|turn| with_decimals(turn, 3));
    let text = format!(
        "the model states another gravity ({size} m/s², base turned by {x}, {y} rad) than the simulation file, whose \
         {own} m/s² count"
    );
    Some(Note::new(
        findings::MODEL_LEFT_OUT,
        text,
        "set `world.gravity_m_s2` and `robot.base_tilt_rad` if the model is right",
    ))
}

/// The chain of the file's joints, all others held.
fn model(file: &SimulationFile) -> Result<Model> {
    let (whole, _) = model_file::read_driven(&model_path(file)?)?;
    chain(file, &whole)
}

/// The same of a model that was read. Its joints have the names of the file.
pub(crate) fn chain(file: &SimulationFile, whole: &Model) -> Result<Model> {
    let names: Vec<&str> = whole.joints().into_iter().map(|joint| joint.name.as_str()).collect();
    let mut kept = Vec::new();
    for key in file.robot()?.joints.keys() {
        let name = model_file::named(file, whole, key)?;
        kept.extend(names.iter().position(|known| *known == name));
    }
    Ok(model_file::keyed(whole.clone()).keep(&kept))
}

/// The joints of the file in the order of the model.
pub(crate) fn order<'a>(file: &'a SimulationFile, model: &Model) -> Result<Vec<(&'a str, &'a JointScene)>> {
    let scene = file.robot()?;
    let one = |joint: &&crate::arm::Joint| scene.joints.get_key_value(&joint.name);
    Ok(model.joints().iter().filter_map(one).map(|(name, joint)| (name.as_str(), joint)).collect())
}

/// Whether the joint of this name slides.
pub(crate) fn is_slide(model: &Model, name: &str) -> bool {
    model.joints().into_iter().any(|joint| joint.name == name && joint.kind == JointKind::Prismatic)
}

/// Between which positions a joint may move, rad or m; infinite without limits.
fn limits(joint: &Joint) -> [f64; 2] {
    let [lower, upper] = [joint.limits.lower, joint.limits.upper];
    if upper > lower { [lower, upper] } else { [f64::NEG_INFINITY, f64::INFINITY] }
}

/// One setup.
pub(crate) fn rig(file: &SimulationFile, model: &Model) -> Result<Rig> {
    let scene = file.robot()?;
    let mut masses = Vec::new();
    for (name, load) in &scene.loads {
        let Some(link) = model.frames.iter().find(|frame| frame.name == load.link) else {
            let known: Vec<&str> = model.frames.iter().map(|frame| frame.name.as_str()).collect();
            let message = format!(
                "`loads.{name}.link`: expected a link of the model ({}), found `{}`",
                known.join(", "),
                load.link
            );
            return Err(Error::file(file.path(), message, "name the link that carries the load"));
        };
        masses.push(Mass { link: link.clone(), mass_kg: load.mass_kg, position_m: Vector3::from(load.position_m) });
    }
    let order = order(file, model)?;
    let kinds: Vec<JointKind> = model.joints().iter().map(|joint| joint.kind).collect();
    for ((name, joint), kind) in order.iter().zip(&kinds) {
        fits(file, name, joint, *kind)?;
    }
    let joints = model.joints().into_iter().zip(&order).map(|(of_model, (_, joint))| numbers(joint, of_model));
    let world = (scene.world.gravity_m_s2, scene.robot.base_tilt_rad);
    Ok(Rig::new(model.clone(), masses, world, joints.collect(), scene.integrate.step_s))
}

/// Refuses units that the kind of joint does not have.
fn fits(file: &SimulationFile, name: &str, joint: &JointScene, kind: JointKind) -> Result<()> {
    let slides = kind == JointKind::Prismatic;
    let wrong = |key: &str, found: &str| {
        let expected =
            if slides { "units of a prismatic joint (m, m_s, n)" } else { "units of a turning joint (rad, rad_s, nm)" };
        let message = format!("`joints.{name}.{key}`: expected {expected}, found `{found}`");
        Err(Error::file(file.path(), message, "the model says how the joint moves"))
    };
    if (slides && joint.nm_v.is_some()) || (!slides && joint.n_v.is_some()) {
        let key = if slides { "nm_v" } else { "n_v" };
        return wrong(key, key);
    }
    for header in &joint.observe {
        let unit = Channel::from_header(header).map(|channel| channel.unit).unwrap_or_default();
        let other = if slides { ["rad", "rad/s", "N·m"] } else { ["m", "m/s", "N"] };
        if other.contains(&unit.as_str()) {
            return wrong("observe", header);
        }
    }
    Ok(())
}

/// A joint as the file and the model have it, before parameters and effects.
fn numbers(joint: &JointScene, of_model: &crate::arm::Joint) -> JointNumbers {
    JointNumbers {
        kp: joint.kp,
        kd: joint.kd,
        gain: joint.gain_1_rad.or(joint.n_v).or(joint.nm_v).unwrap_or(0.0),
        duty_max: joint.duty_max,
        supply_v: joint.supply_v,
        command_scale: joint.command_scale,
        command_range: joint.command_range.unwrap_or(NO_RANGE),
        viscous: of_model.damping,
        coulomb: of_model.friction,
        armature: of_model.armature,
        spring: of_model.stiffness,
        preload: of_model.stiffness * of_model.spring_rest,
        ..JointNumbers::free(joint.drive)
    }
}

fn wiring(scene: &RobotScene, joint: &JointScene) -> Wiring {
    let place = |name: &str| scene.inputs.get_index_of(name);
    Wiring { command: place(&joint.command), enable: joint.enable.as_deref().and_then(place) }
}

/// What each channel reads, in the order of the file's joints.
fn readings(scene: &RobotScene, order: &[(&str, &JointScene)]) -> Vec<Reading> {
    let of = |(name, joint): (&String, &JointScene)| {
        let place = order.iter().position(|(known, _)| known == name).unwrap_or(0);
        let gain = joint.nm_a.unwrap_or(1.0);
        let one = move |header: &String| {
            let unit = Channel::from_header(header).map(|channel| channel.unit).unwrap_or_default();
            let (quantity, factor) = match unit.as_str() {
                "rad/s" | "m/s" => (Quantity::Speed, 1.0),
                "N·m" | "N" => (Quantity::Torque, 1.0),
                "A" => (Quantity::Torque, gain.recip()),
                _ => (Quantity::Position, 1.0),
            };
            Reading { joint: place, quantity, factor }
        };
        joint.observe.iter().map(one).collect::<Vec<_>>()
    };
    scene.joints.iter().flat_map(of).collect()
}

/// Position and speed of every joint at the start, with the names that `[start]` has for them.
fn starts(scene: &RobotScene, order: &[(&str, &JointScene)]) -> Vec<(Start, String)> {
    let mut all = Vec::new();
    for (place, (name, joint)) in order.iter().enumerate() {
        let ending = |units: [&str; 2]| {
            let unit = |header: &String| Channel::from_header(header).map(|channel| channel.unit).unwrap_or_default();
            let observed = joint.observe.iter().find(|header| units.contains(&unit(header).as_str()));
            let named = scene.start.keys().find(|key| {
                Channel::from_header(key).is_some_and(|c| c.name == *name && units.contains(&c.unit.as_str()))
            });
            observed.or(named).cloned()
        };
        let position = ending(["rad", "m"]).unwrap_or_else(|| format!("{name}_rad"));
        let speed = ending(["rad/s", "m/s"]).unwrap_or_else(|| format!("{name}_rad_s"));
        all.push((Start { joint: place, speed: false }, position));
        all.push((Start { joint: place, speed: true }, speed));
    }
    all
}

/// The initial state of a setup: as the file says it, else the first sample of a channel that shows the position, else at rest at 0.
fn states_of(file: &SimulationFile, starts: &[(Start, String)]) -> Result<Vec<StartState>> {
    let (declared, headers) = (declared::states(file)?, file.headers());
    let lost = file.starts().map(|(name, _)| name).find(|name| starts.iter().all(|(_, known)| known != name));
    if let Some(name) = lost {
        let known: Vec<&str> = starts.iter().map(|(_, name)| name.as_str()).collect();
        let message = format!("`start.{name}`: expected a position or a speed of a joint ({})", known.join(", "));
        return Err(Error::file(file.path(), message, "name it as the channel, or JOINT_rad and JOINT_rad_s"));
    }
    let one = |(start, name): &(Start, String)| {
        if let Some(said) = declared.iter().find(|state| state.name == *name) {
            return said.clone();
        }
        let unit = Channel::from_header(name).map_or_else(|| "rad".into(), |channel| channel.unit);
        let observed = headers.iter().position(|header| header == name).filter(|_| !start.speed);
        let value = observed.map_or(StartValue::Number(0.0), StartValue::First);
        StartState::new(name.clone(), unit, value)
    };
    Ok(starts.iter().map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A model may state more damping than the servo has: the effect takes away as much as there is, and adds to it otherwise.
    #[test]
    fn damping_is_taken_away_down_to_none() {
        let entry = RobotEffect::find(DAMPING).unwrap().entry(&["a", "b"], |_| true);
        let bounds: Vec<(f64, f64)> =
            with_damping_left(entry, &[0.5, 0.0]).coefficients.iter().map(|c| (c.min, c.max)).collect();
        assert_eq!(bounds, [(-0.5, 10.0), (0.0, 10.0)]);
    }
}
