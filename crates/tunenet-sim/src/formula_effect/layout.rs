//! Which of a candidate's numbers belongs to which direction.

/// The order of the numbers of a formula: coefficient by coefficient, one for every direction where it has its own there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    directions: usize,
    /// Whether a coefficient has one number for every direction.
    each: Vec<bool>,
}

impl Layout {
    pub fn new(directions: usize, each: Vec<bool>) -> Self {
        Self { directions, each }
    }

    /// Puts the coefficients of one direction into `into`, one for each coefficient.
    pub fn fill(&self, values: &[f64], direction: usize, into: &mut [f64]) {
        let mut first = 0;
        for (each, into) in self.each.iter().zip(into) {
            *into = values[first + if *each { direction } else { 0 }];
            first += if *each { self.directions } else { 1 };
        }
    }

    /// How many coefficients a formula sees.
    pub fn coefficients(&self) -> usize {
        self.each.len()
    }

    /// How many numbers there are in all.
    pub fn numbers(&self) -> usize {
        self.each.iter().map(|each| if *each { self.directions } else { 1 }).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_takes_its_own_numbers_and_the_shared_ones() {
        let layout = Layout::new(2, vec![true, false, true]);
        assert_eq!((layout.numbers(), layout.coefficients()), (5, 3));
        let mut seen = [0.0; 3];
        layout.fill(&[1.0, 2.0, 3.0, 4.0, 5.0], 1, &mut seen);
        assert_eq!(seen, [2.0, 3.0, 5.0]);
        layout.fill(&[1.0, 2.0, 3.0, 4.0, 5.0], 0, &mut seen);
        assert_eq!(seen, [1.0, 3.0, 4.0]);
    }
}
