//! The answer of `tunenet diagnose`: what was read, what was found, and what changes in the simulation file.

use std::borrow::Cow;

use toml_edit::{Array, InlineTable};
use tunenet_core::diagnose::{
    self, Diagnosis, Doubt, Explained, Fitted, Gap, GapOf, NamedEffect, OfObject, PartGap, Tuned, Value, Verdict,
};
use tunenet_core::finding::FindingKind;
use tunenet_core::findings;
use tunenet_core::law::{Member, Reason};
use tunenet_core::observation::{Note, Observation};
use tunenet_core::simulator::{Effect, Simulator, measurement_effects};
use tunenet_sim::arm::effects::ArmEffect;
use tunenet_sim::observed_robot::joint_names;
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{Session, SimulationFile};

use super::law::{self, AnswerVerdict, Found, Law};

/// The alternative that is shown where one effect cannot be named alone.
pub const NOT_IN_CATALOGUE: &str = "what is in no catalogue";
/// The effect whose coefficient is known to everyone in another form.
pub const DRAG: &str = "quadratic_drag";

/// One thing that was recorded, possibly several times.
pub struct Object {
    pub name: String,
    pub file: SimulationFile,
    /// In which its program runs, where it has one.
    pub session: Session,
    pub simulator: Box<dyn Simulator>,
    /// A file for each setup of its recordings.
    pub setups: Vec<SimulationFile>,
}

/// One recording of it.
pub struct Recorded {
    pub name: String,
    pub hash: String,
    pub object: usize,
    pub held_out: bool,
    pub seen: Observation,
    /// The run without payload that was aligned with it, as the provenance names it.
    pub reference: Option<InlineTable>,
    /// The files of their own in which its inputs stand, likewise.
    pub inputs: Array,
    /// The keys of the scene in which it differs from other recordings of its object.
    pub own: InlineTable,
}

/// Everything that was read.
pub struct Loaded {
    pub objects: Vec<Object>,
    pub recorded: Vec<Recorded>,
    pub notes: Vec<Note>,
}

impl Loaded {
    /// As the library takes them.
    pub fn recordings<'a>(&'a self) -> Vec<diagnose::Recording<'a>> {
        let one = |r: &'a Recorded| diagnose::Recording {
            name: r.name.clone(),
            object: r.object,
            held_out: r.held_out,
            seen: &r.seen,
        };
        self.recorded.iter().map(one).collect()
    }

    /// Rollouts that programs were asked for again up to now, to test that they are deterministic.
    pub fn re_asks(&self) -> u64 {
        self.objects.iter().map(|object| object.session.rechecks()).sum()
    }
}

/// A simulation file as it was given and as it would be, both without provenance.
pub struct Edited {
    pub object: String,
    pub given: String,
    pub improved: String,
}

/// A diagnosis and what it was made of.
pub struct Answer<'a> {
    pub loaded: &'a Loaded,
    pub diagnosis: &'a Diagnosis,
    pub seconds: f64,
    /// Rollouts that programs were asked for again, to test that they are deterministic.
    pub re_asks: u64,
    /// The search for a law, where there was one.
    pub law: Option<&'a Law>,
}

