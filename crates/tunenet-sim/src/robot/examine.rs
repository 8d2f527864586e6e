//! What is wrong with a recording of joints: units, clocks, a joint that stands still, jumps, and a log of what commanded it.

use tunenet_core::Result;
use tunenet_core::observation::{
    Check, Circumstances, Note, Observation, State, lattice_step, noise_sd, with_decimals,
};
use tunenet_core::simulator::{Preparation, Prepared, Rejected};
use tunenet_core::statistics::{dot, median, range};

use super::layout::{Layout, Reading, goals};
use super::limits::{another_zero, at_a_stop, beyond_command_range, beyond_limits, many_turns};
use super::numbers::{JointNumbers, NO_RANGE};
use super::start;
use super::step_error::step_error;
use super::trajectory::Quantity;
use crate::findings;

/// A sample this much farther from the median of the seven around it than the motion there explains is a jump of the reading, rad or m.
const JUMP: f64 = 0.25;
/// Samples that are farther apart than this, s, show no motion of a joint.
const RARE_S: f64 = 1.0;
/// A pause this long, s, and this many times the usual one, is a gap.
const GAP_S: f64 = 0.5;
const GAP_PERIODS: f64 = 20.0;
const WINDOW: usize = 7;
/// Positions that move by less than so many steps of the encoder stand still.
const STILL_STEPS: f64 = 3.0;
/// Commands that move more than so many times as far as the joint are in another unit: degrees are 57 times as many.
const OTHER_UNIT: f64 = 20.0;
/// A joint that moves so many times as far as its commands, or the reverse, within this share, is in another unit than they are, where they
/// explain so much of its variance at one of so many lags.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
const NEAR_DEGREES: f64 = 0.25;
const FOLLOWS: f64 = 0.8;
/// Commands explain less than this share of what they explain with the other sign.
const AGAINST: f64 = 0.5;
const FOLLOWING_LAGS: u32 = 25;
/// Steps of a joint span less than one of so many parts of its way.
const SMALL_STEPS: f64 = 3.0;
/// Commands that jump between few values, by this much at least, are no motion of a joint that is as near to them at every sample, as a share
/// of the jump.
const LEAST_JUMP: f64 = 0.01;
const JUMP_ALIKE: f64 = 0.01;
/// Commands that change faster than this from one sample to the next, rad/s or m/s, jump: no joint follows them at once.
const TOO_FAST: f64 = 15.0;
/// Positions follow a jump at once that are this near to the commands before and after it, as a share of the largest jump.
const NEAR_JUMP: f64 = 0.1;
/// Commands that fit this much later (s) are on another clock: a servo with a low gain and a heavy load follows 0.7 s late.
const OTHER_CLOCK_S: f64 = 0.85;
/// Lags that are tried, s, and as a share of the recording, whose middle is compared at all of them.
const LONGEST_LAG_S: f64 = 2.0;
const LONGEST_LAG: f64 = 1.0 / 3.0;
/// The middle has at least this share of the whole recording's variance.
const LEAST_MOTION: f64 = 0.05;
const LAG_STEP_S: f64 = 0.02;
/// A correlation at another lag has to leave so much less of the variance.
const CLEARER: f64 = 0.3;

