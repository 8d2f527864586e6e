"""A damped pendulum that speaks with tunenet: the standard library of Python is all it needs."""
import json
import math
import sys

STEP_S = 1e-3  # longest step of the integration


def slope(angle, rate, parameters, gravity):
    return rate, -gravity / parameters["length"] * math.sin(angle) - parameters["damping"] * rate


def swing(parameters, times_s, settings):
    gravity = settings.get("gravity_m_s2", 9.81)
    angle, rate, now, values = settings.get("start_rad", 0.5), 0.0, 0.0, []  # let go at time 0
    for time in times_s:
        steps = max(0, math.ceil((time - now) / STEP_S))  # none before time 0: it is held until then
        for _ in range(steps):  # midpoint steps
            h = (time - now) / steps
            v, a = slope(angle, rate, parameters, gravity)
            v, a = slope(angle + h / 2 * v, rate + h / 2 * a, parameters, gravity)
            angle, rate = angle + h * v, rate + h * a
        now = max(now, time)
        values.append([angle])  # one number for each channel
    return values


for line in sys.stdin:  # until tunenet is done
    request = json.loads(line)
    if "tunenet" in request:  # the first line
        answer = {"tunenet": 1}
    elif request["parameters"]["length"] <= 0:
        answer = {"id": request["id"], "error": "a pendulum has a length above 0"}
    else:
        values = swing(request["parameters"], request["times_s"], request["settings"])
        answer = {"id": request["id"], "values": values}
    print(json.dumps(answer), flush=True)