impl Answer<'_> {
    /// What it comes to.
    pub fn verdict(&self) -> AnswerVerdict {
        AnswerVerdict::of(self.diagnosis.verdict(), self.law)
    }

    /// The answer in one word, as programs read it.
    pub fn word(&self) -> &'static str {
        self.verdict().word()
    }

    /// The best law, where it is the answer.
    pub fn found(&self) -> Option<(&Found, &Member)> {
        let found = self.law?.decides(self.diagnosis.verdict())?;
        Some((found, found.answer.members.first()?))
    }

    /// The keys of an effect's coefficients, in order; those that stand there for several joints with the joint: `nm of joint 2` of an arm,
    /// and by its name of a robot.
    pub fn keys_of(&self, named: &NamedEffect) -> Vec<String> {
        let coefficients = &named.coefficients;
        let of_key = |fitted: &Fitted| coefficients.iter().filter(|other| other.key == fitted.key).count();
        let domain = self.loaded.objects.first().map(|object| (object.file.domain(), &object.file));
        let names = match domain {
            Some((Domain::Robot, file)) if coefficients.iter().any(|fitted| of_key(fitted) > 1) => {
                joint_names(file).unwrap_or_default()
            }
            Some((Domain::Arm, _)) if is_per_joint(named) => {
                (1..=coefficients.len()).map(|number| format!("joint {number}")).collect()
            }
            _ => Vec::new(),
        };
        let each = coefficients.iter().enumerate().map(|(i, fitted)| {
            let before = coefficients[..i].iter().filter(|other| other.key == fitted.key).count();
            names.get(before).map_or_else(|| fitted.key.to_string(), |joint| format!("{} of {joint}", fitted.key))
        });
        each.collect()
    }

    /// Effects of the catalogue that explain as much as the laws of the answer.
    pub fn rivals(&self) -> Vec<&str> {
        let as_well = self.found().is_some_and(|(found, _)| found.answer.reason == Some(Reason::Catalogue));
        if as_well { self.chosen() } else { Vec::new() }
    }

    /// How far the simulation is from the recordings: with the law, where one is the answer.
    pub fn gap(&self) -> Option<Gap> {
        let gap = self.diagnosis.gap.as_ref()?;
        Some(self.found().map_or_else(|| gap.clone(), |(_, law)| law::gap(gap, law)))
    }

    /// The recordings as they are followed before and after: with the law, where one is the answer.
    pub fn explained(&self) -> Cow<'_, [Explained]> {
        match self.found() {
            Some((found, _)) => Cow::Owned(law::explained(found)),
            None => Cow::Borrowed(&self.diagnosis.explained),
        }
    }

    /// The parameters that were tuned: with the law, where one is the answer.
    pub fn parameters(&self) -> Vec<Tuned> {
        let all = &self.diagnosis.parameters;
        self.found().map_or_else(|| all.clone(), |(found, law)| law::parameters(all, found, law))
    }

    /// Rollouts of the diagnosis and of the search for a law.
    pub fn rollouts(&self) -> usize {
        self.diagnosis.rollouts + self.rollouts_for_law()
    }

    /// Those of the search for a law.
    pub fn rollouts_for_law(&self) -> usize {
        let law = self.law.and_then(|law| law.found.as_ref().ok());
        law.map_or(0, |found| found.answer.rollouts)
    }

    /// How long the diagnosis and the search for a law took, s.
    pub fn all_seconds(&self) -> f64 {
        self.seconds + self.law.map_or(0.0, |law| law.seconds)
    }

    /// Names to choose from: of a set, or the nearest where nothing fits.
    pub fn candidates(&self) -> Vec<&str> {
        match self.diagnosis.verdict() {
            Verdict::OneOf | Verdict::Unknown => self.diagnosis.names(),
            _ => Vec::new(),
        }
    }

    /// Of an ambiguous answer: for each effect that it holds, that effect and whatever could be in its place. Those that are
    /// alone in theirs are certain in addition to the others.
    pub fn choices(&self) -> Vec<Vec<&str>> {
        let effects = self.diagnosis.effects().iter();
        let all = effects.map(|e| std::iter::once(&e.effect.name).chain(&e.alternatives));
        all.map(|names| names.map(AsRef::as_ref).collect()).collect()
    }

    /// The [choices](Self::choices) in the place of something else, and what is certain in addition to them. Where nothing is left to
    /// choose from, the effect is open itself: what is in no catalogue could be in its place. Nothing is certain where a discrepancy remains.
    pub fn open_and_firm(&self) -> (Vec<Vec<&str>>, Vec<&str>) {
        let remains = matches!(self.diagnosis.conclusion.doubt(), Some(Doubt::DiscrepancyRemains));
        let (mut open, mut firm): (Vec<_>, Vec<_>) = self.choices().into_iter().partition(|names| names.len() > 1);
        if remains {
            open.append(&mut firm);
        }
        if open.is_empty() { (firm, Vec::new()) } else { (open, firm.into_iter().flatten().collect()) }
    }

    /// Whether an ambiguous answer may be none of its effects: one of them is open alone, or what they leave is no noise.
    pub fn allows_unknown(&self) -> bool {
        let lone = || self.open_and_firm().0.iter().any(|names| names.len() == 1);
        self.diagnosis.conclusion.doubt().is_some_and(Doubt::allows_unknown) || lone()
    }

    /// The effects that the improved file holds where several could be in their place.
    pub fn chosen(&self) -> Vec<&str> {
        self.diagnosis.effects().iter().map(|e| e.effect.name.as_ref()).collect()
    }

    /// The drag coefficient of an object: the force over that of the pressure ρv²/2 on the ball's section. None where its
    /// mass is not known.
    pub fn drag_coefficient(&self, effect: &NamedEffect, value: &Value) -> Option<Value> {
        // A value of all objects together is only ever that of the measurement.
        let object = self.loaded.objects.get(value.object.unwrap_or(0)).filter(|_| effect.effect.name == DRAG)?;
        let unit = object.file.ball().ok()?.body().drag_1_m()?;
        let (low, high) = value.interval95;
        Some(Value { object: value.object, value: value.value / unit, interval95: (low / unit, high / unit) })
    }

    /// Where coefficient `i` of an effect has to lie to be plausible, for the object that a value belongs to.
    pub fn plausible(&self, named: &NamedEffect, i: usize, value: &Value) -> (f64, f64) {
        let own = value.object.and_then(|object| self.loaded.objects.get(object));
        let own = own.and_then(|o| o.simulator.effects().into_iter().find(|e| e.name == named.effect.name));
        let effect = own.as_ref().unwrap_or(&named.effect);
        effect.plausible.get(i).copied().unwrap_or((f64::NEG_INFINITY, f64::INFINITY))
    }

    /// Everything that a person should know, of reading, of each recording, and of judging.
    pub fn notes(&self) -> Vec<Note> {
        let several = self.diagnosis.uses.len() > 1;
        let of_each = self.diagnosis.uses.iter().flat_map(|one| one.notes.iter().map(move |note| (one, note)));
        // What is said of all as well is said once.
        let of_each = of_each.filter(|(_, note)| !self.diagnosis.notes.contains(note));
        let named = of_each.map(|(one, note)| {
            let name = if several { format!("{}: ", one.name) } else { String::new() };
            Note { text: format!("{name}{}", note.text), ..note.clone() }
        });
        // The intervals of a law are its own: they do not follow from what is left without it.
        let is_moot = |note: &&Note| note.kind == findings::INTERVALS_WIDENED && self.found().is_some();
        let of_all = self.diagnosis.notes.iter().filter(|note| !is_moot(note));
        self.loaded.notes.iter().cloned().chain(named).chain(of_all.cloned()).collect()
    }

    /// Why recordings do not suffice: what is said of all, then of each that cannot be used.
    pub fn reasons(&self) -> Vec<&Note> {
        let of_all = [findings::RECORDINGS_NONE, findings::RECORDINGS_SHORT, findings::RECORDINGS_ALIKE];
        let of_all = self.diagnosis.notes.iter().filter(move |n| of_all.contains(&n.kind));
        of_all.chain(self.diagnosis.uses.iter().filter(|u| !u.used).filter_map(|u| u.notes.first())).collect()
    }

    /// An entry of the catalogue.
    pub fn entry(&self, name: &str) -> Option<Effect> {
        let simulator = &self.loaded.objects.first()?.simulator;
        let all = simulator.effects().into_iter().chain(measurement_effects(simulator.kind()));
        all.into_iter().find(|effect| effect.name == name)
    }

    /// What each of several objects shows, with its name; nothing of a single one, whose answer is that of the whole.
    pub fn objects(&self) -> impl Iterator<Item = (&str, &OfObject)> {
        let all = &self.diagnosis.objects;
        let named = all.iter().filter_map(|one| Some((self.loaded.objects.get(one.object)?.name.as_str(), one)));
        named.filter(|_| all.len() > 1)
    }

    /// The effects that some objects do not need, each with the names of these objects: their own recordings do not show it.
    pub fn unneeded(&self) -> Vec<(&str, Vec<&str>)> {
        let each = self.diagnosis.effects().iter().enumerate().map(|(k, named)| {
            let idle = self.objects().filter(|(_, one)| one.effects.get(k).is_some_and(|own| !own.needed));
            (named.effect.name.as_ref(), idle.map(|(name, _)| name).collect())
        });
        each.filter(|(_, objects): &(&str, Vec<&str>)| !objects.is_empty()).collect()
    }

    /// The effects of the answer that an object's simulation has to hold.
    pub fn effects_of(&self, object: usize) -> Vec<&NamedEffect> {
        let own = self.diagnosis.objects.iter().find(|one| one.object == object);
        let needed = |k: usize| own.and_then(|one| one.effects.get(k)).is_none_or(|effect| effect.needed);
        self.diagnosis.effects().iter().enumerate().filter(|(k, _)| needed(*k)).map(|(_, named)| named).collect()
    }

    /// The gaps that say more than the one of all: of each object where there are several, of each channel where units differ.
    pub fn gaps(&self) -> Vec<&PartGap> {
        let all = &self.diagnosis.gaps;
        let several = all.iter().any(|one| one.object != all[0].object);
        let mixed = all.iter().any(|one| one.unit != all[0].unit);
        let whole = |one: &&PartGap| {
            one.channel.is_none() || all.iter().all(|other| other.object != one.object || other.channel.is_some())
        };
        if mixed {
            all.iter().filter(|one| one.channel.is_some()).collect()
        } else if several {
            all.iter().filter(whole).collect()
        } else {
            Vec::new()
        }
    }

    /// What a part of the gap is of: object and channel, as far as there are several.
    pub fn part_name(&self, part: &PartGap) -> String {
        let object = self.loaded.objects.get(part.object).filter(|_| self.loaded.objects.len() > 1);
        let words = object.map(|o| o.name.as_str()).into_iter().chain(part.channel.as_deref());
        let words: Vec<&str> = words.collect();
        words.join(" ")
    }

    /// The name of the object that a value belongs to.
    pub fn object(&self, value: &Value) -> Option<&str> {
        Some(self.loaded.objects.get(value.object?)?.name.as_str())
    }
}

/// Whether an effect has numbers of each joint of an arm.
pub fn is_per_joint(named: &NamedEffect) -> bool {
    ArmEffect::find(&named.effect.name).is_some_and(|effect| effect.per_joint)
}

/// What the gap was measured on.
pub fn gap_of(gap: &Gap) -> &'static str {
    match gap.of {
        GapOf::Recordings => "recordings",
        GapOf::Segments => "flights",
        GapOf::Events => "contacts",
    }
}

/// Why an answer is `insufficient`.
pub fn why_insufficient(diagnosis: &Diagnosis) -> &str {
    const WHY: [FindingKind; 3] = [findings::RECORDINGS_NONE, findings::RECORDINGS_SHORT, findings::ROLLOUTS_LIMIT];
    let why = diagnosis.notes.iter().find(|note| WHY.contains(&note.kind));
    why.map_or("the recordings do not suffice for an answer", |note| &note.text)
}

/// The value of an object, or the one that all share.
pub fn value_of(fitted: &Fitted, object: usize) -> Option<&Value> {
    fitted.values.iter().find(|v| v.object.is_none_or(|o| o == object))
}
