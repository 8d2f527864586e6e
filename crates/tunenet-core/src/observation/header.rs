//! A channel as the header of a column: `z_m`, `dq1_rad_s`.

use super::Channel;

/// How the header of a column ends, and the unit that this means. Longer endings come first.
const ENDINGS: [(&str, &str); 36] = [
    ("rad_s2", "rad/s²"),
    ("kg_m2", "kg·m²"),
    ("kg_m3", "kg/m³"),
    ("deg_s", "deg/s"),
    ("rad_s", "rad/s"),
    ("m_s2", "m/s²"),
    ("m_s", "m/s"),
    ("1_m", "1/m"),
    ("1_s", "1/s"),
    ("n_m", "N/m"),
    ("kg_s", "kg/s"),
    ("m3_s", "m³/s"),
    ("w_m2", "W/m²"),
    ("rad", "rad"),
    ("deg", "deg"),
    ("mol", "mol"),
    ("bar", "bar"),
    ("px", "px"),
    ("hz", "Hz"),
    ("kg", "kg"),
    ("nm", "N·m"),
    ("pa", "Pa"),
    ("m2", "m²"),
    ("m3", "m³"),
    ("ms", "ms"),
    ("mm", "mm"),
    ("cm", "cm"),
    ("ohm", "Ohm"),
    ("c", "°C"),
    ("v", "V"),
    ("w", "W"),
    ("j", "J"),
    ("k", "K"),
    ("n", "N"),
    ("a", "A"),
    ("m", "m"),
];
/// A number without a unit, and seconds, which are looked for last: `rad_s` is no time.
const LAST: [(&str, &str); 2] = [("s", "s"), ("1", "1")];
/// Most characters of a header.
const LONGEST: usize = 64;

impl Channel {
    /// The header of its column: the name, then the unit.
    ///
    /// ```
    /// use tunenet_core::observation::Channel;
    /// assert_eq!(Channel::new("speed", "m/s").header(), "speed_m_s");
    /// assert_eq!(Channel::from_header("speed_m_s"), Some(Channel::new("speed", "m/s")));
    /// assert_eq!(Channel::from_header("speed"), None);
    /// ```
    #[must_use]
    pub fn header(&self) -> String {
        match self.unit.as_str() {
            "1" => self.name.clone(),
            unit => match ENDINGS.iter().chain(&LAST).find(|(_, known)| *known == unit) {
                Some((ending, _)) => format!("{}_{ending}", self.name),
                None => format!("{}_{}", self.name, plain(unit)),
            },
        }
    }

    /// The channel of a header that names its unit, in lower-case letters, digits and `_`, beginning with a letter; a number without
    /// a unit ends in `_1`. `None` for an unknown unit or another name.
    #[must_use]
    pub fn from_header(header: &str) -> Option<Self> {
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if header.len() > LONGEST || !header.starts_with(|c: char| c.is_ascii_lowercase()) || !header.chars().all(plain)
        {
            return None;
        }
        let named = |(ending, unit): &(&str, &str)| {
            let name = header.strip_suffix(ending)?.strip_suffix('_')?;
            (!name.is_empty()).then(|| Self::new(name, *unit))
        };
        ENDINGS.iter().chain(&LAST).find_map(named)
    }
}

/// Lower case, with every run of other signs as one `_`: "Time (s)" is `time_s`, "rad/s" is `rad_s`.
#[must_use]
pub fn plain(name: &str) -> String {
    let name = name.to_lowercase().replace('μ', "µ");
    name.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_comes_back_from_its_header() {
        for (ending, unit) in ENDINGS.iter().chain(&LAST[..1]) {
            let channel = Channel::from_header(&format!("dq1_{ending}")).unwrap();
            assert_eq!(channel, Channel::new("dq1", *unit), "{ending}");
            assert_eq!(channel.header(), format!("dq1_{ending}"));
        }
        assert_eq!(Channel::from_header("slip_1").unwrap().header(), "slip");
        for (i, (ending, _)) in ENDINGS.iter().enumerate() {
            let hidden = ENDINGS[..i].iter().find(|(before, _)| format!("_{ending}").ends_with(&format!("_{before}")));
            assert_eq!(hidden, None, "{ending} is never reached");
        }
    }

    #[test]
    fn what_names_no_unit_is_no_channel() {
        for header in ["", "angle", "_m", "m", "Angle_rad", "z_ft", "<b>_m", "z m", "1_m", "ä_m", &"z".repeat(99)] {
            assert_eq!(Channel::from_header(header), None, "{header}");
        }
    }
}
