//! `<compiler>`: in which units and by which rules the rest of the file is to be read.

use crate::Result;
use crate::given::Given;
use crate::xml::Document;

/// When inertias follow from shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FromShapes {
    Never,
    Absent,
    Always,
}

/// How the file is to be read.
#[derive(Debug, Clone)]
pub(super) struct Compiler {
    pub degrees: bool,
    /// Axes of Euler angles; capitals turn about axes that stay.
    pub euler: [u8; 3],
    pub auto_limits: bool,
    pub from_shapes: FromShapes,
    /// Groups of shapes that count for inertias.
    pub groups: [f64; 2],
    pub balance_inertia: bool,
    pub bound_mass_kg: f64,
    pub bound_inertia_kg_m2: f64,
    /// Not positive where it is not set.
    pub total_mass_kg: f64,
}

impl Compiler {
    /// All `<compiler>` elements; later ones come last, wherever they stand.
    pub fn read(document: &Document) -> Result<Self> {
        let mut new = Self {
            degrees: true,
            euler: *b"xyz",
            auto_limits: true,
            from_shapes: FromShapes::Absent,
            groups: [0.0, 5.0],
            balance_inertia: false,
            bound_mass_kg: 0.0,
            bound_inertia_kg_m2: 0.0,
            total_mass_kg: -1.0,
        };
        for element in document.root.named("compiler") {
            new.update(&Given::own(document, element))?;
        }
        Ok(new)
    }

    fn update(&mut self, given: &Given) -> Result<()> {
        use FromShapes::{Absent, Always, Never};
        let set = |slot: &mut bool, value: Option<bool>| *slot = value.unwrap_or(*slot);
        set(&mut self.degrees, given.word("angle", &[("degree", true), ("radian", false)])?);
        set(&mut self.auto_limits, given.flag("autolimits")?);
        set(&mut self.balance_inertia, given.flag("balanceinertia")?);
        if let Some(text) = given.text("eulerseq") {
            let axes: Option<[u8; 3]> = text.as_bytes().try_into().ok();
            let known = |axes: &[u8; 3]| axes.iter().all(|c| b"xyzXYZ".contains(c));
            self.euler = axes.filter(known).ok_or_else(|| {
                given.error(
                    "eulerseq",
                    "`eulerseq`: expected three of x, y, z, X, Y, Z, found others",
                    "write xyz, say",
                )
            })?;
        }
        let rules = [("false", Never), ("auto", Absent), ("true", Always)];
        self.from_shapes = given.word("inertiafromgeom", &rules)?.unwrap_or(self.from_shapes);
        self.groups = given.numbers("inertiagrouprange")?.unwrap_or(self.groups);
        self.bound_mass_kg = given.not_negative("boundmass", self.bound_mass_kg)?;
        self.bound_inertia_kg_m2 = given.not_negative("boundinertia", self.bound_inertia_kg_m2)?;
        self.total_mass_kg = given.number("settotalmass")?.unwrap_or(self.total_mass_kg);
        if given.text("coordinate") == Some("global") {
            let hint = "let an old MuJoCo (2.3.3 or before) save the file once with local coordinates";
            return Err(given.error("coordinate", "`coordinate`: expected `local`, found `global`", hint));
        }
        Ok(())
    }

    /// An angle of the file, rad.
    pub fn angle(&self, value: f64) -> f64 {
        if self.degrees { value.to_radians() } else { value }
    }
}
