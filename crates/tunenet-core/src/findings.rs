//! Kinds of findings about tuning and diagnosis.

use crate::finding_kinds;

finding_kinds! {
    warning RECORDINGS_NONE = "recordings.none",
        "no recording can be used for the fit",
        "see the notes of each recording";
    warning RECORDINGS_SHORT = "recordings.short",
        "`tune`: no more values than fitted parameters, so any fit is exact; `diagnose`: fewer than 12 values more than unknowns",
        "use longer recordings, or more of them";
    note SAMPLES_EXCLUDED = "samples.excluded",
        "samples after the end of the motion, and outliers, do not count; says which share of all samples counts",
        "none needed";
    warning FIT_POOR = "fit.poor",
        "the tuned simulation leaves more than noise explains",
        "look for a missing effect, a wrong radius or unit, or another object in the recording; add a known effect to the file";
    warning RECORDINGS_DISAGREE = "recordings.disagree",
        "lists of events differ by more than their own scatter explains (analysis of variance); the fit is poor",
        "tune each by itself, and look for what differs: the object, the surface, a missed event";
    warning FIT_UNTESTED = "fit.untested",
        "too few samples to distinguish noise from model error",
        "use a longer recording";
    warning FIT_LOCAL = "fit.local",
        "a parameter was estimated from the contacts only, because the full fit is poor; all figures are of that value, and the result of the full fit is reported",
        "resolve `fit.poor`";
    warning ROLLOUTS_LIMIT = "rollouts.limit",
        "the limit on rollouts ended the fit, or the searches and checks after it; `diagnose` has no answer if it ends the first search",
        "allow more rollouts";
    note FIT_QUICK = "fit.quick",
        "`tune`: only the first fit was made, and intervals are those of the curvature; `diagnose`: whole recordings were searched once",
        "none needed; a fit that is not quick checks intervals and makes all searches";
    warning PARAMETER_NOT_IDENTIFIABLE = "parameter.not_identifiable",
        "the data do not determine a parameter",
        "use a recording that depends on it";
    warning PARAMETER_NO_EFFECT = "parameter.no_effect",
        "a parameter changes nothing in these recordings",
        "use a recording that depends on it";
    warning START_NO_EFFECT = "start.no_effect",
        "an initial state that is estimated changes nothing in any recording",
        "check the name of the state: what simulates may not read it";
    warning PARAMETER_DIRECTION = "parameter.direction",
        "a combination of parameters is not determined",
        "fix one of them, or use a recording that separates them";
    note PARAMETERS_TIED = "parameter.tied",
        "parameters, or a parameter and a number that the simulation states, of which the recordings determine a combination only; `tied` lists them",
        "read them as a set; a value of one holds for these values of the others";
    warning PARAMETER_AT_BOUND = "parameter.at_bound",
        "a parameter ends on its bound, and the data favour values beyond it",
        "widen the bound if the value may lie beyond; otherwise check units, surface height and missing effects";
    note PARAMETER_ONE_SIDED = "parameter.one_sided",
        "a parameter lies on its bound, which is allowed",
        "none needed";
    note HELD_OUT_CHOSEN = "held_out.chosen",
        "which recordings were held out for validation",
        "none needed; you can also choose them yourself";
    note NOISE_AUTOCORRELATED = "noise.coloured",
        "the residual is autocorrelated and was prewhitened. Above a correlation of 0.7 a model error looks the same: the search is then repeated with white noise, and its answer is taken if the effects found remove the correlation; without any effect the answer is `unknown`, never `none`",
        "none needed below 0.7; more recordings above";
    note ADEQUACY_PRACTICAL = "adequacy.practical",
        "the residual exceeds the noise; the effects remove most of the misfit, and held-out recordings confirm them where there are any",
        "none needed; the coefficients absorb a small part of what remains";
    note REMAINDER_UNKNOWN = "remainder.unknown",
        "effects are named, and what they leave is far above the noise: no other effect of the catalogue is confirmed by held-out recordings",
        "compare parameters on other recordings before relying on them; what the remainder depends on is shown in the report";
    warning CONTACT_UNEXPLAINED = "contact.unexplained",
        "the named effects explain the motion between contacts; contacts leave a discrepancy that no effect explains",
        "vary height and surface, to see which of them changes it";
    note INTERVALS_CURVATURE = "intervals.curvature",
        "the fit is poor: intervals are those of the curvature, and were not checked",
        "search for the missing effect with `diagnose`";
    note INTERVALS_WIDENED = "intervals.widened",
        "recordings differ by more than their noise; intervals follow from their scatter",
        "vary less between recordings, or specify the difference";
    warning RECORDINGS_ALIKE = "recordings.alike",
        "all recordings show the same motion and count as one",
        "record motions with other initial states or inputs";
    note EFFECT_IMPLAUSIBLE = "effect.unlikely",
        "an effect explains the recordings as well, but is implausible for this object",
        "state in the simulation file in which medium the object moved";
    warning EFFECT_EXCLUDED = "effect.excluded",
        "an effect explains more than the answer, but needs a coefficient outside its physical range",
        "check the settings on which that range depends, such as mass and radius";
    warning EFFECT_OUT_OF_RANGE = "effect.out_of_range",
        "one of several objects needs a coefficient outside its physical range",
        "check that object's settings, such as mass and radius";
    warning PARAMETER_DIFFERS = "parameter.differs",
        "a parameter differs from recording to recording; it is treated as a random effect, and its value is the mean",
        "keep the conditions of the recordings the same, or give each its own object";
    warning RECORDINGS_ODD = "recordings.odd",
        "one recording disagrees with all others; the answer is that of the others. Where it is held out, and nothing is missing from those that were fitted, the answer is `unknown`",
        "check what differs in it: the object, the units, the frame rate";
    warning EFFECT_OMITTED = "effect.omitted",
        "the simulation leaves out an effect that every real body shows, the recordings show some of it, and a parameter moves with it by more than half of its interval; the interval includes its value with the effect",
        "search for the missing effect with a diagnosis of the same recordings";
    note CONSTANT_ASSUMED = "constant.assumed",
        "a constant stands at its usual value, as gravity at 9.81 m/s²; what it may be in this place moves a parameter by more than half of its interval",
        "set it to the local value, with four digits; 9.8, 9.81 and 9.80665 m/s² count as usual values of gravity";
    note PARAMETER_CARRIED = "parameter.carried",
        "a fixed value was itself tuned, and the intervals allow for its uncertainty",
        "none needed";
}
