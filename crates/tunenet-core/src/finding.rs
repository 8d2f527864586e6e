//! What a finding is: a kind with a stable code, its severity, its meaning and what to do about it.

use std::fmt;

use serde::{Serialize, Serializer};

/// Whether a finding asks for something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// It says what was done; nothing is wrong.
    Note,
    /// It may make the answer wrong, or keeps it from being better.
    Warning,
}

impl Severity {
    /// The word for it: `note`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
        }
    }
}

/// A kind of finding. Decisions compare kinds; scripts read [`code`](Self::code); the tables in `docs/` are made of
/// [`meaning`](Self::meaning) and [`remedy`](Self::remedy).
///
/// Each crate declares its kinds with [`finding_kinds!`](crate::finding_kinds), as this crate does in
/// [`findings`](crate::findings). Two kinds are equal where their codes are.
#[derive(Debug, Clone, Copy)]
pub struct FindingKind {
    code: &'static str,
    severity: Severity,
    meaning: &'static str,
    remedy: &'static str,
}

impl FindingKind {
    /// A kind from its code (`fit.poor`), what it means and what to do about it.
    #[must_use]
    pub const fn new(code: &'static str, severity: Severity, meaning: &'static str, remedy: &'static str) -> Self {
        Self { code, severity, meaning, remedy }
    }

    /// The fixed code for scripts: `fit.poor`.
    #[must_use]
    pub const fn code(self) -> &'static str {
        self.code
    }

    /// Whether it is a warning.
    #[must_use]
    pub const fn severity(self) -> Severity {
        self.severity
    }

    /// What was found, in general; Markdown.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        self.meaning
    }

    /// What to do about it, in general; Markdown.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        self.remedy
    }
}

impl PartialEq for FindingKind {
    fn eq(&self, other: &Self) -> bool {
        self.code == other.code
    }
}

impl Eq for FindingKind {}

impl fmt::Display for FindingKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.code)
    }
}

impl Serialize for FindingKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.code)
    }
}

/// Declares kinds of findings as constants, each a `note` or a `warning`, and `ALL` of them in one list.
///
/// ```
/// use tunenet_core::finding::Severity;
///
/// tunenet_core::finding_kinds! {
///     warning SENSOR_COLD = "sensor.cold",
///         "the sensor had not reached its working temperature",
///         "wait a minute after switching it on";
///     note SENSOR_SLOW = "sensor.slow", "the sensor answers once a second", "none needed";
/// }
/// assert_eq!(ALL, [SENSOR_COLD, SENSOR_SLOW]);
/// assert_eq!((SENSOR_COLD.code(), SENSOR_COLD.severity()), ("sensor.cold", Severity::Warning));
/// ```
#[macro_export]
macro_rules! finding_kinds {
    (@severity note) => { $crate::finding::Severity::Note };
    (@severity warning) => { $crate::finding::Severity::Warning };
    ($($severity:ident $name:ident = $code:literal, $meaning:literal, $remedy:literal;)*) => {
        $(
            #[doc = concat!("`", $code, "`: ", $meaning, ".")]
            pub const $name: $crate::finding::FindingKind =
                $crate::finding::FindingKind::new(
                    $code,
                    $crate::finding_kinds!(@severity $severity),
                    $meaning,
                    $remedy,
                );
        )*

        /// All kinds that this module declares.
        pub const ALL: &[$crate::finding::FindingKind] = &[$($name),*];
    };
}

#[cfg(test)]
mod tests {
    use crate::findings::{ALL, FIT_LOCAL, FIT_POOR};

    #[test]
    fn kinds_are_equal_by_code_and_serialise_as_it() {
        assert_ne!(FIT_LOCAL, FIT_POOR);
        assert_eq!(serde_json::to_string(&FIT_POOR).unwrap(), "\"fit.poor\"");
        assert_eq!(FIT_POOR.to_string(), FIT_POOR.code());
    }

    #[test]
    fn codes_are_unique() {
        for (i, kind) in ALL.iter().enumerate() {
            assert!(!ALL[..i].contains(kind), "{kind} is declared twice");
        }
    }
}
