//! An acceleration of a ball in flight: a formula of where it is, how it moves and when, along one direction or several.

use std::sync::Arc;

use rapier3d::math::Vector;
use tunenet_core::law::Term;
use tunenet_formula::{Divisor, Formula};

use super::layout::Layout;
use super::{MOST_COEFFICIENTS, Misfit, formula, require_unit};
use crate::scene::Candidate;
use crate::valid_range::LeftRange;

/// What a formula of a flight may use, with its unit.
pub(crate) const VARIABLES: [(&str, &str); 9] = [
    ("x_m", "m"),
    ("y_m", "m"),
    ("z_m", "m"),
    ("vx_m_s", "m/s"),
    ("vy_m_s", "m/s"),
    ("vz_m_s", "m/s"),
    ("speed_m_s", "m/s"),
    ("t_s", "s"),
    ("r_m", "m"),
];
const COUNT: usize = VARIABLES.len();
const TIME: usize = 7;
/// The words of `along`.
const WORDS: [&str; 8] = ["v", "r", "x", "y", "z", "spin", "across", "around"];

/// Where a formula points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Direction {
    /// Along the velocity.
    Velocity,
    /// Away from the centre.
    Radius,
    /// Along an axis.
    Axis(usize),
    /// Along the cross product of an axis and the velocity, whose length counts.
    Spin(usize),
    /// Along the velocity turned by 90° about z.
    Across,
    /// Along z × r.
    Around,
}

impl Direction {
    fn vector(self, away: Vector, v: Vector) -> Vector {
        let axis = |i: usize| Vector::from_array(std::array::from_fn(|k| f64::from(u8::from(k == i))));
        match self {
            Self::Velocity => v.normalize_or_zero(),
            Self::Radius => away.normalize_or_zero(),
            Self::Axis(i) => axis(i),
            Self::Spin(i) => axis(i).cross(v),
            Self::Across => Vector::new(-v.y, v.x, 0.0).normalize_or_zero(),
            Self::Around => Vector::new(-away.y, away.x, 0.0).normalize_or_zero(),
        }
    }
}

/// What says how large a force is.
#[derive(Debug, Clone, PartialEq)]
enum Size {
    /// A formula of the file.
    Formula { formula: Formula, layout: Layout, divisors: Vec<Divisor> },
    /// A term of a law that is searched, evaluated natively: with a coefficient for each direction.
    Law(Term),
}

/// What a term of a law may depend on, as positions among the variables: those of [`LAW_VARIABLES`].
pub(crate) const LAW_VARIABLES: [usize; 5] = [0, 1, 2, 6, 7];

/// The force.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FlightForce {
    name: String,
    size: Size,
    directions: Vec<Direction>,
    centre: Vector,
    /// What turns the formula's value into an acceleration.
    factor: f64,
    depends_on_time: bool,
    /// Between which values of a variable it was seen to hold.
    valid: Vec<(usize, (f64, f64))>,
}

impl FlightForce {
    pub fn new(name: &str, candidate: &Candidate, mass_kg: Option<f64>) -> Result<Self, Misfit> {
        let words = &candidate.along;
        if words.is_empty() {
            let expected = format!("at least one of {}", WORDS.map(|word| format!("\"{word}\"")).join(", "));
            return Err(Misfit::new("along", expected, "none"));
        }
        let mut directions = Vec::new();
        for (i, word) in words.iter().enumerate() {
            if words[..i].contains(word) {
                return Err(Misfit::new("along", "each direction once", format!("\"{word}\" twice")));
            }
            match word.as_str() {
                "v" => directions.push(Direction::Velocity),
                "r" => directions.push(Direction::Radius),
                "x" => directions.push(Direction::Axis(0)),
                "y" => directions.push(Direction::Axis(1)),
                "z" => directions.push(Direction::Axis(2)),
                "across" => directions.push(Direction::Across),
                "around" => directions.push(Direction::Around),
                "spin" => directions.extend((0..3).map(Direction::Spin)),
                other => {
                    let expected = format!("some of {}", WORDS.map(|word| format!("\"{word}\"")).join(", "));
                    return Err(Misfit::new("along", expected, format!("\"{}\"", other.escape_debug())));
                }
            }
        }
        let (factor, mut unit) = match (candidate.gives.as_deref().unwrap_or("m_s2"), mass_kg) {
            ("m_s2", _) => (1.0, "m/s²"),
            ("n", Some(mass)) => (1.0 / mass, "N"),
            ("n", None) => {
                return Err(Misfit::new("gives", "`ball.mass_kg` in the file, by which the force is divided", "none"));
            }
            (other, _) => {
                return Err(Misfit::new("gives", "\"m_s2\" or \"n\"", format!("\"{}\"", other.escape_debug())));
            }
        };
        if directions.iter().all(|direction| matches!(direction, Direction::Spin(_))) {
            // It is multiplied with a velocity.
            unit = if unit == "N" { "kg/s" } else { "1/s" };
        }
        let (formula, layout) = formula(candidate, &VARIABLES, directions.len())?;
        require_unit(&formula, unit)?;
        let divisors = formula.divisors(&|name| name < COUNT).map_err(Misfit::of)?;
        let range = |(name, range): (&String, &(f64, f64))| {
            let place = VARIABLES.iter().position(|(known, _)| known == name).ok_or_else(|| {
                let known = VARIABLES.map(|(known, _)| known).join(", ");
                Misfit::new("valid", format!("ranges of {known}"), format!("`{name}`"))
            });
            Ok((place?, *range))
        };
        Ok(Self {
            name: name.to_owned(),
            valid: candidate.valid.iter().map(range).collect::<Result<_, _>>()?,
            depends_on_time: formula.uses(TIME),
            size: Size::Formula { formula, layout, divisors },
            directions,
            centre: Vector::from_array(candidate.centre.unwrap_or_default()),
            factor,
        })
    }

