"""Swings a servo's pendulum in MuJoCo: cases as JSON on standard input, positions every 10 ms as JSON on standard output.

Its steps are a fifth of ours, and its dry friction, which creeps by default, is as stiff as these steps allow: the difference is ours."""

import json
import sys

import mujoco

MODEL = """<mujoco><option timestep="0.0002" gravity="0 0 -9.81" integrator="implicitfast"><flag contact="disable"/></option>
<worldbody><body><joint name="j" type="hinge" axis="0 -1 0" armature="{armature}" damping="{damping}" frictionloss="{coulomb}"
 solreffriction="0.0004 1" solimpfriction="0.9999 0.9999 0.001"/>
<inertial pos="0 0 -{length}" mass="{mass}" diaginertia="1e-9 1e-9 1e-9"/></body></worldbody>
<actuator><position joint="j" kp="{kp}" kv="{kv}" forcerange="-{stall} {stall}"/></actuator></mujoco>"""

answers = []
for case in json.load(sys.stdin):
    model = mujoco.MjModel.from_xml_string(MODEL.format(**case))
    data = mujoco.MjData(model)
    positions = [float(data.qpos[0])]
    goals = case["goals"]
    for step in range(30000):
        share = (step + 0.5) / 50
        before = int(share)
        data.ctrl[0] = goals[before] + (share - before) * (goals[before + 1] - goals[before])
        mujoco.mj_step(model, data)
        if step % 50 == 49:
            positions.append(float(data.qpos[0]))
    answers.append(positions)
json.dump(answers, sys.stdout)
