//! Kinds of findings about the contents of files.

use tunenet_core::finding_kinds;

finding_kinds! {
    note COLUMNS_IGNORED = "columns.ignored",
        "columns with unknown names are ignored",
        "map them with `--columns` if they matter";
    warning COLUMNS_REPEATED = "columns.repeated",
        "columns that repeat a quantity are ignored",
        "choose with `--columns`";
    warning COLUMNS_ABSENT = "columns.absent",
        "no column for x or y: taken as 0",
        "name them with `--columns` if the file has them";
    note COLUMNS_CONVERTED = "columns.converted",
        "a column was converted to SI units",
        "check the unit";
    note COLUMNS_NEGATED = "columns.negated",
        "a column was read with its sign reversed, as `--columns` asked",
        "none needed";
    note ROWS_EMPTY_CELL = "rows.empty_cell",
        "rows with an empty cell were left out",
        "none needed if they are few";
    note ROWS_REPEATED = "rows.repeated",
        "rows that repeat the previous one were left out",
        "none needed";
    warning CLOCK_REPEATED = "clock.repeated",
        "rows with the time of the previous row were left out",
        "record the time with more digits";
    warning CLOCK_JUMP = "clock.jump",
        "one pause is more than 99.9 % of the record, as after a false stamp; the part with more samples is used",
        "correct the stamps, or give each part as a file of its own";
    note BOUNCES_MANY = "bounces.many",
        "the list of impacts is longer than is fitted; the first ones are used",
        "none needed";
    warning BOUNCES_MISSED = "bounces.missed",
        "an interval does not fit the previous one: an impact is missing or false; the list is used up to there",
        "number the impacts in a column `bounce_number`";
    note BOUNCES_TRAILING_ZERO = "bounces.trailing_zero",
        "zeros at the end of a list of times were left out",
        "none needed";
    warning MESSAGES_NOT_FINITE = "messages.not_finite",
        "messages with a number that is not finite were left out",
        "none needed if they are few";
    warning MESSAGES_LAYOUT = "messages.layout",
        "messages without some of the columns of the first message were left out",
        "record a topic whose messages have all of them; none needed if they are few";
    warning MESSAGES_REPEATED = "messages.repeated",
        "messages that repeat the previous one were left out",
        "none needed";
    warning CLOCK_FALLING = "clock.falling",
        "messages whose time does not rise were left out",
        "check the driver's clock";
    warning CLOCK_LOG_TIME = "clock.log_time",
        "time stamps are not set or do not rise: the recording times are used",
        "set the time stamps where the data are measured";
    note JOINTS_ORDER = "joints.order",
        "which joint got which number",
        "none needed";
    warning JOINTS_ABSENT = "joints.absent",
        "positions, velocities or efforts are not in the messages",
        "record them where the driver measures them";
    warning JOINTS_PARTIAL = "joints.partial",
        "messages that lack a joint or a quantity were left out",
        "none needed if they are few";
    warning ROWS_BROKEN = "rows.broken",
        "lines that were skipped, with the reason for each",
        "check whether the rest can be trusted";
    note JOINTS_OTHERS = "joints.others",
        "joints in the messages that the arm does not have between base and payload",
        "none needed";
    note CLOCK_COMPUTED = "clock.computed",
        "the stamps were computed from the rate: the recorder's jitter is not in them",
        "record the time of each frame where delays matter";
    warning STATE_CONSTANT = "state.constant",
        "a state or a command does not change: the robot stands still",
        "choose an episode in which it moves";
    warning ACTIONS_OTHER = "actions.other",
        "actions are as wide as the joints, and are no joint angles",
        "do not drive joints with them; record the joint targets";
    warning UNITS_DISAGREE = "units.disagree",
        "the numbers of a column do not fit the unit that is stated for it",
        "check the unit, and whose calibration file it is";
    note GROUPS_EMPTY = "groups.empty",
        "groups without arrays were left out",
        "none needed";
    warning EPISODES_MISSING = "episodes.missing",
        "not all of the episodes that a data set lists are there",
        "download the others where they are needed";
    warning FRAMES_DIFFER = "frames.differ",
        "an episode has another number of frames than its data set lists",
        "download `meta` and `data` of one version";
    warning COLUMNS_NUMBERED = "columns.numbered",
        "names of a data set's numbers occur twice, or are not as many as the numbers: these are numbered instead",
        "correct `names` in `meta/info.json`";
    warning FILES_MISSING = "files.missing",
        "the numbers of a recording's files have a gap",
        "copy the whole folder, with its metadata.yaml";
    note INPUT_LATE = "inputs.late",
        "an input begins after the recording; its first value holds before",
        "record the input from the start";
    warning INPUT_SHORT = "inputs.short",
        "the recording goes on after its input; it is used up to the input's last sample",
        "record the input to the end";
    note INPUT_LONG = "inputs.long",
        "the inputs go on after the last sample that `[record]` has; what comes later is not simulated",
        "state more samples: `record.frames`";
    note INPUT_DEFAULT = "inputs.default",
        "the recording does not have an input; its `default` is used",
        "none needed";
}