/// A recording examined; `joints` are those of its setup, which are simulated in steps of `step_s`.
pub(super) fn examine(
    layout: &Layout,
    (joints, step_s): (&[JointNumbers], f64),
    mut prepared: Box<Prepared>,
) -> Result<Preparation> {
    prepared.discrepancy = true;
    let mut checks = Vec::new();
    let (seen, jumps) = without_jumps(layout, &prepared.seen)?;
    if jumps > 0 {
        let what = if jumps == 1 { "1 sample jumps".into() } else { format!("{jumps} samples jump") };
        let text = format!(
            "{what} by more than {JUMP} rad or m from the others near it, and {} left out",
            if jumps == 1 { "is" } else { "are" }
        );
        checks.push(noticed(Note::new(
            findings::ROBOT_JUMPS,
            text,
            "none needed; check the wiring where there are many",
        )));
    }
    prepared.seen = seen;
    if let Some(note) = rare(prepared.seen.clock()) {
        return Ok(rejected(note, checks));
    }
    checks.extend(gap(prepared.seen.clock()).map(noticed));
    let known = prepared.circumstances.clone().unwrap_or_default();
    for (channel, reading) in layout.readings.iter().enumerate() {
        if reading.quantity != Quantity::Position {
            continue;
        }
        match position(layout, (&prepared.seen, channel, *reading), goals(layout, joints, &known, reading.joint)) {
            Some((note, true)) => return Ok(rejected(note, checks)),
            Some((note, false)) => checks.push(noticed(note)),
            None => {}
        }
        checks.extend(zero(layout, &prepared.seen, (channel, reading.joint)).map(noticed));
    }
    let clock = prepared.seen.clock();
    checks.extend((0..joints.len()).filter_map(|joint| clipped(layout, joints, &known, joint, clock)).map(noticed));
    prepared.noise = Some((0..prepared.seen.channels().len()).map(|channel| noise(&prepared.seen, channel)).collect());
    let step_s = step_s.max(layout.model_step_s);
    prepared.step_error =
        Some((0..prepared.seen.channels().len()).map(|channel| step_error(&prepared.seen, channel, step_s)).collect());
    checks.extend(start::at_median(layout, joints, &mut prepared).into_iter().map(noticed));
    prepared.notes.extend(layout.notes.iter().cloned());
    prepared.notes.extend(checks.iter().filter_map(Check::note));
    prepared.checks.extend(checks);
    Ok(Preparation::Usable(prepared))
}

/// That a joint has another zero than its model.
fn zero(layout: &Layout, seen: &Observation, (channel, joint): (usize, usize)) -> Option<Note> {
    let shown = seen.channels().get(channel).filter(|channel| channel.unit == "rad")?;
    let values: Vec<f64> = seen.column(channel).collect();
    another_zero(&shown.header(), &values, layout.limits[joint], layout.zeros[joint])
}

/// That a copy of the model clips the commands of a joint, and the simulation does not.
fn clipped(
    layout: &Layout,
    joints: &[JointNumbers],
    known: &Circumstances,
    joint: usize,
    clock: &[f64],
) -> Option<Note> {
    let range = layout.command_ranges.get(joint).copied().flatten()?;
    if joints.get(joint)?.command_range != NO_RANGE {
        return None;
    }
    let goal = goals(layout, joints, known, joint)?;
    let command = layout.wiring[joint].command.and_then(|place| known.inputs.get(place))?;
    let name = command.series().channels().first()?.header();
    let values: Vec<f64> = clock.iter().map(|time| goal(*time)).collect();
    beyond_command_range(&name, &values, range)
}

/// The recording refused, after these checks.
fn rejected(note: Note, mut checks: Vec<Check>) -> Preparation {
    let (text, remedy) = (note.text.clone(), note.remedy.clone());
    checks.push(Check { kind: note.kind, state: State::Failed, text, remedy });
    Preparation::Rejected(Box::new(Rejected { note, checks }))
}

/// That samples are so far apart that they show no motion of a joint, and a rollout between them takes for ever.
fn rare(clock: &[f64]) -> Option<Note> {
    rare_samples(median(clock.windows(2).map(|two| two[1] - two[0]))?)
}

/// That samples with this period, s, show no motion of a joint, where they do not.
#[must_use]
pub fn rare_samples(period_s: f64) -> Option<Note> {
    if period_s.is_nan() || period_s <= RARE_S {
        return None;
    }
    let text = format!(
        "samples are {} s apart: expected {RARE_S} s at most, in which a joint moves little",
        with_decimals(period_s, 2)
    );
    let remedy = "state the unit of the clock (`t_ms` where it counts ms), or record more often";
    Some(Note::new(findings::ROBOT_RARE, text, remedy))
}

/// The longest pause of a clock, where it is much longer than the others: a simulation goes on in it with the last command.
fn gap(clock: &[f64]) -> Option<Note> {
    let pauses = || clock.windows(2).map(|two| two[1] - two[0]);
    let (before, longest_s) = pauses().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    if longest_s < GAP_S || longest_s < GAP_PERIODS * median(pauses())? {
        return None;
    }
    let text = format!(
        "no samples for {} s after {} s: the simulation holds the last commands meanwhile",
        with_decimals(longest_s, 2),
        with_decimals(clock[before], 2)
    );
    let remedy = "correct the stamps, or give the parts before and after as recordings of their own";
    Some(Note::new(findings::ROBOT_GAP, text, remedy))
}

fn noticed(note: Note) -> Check {
    Check { kind: note.kind, state: State::Noticed, text: note.text, remedy: note.remedy }
}

