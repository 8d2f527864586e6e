//! One step of a mass with dry friction, implicit in the friction: it sticks where the impulse of everything else stays within that of
//! the friction (Coulomb's law as a complementarity problem: Moreau 1988; Stewart and Trinkle 1996).

/// The speed after a step. `impulse` is what the mass would have without friction, as momentum; `per_mass` is the reciprocal of the mass, which
/// includes the share of damping that acts at the end of the step; `most` are the impulses of friction against positive and negative speed.
/// All of them may be divided by the step.
#[inline]
pub(super) fn speed_after(impulse: f64, per_mass: f64, most: (f64, f64)) -> f64 {
    if impulse > most.0 {
        (impulse - most.0) * per_mass
    } else if impulse < -most.1 {
        (impulse + most.1) * per_mass
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::speed_after;

    #[test]
    fn it_sticks_inside_the_cone_and_loses_the_cone_outside() {
        assert_eq!(speed_after(0.5, 0.5, (0.5, 0.1)), 0.0);
        assert_eq!(speed_after(1.5, 0.5, (0.5, 0.1)), 0.5);
        assert_eq!(speed_after(-0.5, 0.5, (0.5, 0.1)), -0.2);
    }
}
