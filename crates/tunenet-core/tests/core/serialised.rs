//! Answers as JSON, and effects whose names exist at run time only.

use serde_json::Value;
use tunenet_core::diagnose::{self, Conclusion, Diagnosis, Doubt, Recording, Subject, Verdict, diagnose};
use tunenet_core::observation::{Channel, Observation};
use tunenet_core::simulator::{Effect, Parameter, Phase, Preparation, RolloutResult, Simulator};
use tunenet_core::testing::{Exact, Pendulum};
use tunenet_core::tune::{self, tune};
use tunenet_core::{Error, Origin, Result};

/// The true effect of the pendulum's recordings.
const TRUTH: [(&str, f64); 1] = [("viscous_friction.rate_1_s", 0.2)];

/// A pendulum whose effects a user has named.
struct Renamed {
    pendulum: Box<dyn Simulator>,
    prefix: String,
    parameters: Vec<Parameter>,
}

impl Renamed {
    fn new(pendulum: Box<dyn Simulator>, prefix: &str) -> Self {
        let named = |p: &Parameter| {
            let name = if p.name.contains('.') { format!("{prefix}_{}", p.name) } else { p.name.clone() };
            Parameter { name, ..p.clone() }
        };
        let parameters = pendulum.parameters().iter().map(named).collect();
        Self { pendulum, prefix: prefix.to_owned(), parameters }
    }
}

fn recordings() -> Vec<Observation> {
    let pendulum = Exact::new(Pendulum);
    let starts = [[0.2, 0.0], [-0.1, 0.5], [0.05, -0.4]];
    (0..).zip(&starts).map(|(seed, start)| pendulum.observe(&TRUTH, start, 0.001, seed).unwrap()).collect()
}

fn pendulum() -> Renamed {
    Renamed::new(Box::new(Exact::new(Pendulum)), "users")
}

impl Simulator for Renamed {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        self.pendulum.channels()
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        self.pendulum.prepare(seen)
    }

    fn effects(&self) -> Vec<Effect> {
        let named = |effect: Effect| Effect {
            name: format!("{}_{}", self.prefix, effect.name).into(),
            phase: Phase::Other(format!("the {}", self.prefix).into()),
            ..effect
        };
        self.pendulum.effects().into_iter().map(named).collect()
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        let inner: Option<Vec<&str>> =
            names.iter().map(|name| name.strip_prefix(self.prefix.as_str())?.strip_prefix('_')).collect();
        let unknown = || Error::Setting {
            origin: Origin::Caller,
            name: "effects",
            expected: "an effect of this pendulum".into(),
            found: names.join(", "),
        };
        let inner = self.pendulum.with_effects(&inner.ok_or_else(unknown)?)?;
        Ok(Box::new(Self::new(inner, &self.prefix)))
    }

    fn rollout(&self, parameters: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        self.pendulum.rollout(parameters, nuisances, clock, values)
    }
}

fn diagnosed() -> Diagnosis {
    let simulator = pendulum();
    let seen = recordings();
    let recording = |seen| Recording { name: "swing".into(), object: 0, held_out: false, seen };
    let recordings: Vec<Recording> = seen.iter().map(recording).collect();
    let subjects = [Subject { name: "pendulum".into(), simulator: &simulator }];
    diagnose(&subjects, &recordings, &diagnose::Settings::default(), &|_| {}).unwrap()
}

#[test]
fn an_effect_with_a_name_of_run_time_is_named() {
    let found = diagnosed();
    assert_eq!((found.verdict(), found.names()), (Verdict::Named, vec!["users_viscous_friction"]));
    assert_eq!(found.effects()[0].effect.phase, Phase::Other("the users".into()));
}