/// The recording without samples whose position jumps, and how many those were.
fn without_jumps(layout: &Layout, seen: &Observation) -> Result<(Observation, usize)> {
    let mut kept = vec![true; seen.len()];
    for (channel, _) in layout.readings.iter().enumerate().filter(|(_, one)| one.quantity == Quantity::Position) {
        let values: Vec<f64> = seen.column(channel).collect();
        kept.iter_mut().zip(within_motion(&values)).for_each(|(kept, within)| *kept &= within);
    }
    let jumps = kept.iter().filter(|kept| !**kept).count();
    if jumps == 0 {
        return Ok((seen.clone(), 0));
    }
    let rows = || (0..seen.len()).filter(|&i| kept[i]);
    let clock = rows().map(|i| seen.clock()[i]).collect();
    let values = rows().flat_map(|i| seen.row(i).to_vec()).collect();
    let cut = Observation::new(seen.kind(), seen.channels().to_vec(), clock, values)?;
    let circumstances = seen.circumstances().map(|known| Circumstances::clone(known));
    Ok((circumstances.map_or(cut.clone(), |known| cut.under(known)), jumps))
}

/// For each value whether it is as near to the others around it as they move.
fn within_motion(values: &[f64]) -> Vec<bool> {
    let within = |(i, value): (usize, &f64)| {
        let first = i.saturating_sub(WINDOW / 2).min(values.len().saturating_sub(WINDOW));
        let near = &values[first..(first + WINDOW).min(values.len())];
        // What moves fast is far from the middle of its window at the ends of the record and where it turns back.
        let moves = median(near.windows(2).map(|two| (two[1] - two[0]).abs())).unwrap_or(0.0);
        let most = JUMP + WINDOW as f64 / 2.0 * moves;
        median(near.iter().copied()).is_none_or(|middle| (value - middle).abs() <= most)
    };
    values.iter().enumerate().map(within).collect()
}

/// The step of an encoder, 0 where the values show none.
fn encoder_step(values: &[f64]) -> f64 {
    lattice_step(values).unwrap_or(0.0)
}

/// The noise of a channel: that of its third differences, and of its encoder where that is larger.
fn noise(seen: &Observation, channel: usize) -> f64 {
    let values: Vec<f64> = seen.column(channel).collect();
    noise_sd(&values).max(encoder_step(&values) / 12f64.sqrt()).max(1e-6)
}

