//! A pendulum whose torques follow from a formula, as the process tests of arms share it.

use std::fmt::Write as _;

use crate::common::Folder;

/// A rod of .5 kg with its centre .2 m below the hinge, which turns about x; 1.2 m below it the tool.
pub const URDF: &str = r#"<robot name="pendulum">
  <link name="base"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.2"/><mass value="0.5"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
  <joint name="hinge" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="10"/></joint>
</robot>
"#;
pub const SCENE: &str = "\
kind = \"arm\"
[arm]
urdf = \"pendulum.urdf\"
payload_link = \"rod\"
[motion]
kind = \"replay\"
[parameters.payload_mass]
value = 0.0
min = 0.0
max = 5.0
[parameters.payload_com_z]
value = -0.4
min = -1.0
max = 1.0
tune = false
";

/// A folder with both, as `pendulum.urdf` and `arm.toml`.
pub fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("pendulum.urdf", URDF);
    folder.write("arm.toml", SCENE);
    folder
}

pub const HEADER: &str = "t_s,q1_rad,dq1_rad_s,tau1_nm\n";

/// What is added to the torque of a rigid pendulum.
#[derive(Clone, Copy, Default)]
pub struct Beside {
    pub payload_kg: f64,
    pub viscous: f64,
    pub bias: f64,
    pub late_s: f64,
    /// What the rod weighs more than its URDF says.
    pub rod_kg: f64,
}

/// Position, speed and torque at `t`: `τ = (I + m r²) q̈ + m r g sin q` of both masses, by hand.
pub fn pendulum(t: f64, beside: Beside) -> [f64; 3] {
    let t = t - beside.late_s;
    let wave = |a: f64, w: f64| [a * (w * t).sin(), a * w * (w * t).cos(), -a * w * w * (w * t).sin()];
    let (slow, fast) = (wave(0.9, 1.3), wave(0.3, 4.1));
    let [q, dq, ddq] = [0, 1, 2].map(|i| slow[i] + fast[i]);
    let rod = 0.5 + beside.rod_kg;
    let inertia = 0.01 + rod * 0.2 * 0.2 + beside.payload_kg * 0.4 * 0.4;
    let weight = (rod * 0.2 + beside.payload_kg * 0.4) * 9.81;
    [q, dq, inertia * ddq + weight * q.sin() + beside.viscous * dq + beside.bias]
}

/// Even noise up to ±.05 N·m, from a generator that scrambles a counter (Steele, Lea and Flood 2014).
pub fn noise(i: u32) -> f64 {
    let mut z = u64::from(i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    0.1 * (((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
}

/// A log of 20 s at 100 Hz, each line through `line`.
pub fn log(beside: Beside, line: impl Fn(f64, [f64; 3]) -> String) -> String {
    let mut text = String::from(HEADER);
    for i in 0..2000 {
        let t = 0.01 * f64::from(i);
        let [q, dq, torque] = pendulum(t, beside);
        writeln!(text, "{}", line(t, [q, dq, torque + noise(i)])).unwrap();
    }
    text
}

pub fn plain(t: f64, [q, dq, torque]: [f64; 3]) -> String {
    format!("{t:.3},{q:.9},{dq:.9},{torque:.9}")
}
