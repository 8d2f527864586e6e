//! A search for a law, for readers.

use tunenet_core::law::{MOST_FORCE_NATS, Member, Reason, Verdict};
use tunenet_core::observation::after_number;

use super::fitted::{gap_line, parameter};
use super::rounded;
use crate::answers::diagnose::Answer;
use crate::answers::law::{Law, alias, cautions, nats_in_words, why, why_not, why_refused};
use crate::view::answer::Printout;
use crate::view::sentence::Headline;

/// The verdict in one sentence, where the law is the answer.
pub fn headline(answer: &Answer) -> Option<Headline> {
    let found = answer.law.and_then(|law| law.decides(answer.diagnosis.verdict()))?;
    let texts: Vec<String> = found.answer.members.iter().map(name).collect();
    let (word, sentence) = match (found.answer.verdict, found.answer.reason) {
        (Verdict::Law, _) => ("LAW", texts.join("")),
        (_, Some(Reason::Catalogue)) => {
            let known = answer.rivals().join(" and ");
            ("ONE OF", format!("{known}; or {}: {}", texts.join("; or "), why(Reason::Catalogue)))
        }
        (_, Some(_)) => ("ONE OF", format!("{}: {}", texts.join("; or "), why_not(&found.answer).unwrap_or_default())),
        (_, None) => ("ONE OF", texts.join("; or ")),
    };
    Some(Headline { word, sentence })
}

fn name(member: &Member) -> String {
    alias(member).map_or_else(|| member.text(), |alias| format!("{} ({alias})", member.text()))
}

/// What a person wants to know of the search.
pub fn lines(shown: &mut Printout, answer: &Answer, law: &Law) {
    let found = match &law.found {
        Ok(found) => found,
        Err(why) => return shown.line(&format!("  law: {why}")),
    };
    let decides = law.decides(answer.diagnosis.verdict()).is_some();
    // What a search by itself did not find is no news to somebody who did not ask for it.
    if !decides && !law.asked {
        return;
    }
    let members = &found.answer.members;
    for member in if decides { members.as_slice() } else { &[] } {
        shown.line(&format!("  {}: {}", name(member), numbers(member)));
        let gates = &member.gates;
        let p = gates.heterogeneity_p.map_or_else(String::new, |p| format!(", recordings agree (p {p:.2})"));
        let ahead = gates.held_out_ratio.zip(gates.held_out_left).map_or_else(String::new, |(ratio, left)| {
            // Where the density is not known, uncertain constants may explain anything.
            let left = match gates.held_out_nats {
                Some(_) => format!("{left:.3} less what uncertain constants explain"),
                None => {
                    "recordings beyond the fitted ones, where its constants are too uncertain for a test".to_owned()
                }
            };
            format!(", held-out error {ratio:.3} times the noise ({left})")
        });
        shown.line(&format!(
            "    gain {:.0}, residual force {:.1} nats (at most {MOST_FORCE_NATS}){p}{ahead}",
            member.bic_gain, gates.residual_force_nats
        ));
        if !member.valid.is_empty() {
            let ranges: Vec<String> =
                member.valid.iter().map(|(name, (low, high))| format!("{name} {low:.3} to {high:.3}")).collect();
            shown.line(&format!("    seen for {}", ranges.join(", ")));
        }
        for caution in cautions(member) {
            shown.line(&format!("    {caution}"));
        }
    }
    for refused in &found.answer.refused {
        shown.line(&format!("  law refused: {} ({})", refused.text, why_refused(refused)));
    }
    if !decides {
        let said = match found.answer.verdict {
            Verdict::None => {
                format!("no smooth force is left that a law could explain ({})", evidence(&found.answer))
            }
            Verdict::Named => match members.first().and_then(alias) {
                Some(alias) => format!("the law is an effect of the catalogue: {alias}"),
                None => "the effect of the catalogue explains the recordings as well as any law".to_owned(),
            },
            _ => {
                let why = why_not(&found.answer).unwrap_or_else(|| "no law was found".to_owned());
                format!("none passes ({}): {why}", evidence(&found.answer))
            }
        };
        shown.line(&format!("  law: {said}"));
    }
    if decides {
        for tuned in answer.parameters() {
            shown.line(&format!("  {}", parameter(answer, &tuned)));
        }
        if let Some(gap) = answer.gap() {
            shown.line(&format!("  {}", gap_line(&gap)));
        }
    }
    let sample = found.sample().map_or_else(String::new, |sample| format!(" in {sample}"));
    shown.line(&format!("  law: {} rollouts{sample}, {:.1} s", found.answer.rollouts, law.seconds));
}

/// The evidence of a force without a law.
fn evidence(answer: &tunenet_core::law::Answer) -> String {
    format!("evidence of a force {} nats", nats_in_words(answer.base_force_nats))
}

fn numbers(member: &Member) -> String {
    let all = member.terms.iter().flat_map(|term| &term.numbers);
    let each = all.map(|n| {
        let half = (n.interval95.1 - n.interval95.0) / 2.0;
        let unit = after_number(&n.unit);
        format!("{} {} ± {}{unit}", n.key, rounded(n.value, half), rounded(half, half))
    });
    each.collect::<Vec<_>>().join(", ")
}