/// What is wrong with a position, and whether the recording cannot be used.
fn position(
    layout: &Layout,
    (seen, channel, reading): (&Observation, usize, Reading),
    goal: Option<impl Fn(f64) -> f64 + Copy>,
) -> Option<(Note, bool)> {
    let values: Vec<f64> = seen.column(channel).collect();
    let name = seen.channels()[channel].header();
    let moved = range(values.iter().copied());
    let limits = layout.limits[reading.joint];
    if let Some(beyond) = beyond_limits(&name, moved, (limits[1] - limits[0], &seen.channels()[channel].unit)) {
        return Some((beyond, true));
    }
    let goal = goal?;
    let goals: Vec<f64> = seen.clock().iter().map(|t| goal(*t)).collect();
    let commanded = range(goals.iter().copied());
    if layout.follows[reading.joint]
        && let Some(how) = of_the_leader(seen.clock(), (&goals, &values))
    {
        let text = format!("`{name}` {how}: this is what commanded it, not what it did");
        let remedy = "record the positions of the follower, not of the leader";
        return Some((Note::new(findings::ROBOT_LEADER, text, remedy), true));
    }
    if moved <= STILL_STEPS * encoder_step(&values) || moved == 0.0 {
        let text = format!("`{name}` never moves");
        let remedy = "leave the joint out of [joints], or record it while it moves";
        return Some((Note::new(findings::ROBOT_STILL, text, remedy), false));
    }
    if !layout.follows[reading.joint] {
        return None;
    }
    if commanded > OTHER_UNIT * moved && commanded > 2.0 * std::f64::consts::TAU {
        let text = format!(
            "commands of `{name}` span {}, and it moves by {}: expected one unit, found two (degrees?)",
            with_decimals(commanded, 2),
            with_decimals(moved, 2)
        );
        let remedy = "name the column of commands with its unit (goal_deg), or convert it";
        return Some((Note::new(findings::ROBOT_UNITS, text, remedy), true));
    }
    if let Some(share) = following(seen.clock(), &values, goal)
        && [share, share.recip()].iter().any(|share| (share / DEGREES - 1.0).abs() < NEAR_DEGREES)
    {
        let (further, which) = if share > 1.0 { (share, "moves") } else { (share.recip(), "is commanded") };
        let other = if share > 1.0 { "is commanded" } else { "moves" };
        let text = format!(
            "`{name}` {which} {} times as far as it {other}: expected one unit, found two (degrees and radians?)",
            with_decimals(further, 1)
        );
        let remedy = "state the unit of the commands and that of the positions, each as it was recorded";
        return Some((Note::new(findings::ROBOT_UNITS, text, remedy), true));
    }
    if commanded < moved / SMALL_STEPS && follows_as_steps(seen.clock(), &values, goal) {
        let text = format!(
            "commands of `{name}` span {} and follow its speed: expected positions to go to, found steps",
            with_decimals(commanded, 3)
        );
        let remedy = "record the positions that it was sent to, or add up the steps";
        return Some((Note::new(findings::ROBOT_STEPS, text, remedy), true));
    }
    let share = |sign: f64| explained(seen.clock(), &values, |t| sign * goal(t)).map_or(0.0, |(share, _)| share);
    if share(-1.0) > FOLLOWS && share(1.0) < AGAINST * share(-1.0) {
        let text = format!("`{name}` moves against its commands: expected one sign, found two");
        let remedy = "turn the sign of the column of commands or of positions: a `-` before its name in `--columns`";
        return Some((Note::new(findings::ROBOT_SIGN, text, remedy), false));
    }
    let unlimited_rad = limits[0] == f64::NEG_INFINITY && seen.channels()[channel].unit == "rad";
    if let Some(turns) = unlimited_rad.then(|| many_turns(&name, moved)).flatten() {
        return Some((turns, false));
    }
    if let Some(stopped) = at_a_stop(&name, (seen.clock(), &values, &goals), limits) {
        return Some((stopped, false));
    }
    let lag = best_lag(seen.clock(), &values, goal)?;
    (lag.abs() > OTHER_CLOCK_S).then(|| {
        let early = if lag > 0.0 { "before" } else { "after" };
        let text = format!("commands of `{name}` come {} s {early} its motion", with_decimals(lag.abs(), 2));
        let remedy = "give both the same clock; a command that comes after the motion that it causes explains nothing";
        (Note::new(findings::ROBOT_CLOCK, text, remedy), false)
    })
}

/// How positions show that they are their commands, where they do.
fn of_the_leader(clock: &[f64], (goals, values): (&[f64], &[f64])) -> Option<&'static str> {
    if is_alike(goals, values) {
        Some("equals its commands at every sample")
    } else if goals.len() > 1 && is_alike(&goals[..goals.len() - 1], &values[1..]) {
        Some("equals its commands of the sample before")
    } else if (0..=1).any(|late| jumps_with(clock, (goals, values), late)) {
        Some("jumps with its commands, faster than a joint moves")
    } else {
        None
    }
}

/// Whether commands jump faster than a joint moves, and positions jump as far so many samples later.
fn jumps_with(clock: &[f64], (goals, values): (&[f64], &[f64]), late: usize) -> bool {
    let jump = |i: usize| goals[i] - goals[i - 1];
    let fast = |i: &usize| jump(*i).abs() > TOO_FAST * (clock[*i] - clock[*i - 1]);
    let jumps: Vec<usize> = (1..goals.len().saturating_sub(late)).filter(fast).collect();
    let largest = jumps.iter().map(|&i| jump(i).abs()).fold(0.0, f64::max);
    let with = |&i: &usize| {
        let near = |i: usize| (values[i + late] - goals[i]).abs() < NEAR_JUMP * largest;
        near(i - 1) && near(i)
    };
    !jumps.is_empty() && jumps.iter().all(with)
}

/// Whether positions are their commands, up to the resolution of an encoder.
fn is_alike(goals: &[f64], values: &[f64]) -> bool {
    let (commanded, resolution) = (range(goals.iter().copied()), encoder_step(values).max(1e-6));
    // Where commands jump and so do these values, the smallest step of them is a jump, and no encoder's.
    let alike = if commanded > 10.0 * resolution { resolution } else { JUMP_ALIKE * commanded };
    commanded > LEAST_JUMP && goals.iter().zip(values).all(|(goal, q)| (goal - q).abs() <= alike)
}

