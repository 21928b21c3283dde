"""Traces rays on the Verilated device and compares each hit with the functional model: python3 trace.py [FOLDER]."""

import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np

import raypath

HERE = pathlib.Path(__file__).parent.resolve()
SOFTWARE = HERE.parents[1] / "software"
PARAMETERS = {"Units": 2, "CacheSets": 8, "CacheMisses": 4}
# The bits of an id below that which tells reads of the ring: the number of a unit, and that of a line under way.
RING_BIT = sum((PARAMETERS[name] - 1).bit_length() for name in ("Units", "CacheMisses"))
# The words of a hit's record from the fourth on, for a unit with queries and without instances.
FIELDS = ("primitive", "t", "t_num", "t_denom", "geometry", "nodes", "triangles")


def setting():
    """A unit, a scene of random triangles and rays through it."""
    random = np.random.default_rng(5)
    unit = raypath.Unit("compact", contexts=8, memory_width=128, queries="full")
    triangles = random.uniform(-1, 1, (300, 1, 3)) + random.uniform(-0.2, 0.2, (300, 3, 3))
    scene = unit.scene(triangles.astype(np.float32))
    origins = random.uniform(-2, 2, (400, 3)).astype(np.float32)
    return unit, scene, scene.rays(origins, (random.uniform(-1, 1, (400, 3)) - origins).astype(np.float32))


def words(values):
    return np.ascontiguousarray(values).view(np.uint32) if values.dtype == np.float32 else values.astype(np.uint32)


def records(rays, hits):
    """The records of rays and of their hits, 16 words each."""
    count = len(rays)
    of_rays, of_hits = np.zeros((2, count, 16), np.uint32)
    of_rays[:, 0] = of_hits[:, 0] = np.arange(count)
    for name, place in (("flags", 2), ("cull_mask", 3), ("root", 4), ("base", 5), ("t_min", 6), ("t_max", 7)):
        of_rays[:, place] = words(rays[name])
    for name, place in (("origin", 8), ("direction", 12)):
        of_rays[:, place:place + 3] = words(rays[name])
    of_hits[:, 2] = hits.status | hits.back_face.astype(np.uint32) << 8
    for place, name in enumerate(FIELDS, 3):
        of_hits[:, place] = words(getattr(hits, name))
    return of_rays, of_hits


def main(folder="build/device"):
    folder = pathlib.Path(folder).resolve()
    verilator = os.environ.get("VERILATOR", "verilator")
    for tool in (verilator, "c++"):
        if shutil.which(tool) is None:
            sys.exit(f"trace.py: found no program {tool}")
    unit, scene, rays = setting()
    unit.generate(folder)
    of_rays, of_hits = records(rays, unit.trace(scene, rays))
    (folder / "scene.bin").write_bytes(scene.data)
    (folder / "rays.bin").write_bytes(of_rays.tobytes())
    (folder / "expected.bin").write_bytes(of_hits.tobytes())
    sources = [folder / line for line in (folder / "raypath_device.f").read_text().split()]
    build = [verilator, "--cc", "--exe", "--build", "-j", "2", "-O3", "-fno-inline", "--assert", "-Wno-fatal", "-Wno-WIDTH",
             "--Mdir", folder / "device", "--top-module", "raypath_device", *sources, HERE / "device.cpp",
             SOFTWARE / "raypath_driver.c", "-CFLAGS", f"-I{SOFTWARE} -DRING_BIT={RING_BIT}",
             *(f"-G{name}={value}" for name, value in PARAMETERS.items())]
    environment = {**os.environ, "MAKEFLAGS": "OPT_FAST=-O1 OPT_SLOW=-O0 OPT_GLOBAL=-O0 VM_PARALLEL_BUILDS=0"}
    built = subprocess.run([str(part) for part in build], env=environment, capture_output=True, text=True, check=False)
    if built.returncode != 0:
        sys.exit(built.stdout + built.stderr)
    sys.exit(subprocess.run([folder / "device/Vraypath_device", folder], check=False).returncode)


if __name__ == "__main__":
    main(*sys.argv[1:])
