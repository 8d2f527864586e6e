//! Numbers of effects in joints that slide: units, typical sizes and bounds.
//!
//! The catalogue states them for hinges. A radian of a hinge moves its link by about 0.1 m at the lever at which loads act, so that 1 rad
//! corresponds to 0.1 m, 1 N·m to 10 N, and 1 N·m·s/rad to 100 N·s/m. Where the numbers of slides go farther than that, the bounds do: spindles
//! move at a few mm/s, and turn the rotor hundreds of times for each metre. No bound is narrower than that of a hinge.

use tunenet_core::simulator::{Coefficient, Effect};

/// A unit of hinges with that of slides.
struct Row {
    hinge: &'static str,
    slide: &'static str,
    /// Typical size of a slide over that of a hinge.
    typical: f64,
    /// The same of the greatest number.
    greatest: f64,
}

const fn row(hinge: &'static str, slide: &'static str, typical: f64, greatest: f64) -> Row {
    Row { hinge, slide, typical, greatest }
}

const ROWS: [Row; 9] = [
    row("rad", "m", 0.1, 1.0),
    row("rad/s", "m/s", 0.1, 1.0),
    row("s/rad", "s/m", 10.0, 100.0),
    row("N·m", "N", 10.0, 10.0),
    row("N·m/rad", "N/m", 100.0, 100.0),
    row("rad/(N·m)", "m/N", 0.01, 1.0),
    row("N·m·s/rad", "N·s/m", 100.0, 100.0),
    row("N·m·s²/rad²", "N·s²/m²", 1000.0, 1000.0),
    row("kg·m²", "kg", 100.0, 100.0),
];

fn find(of_a_hinge: &str) -> Option<&'static Row> {
    ROWS.iter().find(|row| row.hinge == of_a_hinge)
}

/// The unit of a hinge's number where the joint slides: m for rad, and N for N·m.
pub(crate) fn unit_of_slide(of_a_hinge: &str) -> &str {
    find(of_a_hinge).map_or(of_a_hinge, |row| row.slide)
}

impl Row {
    /// Bounds of a hinge as those of a slide. A least number above 0 is a size, and shrinks with the typical one.
    fn bounds(&self, (min, max): (f64, f64)) -> (f64, f64) {
        (if min > 0.0 { min * self.typical.min(1.0) } else { min * self.greatest }, max * self.greatest)
    }
}

/// The bounds of a number in a file, which does not say which joints slide: those of hinges and of slides together.
pub(super) fn bounds_of_any_joint(c: &Coefficient) -> (f64, f64) {
    let (min, max) = find(&c.unit).map_or((c.min, c.max), |row| row.bounds((c.min, c.max)));
    (min.min(c.min), max.max(c.max))
}

/// The same entry with units, sizes and bounds of slides in the numbers of joints that slide.
pub(crate) fn in_units_of_joints(mut entry: Effect, slides: &[bool]) -> Effect {
    for (coefficient, plausible) in entry.coefficients.iter_mut().zip(&mut entry.plausible) {
        let joint = coefficient.number.and_then(|number| number.checked_sub(1));
        let slides = joint.and_then(|joint| slides.get(joint)) == Some(&true);
        let Some(row) = find(&coefficient.unit).filter(|_| slides) else { continue };
        coefficient.unit = row.slide.into();
        coefficient.typical *= row.typical;
        (coefficient.min, coefficient.max) = row.bounds((coefficient.min, coefficient.max));
        *plausible = row.bounds(*plausible);
    }
    entry
}

#[cfg(test)]
mod tests {
    use super::super::{RobotEffect, all};
    use super::*;

    #[test]
    fn a_slide_has_units_of_a_slide() {
        let units = |name: &str| -> Vec<String> {
            let entry = RobotEffect::find(name).unwrap().entry(&["a", "b"], |_| true);
            in_units_of_joints(entry, &[false, true]).coefficients.iter().map(|c| c.unit.to_string()).collect()
        };
        assert_eq!(units("command_offset"), ["rad", "m"]);
        assert_eq!(units("speed_limit"), ["s/rad", "s/m"]);
        assert_eq!(units("quadratic_friction"), ["N·m·s²/rad²", "N·s²/m²"]);
        for effect in all() {
            let entry = in_units_of_joints(effect.entry(&["a"], |_| true), &[true]);
            let of_hinge = |c: &Coefficient| c.number.is_some() && c.unit.contains("rad");
            assert!(!entry.coefficients.iter().any(of_hinge), "{}: {:?}", effect.name, entry.coefficients);
        }
    }

    /// What slides do in practice, from data sheets: a spindle at 5 mm/s, guides with 300 N of friction, a rotor of 10⁻⁴ kg·m² behind a pitch of
    /// 5 mm (158 kg), a belt with 20 N/mm.
    #[test]
    fn bounds_of_slides_hold_what_slides_do() {
        let of = |name: &str| {
            let entry = in_units_of_joints(RobotEffect::find(name).unwrap().entry(&["z"], |_| true), &[true]);
            (entry.coefficients[0].clone(), entry.plausible[0])
        };
        let fits = [
            ("speed_limit", 1.0 / 0.005),
            ("coulomb_friction", 300.0),
            ("viscous_friction", 2000.0),
            ("armature", 158.0),
            ("joint_spring", 20e3),
            ("joint_elasticity", 1.0 / 20e3),
            ("quadratic_friction", 200.0),
            ("command_offset", 0.05),
            ("firmware_damping", 20.0),
        ];
        for (name, value) in fits {
            let (c, (low, high)) = of(name);
            assert!((low..=high).contains(&value) && (c.min..=c.max).contains(&value), "{name}: {c:?}");
        }
        let hinge = RobotEffect::find("speed_limit").unwrap().entry(&["a"], |_| true);
        let kept = in_units_of_joints(hinge.clone(), &[false]);
        assert_eq!((kept.coefficients, kept.plausible), (hinge.coefficients, hinge.plausible));
    }

    #[test]
    fn every_entry_stays_in_order_and_no_bound_is_narrower() {
        for effect in all() {
            let hinge = effect.entry(&["a"], |_| true);
            let slide = in_units_of_joints(hinge.clone(), &[true]);
            for (k, (own, c)) in hinge.coefficients.iter().zip(&slide.coefficients).enumerate() {
                let (plausible, (low, high)) = (hinge.plausible[k], slide.plausible[k]);
                assert!(c.min <= own.min && own.max <= c.max, "{}: {c:?}", effect.name);
                assert!(low <= plausible.0 && plausible.1 <= high, "{}", effect.name);
                assert!(c.min <= low && high <= c.max && (c.min..=c.max).contains(&c.absent), "{}: {c:?}", effect.name);
                if effect.per_joint {
                    assert_eq!(bounds_of_any_joint(own), (c.min, c.max), "{}", effect.name);
                }
            }
        }
    }
}
