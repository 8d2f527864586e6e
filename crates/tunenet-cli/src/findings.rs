//! Kinds of findings about the tool's own work: caches, shards, thinning.

use tunenet_core::finding_kinds;

finding_kinds! {
    note SAMPLES_THINNED = "samples.thinned",
        "the recording is longer than the fit needs; evenly spaced samples are used",
        "none needed";
    note CACHE_REPLACED = "cache.replaced",
        "a cached network was damaged or did not match its name, and was trained again",
        "none needed";
    warning CACHE_UNUSABLE = "cache.unusable",
        "the cache could not be read or written",
        "make the folder writable, set `TUNENET_CACHE`, or use `--no-cache`";
    note START_ESTIMATED = "start.estimated",
        "these states are estimated in every recording, and the simulation starts where the first samples of this one show them",
        "set `start.NAME.value` on the command line to start there";
    note EFFECTS_HELD = "effects.held",
        "effects of the simulation file keep their values, and intervals of parameters do not include how uncertain those are",
        "estimate them together: `tune = true` in `[effects.NAME]`";
    note SETUPS_DIFFER = "setups.differ",
        "recordings of one object differ in these keys of the scene; a written file keeps what the simulation file says of them, and \
         `observations` of its `[provenance]` has the keys of each recording under `scene`",
        "none needed";
    warning UNITS_DIFFER = "units.differ",
        "a channel or an input of one recording varies by another order of magnitude than in the others",
        "check its unit: degrees among radians, or milli-units, look like that";
    warning CHECKPOINT_INCOMPLETE = "checkpoint.incomplete",
        "the checkpoint does not hold all rollouts; the answer is not affected",
        "free some space, or name a file on another disk, before a long tuning";
    warning PLAN_ARM_REACH = "plan.arm_reach",
        "the arm does not reach all of the heights",
        "move its base in the task file, or narrow `release.heights_m`";
    warning PLAN_AT_END = "plan.at_end",
        "the best height is the lowest or highest that the task allows",
        "widen `release.heights_m` if possible";
    warning SHARDS_MANY = "shards.many",
        "there are more shards than pieces of work, so some have none",
        "use as many shards as there are pieces, or fewer";
}
