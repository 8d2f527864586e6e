"""A driven cart in MuJoCo that speaks with tunenet: an input, a setting and a candidate effect; `pip install mujoco`."""
import bisect
import json
import sys

import mujoco

MODEL = """<mujoco><option timestep="0.002" integrator="implicitfast"/><worldbody><body>
  <joint name="slide" type="slide" axis="1 0 0" damping="{damping}" frictionloss="{friction}"/>
  <geom type="box" size="0.1 0.05 0.05" mass="{mass}"/></body></worldbody>
  <actuator><motor joint="slide" gear="{gear}"/></actuator></mujoco>"""
recordings = {}


def drive(asked):
    known, friction = recordings[asked["recording"]], asked["effects"]["dry_friction"]["n"]
    text = MODEL.format(friction=friction, gear=known["settings"]["gear"], **asked["parameters"])
    model = mujoco.MjModel.from_xml_string(text)
    data, force, values = mujoco.MjData(model), known["inputs"]["force_n"], []
    data.time, data.qpos[0], step_s = known["start_s"], asked["start"]["x_m"], model.opt.timestep
    for time in asked["times_s"]:
        while time - data.time > 1e-9:
            at = bisect.bisect_right(force["times_s"], data.time + 1e-9) - 1
            data.ctrl[0], model.opt.timestep = force["values"][max(0, at)], min(step_s, time - data.time)
            mujoco.mj_step(model, data)
        values.append([float(data.qpos[0])])
    return {"values": values}


for line in sys.stdin:
    asked = json.loads(line)
    answer = {"tunenet": 2} if "tunenet" in asked else {"id": asked["id"]}
    if "inputs" in asked and "tunenet" not in asked:  # a recording, of which rollouts are asked later
        recordings[asked["recording"]] = asked
    elif "batch" in asked:  # many rollouts at once
        answer["answers"] = [drive(one) for one in asked["batch"]]
    elif "times_s" in asked:
        answer |= drive(asked)
    recordings.pop(asked.get("forget"), None)
    print(json.dumps(answer), flush=True)
