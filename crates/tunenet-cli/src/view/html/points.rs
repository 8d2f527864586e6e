//! Points of a curve, and fewer of them.

/// Places of a drawing: the instant and the value of each.
pub type Points = Vec<(f64, f64)>;

/// An even choice of at most about `most` points, the last one among them.
pub fn thinned(points: &[(f64, f64)], most: usize) -> Points {
    let every = points.len().div_ceil(most).max(1);
    let last = points.last().filter(|_| !(points.len().max(1) - 1).is_multiple_of(every));
    points.iter().step_by(every).chain(last).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_choice_keeps_both_ends() {
        let points: Points = (0..10).map(|i| (f64::from(i), 0.0)).collect();
        let chosen: Vec<f64> = thinned(&points, 4).iter().map(|p| p.0).collect();
        assert_eq!(chosen, [0.0, 3.0, 6.0, 9.0]);
        assert_eq!(thinned(&points, 5).last(), Some(&(9.0, 0.0)));
        assert!(thinned(&[], 4).is_empty());
    }
}
