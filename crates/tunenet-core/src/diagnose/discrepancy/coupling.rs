//! Relative coupling of channels: how much of what parameters do, as a root of summed squares, reaches channels other than those on which
//! they act directly. Of joints whose drives are stiff it is little, so that one rollout shows derivatives by a parameter of each (partial
//! separability: Griewank and Toint 1982).

use crate::Result;
use crate::diagnose::hypothesis::context::Context;
use crate::diagnose::hypothesis::joint::{Joint, Point, Which};
use crate::estimate::jacobian::Columns;

/// More than this is too much to leave out. Less makes some steps of a fit shorter; its last is by derivatives that were measured each.
const LITTLE: f64 = 0.5;

/// The same context, in which derivatives share rollouts where the first recording shows at the values of the files that they may.
///
/// # Errors
/// Where the structure cannot be made.
pub(in crate::diagnose) fn with_groups<'a>(context: &Context<'a>) -> Result<Context<'a>> {
    let structure = context.structure(&[])?;
    let own = |column: usize| structure.shared[column].parameter.channels.as_deref();
    let first = (0..structure.shared.len()).find_map(own);
    let several = first.is_some_and(|first| {
        (0..structure.shared.len()).filter_map(own).any(|other| other.iter().all(|channel| !first.contains(channel)))
    });
    let (true, Some(recording)) = (several, context.recordings().first()) else { return Ok(context.clone()) };
    let joint = Joint { recordings: std::slice::from_ref(recording), ..context.joint(&structure) };
    let parameters = structure.shared.iter().map(|shared| shared.parameter.value).collect();
    let point = Point { parameters, nuisances: vec![recording.prepared.nuisance_values()] };
    let Ok(residuals) = joint.residuals(&point, 1.0) else { return Ok(context.clone()) };
    let columns = joint.columns(&point, &residuals, Which { nuisances: false, ..Which::ALL });
    let span = |column: usize| structure.shared[column].parameter.span();
    let coupled = columns.iter().map(|one| coupling(one, joint.width(), (own, span))).fold(0.0, f64::max);
    let separable = coupled <= LITTLE;
    Ok(Context { separable, ..context.clone() })
}

/// The coupling of a recording with `width` channels: of all columns together, each over the `span` of its parameter; `own` are the channels
/// on which it acts directly.
fn coupling<'c>(
    columns: &Columns,
    width: usize,
    (own, span): (impl Fn(usize) -> Option<&'c [usize]>, impl Fn(usize) -> f64),
) -> f64 {
    let (mut direct, mut whole) = (0.0, 0.0);
    for (&index, column) in columns.indices.iter().zip(&columns.shared) {
        let Some(own) = own(index) else { continue };
        for (i, value) in column.iter().enumerate() {
            let square = (value * span(index)).powi(2);
            whole += square;
            direct += if own.contains(&(i % width)) { square } else { 0.0 };
        }
    }
    if whole > 0.0 { (1.0 - direct / whole).max(0.0).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::in_swings;

    #[test]
    fn coupling_is_the_share_on_other_channels() {
        // Two samples of two channels.
        let shared = vec![vec![4.0, 0.0, 0.0, 0.0], vec![0.0, 2.0, 0.0, -1.0], vec![9.0; 4], vec![3.0, 0.0, 0.0, 0.0]];
        let columns = Columns { indices: vec![0, 1, 2, 3], shared, nuisances: Vec::new() };
        let own: [Option<&[usize]>; 4] = [Some(&[0]), Some(&[1]), None, Some(&[1])];
        let of = |span: f64| coupling(&columns, 2, (|index| own[index], |index| if index == 3 { span } else { 1.0 }));
        assert!((of(1.0) - (9.0f64 / 30.0).sqrt()).abs() < 1e-12 && of(0.0) == 0.0);
    }

    #[test]
    fn a_single_channel_needs_no_groups() {
        in_swings(&[], 2, 0, |context| assert!(!with_groups(context).unwrap().separable));
    }
}
