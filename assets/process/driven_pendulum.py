"""A driven pendulum that speaks with tunenet: an input, an initial state and a candidate effect, in the standard library."""
import bisect
import json
import math
import sys

STEP_S, GRAVITY_M_S2, recordings = 1e-3, 9.81, {}


def swing(asked):
    known, p, friction = recordings[asked["recording"]], asked["parameters"], asked["effects"]["dry_friction"]["rad_s2"]
    torque, now, values = known["inputs"]["torque_nm"], known["start_s"], []
    angle, rate = asked["start"]["angle_rad"], 0.0  # at rest at the first stamp of the recording
    for time in asked["times_s"]:
        steps = max(0, math.ceil((time - now) / STEP_S))
        for i in range(steps):  # leapfrog steps; the torque holds between its samples
            h = (time - now) / steps
            at = max(0, bisect.bisect_right(torque["times_s"], now + i * h + 1e-9) - 1)
            angle += h / 2 * rate
            driven = torque["values"][at] / (known["settings"]["mass_kg"] * p["length"] ** 2)
            rate += h * (driven - GRAVITY_M_S2 / p["length"] * math.sin(angle) - p["damping"] * rate)
            rate -= math.copysign(min(abs(rate), h * friction), rate)  # absent at 0
            angle += h / 2 * rate
        now = max(now, time)
        values.append([angle])  # one number for each channel
    return {"values": values}


for line in sys.stdin:  # until tunenet is done
    asked = json.loads(line)
    if "tunenet" in asked:  # the first line
        answer = {"tunenet": 2}
    elif "batch" in asked:  # many rollouts at once
        answer = {"id": asked["id"], "answers": [swing(one) for one in asked["batch"]]}
    else:
        answer = {"id": asked["id"]} | (swing(asked) if "times_s" in asked else {})
        if "inputs" in asked:  # a recording, of which rollouts are asked later
            recordings[asked["recording"]] = asked
        recordings.pop(asked.get("forget"), None)
    print(json.dumps(answer), flush=True)
