//! Times a search for a law in recordings that are integrated here: rollouts, seconds, and what was found.

use std::time::Instant;
use tunenet_core::law::{Settings, search};
use tunenet_core::observation::{Channel, Kind, Observation};
use tunenet_core::simulator::{Preparation, Prepared, Simulator};
use tunenet_sim::{SimulationFile, law};

/// Uniform and normal numbers of a small generator.
struct Noise(u64);

impl Noise {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

type Torque = Box<dyn Fn(f64, f64, f64) -> f64>;
type Force = Box<dyn Fn(f64, [f64; 3], [f64; 3]) -> [f64; 3]>;

fn throw(seed: u64, force: &Force) -> Observation {
    let mut noise = Noise(seed);
    (0..10).for_each(|_| _ = noise.unit());
    let mut x = [noise.between(-0.2, 0.2), noise.between(-0.2, 0.2), noise.between(0.8, 1.5)];
    let mut v = [noise.between(1.0, 3.0), noise.between(-2.0, 2.0), noise.between(0.0, 3.0)];
    let (mut clock, mut values) = (Vec::new(), Vec::new());
    let h = 2e-5;
    for i in 0..150 {
        clock.push(f64::from(i) * 0.01);
        values.extend(x.map(|x| x + 0.002 * noise.normal()));
        for k in 0..500 {
            let t = f64::from(i) * 0.01 + f64::from(k) * h;
            let a = force(t, x, v);
            let middle: [f64; 3] = std::array::from_fn(|k| v[k] + 0.5 * h * a[k]);
            let at: [f64; 3] = std::array::from_fn(|k| x[k] + 0.5 * h * v[k]);
            let a = force(t + 0.5 * h, at, middle);
            (0..3).for_each(|k| x[k] += h * (v[k] + 0.5 * h * a[k]));
            (0..3).for_each(|k| v[k] += h * a[k]);
            if x[2] < 0.02 && v[2] < 0.0 {
                v[2] *= -0.8;
                x[2] = 0.02 + 0.8 * (0.02 - x[2]);
            }
        }
    }
    Observation::new(Kind::Positions, Channel::positions(), clock, values).unwrap()
}

fn swing(seed: u64, law: &dyn Fn(f64, f64, f64) -> f64) -> Observation {
    let mut noise = Noise(seed);
    (0..10).for_each(|_| _ = noise.unit());
    let (mut q, mut v) = (noise.between(-1.5, 1.5), noise.between(-3.0, 3.0));
    let (mut clock, mut values) = (Vec::new(), Vec::new());
    let h = 1e-5;
    for i in 0..200 {
        clock.push(f64::from(i) * 0.02);
        values.push(q + 0.002 * noise.normal());
        for k in 0..2000 {
            let t = f64::from(i) * 0.02 + f64::from(k) * h;
            let a = -9.0 * q - 0.3 * v + law(t, q, v);
            let (qm, vm) = (q + 0.5 * h * v, v + 0.5 * h * a);
            let a = -9.0 * qm - 0.3 * vm + law(t + 0.5 * h, qm, vm);
            q += h * (v + 0.5 * h * a);
            v += h * a;
        }
    }
    Observation::new(Kind::Other, vec![Channel::from_header("q_rad").unwrap()], clock, values).unwrap()
}

const BALL: &str =
    "kind = \"ball\"\nball.radius_m = 0.02\nparameters.restitution = { value = 0.7, min = 0.0, max = 1.0 }\n";
const PENDULUM: &str = "kind = \"equations\"\n[states]\n[states.q_rad]\n[states.dq_rad_s]\n[start.q_rad]\nvalue = \"first\"\nsd = 0.01\n\
[start.dq_rad_s]\nvalue = 0.0\nmin = -20.0\nmax = 20.0\n[derivatives]\nq_rad = \"dq_rad_s\"\n\
dq_rad_s = \"-stiffness*q_rad - damping*dq_rad_s\"\n[outputs]\nq_rad = \"q_rad\"\n\
[parameters.stiffness]\nvalue = 8.0\nmin = 0.0\nmax = 30.0\nunit = \"1/s²\"\n\
[parameters.damping]\nvalue = 0.2\nmin = 0.0\nmax = 5.0\nunit = \"1/s\"\n";

fn ask(name: &str, text: &str, kind: Kind, seen: &[Observation]) {
    let file = SimulationFile::parse(std::path::Path::new("it.toml"), text).unwrap();
    let host = law::host(&[&file], kind, &[]).unwrap().map_err(str::to_owned).unwrap();
    let base = host.carrying(&[]).unwrap();
    let prepared: Vec<Prepared> = seen
        .iter()
        .map(|seen| match base.prepare(seen).unwrap() {
            Preparation::Usable(prepared) => *prepared,
            Preparation::Rejected(rejected) => panic!("{:?}", rejected.note),
        })
        .collect();
    let (fit, ahead) = prepared.split_at(3);
    let began = Instant::now();
    let answer = search(host.as_ref(), fit, ahead, &Settings::default()).unwrap();
    println!(
        "{name}: {:?} {:?}, base {:.1} nats, left {:.2} -> {:.3}, {} rollouts, {:.2} s",
        answer.verdict,
        answer.reason,
        answer.base_force_nats,
        answer.left.0,
        answer.left.1,
        answer.rollouts,
        began.elapsed().as_secs_f64()
    );
    for member in &answer.members {
        let numbers: Vec<String> = member
            .terms
            .iter()
            .flat_map(|t| &t.numbers)
            .map(|n| format!("{}={:.4} ({:.4}..{:.4}) {}", n.key, n.value, n.interval95.0, n.interval95.1, n.unit))
            .collect();
        println!(
            "   {} [{}] bic {:.1} score {:.1} {:?} bounded {} alias {:?}",
            member.text(),
            numbers.join(", "),
            member.bic_gain,
            member.score,
            member.gates,
            member.bounded,
            member.alias
        );
    }
    for refused in &answer.refused {
        println!("   refused {refused:?}");
    }
    if let Some(member) = answer.members.first() {
        let made = law::written(&file, base.parameters(), member).unwrap();
        if std::env::var("SHOW").is_ok() {
            println!("{}", made.text());
        }
    }
}

fn main() {
    let which = std::env::args().nth(1).unwrap_or_default();
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let drag = move |c: f64, p: f64| -> Force {
        Box::new(move |_, _, v| {
            let size = -c * length(v).powf(p - 1.0);
            [size * v[0], size * v[1], size * v[2] - 9.81]
        })
    };
    let balls: Vec<(&str, Force)> = vec![
        ("clean", Box::new(|_, _, _| [0.0, 0.0, -9.81])),
        ("drag1.5", drag(0.04, 1.5)),
        ("drag2", drag(0.02, 2.0)),
        ("drag3", drag(0.006, 3.0)),
        ("jet", Box::new(|_, x, _| [1.2 * (-((x[2] - 0.6) / 0.25).powi(2)).exp(), 0.0, -9.81])),
        ("floor", Box::new(|_, x, _| [0.0, 0.0, -9.81 + 2e-4 / x[2].powi(3)])),
        ("osc", Box::new(|t, _, _| [0.5 * (9.0 * t + 0.7).cos(), 0.0, -9.81])),
        (
            "dragexp",
            Box::new(move |_, x, v| {
                let size = -0.06 * length(v) * (-x[2] / 0.5).exp();
                [size * v[0], size * v[1], size * v[2] - 9.81]
            }),
        ),
    ];
    for (name, force) in balls {
        if which.is_empty() || which == name || which == "ball" {
            let seen: Vec<Observation> = (0..5).map(|i| throw(11 + 7 * i, &force)).collect();
            ask(name, BALL, Kind::Positions, &seen);
        }
    }
    if which.is_empty() || which == "spin" || which == "ball" {
        let seen: Vec<Observation> = (0..5)
            .map(|i| {
                let w = [0.25, -0.4, 0.5, -0.2, 0.35][i];
                let force: Force = Box::new(move |t, _, v| {
                    let s = w * (-t / 0.8_f64).exp();
                    [-s * v[1], s * v[0], -9.81]
                });
                throw(11 + 7 * i as u64, &force)
            })
            .collect();
        ask("spin", BALL, Kind::Positions, &seen);
    }
    let swings: Vec<(&str, Torque)> = vec![
        ("p-clean", Box::new(|_, _, _| 0.0)),
        ("p-cubic", Box::new(|_, q, _| -0.25 * q * q * q)),
        ("p-sin2", Box::new(|_, q, _| 0.15 * (2.0 * q).sin())),
        ("p-abs", Box::new(|_, _, v| -0.03 * v * v.abs())),
        ("p-stribeck", Box::new(|_, _, v| -0.15 * (-(v / 0.5) * (v / 0.5)).exp() * v.signum())),
        ("p-osc", Box::new(|t, _, _| 0.15 * (4.1 * t + 0.3).cos())),
        ("p-bump", Box::new(|_, q, v| -0.4 * (-((q - 0.5) / 0.2) * ((q - 0.5) / 0.2)).exp() * v)),
    ];
    for (name, law) in swings {
        if which.is_empty() || which == name || which == "pendulum" {
            let seen: Vec<Observation> = (0..5).map(|i| swing(5 + 13 * i, &law)).collect();
            ask(name, PENDULUM, Kind::Other, &seen);
        }
    }
}
