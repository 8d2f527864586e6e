//! What can be hidden in a set: every effect of the catalogue that drops can show, and some that no catalogue holds.

/// An effect, in this generator's own words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EffectKind {
    QuadraticDrag,
    LinearDrag,
    Wind,
    Magnus,
    EffectiveGravity,
    SpeedDependentRestitution,
    SurfaceTilt,
    BounceFriction,
    TangentialRestitution,
    ContactTime,
    BounceScatter,
    LengthScale,
    AspectRatio,
    TimeScale,
    CameraTilt,
    Perspective,
    LensDistortion,
    RollingShutter,
    ObservationBlur,
    /// A fan that blows sideways at one height.
    Fan,
    /// A magnet under the floor.
    Magnet,
    /// A floor or ball that wears: every bounce returns less than the one before.
    Wear,
    /// One place of the floor is soft.
    SoftSpot,
    /// An updraught that grows with time.
    Updraught,
    /// A camera that sways to and fro.
    CameraShake,
    /// Air drag that begins in the middle of the record.
    LateDrag,
    /// Spin of the same size in every throw, whose sense differs from throw to throw.
    SignedSpin,
    /// A sideways push between two instants.
    Jet,
    /// A rubber band to one point of the room.
    Tether,
    /// A brake of constant force along the motion.
    ConstantBrake,
    /// A lens that zooms while it records.
    Zoom,
    /// A wind that comes and goes, in another phase in every throw.
    Gust,
    /// A clock whose rate drifts.
    ClockDrift,
    /// A push around a vertical axis that grows with the distance from it.
    Vortex,
    /// A floor that swings up and down.
    ShakenFloor,
    /// A wind that grows with height.
    Shear,
    /// A camera that rolls while it records.
    PictureRoll,
    /// A short push in flight, at another instant in every throw.
    Pulse,
    /// A floor that moves along: every bounce adds the same speed sideways.
    Conveyor,
    /// A brake of constant force against the motion along the floor.
    LevelBrake,
}

impl EffectKind {
    /// Effects that the catalogue names. `time_offset` is left out, as the free start hides it, and `rolling_resistance`,
    /// as a throw that bounces does not roll.
    pub const CATALOGUE: [Self; 19] = [
        Self::QuadraticDrag,
        Self::LinearDrag,
        Self::Wind,
        Self::Magnus,
        Self::EffectiveGravity,
        Self::SpeedDependentRestitution,
        Self::SurfaceTilt,
        Self::BounceFriction,
        Self::TangentialRestitution,
        Self::ContactTime,
        Self::BounceScatter,
        Self::LengthScale,
        Self::AspectRatio,
        Self::TimeScale,
        Self::CameraTilt,
        Self::Perspective,
        Self::LensDistortion,
        Self::RollingShutter,
        Self::ObservationBlur,
    ];

    /// Effects that no catalogue names.
    pub const OUTSIDE: [Self; 21] = [
        Self::Fan,
        Self::Magnet,
        Self::Wear,
        Self::SoftSpot,
        Self::Updraught,
        Self::CameraShake,
        Self::LateDrag,
        Self::SignedSpin,
        Self::Jet,
        Self::Tether,
        Self::ConstantBrake,
        Self::Zoom,
        Self::Gust,
        Self::ClockDrift,
        Self::Vortex,
        Self::ShakenFloor,
        Self::Shear,
        Self::PictureRoll,
        Self::Pulse,
        Self::Conveyor,
        Self::LevelBrake,
    ];

    /// Effects of no catalogue that a formula in a user's file describes; `ask` writes them.
    pub const DECLARED: [Self; 6] =
        [Self::Fan, Self::Magnet, Self::Updraught, Self::ConstantBrake, Self::Vortex, Self::Shear];

