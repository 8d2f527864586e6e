"""Writes links_new.hdf5 and links_old.hdf5 with h5py: groups of both forms with links that are not followed."""

import h5py
import numpy

for form, bound in (("old", "earliest"), ("new", "latest")):
    with h5py.File(f"links_{form}.hdf5", "w", libver=bound) as file:
        group = file.create_group("observations")
        group["qpos"] = numpy.arange(20.0).reshape(10, 2)
        file["action"] = h5py.SoftLink("/observations/qpos")
        # A link into another file makes its group one of the newer form.
        file["far"] = h5py.ExternalLink("x.hdf5", "/a") if form == "new" else h5py.SoftLink("/x")
        group["alias"] = h5py.SoftLink("/observations/qpos")
