//! Kinds of findings about simulation files, arms, programs and plans.

use tunenet_core::finding_kinds;

finding_kinds! {
    warning PREFLIGHT_FORCED = "preflight.forced",
        "a recording that failed the checks is used because of `--force`",
        "correct the recording";
    warning FRICTION_NOT_OBSERVABLE = "friction.unseen",
        "bounce times do not depend on friction",
        "record positions of a throw along the surface";
    warning PROGRAM_REFUSED = "program.refused",
        "the program reported that it cannot simulate some parameter values; how many, those nearest to the file's values, and its message",
        "narrow `min` and `max` of `[parameters.NAME]` if the answer is close to these values";
    warning PROGRAM_BEYOND = "program.beyond",
        "the same for rollouts that returned numbers beyond 1e100",
        "the same";
    note URDF_IGNORED = "urdf.ignored",
        "elements of the file that the simulation leaves out",
        "none needed";
    warning URDF_LIMITS = "urdf.limits",
        "a joint has no range between its limits, as exporters write if none are known; it moves freely",
        "write lower and upper";
    warning URDF_HELD = "urdf.held",
        "a joint that is not between base and payload is held",
        "name another `arm.payload_link`";
    warning URDF_WEIGHTLESS = "urdf.weightless",
        "a moving link has no inertia",
        "add it";
    warning MODEL_LEFT_OUT = "model.left_out",
        "a model states forces, parts, gravity or commands that the simulation leaves out",
        "check that they do not matter, or remove them";
    note MODEL_COMMAND_SCALE = "model.command_scale",
        "actuators of an MJCF have a gear or a gain, by which commands are multiplied",
        "write `command_scale = 1.0` where commands were recorded in the unit of the joint";
    note MODEL_EFFECTS = "model.effects",
        "an MJCF states armature or springs, which an arm has as effects of the simulation file",
        "write them under `[effects]` if they are to count";
    warning ARM_UNUSABLE = "arm.unusable",
        "the recording lacks torques, has those of other joints, or fewer than 20 samples of the motion",
        "record the efforts of all joints between base and payload, over the whole motion";
    warning ARM_CLOCK = "arm.clock",
        "the clock does not begin with the motion; the first sample is taken for its start",
        "start the clock with the motion";
    note ARM_LONGER = "arm.longer",
        "samples after the end of the motion are left out",
        "raise `motion.duration_s`";
    warning JOINTS_COUNT = "joints.count",
        "the number of joints with positions differs from that of the URDF between base and payload",
        "number or map the columns in the order of the URDF";
    warning JOINTS_CLOCK = "joints.clock",
        "samples cover less than half of the log",
        "cut it at its gaps";
    warning JOINTS_EFFORT = "joints.effort",
        "there are neither torques nor currents with their constants",
        "record efforts; set `arm.current_gain_nm_a`";
    warning JOINTS_UNITS = "joints.units",
        "angles far beyond the limits, or speeds that are not the slopes of the positions: degrees instead of radians, or a clock that is not in seconds",
        "name columns `q1_deg`, `dq1_deg_s`, `t_ms`";
    warning JOINTS_LIMITS = "joints.limits",
        "a joint exceeds its limits by more than 0.05 rad (`not_run` if the URDF gives none)",
        "check order and zero of the joints, and the URDF";
    warning JOINTS_SPEEDS = "joints.speeds",
        "measured speeds are not the slopes of the positions (`noticed` only)",
        "check order and signs";
    warning JOINTS_SHORT = "joints.short",
        "fewer than 20 windows remain",
        "record longer, without gaps";
    warning JOINTS_SIGNS = "joints.signs",
        "the torque of a joint has the opposite sign of the simulated arm's",
        "change the sign of the column; with currents, use a negative `arm.current_gain_nm_a`";
    warning REFERENCE_SWAPPED = "reference.swapped",
        "the run needs less torque than its reference",
        "give the loaded run to `--observation`, the bare one to `--reference`";
    warning PAYLOAD_GAIN = "payload.gain",
        "mass and gain are tuned together (`noticed` only; with their correlation)",
        "calibrate the gain first, with a known payload and a reference";
    warning PAYLOAD_ALONE = "payload.alone",
        "there is no reference, and the URDF alone does not explain the torques (`noticed` only)",
        "record the same motion without payload, and give it with `--reference`";
    warning PAYLOAD_PLACE = "payload.place",
        "the centre of mass lies where no payload of that mass can have one: beyond 0.2 m and half the edge of a cube of 5 kg/m³ (`noticed` only)",
        "check order, zeros and constants of the joints; record a reference";
    warning PAYLOAD_MOVED = "payload.moved",
        "the centre of mass differs from the one tuned before, in `[provenance]` (`noticed` only)",
        "check how the payload was mounted, and the zeros and signs of both logs";
    note ROBOT_JUMPS = "robot.jumps",
        "single samples of a joint jump and are left out",
        "none needed; check the wiring where there are many";
    warning ROBOT_GAP = "robot.gap",
        "a recording pauses much longer than between its other samples, and the simulation holds the last commands meanwhile",
        "correct the stamps, or give the parts before and after as recordings of their own";
    note ROBOT_START = "robot.start",
        "a joint of a velocity, torque or voltage drive moves from its first samples on: nothing corrects an error of its start",
        "estimate the start: `[start.JOINT_rad]` with `value = \"first\"` and `sd`, about three times the noise";
    warning ROBOT_STILL = "robot.still",
        "a joint never moves",
        "leave it out of `[joints]`, or record it while it moves";
    warning ROBOT_UNITS = "robot.units",
        "commands and positions of a joint are in different units, such as degrees and radians, or positions span more than three times what the model's limits allow; the recording is not used",
        "state the units as they were recorded, or correct the limits in the model";
    warning ROBOT_ZERO = "robot.zero",
        "a turning joint is read more than a quarter turn beyond the limits of its model: it has another zero",
        "write the joint's `zero` into its parameter, with bounds near it";
    warning ROBOT_STOP = "robot.stop",
        "a joint stands at a limit of the model while its commands go beyond it: stops are not simulated",
        "leave these parts out, or keep the commands within the limits";
    warning ROBOT_COMMAND_RANGE = "robot.command_range",
        "commands of a joint go beyond the `ctrlrange` of its MJCF: the simulation does not clip them, a copy of the model does",
        "write `command_range` into the joint's table if the robot clips them too, or widen `ctrlrange` in the model";
    warning ROBOT_RARE = "robot.rare",
        "samples are more than a second apart: they do not show how a joint moves; the recording is not used",
        "state the unit of the clock (ms as s?), or record more often";
    warning ROBOT_LEADER = "robot.leader",
        "the positions of a joint equal its commands, or jump with them faster than a joint moves: a log of what commanded it; the recording is not used",
        "record the positions of the follower";
    warning ROBOT_SIGN = "robot.sign",
        "a joint moves against its commands: one of both has the other sign",
        "turn the sign of one column: a `-` before its name in `--columns`";
    warning ROBOT_STEPS = "robot.steps",
        "the commands of a joint are followed by its speed: they are steps, as of a policy, not positions to go to; the recording is not used",
        "record the positions that it was sent to, or add up the steps";
    warning ROBOT_CLOCK = "robot.clock",
        "the commands of a joint fit its motion far better almost a second or more earlier or later",
        "give both the same clock";
    warning ROBOT_ONE_SETUP = "robot.one_setup",
        "all recordings have one gain and one load: some effects are the same as parameters there and are not looked for",
        "record at another gain and with another load";
    note ROBOT_SEVERAL_JOINTS = "robot.several_joints",
        "some effects are simulated at a single joint only and are not looked for",
        "to look for them, keep one joint in `[joints]`";
    note REFERENCE_ALIGNED = "reference.aligned",
        "by which lag the reference was aligned",
        "none needed";
    warning CAMERA_UNKNOWN = "camera.unknown",
        "the pixels of a drop from a known height do not match its first fall for any camera",
        "correct `release.height_m` and `release.time_s`, or leave both out and give metres";
    warning EFFECT_CLOCK = "effect.clock",
        "the formula of an effect of the file depends on the time, so it holds for recordings with the same clock only",
        "write the formula with what changes, or keep the clock of the recordings";
    note EFFECT_POWER = "effect.power",
        "a power in the formula of an effect has a coefficient as its exponent; its base is read as a multiple of its unit",
        "none needed; divide the base by a length, a speed, … of your own to choose another";
    warning EFFECT_OUTSIDE = "effect.outside",
        "a rollout leaves the range in which the formula of an effect was seen to hold (`valid`)",
        "rely on it within the range only, or record there and diagnose again";
    warning PLAN_UNTUNED = "plan.untuned",
        "this simulation was never tuned; its values are used as they are",
        "tune it to a drop of this ball";
    warning PLAN_POOR_FIT = "plan.poor_fit",
        "it was tuned, but does not match the measurement",
        "ask `tunenet diagnose` what it lacks";
    warning PLAN_ONE_EXPLANATION = "plan.one_explanation",
        "several effects explain the measurement, and the file has only the numbers of one",
        "record what `diagnose` proposes next, and diagnose again";
    warning PLAN_OPEN_DRAG = "plan.open_drag",
        "the measurement leaves air drag uncertain by more than 0.01 1/m",
        "nothing, or a recording with more or higher bounces";
    warning PLAN_CHANGED = "plan.changed",
        "a value of the file is not the one that was tuned; its interval is not used",
        "tune the file again, or restore the value";
}
