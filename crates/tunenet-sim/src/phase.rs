//! Where effects act, in words: segments are flights and events contacts, as of a ball; joints are those of any mechanism.

use std::borrow::Cow;

use tunenet_core::simulator::Phase;

/// A phrase for users that follows a name or a verb: "in flight". A user's own word is quoted: `in "hydraulics"`.
#[must_use]
pub fn name(phase: &Phase) -> Cow<'static, str> {
    Cow::Borrowed(match phase {
        Phase::Segment => "in flight",
        Phase::Event => "at contact",
        Phase::Measurement => "in the measurement",
        Phase::Joint => "in the mechanism",
        Phase::Sensor => "in the sensor",
        Phase::Actuator => "in the actuator",
        Phase::Other(word) => return format!("in \"{word}\"").into(),
    })
}

/// The stable code in answers, as a user writes it after `acts`: "flight".
#[must_use]
pub fn code(phase: &Phase) -> &str {
    match phase {
        Phase::Segment => "flight",
        Phase::Event => "contact",
        Phase::Measurement => "measurement",
        Phase::Joint => "joint",
        Phase::Sensor => "sensor",
        Phase::Actuator => "actuator",
        Phase::Other(word) => word,
    }
}

/// The place that has this [code]; any other word is a place of its own.
#[must_use]
pub fn parse(word: &str) -> Phase {
    match word {
        "flight" => Phase::Segment,
        "contact" => Phase::Event,
        "measurement" => Phase::Measurement,
        "joint" => Phase::Joint,
        "sensor" => Phase::Sensor,
        "actuator" => Phase::Actuator,
        other => Phase::Other(other.to_owned().into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_is_the_code_of_the_place_that_it_means() {
        for word in ["flight", "contact", "measurement", "joint", "sensor", "actuator", "hydraulics", "Flight", ""] {
            assert_eq!(code(&parse(word)), word);
        }
        assert_eq!((parse("flight"), parse("contact")), (Phase::Segment, Phase::Event));
        assert_eq!((parse("sensor"), parse("actuator")), (Phase::Sensor, Phase::Actuator));
        assert_eq!(parse("hydraulics"), Phase::Other("hydraulics".into()));
    }

    #[test]
    fn known_places_have_a_phrase_and_any_other_word_is_quoted() {
        assert_eq!(name(&parse("flight")), "in flight");
        assert_eq!(name(&parse("actuator")), "in the actuator");
        assert_eq!(name(&parse("the pump")), "in \"the pump\"");
    }
}
