"""Trust Region Reflective least squares of scipy; asks for residuals with one line of JSON, is answered with one.

The first line from outside holds `start`, `low` and `high`. A line {"point": […]} asks; null is the answer where it cannot be simulated.
The last line holds the `answer`.
"""

import json
import sys


def say(line):
    print(json.dumps(line), flush=True)


def hear():
    return json.loads(sys.stdin.readline())


try:
    import numpy
    from scipy.optimize import least_squares
except ImportError as error:
    say({"missing": str(error)})
    sys.exit(0)

problem = hear()
low, high = (numpy.array(problem[key]) for key in ("low", "high"))
count = 0


def residuals(point):
    global count
    say({"point": point.tolist()})
    values = hear()
    if values is None:
        return numpy.full(count, numpy.nan)
    count = len(values)
    return numpy.array(values)


found = least_squares(residuals, problem["start"], bounds=(low, high), x_scale=high - low, method="trf")
say({"answer": found.x.tolist()})
