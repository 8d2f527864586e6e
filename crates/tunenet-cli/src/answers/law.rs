//! What a search for a law changes of the answer of `tunenet diagnose`.

use tunenet_core::diagnose::{self, Change, Explained, Gap, Tuned};
use tunenet_core::law::{
    self, Failure, Followed, LEAST_PROBABILITY, MOST_FORCE_NATS, MOST_HELD_OUT, MOST_HELD_OUT_FORCE_NATS, Member,
    Reason, Refused,
};
use tunenet_core::simulator::Parameter;

/// A search for a law, or why there was none.
pub struct Law {
    /// Whether it was asked for.
    pub asked: bool,
    pub seconds: f64,
    pub found: Result<Found, &'static str>,
}

/// What a search found.
pub struct Found {
    pub answer: law::Answer,
    /// The names of the fitted recordings, in their order.
    pub names: Vec<String>,
    /// The parameters of the simulator in which it was searched.
    pub parameters: Vec<Parameter>,
}

impl Found {
    /// In how many recordings it was searched, where not in all.
    pub fn sample(&self) -> Option<String> {
        let (searched, all) = (self.answer.searched.len(), self.names.len());
        (searched < all).then(|| format!("{searched} of {all} recordings"))
    }
}

impl Law {
    /// What the search found, where it is the answer: a law, or several.
    pub fn decides(&self, diagnosis: diagnose::Verdict) -> Option<&Found> {
        let found = self.found.as_ref().ok()?;
        let open = matches!(diagnosis, diagnose::Verdict::Unknown);
        let decides = match found.answer.verdict {
            law::Verdict::Law | law::Verdict::OneOf => true,
            // What the catalogue names only in the form of a law: the catalogue's own answer says more where it has one.
            law::Verdict::Named => open && !found.answer.members.is_empty(),
            law::Verdict::None | law::Verdict::Unknown => false,
        };
        decides.then_some(found)
    }
}

/// The gap without and with a law instead of effects of the catalogue.
pub fn gap(without: &Gap, law: &Member) -> Gap {
    let (before, after) = law.gap;
    let held_out = law.gates.held_out_gap.map(|(before, after)| Change { before, after });
    Gap { before, after, held_out, control: None, forecast: None, ..without.clone() }
}

/// The fitted recordings, before without the law and after with it.
pub fn explained(found: &Found) -> Vec<Explained> {
    let one = |(recording, (followed, name)): (usize, (&Followed, &String))| Explained {
        recording,
        object: 0,
        name: name.clone(),
        segment: None,
        held_out: false,
        seen: followed.seen.clone(),
        kept: vec![true; followed.with.len()],
        before: followed.without.clone(),
        after: followed.with.clone(),
        noise: followed.noise.clone(),
        measured_noise: followed.noise.clone(),
        events: followed.events.clone(),
        nuisances: followed.nuisances.clone(),
    };
    let names = found.answer.searched.iter().map(|&recording| &found.names[recording]);
    found.answer.followed.iter().zip(names).enumerate().map(one).collect()
}

/// The parameters of the simulator as they were fitted with a law.
pub fn parameters(without: &[Tuned], found: &Found, law: &Member) -> Vec<Tuned> {
    let fitted = |one: &Tuned| {
        let place = found.parameters.iter().position(|parameter| parameter.name == one.name)?;
        let &(value, interval95) = law.parameters.get(place)?;
        Some(Tuned { value, interval95, ..one.clone() })
    };
    without.iter().filter_map(fitted).collect()
}

/// What the answer comes to, with a search for laws where one decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnswerVerdict {
    /// A law alone.
    Law,
    /// Several laws that the recordings do not distinguish.
    OneOfLaws,
    /// What the effects say; [`Named`](diagnose::Verdict::Named) where a law equals an effect of the catalogue.
    Effects(diagnose::Verdict),
}

impl AnswerVerdict {
    /// That of a diagnosis, with what a search for laws found.
    pub fn of(diagnosis: diagnose::Verdict, law: Option<&Law>) -> Self {
        match law.and_then(|law| law.decides(diagnosis)).map(|found| found.answer.verdict) {
            Some(law::Verdict::Law) => Self::Law,
            Some(law::Verdict::Named) => Self::Effects(diagnose::Verdict::Named),
            Some(_) => Self::OneOfLaws,
            None => Self::Effects(diagnosis),
        }
    }

    /// The word for it in scripts.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Law => "law",
            Self::OneOfLaws | Self::Effects(diagnose::Verdict::OneOf) => "one_of",
            Self::Effects(diagnose::Verdict::None) => "none",
            Self::Effects(diagnose::Verdict::Named) => "named",
            Self::Effects(diagnose::Verdict::Unknown) => "unknown",
            Self::Effects(diagnose::Verdict::Insufficient) => "insufficient",
        }
    }
}

