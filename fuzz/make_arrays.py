"""Seeds of the targets `hdf5` and `npz`: demonstrations of two layouts, and arrays stored and packed."""

import sys
from pathlib import Path

import h5py
import numpy as np

ROWS = 16


def main(corpus):
    angles = np.sin(np.arange(2 * ROWS).reshape(ROWS, 2) * 0.1)
    for name, libver, options in [("robomimic", "earliest", {}), ("packed", "latest", {"compression": "gzip", "chunks": (8, 2)})]:
        with h5py.File(corpus / "hdf5" / name, "w", libver=libver) as made:
            data = made.create_group("data")
            data.attrs["env_args"] = '{"env_name": "Reach-IK-Rel-v0"}'
            demo = data.create_group("demo_0")
            demo.create_dataset("actions", data=angles.astype("<f4"), **options)
            demo.create_dataset("obs/joint_pos", data=angles, **options)
            made.create_group("empty")
    with h5py.File(corpus / "hdf5" / "flat", "w") as made:
        made["t_s"] = np.arange(ROWS) / 30
        made["obs/joint_pos"] = angles
    with open(corpus / "npz" / "stored", "wb") as made:
        np.savez(made, t_s=np.arange(ROWS) / 30, z_m=angles[:, 0])
    with open(corpus / "npz" / "packed", "wb") as made:
        np.savez_compressed(made, t_s=np.arange(ROWS) / 30, q=angles.astype("<f4"), note=np.array(["a"] * ROWS))
    with open(corpus / "npz" / "alone", "wb") as made:
        np.save(made, np.asfortranarray(np.column_stack([np.arange(ROWS) / 30, angles])))
    with open(corpus / "npz" / "records", "wb") as made:
        records = np.zeros(ROWS, dtype=[("t_s", "<f8"), ("z_m", ">f4")])
        records["t_s"] = np.arange(ROWS)
        np.save(made, records)


main(Path(sys.argv[1]))
