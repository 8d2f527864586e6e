//! Pairs of `--columns` that stand for one of each joint: `q1..6_rad=2..7`, `tau1..6_nm=effort_*`.

use crate::quantity::{Meaning, meaning};
use crate::{Origin, Result};

/// Most joints that one pair may stand for.
const MOST: u16 = 1000;

/// `mapping` with every pair for a range of joints written out. `names` are the file's columns; a `*` stands for the number of the
/// joint, counted from 0 where the file does.
///
/// # Errors
/// [`Setting`](tunenet_core::Error::Setting) where a range cannot be what it says.
pub(crate) fn written_out(mapping: &[(String, String)], names: &[&str]) -> Result<Vec<(String, String)>> {
    let mut all = Vec::with_capacity(mapping.len());
    for (ours, theirs) in mapping {
        match range(ours) {
            Some((family, first, last, unit)) => {
                let one = |joint: u16| format!("{family}{joint}_{unit}");
                let known = matches!(meaning(&one(first.max(1))), Meaning::Known(..));
                if !known || first == 0 || last < first || last - first >= MOST {
                    return refused("joints counted from 1 and a unit, as in `q1..6_rad=2..7`", ours);
                }
                for (joint, theirs) in (first..=last).zip(columns(theirs, first, last, names)?) {
                    all.push((one(joint), theirs));
                }
            }
            None => all.push((ours.clone(), theirs.clone())),
        }
    }
    Ok(all)
}

/// `q1..6_rad` as its family, first, last and unit.
fn range(ours: &str) -> Option<(&str, u16, u16, &str)> {
    let (start, end) = ours.split_once("..")?;
    let digits = start.find(|c: char| c.is_ascii_digit())?;
    let (last, unit) = end.split_once('_')?;
    Some((&start[..digits], start[digits..].parse().ok()?, last.parse().ok()?, unit))
}

fn columns(theirs: &str, first: u16, last: u16, names: &[&str]) -> Result<Vec<String>> {
    let count = usize::from(last - first) + 1;
    if let Some(bare) = theirs.strip_prefix('-').filter(|_| !names.iter().any(|name| name.starts_with('-'))) {
        return Ok(columns(bare, first, last, names)?.into_iter().map(|column| format!("-{column}")).collect());
    }
    if let Some((from, to)) = theirs.split_once("..") {
        return match (from.parse::<usize>(), to.parse::<usize>()) {
            (Ok(from), Ok(to)) if from > 0 && to >= from && to - from + 1 == count => {
                Ok((from..=to).map(|n| n.to_string()).collect())
            }
            _ => refused(&format!("{count} columns, one for each joint, as in `2..{}`", count + 1), theirs),
        };
    }
    if theirs.matches('*').count() != 1 {
        return refused("column numbers `2..7`, or a name with one `*` for the joint's number", theirs);
    }
    let named = |number: u16| theirs.replace('*', &number.to_string());
    let there = |number: u16| names.contains(&named(number).as_str());
    // Files that count from 0 have a column 0 and none with the last joint's number.
    let from = u16::from(!there(first - 1) || there(last));
    Ok((first..=last).map(|joint| named(joint - 1 + from)).collect())
}

fn refused<T>(expected: &str, found: &str) -> Result<T> {
    Err(tunenet_core::Error::Setting {
        origin: Origin::Flag,
        name: "columns",
        expected: expected.into(),
        found: format!("`{found}`"),
    }
    .into())
}

#[cfg(test)]
mod tests {
    use crate::Error;

    use super::*;

    fn out(ours: &str, theirs: &str, names: &[&str]) -> Result<String> {
        let pairs = written_out(&[(ours.into(), theirs.into())], names)?;
        Ok(pairs.iter().map(|(a, b)| format!("{a}={b}")).collect::<Vec<_>>().join(","))
    }

    #[test]
    fn a_range_is_one_pair_for_each_joint() {
        assert_eq!(out("q1..3_rad", "2..4", &[]).unwrap(), "q1_rad=2,q2_rad=3,q3_rad=4");
        assert_eq!(out("tau1..2_nm", "eff_*", &["eff_1", "eff_2"]).unwrap(), "tau1_nm=eff_1,tau2_nm=eff_2");
        assert_eq!(out("dq1..2_deg_s", "v*", &["v0", "v1"]).unwrap(), "dq1_deg_s=v0,dq2_deg_s=v1");
        assert_eq!(out("tau1..2_nm", "-v*", &["v0", "v1"]).unwrap(), "tau1_nm=-v0,tau2_nm=-v1");
        assert_eq!(out("q1..2_rad", "-2..3", &[]).unwrap(), "q1_rad=-2,q2_rad=-3");
        assert_eq!(out("t_s", "time", &[]).unwrap(), "t_s=time");
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for (ours, theirs) in
            [("q1..3_rad", "2..5"), ("q0..3_rad", "2..5"), ("q3..1_rad", "a*"), ("q1..3_rad", "a"), ("w1..3_x", "2..4")]
        {
            assert!(
                matches!(
                    out(ours, theirs, &[]),
                    Err(Error::Core(tunenet_core::Error::Setting { name: "columns", .. }))
                ),
                "{ours}={theirs}"
            );
        }
    }
}