/// The values less their mean.
fn centred(values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.into_iter().map(|v| v - mean).collect()
}

/// How much of the variance of `values` the commands explain, and by how much these change with them: by least squares at the lag with
/// the greatest correlation.
fn explained(clock: &[f64], values: &[f64], command: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
    let seen = centred(values.to_vec());
    let at_lag = |lag: f64| {
        let goals = centred(clock.iter().map(|t| command(t - lag)).collect());
        let (both, goal, own) = (dot(&goals, &seen), dot(&goals, &goals), dot(&seen, &seen));
        (goal > 0.0 && own > 0.0).then(|| (both.max(0.0).powi(2) / (goal * own), both / goal))
    };
    let lags = (0..=FOLLOWING_LAGS).map(|step| f64::from(step) * LAG_STEP_S);
    lags.filter_map(at_lag).max_by(|a, b| a.0.total_cmp(&b.0))
}

/// How far a joint moves for each rad of its commands, where it follows them at all.
fn following(clock: &[f64], values: &[f64], command: impl Fn(f64) -> f64) -> Option<f64> {
    explained(clock, values, command).filter(|(share, _)| *share > FOLLOWS).map(|(_, slope)| slope)
}

/// Whether a joint goes by its commands, not to them: these explain its speed, and that better than its position.
fn follows_as_steps(clock: &[f64], values: &[f64], command: impl Fn(f64) -> f64) -> bool {
    let speeds = values.windows(2).zip(clock.windows(2)).map(|(q, t)| (q[1] - q[0]) / (t[1] - t[0]));
    let speeds: Vec<f64> = speeds.collect();
    let share = |found: Option<(f64, f64)>| found.map_or(0.0, |(share, _)| share);
    let by_speed = share(explained(&clock[..speeds.len()], &speeds, &command));
    by_speed > FOLLOWS && by_speed > share(explained(clock, values, &command))
}

