//! Every kind of fault that a record may have, and which checks have to find it.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use tunenet_ball::findings;
use tunenet_ball::preflight::Expected;
use tunenet_core::finding::FindingKind;

use super::motion::{GRAVITY_M_S2, Record, Setup, whole};

/// A kind of fault.
pub struct Kind {
    pub name: &'static str,
    /// Checks that find it.
    pub found_by: &'static [FindingKind],
    pub make: fn(&mut ChaCha8Rng) -> (Record, Expected),
}

pub const KINDS: [Kind; 27] = [
    Kind { name: "each frame twice", found_by: &[findings::CLOCK_REPEATS], make: each_twice },
    Kind {
        name: "each frame twice, stamps stretched",
        found_by: &[findings::CLOCK_REPEATS],
        make: each_twice_stretched,
    },
    Kind { name: "some frames repeated", found_by: &[findings::CLOCK_REPEATS], make: some_repeated },
    Kind { name: "frames dropped", found_by: &[findings::CLOCK_GAPS], make: dropped },
    Kind { name: "one gap", found_by: &[findings::CLOCK_GAPS, findings::VIEW_LEFT], make: gap },
    Kind { name: "irregular clock", found_by: &[findings::CLOCK_IRREGULAR], make: jitter },
    Kind { name: "too few frames", found_by: &[findings::CLOCK_SLOW], make: slow },
    Kind { name: "outliers", found_by: &[findings::SAMPLES_OUTLIERS], make: outliers },
    Kind { name: "tracker stands still", found_by: &[findings::SAMPLES_FROZEN], make: frozen },
    Kind { name: "tracker lost to the end", found_by: &[findings::SAMPLES_FROZEN], make: lost },
    Kind { name: "cut off at the top of the view", found_by: &[findings::SAMPLES_FROZEN], make: clipped },
    Kind { name: "out of view at the top", found_by: &[findings::VIEW_LEFT, findings::CLOCK_GAPS], make: out_of_view },
    Kind { name: "millimetres", found_by: &[findings::UNITS_WRONG], make: |r| lengths(r, 1000.0) },
    Kind { name: "centimetres", found_by: &[findings::UNITS_WRONG], make: |r| lengths(r, 100.0) },
    Kind { name: "feet", found_by: &[findings::UNITS_WRONG], make: |r| lengths(r, 1.0 / 0.3048) },
    Kind { name: "milliseconds", found_by: &[findings::UNITS_WRONG], make: milliseconds },
    Kind { name: "wrong frame rate", found_by: &[findings::GRAVITY_APPARENT, findings::UNITS_WRONG], make: frame_rate },
    Kind { name: "wrong scale, 4 to 20 %", found_by: &[findings::GRAVITY_APPARENT], make: scale },
    Kind { name: "held before the release", found_by: &[findings::RELEASE_LATE], make: held },
    Kind { name: "no bounce", found_by: &[findings::CONTACT_NONE], make: no_bounce },
    Kind { name: "leaves the surface", found_by: &[findings::SURFACE_LEFT, findings::MOTION_BLOW], make: leaves },
    Kind { name: "struck in flight", found_by: &[findings::MOTION_BLOW], make: struck },
    Kind { name: "at rest throughout", found_by: &[findings::MOTION_NONE, findings::MOTION_UNLIKE], make: rest },
    Kind {
        name: "z upside down",
        found_by: &[findings::MOTION_UNLIKE, findings::GRAVITY_APPARENT, findings::UNITS_WRONG],
        make: upside_down,
    },
    Kind { name: "wrong surface given", found_by: &[findings::SURFACE_DISAGREES], make: wrong_surface },
    Kind { name: "wrong height given", found_by: &[findings::RELEASE_DISAGREES], make: wrong_height },
    Kind { name: "frames dropped amid a fall, stamps even", found_by: &[findings::CLOCK_SKIPPED], make: renumbered },
];

fn known(setup: &Setup) -> Expected {
    Expected { radius_m: Some(setup.radius_m), ..Expected::default() }
}

