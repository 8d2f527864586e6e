//! Why a law is not the answer, or not alone: in a word.

use serde::Serialize;

/// Why a law is not the answer, or not alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Held-out recordings are predicted worse than noise allows.
    HeldOut,
    /// There are no held-out recordings.
    NoHeldOut,
    /// More than noise is left.
    ResidualForce,
    /// Recordings differ: something unmeasured.
    Heterogeneity,
    /// It depends on the time, and fails a test.
    Time,
    /// The allowance of rollouts ended the search.
    Rollouts,
    /// Several laws explain the recordings.
    Several,
    /// It has two terms, whose rivals were not compared.
    Terms,
    /// It fits any smooth force: a bump of which one flank was seen only, less than half a period of an oscillation, or a product of two
    /// factors with two constants each, or of one variable.
    Flexible,
    /// The intervals of its coefficients hold 0.
    Size,
    /// A constant of it lies at the end of the range that is searched.
    Bound,
    /// A parameter of the simulation lies at a bound other than 0, or at one beyond which the recordings favour values.
    ParameterBound,
    /// Rollouts are not linear enough in its constants to compare it with other laws by held-out recordings.
    NotLinear,
    /// So few recordings do not show whether something unmeasured differs between them.
    Few,
    /// Recordings ask for constants that differ more than in one case of a hundred by chance.
    Differ,
    /// Held-out recordings leave more than fitted ones, so much more that it comes in less than one case of a hundred by chance.
    LeavesMore,
    /// A force is likely left on fitted recordings, or on held-out ones.
    LeavesForce,
    /// Its tests come out so badly together that it comes in less than one case of a hundred by chance, though each alone does not.
    Together,
    /// A force that decays from a value of its own in each recording explains the fitted recordings as well.
    Decay,
    /// No shape of the table gains what it costs.
    Grammar,
    /// An effect of the catalogue explains the recordings as well.
    Catalogue,
}
