"""Reads URDFs with Pinocchio and prints masses, friction and forces of motions, one JSON object a line."""
import json
import sys

import numpy as np
import pinocchio


def describe(path):
    model = pinocchio.buildModelFromUrdf(path)
    data = model.createData()
    rng = np.random.default_rng(11)
    joints = [(model.names[i], model.joints[i]) for i in range(1, model.njoints)]
    out = {"mass": float(sum(inertia.mass for inertia in list(model.inertias)[1:])), "joints": {}, "dynamics": []}
    for name, joint in joints:
        v = joint.idx_v
        out["joints"][name] = {"damping": float(model.damping[v]) if hasattr(model, "damping") else None,
                               "friction": float(model.friction[v]) if hasattr(model, "friction") else None,
                               "effort": float(model.effortLimit[v]) if hasattr(model, "effortLimit") else None}
    for _ in range(4):
        angles = {name: float(rng.uniform(-1, 1)) for name, _ in joints}
        q, v, a = np.zeros(model.nq), rng.uniform(-2, 2, model.nv), rng.uniform(-5, 5, model.nv)
        for name, joint in joints:
            if joint.nq == 2:
                q[joint.idx_q:joint.idx_q + 2] = np.cos(angles[name]), np.sin(angles[name])
            else:
                q[joint.idx_q] = angles[name]
        force = pinocchio.rnea(model, data, q, v, a)
        pick = lambda values: {name: float(values[joint.idx_v]) for name, joint in joints}
        out["dynamics"].append({"q": angles, "v": pick(v), "a": pick(a), "force": pick(force)})
    return out


for line in sys.stdin:
    try:
        print(json.dumps(describe(line.strip())), flush=True)
    except Exception as error:
        print(json.dumps({"error": str(error)}), flush=True)
