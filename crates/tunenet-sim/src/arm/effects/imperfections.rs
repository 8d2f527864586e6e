//! Everything that effects may change, and what it makes of the torques of rigid bodies.

use nalgebra::{Rotation3, Vector3};

use crate::formula_effect::joint::{AppliedTorque, JointInstant};

/// Speed at which dry friction has found its sign, rad/s: tanh(dq / SLIDING). A measured speed is never exactly 0, and
/// a sign that flickers with its noise would be noise itself.
pub const SLIDING_RAD_S: f64 = 0.01;

/// What a real arm has beyond rigid bodies; one number for each joint in each list.
#[derive(Debug, Clone, PartialEq)]
pub struct Imperfections {
    /// Viscous friction, N·m·s/rad.
    pub viscous_nms_rad: Vec<f64>,
    /// Coulomb friction, N·m.
    pub coulomb_nm: Vec<f64>,
    /// Friction near rest beyond Coulomb's, N·m.
    pub stribeck_nm: Vec<f64>,
    /// The speed at which it has fallen to 1/e, rad/s.
    pub stribeck_rad_s: Vec<f64>,
    /// Inertia of rotors behind their gears, kg·m².
    pub armature_kg_m2: Vec<f64>,
    /// Offset of the torque sensors, N·m.
    pub bias_nm: Vec<f64>,
    /// Measured over true torque.
    pub gain: Vec<f64>,
    /// True less measured joint position, rad.
    pub offset_rad: Vec<f64>,
    /// Springs across joints, N·m/rad.
    pub spring_nm_rad: Vec<f64>,
    /// Twist of gears, rad/(N·m).
    pub elasticity_rad_nm: Vec<f64>,
    /// Where the payload's centre of mass lies beyond the place that the file gives, m, in the axes of its link.
    pub com_offset_m: [f64; 3],
    /// Turn of the base about x, then about y of the world, rad.
    pub tilt_rad: [f64; 2],
    /// How late torques are against the motion, s.
    pub delay_s: f64,
    /// What a user wrote as formulas.
    pub formulas: Vec<AppliedTorque>,
}

impl Imperfections {
    /// An arm that is nothing but rigid bodies.
    #[must_use]
    pub fn none(joints: usize) -> Self {
        let zero = || vec![0.0; joints];
        Self {
            viscous_nms_rad: zero(),
            coulomb_nm: zero(),
            stribeck_nm: zero(),
            stribeck_rad_s: vec![1.0; joints],
            armature_kg_m2: zero(),
            bias_nm: zero(),
            gain: vec![1.0; joints],
            offset_rad: zero(),
            spring_nm_rad: zero(),
            elasticity_rad_nm: zero(),
            com_offset_m: [0.0; 3],
            tilt_rad: [0.0; 2],
            delay_s: 0.0,
            formulas: Vec::new(),
        }
    }

    /// Whether the rigid bodies move or stand otherwise than the encoders and the file say.
    #[must_use]
    pub fn bends(&self) -> bool {
        let any = |values: &[f64]| values.iter().any(|v| *v != 0.0);
        any(&self.offset_rad) || any(&self.elasticity_rad_nm) || any(&self.tilt_rad)
    }

    /// Gravity in the axes of the tilted base, m/s².
    #[must_use]
    pub fn gravity(&self, m_s2: f64) -> Vector3<f64> {
        let [x, y] = self.tilt_rad;
        let base =
            Rotation3::from_axis_angle(&Vector3::y_axis(), y) * Rotation3::from_axis_angle(&Vector3::x_axis(), x);
        base.inverse() * Vector3::new(0.0, 0.0, -m_s2)
    }

    /// What the sensor of joint `j` shows where rigid bodies ask for `rigid` (N·m) at this instant (s), position (rad), speed
    /// and acceleration.
    #[must_use]
    pub fn shown(&self, j: usize, rigid: f64, t: f64, [q, dq, ddq]: [f64; 3]) -> f64 {
        let mut torque = rigid + self.viscous_nms_rad[j] * dq + self.armature_kg_m2[j] * ddq;
        torque += self.spring_nm_rad[j] * (q + self.offset_rad[j]);
        if self.coulomb_nm[j] != 0.0 || self.stribeck_nm[j] != 0.0 {
            let near_rest = self.stribeck_nm[j] * (-(dq / self.stribeck_rad_s[j]).powi(2)).exp();
            torque += (self.coulomb_nm[j] + near_rest) * (dq / SLIDING_RAD_S).tanh();
        }
        let at = JointInstant { t, q, dq, command: 0.0 };
        torque += self.formulas.iter().map(|one| one.torque(j, at)).sum::<f64>();
        self.gain[j] * torque + self.bias_nm[j]
    }
}
