//! What a finding is: a kind with a stable code, its meaning and what to do about it.

use std::fmt;

use serde::{Serialize, Serializer};

/// A kind of finding. Decisions compare kinds; scripts read [`code`](Self::code); the tables in `docs/` are made of
/// [`meaning`](Self::meaning) and [`remedy`](Self::remedy).
///
/// Each crate declares its kinds with [`finding_kinds!`](crate::finding_kinds), as this crate does in
/// [`findings`](crate::findings). Two kinds are equal where their codes are.
#[derive(Debug, Clone, Copy)]
pub struct FindingKind {
    code: &'static str,
    meaning: &'static str,
    remedy: &'static str,
}

impl FindingKind {
    /// A kind from its code (`release.late`), what it means and what to do about it.
    #[must_use]
    pub const fn new(code: &'static str, meaning: &'static str, remedy: &'static str) -> Self {
        Self { code, meaning, remedy }
    }

    /// The fixed code for scripts: `release.late`.
    #[must_use]
    pub const fn code(self) -> &'static str {
        self.code
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

/// Declares kinds of findings as constants, and `ALL` of them in one list.
///
/// ```
/// tunenet_core::finding_kinds! {
///     SENSOR_COLD = "sensor.cold",
///         "the sensor had not reached its working temperature",
///         "wait a minute after switching it on";
/// }
/// assert_eq!(ALL, [SENSOR_COLD]);
/// assert_eq!(SENSOR_COLD.code(), "sensor.cold");
/// ```
#[macro_export]
macro_rules! finding_kinds {
    ($($name:ident = $code:literal, $meaning:literal, $remedy:literal;)*) => {
        $(
            #[doc = concat!("`", $code, "`: ", $meaning, ".")]
            pub const $name: $crate::finding::FindingKind =
                $crate::finding::FindingKind::new($code, $meaning, $remedy);
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
