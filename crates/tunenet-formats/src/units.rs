//! Units of columns whose file does not state them: said with `--units`, or proposed from the numbers themselves.

use crate::joint_words::unit_of_name;
#[cfg(feature = "logs")]
use crate::shown::list;
#[cfg(feature = "logs")]
use crate::{Origin, Result};
use tunenet_core::observation::{Channel, plain};

/// Units that count where a name ends in them.
const BY_NAME: [&str; 10] = ["rad", "deg", "rad_s", "deg_s", "m", "mm", "cm", "m_s", "nm", "n"];

/// What the columns of a name are measured in.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitRule {
    /// The name of columns: `elbow`, `action.elbow`, `action.*`; `*` for all.
    pub name: String,
    /// How many of its unit one in the file is.
    pub factor: f64,
    /// The unit as it ends a header: `rad`, `deg`, `m`, `nm`; `1` for a plain number.
    pub unit: String,
    /// What a calibration file says of its numbers, where one states the rule; such a rule need not fit any column.
    pub calibrated: Option<Calibrated>,
}

/// The numbers of a joint that a calibration file normalises.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrated {
    /// Over how many counts of the encoder they go.
    pub counts: f64,
    /// From which to which number.
    pub within: (f64, f64),
    /// What one count is in them.
    pub step: f64,
}

impl UnitRule {
    /// A rule as `--units` takes it: `elbow=deg`, `elbow=1.0122deg`, `action.*=rad`, or `rad` for all columns.
    ///
    /// # Errors
    /// What was expected, where the text is no rule.
    pub fn parse(text: &str) -> std::result::Result<Self, String> {
        let (name, said) = text.split_once('=').unwrap_or(("*", text));
        let end = said.find(|c: char| c.is_alphabetic() && c != 'e' && c != 'E').unwrap_or(said.len());
        let (number, unit) = said.split_at(end);
        // `1` alone is the unit of a plain number.
        let (number, unit) =
            if unit.is_empty() { (if number == "1" { "" } else { number }, "1") } else { (number, unit) };
        let factor = if number.is_empty() { Some(1.0) } else { number.trim_end_matches('*').parse::<f64>().ok() };
        let factor = factor.filter(|factor| factor.is_finite() && *factor != 0.0);
        let unit = plain(unit);
        let known = unit == "1" || Channel::from_header(&format!("x_{unit}")).is_some_and(|c| c.unit != "1");
        match factor.filter(|_| known && !name.is_empty() && !said.is_empty()) {
            Some(factor) => Ok(Self { name: name.to_owned(), factor, unit, calibrated: None }),
            None => Err(format!(
                "expected a unit such as rad, deg, m, mm or 1 (a plain number), with a factor where one in the file is not one of it, \
                 as in elbow=1.0122deg; found `{text}`"
            )),
        }
    }

    /// The rule that a name which ends in a unit states by itself: `elbow_deg`. Units that become none of the project's own state none.
    pub(crate) fn of_name(name: &str) -> Option<Self> {
        let unit = unit_of_name(name).filter(|unit| BY_NAME.contains(unit))?;
        Some(Self { name: name.to_owned(), factor: 1.0, unit: unit.to_owned(), calibrated: None })
    }

    /// Whether it is about a column of this name.
    fn is_about(&self, name: &str) -> bool {
        let one = |name: &str| match self.name.split_once('*') {
            Some((start, end)) => {
                name.len() >= start.len() + end.len() && name.starts_with(start) && name.ends_with(end)
            }
            None => name == self.name,
        };
        // What is said of a joint holds for its command too.
        one(name) || name.strip_prefix(ACTION).is_some_and(one)
    }
}

/// What stands before the name of a joint where a column holds its command.
pub(crate) const ACTION: &str = "action.";

/// The rule about a column of this name: the last that fits.
pub(crate) fn rule<'a>(rules: &'a [UnitRule], name: &str) -> Option<&'a UnitRule> {
    rules.iter().rev().find(|rule| rule.is_about(name))
}