fn plain(random: &mut ChaCha8Rng) -> (Setup, Record) {
    let setup = Setup::draw(random);
    let record = setup.record(random);
    (setup, record)
}

/// A record without fault, its surface and height of fall given or not.
pub fn good(random: &mut ChaCha8Rng) -> (Record, Expected, bool) {
    let (setup, record) = plain(random);
    let given = random.random_bool(0.5);
    // A throw upwards falls from higher up than it starts.
    let drop = setup.velocity_m_s[2].abs() < 1e-9;
    let expected = Expected {
        surface_height_m: given.then_some(setup.surface_m),
        release_height_m: (given && drop).then_some(setup.fall_m),
        ..known(&setup)
    };
    (record, expected, setup.drag_1_m > 0.0)
}

fn pick(record: &Record, keep: impl Fn(usize) -> bool) -> Record {
    let kept: Vec<usize> = (0..record.clock.len()).filter(|i| keep(*i)).collect();
    Record {
        clock: kept.iter().map(|&i| record.clock[i]).collect(),
        position_m: kept.iter().map(|&i| record.position_m[i]).collect(),
    }
}

fn each_twice(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, record) = plain(random);
    let half = 0.5 / setup.rate_hz;
    let clock = record.clock.iter().flat_map(|t| [*t, t + half]).collect();
    let position_m = record.position_m.iter().flat_map(|p| [*p, *p]).collect();
    (Record { clock, position_m }, known(&setup))
}

fn each_twice_stretched(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (mut record, expected) = each_twice(random);
    record.clock.iter_mut().for_each(|t| *t *= 2.0);
    (record, expected)
}

fn some_repeated(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, mut record) = plain(random);
    let share = random.random_range(0.05..0.3);
    let mut repeated = 0;
    for i in 2..record.clock.len() - 1 {
        let moving = record.clock[i] < setup.fall_s() * (1.0 + 2.0 * setup.restitution);
        if moving && random.random_bool(share) || repeated < 2 && record.clock[i] > 0.7 * setup.fall_s() {
            record.position_m[i] = record.position_m[i - 1];
            repeated += 1;
        }
    }
    (record, known(&setup))
}

fn dropped(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, record) = plain(random);
    let share = random.random_range(0.08..0.3);
    let keep: Vec<bool> = record.clock.iter().map(|_| !random.random_bool(share)).collect();
    (pick(&record, |i| keep[i] || i == 0), known(&setup))
}

/// One to three frames lost amid a fall of thirty or more, where the ball does in them ten times the noise, and the others
/// renumbered.
fn renumbered(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    setup.velocity_m_s[2] = 0.0;
    setup.rate_hz = setup.rate_hz.max(30.0 / setup.fall_s());
    setup.frames = setup.frames.max(whole(setup.fall_s() * (1.2 + 2.0 * setup.restitution) * setup.rate_hz));
    let at = random.random_range(0.4..0.65) * setup.fall_s();
    let frames = random.random_range(1..=3);
    // Ten times the noise: less is lost in it.
    let leap_m = frames as f64 / setup.rate_hz * GRAVITY_M_S2 * at;
    setup.noise_m = setup.noise_m.min(0.1 * leap_m);
    setup.decimals = None;
    let record = setup.record(random);
    let first = whole(at * setup.rate_hz);
    let kept = pick(&record, |i| !(first..first + frames).contains(&i));
    let clock = record.clock[..kept.clock.len()].to_vec();
    (Record { clock, ..kept }, known(&setup))
}

fn gap(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, record) = plain(random);
    let last = record.clock[record.clock.len() - 1];
    let width = random.random_range(0.15..0.3) * last + 5.0 / setup.rate_hz;
    let start = random.random_range(0.1..0.6) * last;
    (pick(&record, |i| !(start..start + width).contains(&record.clock[i])), known(&setup))
}

