//! What a bounce returns: a formula of the speeds before it, added to the coefficient of restitution.

use std::sync::Arc;

use tunenet_formula::Formula;

use super::layout::Layout;
use super::{MOST_COEFFICIENTS, Misfit, formula, require_unit};
use crate::scene::Candidate;

/// What a formula of a contact may use, with its unit: the speed into the surface, that of the touching point along it, and the
/// restitution without the formula.
const VARIABLES: [(&str, &str); 3] = [("vn_m_s", "m/s"), ("vt_m_s", "m/s"), ("restitution", "1")];

/// The formula.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ContactFormula {
    name: String,
    formula: Formula,
    layout: Layout,
}

impl ContactFormula {
    pub fn new(name: &str, candidate: &Candidate) -> Result<Self, Misfit> {
        for (key, given) in [
            ("along", !candidate.along.is_empty()),
            ("per_direction", !candidate.per_direction.is_empty()),
            ("centre", candidate.centre.is_some()),
        ] {
            if given {
                let expected = format!("no `{key}` where it acts at a contact, whose restitution has no direction");
                return Err(Misfit::new(key, expected, "one"));
            }
        }
        if let Some(other) = candidate.gives.as_deref().filter(|gives| *gives != "restitution") {
            let found = format!("\"{}\"", other.escape_debug());
            return Err(Misfit::new("gives", "\"restitution\" where it acts at a contact", found));
        }
        let (formula, layout) = formula(candidate, &VARIABLES, 1)?;
        require_unit(&formula, "1")?;
        Ok(Self { name: name.to_owned(), formula, layout })
    }

    /// As it was written.
    pub fn formula(&self) -> &Formula {
        &self.formula
    }
}

/// The formula with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedContact {
    formula: Arc<ContactFormula>,
    values: Vec<f64>,
}

impl AppliedContact {
    pub(crate) fn new(formula: &Arc<ContactFormula>, values: &[f64]) -> Self {
        debug_assert_eq!(values.len(), formula.layout.numbers());
        Self { formula: Arc::clone(formula), values: values.to_vec() }
    }

    /// What it adds to the coefficient of restitution.
    ///
    /// # Errors
    /// The part of the formula that has no finite value, in words without an end.
    pub(crate) fn added(&self, normal_m_s: f64, along_m_s: f64, restitution: f64) -> Result<f64, String> {
        const COUNT: usize = VARIABLES.len();
        let mut names = [0.0; COUNT + MOST_COEFFICIENTS];
        names[..COUNT].copy_from_slice(&[normal_m_s, along_m_s, restitution]);
        let layout = &self.formula.layout;
        layout.fill(&self.values, 0, &mut names[COUNT..COUNT + layout.coefficients()]);
        let formula = &self.formula.formula;
        let value = formula.program().value(&names);
        if value.is_finite() {
            return Ok(value);
        }
        let part = formula.undefined(&names);
        let (text, what) = part.map_or((formula.text(), "has no finite value"), |part| (part.text, part.what));
        Err(format!("`{text}` in `candidates.{}.formula` {what}", self.formula.name))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::candidate;
    use super::*;

    const LOSS: &str = "sentence = \"fast bounces return less\"\nacts = \"contact\"\nformula = \"-k*vn_m_s\"\n\
                        coefficients.k = { unit = \"s/m\", absent = 0.0, min = 0.0, max = 0.1 }\n";

    #[test]
    fn it_is_added_to_the_restitution() {
        let formula = Arc::new(ContactFormula::new("loss", &candidate(LOSS)).unwrap());
        let applied = AppliedContact::new(&formula, &[0.02]);
        assert!((applied.added(4.0, 1.0, 0.8).unwrap() + 0.08).abs() < 1e-15);
    }

    #[test]
    fn a_formula_without_a_value_is_refused_with_its_part() {
        let text = LOSS.replace("-k*vn_m_s", "-k*sqrt(vn_m_s^2 - 1*vt_m_s^2)");
        let formula = Arc::new(ContactFormula::new("loss", &candidate(&text)).unwrap());
        let refused = AppliedContact::new(&formula, &[0.02]).added(1.0, 2.0, 0.8).unwrap_err();
        assert_eq!(refused, "`sqrt(vn_m_s^2 - 1*vt_m_s^2)` in `candidates.loss.formula` has no real value");
    }

    #[test]
    fn a_contact_has_no_direction() {
        let refused = ContactFormula::new("loss", &candidate(&format!("{LOSS}along = [\"x\"]\n"))).unwrap_err();
        assert_eq!(refused.key, "along");
        let refused = ContactFormula::new("loss", &candidate(&LOSS.replace("vn_m_s", "vn_m_s^2"))).unwrap_err();
        assert_eq!(refused.expected, "a formula in 1");
    }
}
