"""Least squares of another package; asks for residuals with one line of JSON, is answered with one.

The argument names the method: `scipy` (Trust Region Reflective) or `mujoco` (mujoco.sysid.optimize). The first line from outside
holds `start`, `low` and `high`. A line {"point": […]} asks; null is the answer where it cannot be simulated. The last line holds the
`answer`.
"""

import json
import os
import sys


# What the packages print is no answer.
answers, sys.stdout = sys.stdout, open(os.devnull, "w")


def say(line):
    print(json.dumps(line), file=answers, flush=True)


def hear():
    return json.loads(sys.stdin.readline())


try:
    import numpy

    if sys.argv[1] == "scipy":
        from scipy.optimize import least_squares
    else:
        from mujoco.sysid import optimize, parameter
except ImportError as error:
    say({"missing": str(error)})
    sys.exit(0)

problem = hear()
start, low, high = (numpy.array(problem[key]) for key in ("start", "low", "high"))
count = 0


def residuals(point):
    global count
    say({"point": point.tolist()})
    values = hear()
    if values is None:
        return numpy.full(count, numpy.nan)
    count = len(values)
    return numpy.array(values)


def columns(points, _):
    """mujoco asks for several points at once, one in each column."""
    return [numpy.stack([residuals(point) for point in points.T], axis=1)], None, None


if sys.argv[1] == "scipy":
    found = least_squares(residuals, start, bounds=(low, high), x_scale=high - low, method="trf").x
else:
    each = {str(i): parameter.Parameter(str(i), start[i], low[i], high[i]) for i in range(len(start))}
    found, _ = optimize(parameter.ParameterDict(each), columns, optimizer="mujoco", verbose=False)
    found = found.as_vector()
say({"answer": found.tolist()})