    /// Its name in answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::QuadraticDrag => "quadratic_drag",
            Self::LinearDrag => "linear_drag",
            Self::Wind => "wind",
            Self::Magnus => "magnus",
            Self::EffectiveGravity => "effective_gravity",
            Self::SpeedDependentRestitution => "speed_dependent_restitution",
            Self::SurfaceTilt => "surface_tilt",
            Self::BounceFriction => "bounce_friction",
            Self::TangentialRestitution => "tangential_restitution",
            Self::ContactTime => "contact_time",
            Self::BounceScatter => "bounce_scatter",
            Self::LengthScale => "length_scale",
            Self::AspectRatio => "aspect_ratio",
            Self::TimeScale => "time_scale",
            Self::CameraTilt => "camera_tilt",
            Self::Perspective => "perspective",
            Self::LensDistortion => "lens_distortion",
            Self::RollingShutter => "rolling_shutter",
            Self::ObservationBlur => "observation_blur",
            Self::Fan => "fan",
            Self::Magnet => "magnet",
            Self::Wear => "wear",
            Self::SoftSpot => "soft_spot",
            Self::Updraught => "updraught",
            Self::CameraShake => "camera_shake",
            Self::LateDrag => "late_drag",
            Self::SignedSpin => "signed_spin",
            Self::Jet => "jet",
            Self::Tether => "tether",
            Self::ConstantBrake => "constant_brake",
            Self::Zoom => "zoom",
            Self::Gust => "gust",
            Self::ClockDrift => "clock_drift",
            Self::Vortex => "vortex",
            Self::ShakenFloor => "shaken_floor",
            Self::Shear => "shear",
            Self::PictureRoll => "picture_roll",
            Self::Pulse => "pulse",
            Self::Conveyor => "conveyor",
            Self::LevelBrake => "level_brake",
        }
    }

    /// The greatest size that nature or a workshop brings, in the coefficient's unit.
    pub fn greatest(self) -> f64 {
        match self {
            Self::QuadraticDrag | Self::LateDrag => 1.0,
            Self::LinearDrag | Self::EffectiveGravity | Self::ConstantBrake | Self::LevelBrake => 2.5,
            Self::Wind | Self::Shear => 4.0,
            Self::Magnus | Self::Fan | Self::SignedSpin | Self::Jet | Self::Gust | Self::Vortex => 6.0,
            Self::SpeedDependentRestitution => 0.4,
            Self::SurfaceTilt | Self::BounceScatter | Self::Perspective => 0.25,
            Self::BounceFriction | Self::TangentialRestitution => 0.9,
            Self::ContactTime => 0.03,
            Self::LengthScale
            | Self::AspectRatio
            | Self::TimeScale
            | Self::CameraShake
            | Self::Zoom
            | Self::PictureRoll => 0.2,
            Self::CameraTilt => 0.3,
            Self::LensDistortion | Self::Wear => 0.15,
            Self::RollingShutter => 0.02,
            Self::ObservationBlur => 0.04,
            Self::Magnet => 30.0,
            Self::SoftSpot | Self::ShakenFloor | Self::Conveyor => 0.8,
            Self::Tether => 8.0,
            Self::ClockDrift => 0.1,
            Self::Pulse => 40.0,
            Self::Updraught => 5.0,
        }
    }

    /// Effects that no throw can distinguish from this one, itself included. A ball that falls freely onto a floor of
    /// unknown height, without friction, shows one length alone, g t²: what scales heights, times or g is the same, and
    /// what happens to lengths along the floor is the start's.
    pub fn twins(self) -> &'static [Self] {
        const SCALES: &[EffectKind] =
            &[EffectKind::EffectiveGravity, EffectKind::LengthScale, EffectKind::AspectRatio, EffectKind::TimeScale];
        if SCALES.contains(&self) { SCALES } else { &[] }
    }
}

/// An effect of some size.
#[derive(Debug, Clone, Copy)]
pub struct HiddenEffect {
    pub kind: EffectKind,
    /// In the coefficient's unit; of a factor, its distance from 1.
    pub size: f64,
    /// 1 or −1, where a sign makes sense.
    pub sign: f64,
    /// Where it points in the plane, rad.
    pub turn: f64,
    /// How steeply it points, rad; or a phase.
    pub lift: f64,
}

impl HiddenEffect {
    /// Its size with its sign.
    pub fn signed(&self) -> f64 {
        self.sign * self.size
    }

    /// A horizontal direction of its size.
    pub fn level(&self) -> [f64; 2] {
        [self.size * self.turn.cos(), self.size * self.turn.sin()]
    }

    /// A unit axis anywhere in space.
    pub fn axis(&self) -> [f64; 3] {
        let (rise, across) = self.lift.sin_cos();
        [across * self.turn.cos(), across * self.turn.sin(), rise]
    }
}
