"""A ball on a rod in MuJoCo that speaks with tunenet; `pip install mujoco` is all it needs."""
import json
import sys

import mujoco

MODEL = """<mujoco><option timestep="0.001" integrator="RK4" gravity="0 0 -9.81"/><worldbody><body>
  <joint type="hinge" axis="0 1 0" damping="{damping}"/>
  <geom type="sphere" size="0.05" pos="0 0 -{length}" mass="{mass_kg}"/></body></worldbody></mujoco>"""


def swing(parameters, times_s, settings):
    model = mujoco.MjModel.from_xml_string(MODEL.format(mass_kg=settings["mass_kg"], **parameters))
    data = mujoco.MjData(model)
    data.qpos[0] = settings["start_rad"]  # held until time 0
    step_s, values = model.opt.timestep, []
    for time in times_s:
        while time - data.time > 1e-12:
            model.opt.timestep = min(step_s, time - data.time)  # the last step ends at the sample
            mujoco.mj_step(model, data)
        values.append([float(data.qpos[0])])  # one number for each channel
    return values


for line in sys.stdin:  # until tunenet is done
    request = json.loads(line)
    if "tunenet" in request:  # the first line
        answer = {"tunenet": 1}
    else:
        try:
            values = swing(request["parameters"], request["times_s"], request["settings"])
            answer = {"id": request["id"], "values": values}
        except (ValueError, mujoco.FatalError) as error:
            answer = {"id": request["id"], "error": str(error)}
    print(json.dumps(answer), flush=True)