    /// A term of a law, along the directions of these names, which all are words of `along`.
    pub fn law(term: Term, along: &[String]) -> Option<Self> {
        let direction = |word: &String| match word.as_str() {
            "v" => Some(Direction::Velocity),
            "x" => Some(Direction::Axis(0)),
            "y" => Some(Direction::Axis(1)),
            "z" => Some(Direction::Axis(2)),
            "across" => Some(Direction::Across),
            _ => None,
        };
        let clock = |factor: &tunenet_core::law::Factor| LAW_VARIABLES[factor.variable] == TIME;
        Some(Self {
            name: String::new(),
            directions: along.iter().map(direction).collect::<Option<_>>()?,
            depends_on_time: term.factors.iter().any(clock),
            size: Size::Law(term),
            centre: Vector::ZERO,
            factor: 1.0,
            valid: Vec::new(),
        })
    }

    /// As it was written, where a formula says its size.
    pub fn formula(&self) -> Option<&Formula> {
        match &self.size {
            Size::Formula { formula, .. } => Some(formula),
            Size::Law(_) => None,
        }
    }

    /// What each direction adds to the acceleration along x, y and z.
    pub fn vectors(&self, x: Vector, v: Vector) -> Vec<Vec<f64>> {
        self.directions.iter().map(|d| d.vector(x - self.centre, v).to_array().to_vec()).collect()
    }

    /// How many directions it has; `spin` counts as three.
    pub fn directions(&self) -> usize {
        self.directions.len()
    }

    pub fn depends_on_time(&self) -> bool {
        self.depends_on_time
    }

    fn variables(&self, t: f64, x: Vector, v: Vector) -> [f64; COUNT] {
        [x.x, x.y, x.z, v.x, v.y, v.z, v.length(), t, (x - self.centre).length()]
    }

    /// Whether a ball that only falls and rises shows it.
    pub fn shows_in_a_drop(&self) -> bool {
        let vertical = |d: &Direction| matches!(d, Direction::Velocity | Direction::Radius | Direction::Axis(2));
        self.directions.iter().any(vertical)
    }
}

/// The values of [`LAW_VARIABLES`].
pub(crate) fn law_variables(t: f64, x: Vector, v: Vector) -> [f64; LAW_VARIABLES.len()] {
    [x.x, x.y, x.z, v.length(), t]
}

/// A form that accelerates a ball more than this, 50 times as gravity does, is none: its rollout ends at once as one that is no number.
const MOST_SEARCHED_M_S2: f64 = 500.0;

/// The force with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedForce {
    force: Arc<FlightForce>,
    values: Vec<f64>,
}

impl AppliedForce {
    pub(crate) fn new(force: &Arc<FlightForce>, values: &[f64]) -> Self {
        debug_assert_eq!(
            values.len(),
            match &force.size {
                Size::Formula { layout, .. } => layout.numbers(),
                Size::Law(term) => term.constants(),
            }
        );
        Self { force: Arc::clone(force), values: values.to_vec() }
    }