/// Refuses rules that fit no column.
///
/// # Errors
/// [`Setting`](tunenet_core::Error::Setting) with the names that there are.
#[cfg(feature = "logs")]
pub(crate) fn refuse_unused(rules: &[UnitRule], names: &[String]) -> Result<()> {
    let fits = |rule: &UnitRule| names.iter().any(|name| rule.is_about(name));
    let (calibrated, said): (Vec<&UnitRule>, Vec<&UnitRule>) = rules.iter().partition(|rule| rule.calibrated.is_some());
    let (name, unused) = match said.into_iter().find(|rule| !fits(rule)) {
        Some(unused) => ("units", Some(unused)),
        // A robot's file may be about more joints than its log.
        None => ("calibration", calibrated.first().copied().filter(|_| !calibrated.iter().any(|rule| fits(rule)))),
    };
    let Some(unused) = unused else { return Ok(()) };
    Err(tunenet_core::Error::Setting {
        origin: Origin::Flag,
        name,
        expected: format!("one of the columns {}", list(names.iter().map(String::as_str), 12)),
        found: format!("`{}`", unused.name),
    }
    .into())
}

/// How a number becomes one of the project's own units: the factor, and how the header ends.
#[cfg(feature = "logs")]
pub(crate) fn own(rule: &UnitRule) -> (f64, &str) {
    const DEGREE: f64 = std::f64::consts::PI / 180.0;
    let factor = rule.factor;
    match rule.unit.as_str() {
        "deg" => (factor * DEGREE, "rad"),
        "deg_s" => (factor * DEGREE, "rad_s"),
        "mm" => (factor / 1e3, "m"),
        "cm" => (factor / 1e2, "m"),
        "ma" => (factor / 1e3, "a"),
        unit => (factor, unit),
    }
}

/// What a header in `--columns` becomes where its column is in the project's own unit already.
#[cfg(feature = "logs")]
pub(crate) fn in_own_unit(header: &str) -> String {
    let ends = [("_deg", "_rad"), ("_deg_s", "_rad_s"), ("_mm", "_m"), ("_cm", "_m"), ("_ma", "_a")];
    let found = ends.iter().find_map(|(theirs, ours)| Some(format!("{}{ours}", header.strip_suffix(theirs)?)));
    found.unwrap_or_else(|| header.to_owned())
}

#[cfg(all(test, feature = "logs"))]
mod tests {
    use super::*;

    fn rule_of(text: &str) -> UnitRule {
        UnitRule::parse(text).unwrap()
    }

    #[test]
    fn a_rule_names_columns_a_factor_and_a_unit() {
        let one = rule_of("elbow=1.0122deg");
        assert_eq!((one.name.as_str(), one.factor, one.unit.as_str()), ("elbow", 1.0122, "deg"));
        assert_eq!(rule_of("rad"), UnitRule { name: "*".into(), factor: 1.0, unit: "rad".into(), calibrated: None });
        assert_eq!(rule_of("gripper=1").unit, "1");
        assert_eq!(rule_of("gripper=0.01").factor, 0.01);
        assert_eq!(rule_of("a=1e-3m").factor, 1e-3);
        assert_eq!(
            rule_of("a=-1rad/s"),
            UnitRule { name: "a".into(), factor: -1.0, unit: "rad_s".into(), calibrated: None }
        );
        for wrong in ["a=", "a=foot", "=rad", "a=0rad", "a=nandeg", ""] {
            assert!(UnitRule::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_last_rule_that_fits_counts_and_a_joints_holds_for_its_command() {
        let all = rule_of("left*=deg");
        assert!(all.is_about("action.left_elbow") && !all.is_about("action.right_elbow"));
        let rules = [rule_of("rad"), rule_of("elbow=deg"), rule_of("action.w*=m")];
        let unit = |name: &str| rule(&rules, name).unwrap().unit.clone();
        assert_eq!(
            [unit("wrist"), unit("elbow"), unit("action.elbow"), unit("action.wrist")],
            ["rad", "deg", "deg", "m"]
        );
        let names = ["elbow".to_owned(), "action.elbow".to_owned()];
        assert!(refuse_unused(&rules[..2], &names).is_ok());
        let message = refuse_unused(&rules, &names).unwrap_err().to_string();
        assert!(message.contains("one of the columns `elbow`, `action.elbow`"), "{message}");
    }

    #[test]
    fn degrees_and_millimetres_become_own_units() {
        assert_eq!(own(&rule_of("a=2deg")), (2.0 * std::f64::consts::PI / 180.0, "rad"));
        assert_eq!(own(&rule_of("a=mm")), (1.0 / 1e3, "m"));
        assert_eq!(in_own_unit("goal_deg_s"), "goal_rad_s");
        assert_eq!(in_own_unit("q1_rad"), "q1_rad");
    }
}