#[test]
fn a_diagnosis_is_valid_json_with_readable_keys() {
    let mut found = diagnosed();
    let Conclusion::Named { effects } = &mut found.conclusion else { panic!("{:?}", found.verdict()) };
    effects[0].evidence.runner_up_bic_gap = f64::INFINITY;
    effects[0].coefficients[0].values[0].interval95.1 = f64::NAN;
    found.gap.as_mut().unwrap().control = Some(("users_rest_angle".into(), 0.25));
    let json: Value = serde_json::from_str(&serde_json::to_string(&found).unwrap()).unwrap();
    let at = |pointer: &str| json.pointer(pointer).unwrap_or_else(|| panic!("{pointer} in {json}"));
    assert_eq!(at("/conclusion/verdict"), "named");
    assert_eq!(at("/conclusion/effects/0/effect/name"), "users_viscous_friction");
    assert_eq!(at("/conclusion/effects/0/effect/phase"), "the users");
    assert_eq!(at("/conclusion/effects/0/coefficients/0/key"), "rate_1_s");
    let value = at("/conclusion/effects/0/coefficients/0/values/0/value").as_f64().unwrap();
    assert!((value - 0.2).abs() < 0.01, "{value}");
    assert_eq!(at("/conclusion/effects/0/coefficients/0/values/0/interval95/1"), &Value::Null);
    assert_eq!(at("/conclusion/effects/0/evidence/runner_up_bic_gap"), &Value::Null);
    assert_eq!(at("/gap/of"), "recordings");
    assert_eq!(at("/gap/control/name"), "users_rest_angle");
    assert_eq!(at("/gap/control/after"), 0.25);
    assert_eq!(at("/explained/0/seen/channels/0/unit"), "rad");
    assert_eq!(at("/explained/0/seen/clock").as_array().unwrap().len(), found.explained[0].seen.len());
    assert_eq!(at("/explained/0/seen/values/0"), found.explained[0].seen.values()[0]);
    assert_eq!(at("/explained/0/nuisances/0/name"), found.explained[0].nuisances[0].0.as_str());
    assert_eq!(at("/objects/0/effects/0/name"), "users_viscous_friction");
    assert_eq!(at("/rollouts"), found.rollouts);
}

#[test]
fn a_doubt_and_an_unknown_effect_say_what_they_are() {
    let doubt = Some(Doubt::Feigned("users_offset".into(), "wrong masses".into()));
    let open = Conclusion::OneOf { effects: Vec::new(), names: vec!["users_offset".into()], doubt };
    let json = serde_json::to_value(&open).unwrap();
    assert_eq!((&json["verdict"], &json["names"][0]), (&"one_of".into(), &"users_offset".into()));
    assert_eq!((&json["doubt"]["kind"], &json["doubt"]["of"][1]), (&"feigned".into(), &"wrong masses".into()));
    let unknown = |remains| {
        let all = Conclusion::Unknown { nearest: Vec::new(), description: "a bend".into(), remains };
        serde_json::to_value(all).unwrap()
    };
    assert_eq!(unknown(Some(Phase::Segment))["remains"], "segment");
    assert_eq!(unknown(Some(Phase::Actuator))["remains"], "actuator");
    assert_eq!(unknown(None)["remains"], Value::Null);
    assert_eq!(serde_json::to_value(Conclusion::None).unwrap()["verdict"], "none");
}

#[test]
fn what_tuning_found_is_valid_json_with_readable_keys() {
    let simulator = pendulum().with_effects(&["users_viscous_friction"]).unwrap();
    let mut found = tune(&simulator, &recordings(), None, &tune::Settings::default()).unwrap();
    found.parameters[0].interval95.1 = f64::INFINITY;
    let json: Value = serde_json::from_str(&serde_json::to_string(&found).unwrap()).unwrap();
    let at = |pointer: &str| json.pointer(pointer).unwrap_or_else(|| panic!("{pointer} in {json}"));
    assert_eq!(at("/verdict"), "tuned");
    assert_eq!(at("/parameters/0/name"), "length");
    assert_eq!(at("/parameters/0/status"), "pinned");
    assert_eq!(at("/parameters/0/interval95/1"), &Value::Null);
    assert_eq!(at("/correlation/0/0"), 1.0);
    assert_eq!(at("/correlation").as_array().unwrap().len(), found.free.len());
    assert_eq!(at("/region95/parameters/1"), "users_viscous_friction.rate_1_s");
    let region = found.region95.as_ref().unwrap();
    assert_eq!(at("/region95/covariance/0/1"), region.covariance.as_ref().unwrap()[(0, 1)]);
    assert_eq!(at("/recordings/0/seen/values").as_array().unwrap().len(), found.recordings[0].seen.values().len());
    assert_eq!(at("/recordings/0/memoryless"), false);
    assert_eq!(at("/nuisances/0/0/name"), found.nuisances[0][0].name.as_str());
    assert_eq!(at("/stop"), "converged");
    assert_eq!(at("/rollouts"), found.rollouts);
}