fn jitter(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, mut record) = plain(random);
    let step = 1.0 / setup.rate_hz;
    record.clock.iter_mut().for_each(|t| *t += step * random.random_range(-0.45..0.45));
    (record, known(&setup))
}

fn slow(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    setup.velocity_m_s = [0.0; 3];
    setup.rate_hz = random.random_range(1.5..4.0) / setup.fall_s();
    setup.frames = 20;
    let record = setup.record(random);
    (record, known(&setup))
}

fn outliers(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, mut record) = plain(random);
    let count = 1 + record.clock.len() / 60;
    for _ in 0..count {
        let i = random.random_range(3..record.clock.len() - 3);
        let leap = setup.fall_m * random.random_range(0.5..3.0);
        let axis = random.random_range(0..3);
        record.position_m[i][axis] += if random.random_bool(0.5) { leap } else { -leap };
    }
    (record, known(&setup))
}

fn frozen(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, mut record) = plain(random);
    let from = whole(random.random_range(0.5..0.8) * setup.fall_s() * setup.rate_hz).max(2);
    let until = (from + random.random_range(6..16)).min(record.clock.len() - 3);
    for i in from + 1..=until {
        record.position_m[i] = record.position_m[from];
    }
    (record, known(&setup))
}

fn lost(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    setup.noise_m = setup.noise_m.max(1e-3 * setup.fall_m);
    setup.decimals = None;
    setup.frames += 20;
    let mut record = setup.record(random);
    let from = record.clock.len() - random.random_range(6..20);
    for i in from + 1..record.clock.len() {
        record.position_m[i] = record.position_m[from];
    }
    (record, known(&setup))
}

/// The height above which nothing of a rebound is seen, and the record of a ball that rises above it.
fn bordered(random: &mut ChaCha8Rng) -> (Setup, Record, f64) {
    let mut setup = Setup::draw(random);
    setup.restitution = random.random_range(0.75..0.95);
    setup.velocity_m_s[2] = 0.0;
    setup.rate_hz = setup.rate_hz.max(60.0);
    setup.drag_1_m = 0.0;
    let first_hop = setup.fall_m * setup.restitution.powi(2);
    setup.frames = whole(setup.fall_s() * (1.0 + 2.0 * setup.restitution) * 1.3 * setup.rate_hz);
    let record = setup.record(random);
    let border = setup.surface_m + setup.radius_m + first_hop * random.random_range(0.5..0.8);
    (setup, record, border)
}

fn clipped(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, mut record, border) = bordered(random);
    record.position_m.iter_mut().for_each(|p| p[2] = p[2].min(border));
    // It comes into view from above, as a ball does that is dropped from beyond the border.
    let first = record.position_m.iter().position(|p| p[2] < border).unwrap_or(0);
    (pick(&record, |i| i >= first), known(&setup))
}

fn out_of_view(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, record, border) = bordered(random);
    (pick(&record, |i| record.position_m[i][2] < border), known(&setup))
}

fn lengths(random: &mut ChaCha8Rng, factor: f64) -> (Record, Expected) {
    let (setup, mut record) = plain(random);
    record.position_m.iter_mut().for_each(|p| *p = p.map(|v| v * factor));
    (record, known(&setup))
}

fn milliseconds(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, mut record) = plain(random);
    record.clock.iter_mut().for_each(|t| *t *= 1e3);
    (record, known(&setup))
}

fn frame_rate(random: &mut ChaCha8Rng) -> (Record, Expected) {
    const RATES_HZ: [f64; 7] = [24.0, 25.0, 30.0, 50.0, 60.0, 120.0, 240.0];
    let mut setup = Setup::draw(random);
    let taken = random.random_range(1..RATES_HZ.len());
    let said = (taken + random.random_range(1..RATES_HZ.len())) % RATES_HZ.len();
    setup.rate_hz = RATES_HZ[taken];
    setup.frames = setup.frames.max(whole(setup.fall_s() * (1.2 + 2.0 * setup.restitution) * setup.rate_hz));
    let mut record = setup.record(random);
    record.clock.iter_mut().for_each(|t| *t *= RATES_HZ[taken] / RATES_HZ[said]);
    (record, known(&setup))
}

