"""Loads models with MuJoCo and prints what its compiler made of them, one JSON object a line.

Meshes that are not there are replaced by small tetrahedra: inertias that files state do not depend on them.
"""
import json
import os
import re
import struct
import sys

import mujoco
import numpy as np

CORNERS = [(0, 0, 0), (0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.01)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def mesh(name):
    if name.lower().endswith(".obj"):
        lines = ["v %g %g %g" % c for c in CORNERS] + ["f %d %d %d" % tuple(i + 1 for i in f) for f in FACES]
        return ("\n".join(lines) + "\n").encode()
    data = b"\0" * 80 + struct.pack("<I", len(FACES))
    for face in FACES:
        data += struct.pack("<3f", 0, 0, 0)
        for i in face:
            data += struct.pack("<3f", *CORNERS[i])
        data += b"\0\0"
    return data


def provide(folder):
    texts = [open(os.path.join(folder, f), encoding="utf-8").read() for f in os.listdir(folder) if f.endswith(".xml")]
    everything = "".join(texts)
    dirs = set(re.findall(r'(?:meshdir|assetdir)="([^"]*)"', everything)) | {""}
    for name in re.findall(r'<mesh[^>]*\sfile="([^"]*)"', everything):
        for d in dirs:
            path = os.path.join(folder, d, name)
            if not os.path.exists(path):
                os.makedirs(os.path.dirname(path), exist_ok=True)
                open(path, "wb").write(mesh(name))


def tensor(m, i):
    r = np.zeros(9)
    mujoco.mju_quat2Mat(r, m.body_iquat[i])
    r = r.reshape(3, 3)
    return (r @ np.diag(m.body_inertia[i]) @ r.T).tolist()


def describe(path):
    provide(os.path.dirname(path))
    m = mujoco.MjModel.from_xml_path(path)
    d = mujoco.MjData(m)
    out = {"bodies": [], "joints": [], "actuators": [], "dynamics": []}
    for i in range(1, m.nbody):
        out["bodies"].append({"name": m.body(i).name, "mass": m.body_mass[i], "com": m.body_ipos[i].tolist(), "tensor": tensor(m, i)})
    for i in range(m.njnt):
        q, v = m.jnt_qposadr[i], m.jnt_dofadr[i]
        flat = lambda a: float(np.ravel(a[v] if np.ndim(a) else a)[0])
        stiff = float(np.ravel(m.jnt_stiffness[i])[0])
        out["joints"].append({
            "name": m.joint(i).name, "type": int(m.jnt_type[i]), "pos": m.jnt_pos[i].tolist(), "axis": m.jnt_axis[i].tolist(),
            "ref": float(m.qpos0[q]), "range": m.jnt_range[i].tolist() if m.jnt_limited[i] else None,
            "effort": m.jnt_actfrcrange[i].tolist() if m.jnt_actfrclimited[i] else None,
            "armature": flat(m.dof_armature), "damping": flat(m.dof_damping), "friction": flat(m.dof_frictionloss),
            "stiffness": stiff, "springref": float(m.qpos_spring[q]),
        })
    for i in range(m.nu):
        limited = lambda flag, r: r[i].tolist() if flag[i] else None
        out["actuators"].append({
            "name": m.actuator(i).name, "gain": float(m.actuator_gainprm[i][0]), "bias": m.actuator_biasprm[i][:3].tolist(),
            "biastype": int(m.actuator_biastype[i]), "gaintype": int(m.actuator_gaintype[i]), "dyntype": int(m.actuator_dyntype[i]),
            "dyn": float(m.actuator_dynprm[i][0]), "gear": float(m.actuator_gear[i][0]),
            "ctrl": limited(m.actuator_ctrllimited, m.actuator_ctrlrange), "force": limited(m.actuator_forcelimited, m.actuator_forcerange),
            "delay": float(getattr(m, "actuator_delay", np.zeros(m.nu))[i]),
        })
    if m.nq == m.nv:
        # Rigid bodies, armature, springs and damping; what constraints add is another matter.
        m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        rng = np.random.default_rng(7)
        for _ in range(4):
            d.qpos, d.qvel, d.qacc = (rng.uniform(-1, 1, m.nv) * s for s in (1, 2, 5))
            mujoco.mj_inverse(m, d)
            out["dynamics"].append({"q": d.qpos.tolist(), "v": d.qvel.tolist(), "a": d.qacc.tolist(), "force": d.qfrc_inverse.tolist()})
    return out


for line in sys.stdin:
    try:
        print(json.dumps(describe(line.strip())), flush=True)
    except Exception as error:  # the sentence is compared by nobody; that there is one is
        print(json.dumps({"error": str(error)}), flush=True)
