//! Kinds of findings about recordings of a bouncing ball.

use tunenet_core::finding_kinds;

finding_kinds! {
    warning MOTION_NONE = "motion.none",
        "the ball does not move (failed)",
        "check the columns and their units";
    warning CLOCK_IRREGULAR = "clock.irregular",
        "time steps vary by more than half their median, gaps excluded",
        "stamp frames when they are taken, not when they arrive; correct irregular stamps do no harm";
    warning CLOCK_GAPS = "clock.gaps",
        "4 consecutive frames or 4 % of all are missing",
        "record again if an impact lies in a gap";
    warning CLOCK_REPEATS = "clock.repeats",
        "frames occur more than once, with new stamps; the repetitions are left out",
        "save the video at the rate at which it was taken";
    warning CLOCK_SKIPPED = "clock.skipped",
        "frames are missing although the stamps are even: a flight jumps ahead by whole frames",
        "stamp frames when they are taken";
    warning CLOCK_SLOW = "clock.slow",
        "fewer than 5 frames in the longest fall",
        "record faster, or drop from higher up";
    warning SAMPLES_FROZEN = "samples.frozen",
        "the values do not change at all during motion, at the end of a noisy record or at its top: the tracker lost the ball; those samples are left out",
        "keep the whole path in view";
    warning SAMPLES_OUTLIERS = "samples.wild",
        "outliers: single samples jump far away and back; they are excluded",
        "correct or remove them";
    warning UNITS_WRONG = "units.wrong",
        "the fall matches mm, cm, inches, feet, km, ms, µs or ns (failed)",
        "put the unit into the column's name";
    warning GRAVITY_APPARENT = "gravity.apparent",
        "free flight falls significantly more than 1 % too fast or too slowly; below 0.3 or above 2 times gravity it fails",
        "the likeliest causes are listed: repeated or missing frames, a wrong frame rate, a wrong scale, the clock, air drag";
    warning MOTION_UNLIKE = "motion.unlike",
        "no bounce, and no flight under gravity either (failed)",
        "check the units, the sign of z, and which column is which";
    note RELEASE_LATE = "release.late",
        "samples before the release; they are excluded",
        "none needed";
    warning MOTION_BLOW = "motion.blow",
        "something other than the surface changes the velocity permanently; the longest part without it is used",
        "record without touching the ball";
    warning MOTION_DISTURBED = "motion.disturbed",
        "too little undisturbed motion remains (failed)",
        "record a drop that touches nothing but the surface";
    warning CONTACT_NONE = "contact.none",
        "the ball does not bounce, or only within the last samples, which are then excluded; contacts cannot be examined",
        "record until after the first bounce, better the third";
    warning SURFACE_LEFT = "surface.left",
        "the ball falls below its surface; samples from there on are excluded",
        "use a larger surface";
    warning VIEW_LEFT = "view.left",
        "the ball leaves the view upwards and comes back",
        "move the camera back";
    note SURFACE_UNKNOWN = "surface.unknown",
        "the height of the surface is not given; it was estimated",
        "none needed";
    warning SURFACE_DISAGREES = "surface.disagrees",
        "the contacts are not where `surface.height_m` and `ball.radius_m` put them",
        "correct them, or leave the height out";
    warning SURFACE_SHIFTED = "surface.shifted",
        "the surface of one recording lies at another height than that of all others; it is estimated for each recording",
        "check the origin and the calibration of z in this recording";
    warning RELEASE_DISAGREES = "release.disagrees",
        "the ball falls another height than `release.height_m`",
        "correct it, or leave it out";
    note MOTION_REST = "motion.rest",
        "never; reports how long the ball lies still at the end",
        "none needed";
    warning BOUNCES_IMPLAUSIBLE = "bounces.implausible",
        "the first interval would need a hop below 10 µm or above 200 m (failed)",
        "check the unit of the times";
    warning BOUNCES_EVEN = "bounces.even",
        "ten or more intervals hardly shrink: no known ball keeps so much of its energy",
        "check that a free ball made these times, not a clock, a machine or a driven ball";
    warning BOUNCES_GROW = "bounces.grow",
        "a hop lasts longer than the one before, beyond the noise of the times",
        "a hand or a second impact: give only the bounces before it; a missed impact: number the impacts in a column `bounce_number`";
    warning FLIGHTS_ALONE = "flights.alone",
        "the recordings as a whole are not explained; their flight segments were analysed separately",
        "record throws without spin to learn more about the contacts";
    warning CONTACTS_ALONE = "contacts.alone",
        "the recordings as a whole are not explained, but their contacts reduce the speed along the surface, and were analysed separately",
        "record several throws in different directions to learn more about the flights";
}