fn scale(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    // Air and scale may cancel each other.
    setup.drag_1_m = 0.0;
    let mut record = setup.record(random);
    let off = random.random_range(0.04..0.2);
    let factor = if random.random_bool(0.5) { 1.0 + off } else { 1.0 - off };
    record.position_m.iter_mut().for_each(|p| *p = p.map(|v| v * factor));
    (record, known(&setup))
}

fn held(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    setup.velocity_m_s = [0.0; 3];
    setup.held_s = random.random_range(0.3..2.0);
    setup.frames += whole(setup.held_s * setup.rate_hz);
    let record = setup.record(random);
    (record, known(&setup))
}

fn no_bounce(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    let rise = setup.velocity_m_s[2].max(0.0);
    let until = (rise + (rise * rise + 2.0 * GRAVITY_M_S2 * setup.fall_m).sqrt()) / GRAVITY_M_S2;
    setup.frames = whole(random.random_range(0.8..0.97) * until * setup.rate_hz).max(5);
    let record = setup.record(random);
    (record, known(&setup))
}

fn leaves(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    let speed = random.random_range(0.3..1.5);
    setup.velocity_m_s = [speed, 0.0, 0.0];
    // The edge comes after the first bounce; the floor is far enough below to be seen.
    let edge_s = setup.fall_s() * (1.0 + random.random_range(0.4..2.5) * setup.restitution);
    let depth = setup.fall_m * random.random_range(0.3..1.5);
    setup.edge = Some((speed * setup.fall_s() + 0.9 * speed * (edge_s - setup.fall_s()), depth));
    setup.drag_1_m = 0.0;
    let seconds = edge_s + 2.0 * setup.fall_s() + (2.0 * depth / GRAVITY_M_S2).sqrt();
    setup.frames = whole(seconds * setup.rate_hz);
    let record = setup.record(random);
    (record, known(&setup))
}

fn struck(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    setup.restitution = setup.restitution.max(0.5);
    // In the middle of the first hop, sideways and upwards, as a hand or a racket strikes.
    let hop_s = 2.0 * setup.restitution * setup.fall_s();
    setup.velocity_m_s[2] = 0.0;
    let at = setup.fall_s() + hop_s * random.random_range(0.3..0.7);
    let typical = (2.0 * GRAVITY_M_S2 * setup.fall_m).sqrt();
    let [x, y, z] = [0, 1, 2].map(|_| random.random_range(0.5..1.5) * typical);
    let side = if random.random_bool(0.5) { 1.0 } else { -1.0 };
    setup.blow = Some((at, [side * x, y, z]));
    setup.frames = whole((at + setup.fall_s()) * setup.rate_hz).max(24);
    let record = setup.record(random);
    (record, known(&setup))
}

fn rest(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    setup.held_s = 1e3;
    let record = setup.record(random);
    (record, known(&setup))
}

fn upside_down(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, mut record) = plain(random);
    record.position_m.iter_mut().for_each(|p| p[2] = -p[2]);
    (record, known(&setup))
}

fn wrong_surface(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let (setup, record) = plain(random);
    let off = setup.fall_m * random.random_range(0.05..0.3);
    let side = if random.random_bool(0.5) { 1.0 } else { -1.0 };
    (record, Expected { surface_height_m: Some(setup.surface_m + side * off), ..known(&setup) })
}

fn wrong_height(random: &mut ChaCha8Rng) -> (Record, Expected) {
    let mut setup = Setup::draw(random);
    setup.velocity_m_s = [0.0; 3];
    let record = setup.record(random);
    let off = random.random_range(0.05..0.3);
    let factor = if random.random_bool(0.5) { 1.0 + off } else { 1.0 - off };
    (record, Expected { release_height_m: Some(setup.fall_m * factor), ..known(&setup) })
}