    /// Whether it changes while nothing moves.
    pub(crate) fn depends_on_time(&self) -> bool {
        self.force.depends_on_time
    }

    /// The variable that is outside the range in which the formula was seen to hold, the farthest of several.
    pub(crate) fn outside(&self, t: f64, x: Vector, v: Vector) -> Option<LeftRange> {
        let variables = self.force.variables(t, x, v);
        let outside = |(variable, range): &(usize, (f64, f64))| {
            LeftRange::of(VARIABLES[*variable].0, variables[*variable], t, *range)
        };
        LeftRange::farthest(self.force.valid.iter().filter_map(outside))
    }

    /// The values of all names of the formula along direction `i`; of a law nothing.
    fn names(&self, i: usize, (t, x, v): (f64, Vector, Vector)) -> Option<[f64; COUNT + MOST_COEFFICIENTS]> {
        let Size::Formula { layout, .. } = &self.force.size else { return None };
        let mut names = [0.0; COUNT + MOST_COEFFICIENTS];
        names[..COUNT].copy_from_slice(&self.force.variables(t, x, v));
        layout.fill(&self.values, i, &mut names[COUNT..COUNT + layout.coefficients()]);
        Some(names)
    }

    /// The name of its candidate; empty of a law that is searched.
    pub(crate) fn name(&self) -> &str {
        &self.force.name
    }

    /// Which part of the formula has no finite value at an instant, a place and a velocity, in words without an end.
    pub(crate) fn undefined(&self, at: (f64, Vector, Vector)) -> Option<String> {
        let formula = self.force.formula()?;
        let along = |i: usize| formula.undefined(&self.names(i, at)?);
        let part = (0..self.force.directions()).find_map(along)?;
        Some(format!("`{}` in `candidates.{}.formula` {}", part.text, self.force.name, part.what))
    }

    /// Which part of the formula has a pole between two instants, in words without an end.
    pub(crate) fn pole(&self, from: (f64, Vector, Vector), to: (f64, Vector, Vector)) -> Option<String> {
        let Size::Formula { formula, divisors, .. } = &self.force.size else { return None };
        if divisors.is_empty() {
            return None;
        }
        let along = |i: usize| formula.pole_between(divisors, &self.names(i, from)?, &self.names(i, to)?);
        let part = (0..self.force.directions()).find_map(along)?;
        Some(format!("`{part}` in `candidates.{}.formula` grows beyond all bounds", self.force.name))
    }

    /// Whether it is a term of a law that a search tries.
    pub(crate) fn is_searched(&self) -> bool {
        matches!(self.force.size, Size::Law(_))
    }