/// How much later (s) than the commands the motion is, by the greatest correlation of both; `None` where no lag is far better than none.
fn best_lag(clock: &[f64], values: &[f64], command: impl Fn(f64) -> f64) -> Option<f64> {
    let (first, last) = (*clock.first()?, *clock.last()?);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    let longest = LONGEST_LAG_S.min(LONGEST_LAG * (last - first));
    let unexplained = |lag: f64| {
        let (begin, end) = (first + longest, last - longest);
        let inside: Vec<usize> = (0..clock.len()).filter(|&i| (begin..=end).contains(&clock[i])).collect();
        if inside.len() < 20 {
            return 1.0;
        }
        let goals = centred(inside.iter().map(|&i| command(clock[i] - lag)).collect());
        let seen = centred(inside.iter().map(|&i| values[i]).collect());
        // A part in which the joint hardly moves says nothing of lags.
        if dot(&seen, &seen) / (seen.len() as f64) < LEAST_MOTION * variance {
            return 1.0;
        }
        let both = dot(&goals, &goals) * dot(&seen, &seen);
        if both > 0.0 { 1.0 - dot(&goals, &seen).max(0.0).powi(2) / both } else { 1.0 }
    };
    let steps = (2.0 * longest / LAG_STEP_S).floor();
    let mut best = (0.0, unexplained(0.0));
    let now = best.1;
    let mut step = 0.0;
    while step <= steps {
        let lag = step * LAG_STEP_S - longest;
        let left = unexplained(lag);
        if left < best.1 {
            best = (lag, left);
        }
        step += 1.0;
    }
    (best.1 < CLEARER * now).then_some(best.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A periodic command says nothing: half a period later it has the other sign.
    #[test]
    fn commands_of_the_other_sign_explain_nothing_by_themselves() {
        let clock: Vec<f64> = (0..300).map(|i| 0.02 * f64::from(i)).collect();
        let chirp = |t: f64| (t * t).sin();
        let against: Vec<f64> = clock.iter().map(|t| -chirp(t - 0.1)).collect();
        let share = |sign: f64| explained(&clock, &against, |t| sign * chirp(t)).map_or(0.0, |(share, _)| share);
        assert!(share(-1.0) > FOLLOWS && share(1.0) < AGAINST * share(-1.0), "{} {}", share(-1.0), share(1.0));
    }

    #[test]
    fn a_pause_is_noticed_and_an_uneven_clock_is_not() {
        let clock = |late_s: f64| -> Vec<f64> {
            (0..100).map(|i| 0.02 * f64::from(i) + if i < 40 { 0.0 } else { late_s }).collect()
        };
        let text = gap(&clock(9.0)).unwrap().text;
        assert_eq!(text, "no samples for 9.02 s after 0.78 s: the simulation holds the last commands meanwhile");
        assert!(gap(&clock(0.3)).is_none());
        let slow: Vec<f64> = (0..20).map(f64::from).collect();
        assert!(gap(&slow).is_none() && gap(&[]).is_none());
        assert!(rare(&slow).is_none() && rare(&[]).is_none());
        let text = rare(&[0.0, 20.0, 40.0]).unwrap().text;
        assert_eq!(text, "samples are 20.00 s apart: expected 1 s at most, in which a joint moves little");
    }

    /// Noise and a delay of one sample do not hide a leader; a fast follower is none.
    #[test]
    fn a_leader_jumps_with_its_commands() {
        let clock: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
        let goals: Vec<f64> = clock.iter().map(|t| 0.5 * (t / 0.8).floor()).collect();
        let noise = |i: usize| 0.003 * (1.7 * i as f64 * i as f64).sin();
        let leader =
            |late: usize| -> Vec<f64> { (0..goals.len()).map(|i| goals[i.saturating_sub(late)] + noise(i)).collect() };
        let jumps = Some("jumps with its commands, faster than a joint moves");
        assert_eq!([0, 1].map(|late| of_the_leader(&clock, (&goals, &leader(late)))), [jumps; 2]);
        let exact: Vec<f64> = (0..goals.len()).map(|i| clock[i.saturating_sub(1)].sin()).collect();
        let smooth: Vec<f64> = clock.iter().map(|t| t.sin()).collect();
        assert_eq!(of_the_leader(&clock, (&smooth, &exact)), Some("equals its commands of the sample before"));
        let mut position = 0.0;
        let follower: Vec<f64> = goals
            .iter()
            .map(|goal| {
                position += (goal - position).clamp(-0.12, 0.12);
                position
            })
            .collect();
        assert_eq!(of_the_leader(&clock, (&goals, &follower)), None);
        let slow: Vec<f64> = (0..40).map(f64::from).collect();
        assert_eq!(of_the_leader(&slow, (&goals[..40], &leader(0)[..40])), None, "there is time between the samples");
    }

    #[test]
    fn a_joint_that_follows_shows_in_which_unit_its_commands_are() {
        let clock: Vec<f64> = (0..300).map(|i| 0.01 * f64::from(i)).collect();
        let goal = |t: f64| (3.0 * t).sin();
        let late = |scale: f64| clock.iter().map(|t| scale * 0.9 * goal(t - 0.1)).collect::<Vec<f64>>();
        let found = following(&clock, &late(DEGREES), goal).unwrap();
        assert!((found / (0.9 * DEGREES) - 1.0).abs() < 0.02, "{found}");
        assert!((following(&clock, &late(1.0), goal).unwrap() - 0.9).abs() < 0.02);
        let swings: Vec<f64> = clock.iter().map(|t| 40.0 * (11.0 * t).cos()).collect();
        assert_eq!(following(&clock, &swings, goal), None);
    }

    #[test]
    fn steps_are_followed_by_the_speed_and_goals_by_the_position() {
        let clock: Vec<f64> = (0..400).map(|i| 0.02 * f64::from(i)).collect();
        let goal = |t: f64| 0.6 * (1.1 * t).sin() + 0.4 * (2.7 * t).cos();
        let late: Vec<f64> = clock.iter().map(|t| goal(t - 0.1)).collect();
        let step = |t: f64| goal(t + 0.02) - goal(t);
        assert!(follows_as_steps(&clock, &late, step));
        assert!(!follows_as_steps(&clock, &late, goal));
    }

    #[test]
    fn a_glitch_jumps_and_a_fast_motion_does_not() {
        // 9 rad/s at 50 Hz, back and forth.
        let fast: Vec<f64> = (0..60i32).map(|i| 0.18 * f64::from((i % 20 - 10).abs())).collect();
        assert!(within_motion(&fast).iter().all(|within| *within));
        for at in [0, 7, 59] {
            let mut glitch: Vec<f64> = (0..60).map(|i| 0.02 * f64::from(i)).collect();
            glitch[at] += 0.5;
            let found = within_motion(&glitch);
            assert!((0..60).all(|i| found[i] == (i != at)), "{at}: {found:?}");
        }
    }
}