/// Why a search has no law, or not one alone.
pub fn why(reason: Reason) -> &'static str {
    match reason {
        Reason::HeldOut => "held-out recordings are predicted worse than noise allows: something unmeasured may differ",
        Reason::NoHeldOut => "without held-out recordings no law stands alone: hold out at least one",
        Reason::ResidualForce => "it leaves more than noise: a force of another form remains",
        Reason::Heterogeneity => "recordings differ in what they need: something unmeasured changes between them",
        Reason::Time => {
            "what fits depends on the time and fails a test: something unmeasured changes, or no simulation follows recordings as long as these"
        }
        Reason::Rollouts => "the allowance of rollouts ended the search",
        Reason::Several => "the recordings do not distinguish these laws",
        Reason::Terms => "it has two terms, and their rivals were not compared",
        Reason::Flexible => {
            "one flank of a bump, less than half a period of an oscillation, and two factors with two constants each or of one variable fit any smooth force"
        }
        Reason::Few => "fewer than four recordings do not show whether something unmeasured differs between them",
        Reason::Differ => "recordings ask for constants that differ more than by chance (p below 0.01)",
        Reason::LeavesMore => "held-out recordings leave more than fitted ones, and more than by chance (p below 0.01)",
        Reason::LeavesForce => {
            "a force may be left beyond it: the odds exceed 2 to 1 on fitted recordings, or 20 to 1 on held-out ones"
        }
        Reason::Together => {
            "its tests of recordings that differ and of held-out ones come out worse together than by chance (p below 0.01)"
        }
        Reason::Decay => {
            "a force that decays from a value of its own in each recording explains the fitted recordings as well"
        }
        Reason::Size => "the 95 % interval of its coefficient holds 0",
        Reason::Bound => "a constant of it lies at the end of the range that is searched",
        Reason::ParameterBound => {
            "a parameter of the simulation lies at a bound, and the recordings may favour values beyond it"
        }
        Reason::NotLinear => {
            "rollouts are not linear enough in its constants to compare it with others by held-out recordings"
        }
        Reason::Grammar => "no product of two shapes of the table explains the recordings better than none does",
        Reason::Catalogue => "an effect of the catalogue explains the recordings as well",
    }
}

/// Why a search has no law, or not one alone: of a law that passes every test, what another one fails.
pub fn why_not(answer: &law::Answer) -> Option<String> {
    let reason = answer.reason?;
    let of_another = matches!(reason, Reason::HeldOut | Reason::ResidualForce | Reason::Heterogeneity | Reason::Time);
    Some(if of_another && !answer.members.is_empty() {
        format!("it passes every test, and a law that explains the fitted recordings better does not ({})", why(reason))
    } else {
        why(reason).to_owned()
    })
}

/// Beyond these a number says no more than the limit.
const LEAST_SHOWN: f64 = 1e-12;
const MOST_SHOWN: f64 = 1e4;

/// Why a law was refused: the reason, and what each test measured that it fails.
pub fn why_refused(refused: &Refused) -> String {
    let failures: Vec<String> = refused.gates.failures().into_iter().map(failure).collect();
    format!("{}: {}", why(refused.gate), failures.join("; "))
}

/// Evidence as a number.
pub fn nats_in_words(nats: f64) -> String {
    if nats > MOST_SHOWN { format!("above {MOST_SHOWN}") } else { format!("{nats:.1}") }
}

fn failure(of: Failure) -> String {
    let chance = |p: f64| if p < LEAST_SHOWN { format!("below {LEAST_SHOWN:e}") } else { format!("{p:.1e}") };
    match of {
        Failure::Heterogeneity { p } => {
            format!("recordings agree with p {}, at least {LEAST_PROBABILITY}", chance(p))
        }
        Failure::ResidualForce { nats: n } => {
            format!("residual force {} nats, at most {MOST_FORCE_NATS}", nats_in_words(n))
        }
        Failure::Worse { ratio, without } => {
            format!("held-out error {ratio:.3} times the noise, at most {without:.3}, which is that without the law")
        }
        Failure::HeldOutForce { nats: n } => {
            format!(
                "residual force on held-out recordings {} nats, at most {MOST_HELD_OUT_FORCE_NATS}",
                nats_in_words(n)
            )
        }
        Failure::LeavesMore { left, p } => format!(
            "held-out error {left:.3} times the noise with p {}, at most {MOST_HELD_OUT} or p at least {LEAST_PROBABILITY}",
            chance(p)
        ),
        Failure::Differ { p } => {
            format!("held-out recordings ask for the same constants with p {}, at least {LEAST_PROBABILITY}", chance(p))
        }
    }
}

/// A law that equals an effect of the catalogue, in words: `quadratic drag, exponent 1.96 ± 0.05`.
pub fn alias(member: &Member) -> Option<String> {
    let name = member.alias?.replace('_', " ");
    let term = member.terms.first()?;
    let rounded = term.rounded.first().copied().flatten();
    let exponent = term.numbers.iter().find(|number| number.role == Some(law::Role::Exponent));
    let (value, (low, high)) = match (rounded, exponent) {
        (Some(rounded), _) => (f64::midpoint(rounded.interval95.0, rounded.interval95.1), rounded.interval95),
        (None, Some(number)) => (number.value, number.interval95),
        (None, None) => return Some(name),
    };
    Some(format!("{name}, exponent {value:.2} ± {:.2}", (high - low) / 2.0))
}

/// Sentences of a member that a reader has to know before relying on it.
pub fn cautions(member: &Member) -> Vec<String> {
    let mut all = Vec::new();
    if member.depends_on_time {
        all.push("it depends on the time: it holds for the clock of these recordings only".to_owned());
    }
    if !member.bounded {
        all.push("beyond the range in which it was seen it grows without bound: no file is written".to_owned());
    }
    all
}