    /// The acceleration (m/s²) at an instant, a place and a velocity.
    pub(crate) fn acceleration(&self, t: f64, x: Vector, v: Vector) -> Vector {
        let force = &*self.force;
        let away = x - force.centre;
        let mut sum = Vector::ZERO;
        match &force.size {
            Size::Formula { formula, layout, .. } => {
                let mut names = [0.0; COUNT + MOST_COEFFICIENTS];
                names[..COUNT].copy_from_slice(&force.variables(t, x, v));
                for (i, direction) in force.directions.iter().enumerate() {
                    layout.fill(&self.values, i, &mut names[COUNT..COUNT + layout.coefficients()]);
                    sum += direction.vector(away, v) * formula.program().value(&names);
                }
            }
            Size::Law(term) => {
                let variables = law_variables(t, x, v);
                let product = term.product(&self.values, &variables, &variables.map(f64::signum));
                for (direction, coefficient) in force.directions.iter().zip(&self.values) {
                    sum += direction.vector(away, v) * (coefficient * product);
                }
                if sum.length() > MOST_SEARCHED_M_S2 {
                    return Vector::splat(f64::NAN);
                }
            }
        }
        sum * force.factor
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::candidate;
    use super::*;
    use crate::ball::scene::Formulas;
    use crate::ball::{Scene, State, positions};

    fn force(along: &str, formula: &str, more: &str, values: &[f64]) -> AppliedForce {
        let text = format!(
            "sentence = \"s\"\nacts = \"flight\"\nalong = {along}\nformula = \"{formula}\"\n{more}\n\
             coefficients.k = {{ min = -9.0, max = 9.0, absent = 0.0, unit = \"?\" }}\n"
        );
        AppliedForce::new(&Arc::new(FlightForce::new("it", &candidate(&text), Some(0.5)).unwrap()), values)
    }

    #[test]
    fn every_direction_points_where_its_name_says() {
        let (x, v) = (Vector::new(3.0, 4.0, 1.0), Vector::new(0.0, 2.0, 0.0));
        for (along, values, wanted) in [
            ("[\"v\"]", &[2.0][..], [0.0, 2.0, 0.0]),
            ("[\"z\"]", &[2.0], [0.0, 0.0, 2.0]),
            ("[\"across\"]", &[2.0], [-2.0, 0.0, 0.0]),
            ("[\"around\"]", &[5.0], [-4.0, 3.0, 0.0]),
            ("[\"spin\"]\nper_direction = [\"k\"]", &[0.0, 0.0, 1.5], [-3.0, 0.0, 0.0]),
            ("[\"x\", \"z\"]\nper_direction = [\"k\"]", &[1.0, 2.0], [1.0, 0.0, 2.0]),
            ("[\"x\", \"z\"]", &[1.0], [1.0, 0.0, 1.0]),
            ("[\"x\"]\ngives = \"n\"", &[1.0], [2.0, 0.0, 0.0]),
        ] {
            let found = force(along, "k", "", values).acceleration(0.0, x, v);
            assert!((found - Vector::from_array(wanted)).length() < 1e-12, "{along}: {found:?}");
        }
        let away = force("[\"r\"]", "k/r_m^2", "centre = [3.0, 4.0, -1.0]", &[8.0]).acceleration(0.0, x, v);
        assert!((away - Vector::new(0.0, 0.0, 2.0)).length() < 1e-12, "{away:?}");
        let late = force("[\"x\"]", "k*t_s", "", &[2.0]);
        assert!(late.depends_on_time() && late.acceleration(3.0, x, v).x == 6.0);
    }

    /// v' = k v³ has no solution beyond 1 / (2 k v₀²); until then x = (1 − √(1 − 2 k v₀² t)) / (k v₀).
    #[test]
    fn speed_that_grows_without_end_is_refused_and_exact_before() {
        let flight = vec![force("[\"v\"]", "k*speed_m_s^3", "", &[0.25])];
        let formulas = Formulas { flight, ..Formulas::default() };
        let scene = Scene { gravity_m_s2: 0.0, surface_height_m: -100.0, formulas, ..Scene::default() };
        let start = State { velocity_m_s: [2.0, 0.0, 0.0], ..State::at([0.0; 3]) };
        let roll = |clock: &[f64]| {
            let mut out = vec![0.0; 3 * clock.len()];
            positions(&scene, &start, 0.0, clock, &mut out).map(|()| out)
        };
        let x = roll(&[0.0, 0.45]).unwrap()[3];
        assert!((x - (1.0 - 0.1_f64.sqrt()) / 0.5).abs() < 1e-6, "{x}");
        assert!(roll(&[0.0, 0.55]).unwrap_err().contains("speeds up without end"));
    }

    /// A ball that falls from 1 m reaches 0.5 m after √(1/9.81) = 0.319 s; k/(z − 0.5) with k = -0.001 draws it on little before.
    #[test]
    fn a_pole_and_a_value_that_is_none_are_refused_with_their_part() {
        let roll = |formula: &str, k: f64, until_s: f64| {
            let flight = vec![force("[\"z\"]", formula, "", &[k])];
            let formulas = Formulas { flight, ..Formulas::default() };
            let scene = Scene { surface_height_m: -100.0, formulas, ..Scene::default() };
            positions(&scene, &State::at([0.0, 0.0, 1.0]), 0.0, &[0.0, until_s], &mut [0.0; 6])
        };
        let pole = "`k/(z_m - 0.5)` in `candidates.it.formula` grows beyond all bounds by 0.3";
        assert!(roll("k/(z_m - 0.5)", -0.001, 0.3).is_ok());
        let refused = roll("k/(z_m - 0.5)", -0.001, 0.5).unwrap_err();
        assert!(refused.starts_with(pole), "{refused}");
        let none = "`sqrt(z_m - 0.5)` in `candidates.it.formula` has no real value by 0.3";
        let refused = roll("k*sqrt(z_m - 0.5)", 0.001, 0.5).unwrap_err();
        assert!(refused.starts_with(none), "{refused}");
        // 0/0 has a limit, and is passed.
        assert!(roll("k*sin(k*(z_m - 0.5))/(z_m - 0.5)", 0.001, 0.4).is_ok());
    }
}
