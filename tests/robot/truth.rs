//! Runs of a joint by explicit steps of 0.1 ms with a sign, written without a look at the simulator.

use std::fmt::Write as _;

use crate::common::Folder;

/// A joint and what it has beyond its simulation.
#[derive(Clone, Copy)]
pub struct Truth {
    pub coulomb: f64,
    pub viscous: f64,
    /// Friction by the torque that the gear carries.
    pub mu: f64,
    pub command_delay: f64,
    pub release_delay: f64,
    /// Factor of the gain that the firmware has.
    pub gain: f64,
    /// Torque (N·m) of magnets that draw the rotor to eight places of a turn.
    pub cogging: f64,
}

pub const NONE: Truth =
    Truth { coulomb: 0.13, viscous: 0.02, mu: 0.0, command_delay: 0.0, release_delay: 0.0, gain: 1.0, cogging: 0.0 };

/// One run: gain, mass (kg), distance of the mass (m), and the kind of motion.
pub type Run = (f64, f64, f64, Motion);

#[derive(Clone, Copy, PartialEq)]
pub enum Motion {
    Faster,
    Step,
    LiftAndDrop,
}

/// Three runs to fit, and three to hold out, with other gains and loads.
pub const RUNS: [Run; 6] = [
    (12.0, 0.535, 0.15, Motion::Faster),
    (16.0, 1.168, 0.1, Motion::Step),
    (24.0, 0.741, 0.15, Motion::LiftAndDrop),
    (8.0, 0.969, 0.1, Motion::Faster),
    (32.0, 0.535, 0.1, Motion::Step),
    (4.0, 0.741, 0.1, Motion::LiftAndDrop),
];

const OFF_S: f64 = 2.0;
const STEP_S: f64 = 1e-4;
const ENCODER_RAD: f64 = std::f64::consts::TAU / 4096.0;

fn goal(motion: Motion, t: f64) -> f64 {
    match motion {
        Motion::Faster => 0.8 * (t * t).sin(),
        Motion::Step if (1.5..4.0).contains(&t) => 1.5,
        Motion::Step => 0.0,
        Motion::LiftAndDrop => {
            let share = (t / OFF_S).min(1.0);
            -1.5 * share * share * (3.0 - 2.0 * share)
        }
    }
}

/// The goal on straight lines between its samples at 100 Hz.
fn sampled(motion: Motion, t: f64) -> f64 {
    let place = (100.0 * t).max(0.0);
    let (below, share) = (place.floor(), place.fract());
    let (from, to) = (goal(motion, below / 100.0), goal(motion, (below + 1.0) / 100.0));
    from + share * (to - from)
}

/// Positions at 100 Hz for 5 s.
pub fn positions(truth: &Truth, (kp, mass, length, motion): Run) -> Vec<f64> {
    let inertia = 0.022 + mass * length * length;
    let off = if motion == Motion::LiftAndDrop { OFF_S + truth.release_delay } else { f64::INFINITY };
    let (mut q, mut w) = (0.0_f64, 0.0_f64);
    let mut found = Vec::new();
    for k in 0..50_000_u32 {
        if k.is_multiple_of(100) {
            found.push(q);
        }
        let t = f64::from(k) * STEP_S;
        let duty = (0.166 * truth.gain * kp * (sampled(motion, t - truth.command_delay) - q)).clamp(-1.0, 1.0);
        let motor = if t < off { 6.0 * duty - 1.2 * w } else { 0.0 };
        let weight = -mass * 9.81 * length * q.sin() - truth.cogging * (8.0 * q).sin();
        let dry = STEP_S / inertia * (truth.coulomb + truth.mu * (weight - motor).abs());
        let ahead = w + STEP_S / inertia * (motor + weight - truth.viscous * w);
        w = if ahead.abs() <= dry { 0.0 } else { ahead - dry * ahead.signum() };
        q += STEP_S * w;
    }
    found
}

/// Noise of about 2 mrad, the same in every run of the tests: a congruential generator (Knuth 1998, section 3.3.4).
fn noisy(positions: Vec<f64>, mut state: u64) -> Vec<f64> {
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 9_007_199_254_740_992.0 - 0.5
    };
    let each = positions.into_iter().map(|q| q + 0.004 * (draw() + draw() + draw()));
    each.map(|q| (q / ENCODER_RAD).round() * ENCODER_RAD).collect()
}

/// Writes the runs of a joint and a manifest; `stated` is what the manifest says of each run's mass.
pub fn recorded(folder: &Folder, truth: &Truth, stated: impl Fn(usize, f64) -> f64) {
    let mut manifest = String::new();
    for (number, run) in RUNS.into_iter().enumerate() {
        let (kp, mass, length, motion) = run;
        let seen = noisy(positions(truth, run), number as u64 + 1);
        let mut text = String::from("t_s,hinge_goal_rad,torque_on,hinge_rad\n");
        for (i, q) in seen.iter().enumerate() {
            let t = i as f64 / 100.0;
            let on = u8::from(motion != Motion::LiftAndDrop || t < OFF_S);
            writeln!(text, "{t},{},{on},{q}", goal(motion, t)).unwrap();
        }
        folder.write(&format!("run_{number}.csv"), text);
        let mass = stated(number, mass);
        writeln!(
            manifest,
            "[[observation]]\nfile = \"run_{number}.csv\"\nobject = \"servo\"\njoints.hinge.kp = {kp:?}\n\
             loads.tip.mass_kg = {mass:?}\nloads.tip.position_m = [0.0, 0.0, {:?}]\nheld_out = {}\n",
            -length,
            number > 2
        )
        .unwrap();
    }
    folder.write("runs.toml", manifest);
}

/// A simulation file of the joint whose parameters start at these values.
pub fn simulation(folder: &Folder, starts: [f64; 6]) {
    let names = ["stall_torque", "back_emf", "viscous", "coulomb", "armature", "zero"];
    let bounds = [(0.5, 20.0), (0.0, 5.0), (0.0, 1.0), (0.0, 1.0), (0.001, 0.1), (-0.3, 0.3)];
    let mut text = String::from(
        "kind = \"robot\"\nrobot.model = \"arm.urdf\"\n[inputs.hinge_goal_rad]\nhold = \"linear\"\n\
         [inputs.torque_on]\ndefault = 1.0\n[joints.hinge]\ndrive = \"position\"\ncommand = \"hinge_goal_rad\"\n\
         enable = \"torque_on\"\nobserve = [\"hinge_rad\"]\ngain_1_rad = 0.166\n\
         [loads.tip]\nlink = \"pendulum\"\nmass_kg = 0.5\nposition_m = [0.0, 0.0, -0.1]\n",
    );
    for ((name, (min, max)), value) in names.iter().zip(bounds).zip(starts) {
        writeln!(text, "[parameters.hinge__{name}]\nvalue = {value:?}\nmin = {min:?}\nmax = {max:?}").unwrap();
    }
    folder.write("servo.toml", text);
}
