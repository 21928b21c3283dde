"""Traces the rays of the pictures of draw.py through the Verilated RTL, and draws them: python3 run.py FOLDER.

The shaders decide about the candidates that the RTL reports. leaves-rtl.png and spheres-rtl.png are equal to the pictures
of the model."""

import json
import pathlib
import sys

HERE = pathlib.Path(__file__).parent.resolve()
sys.path.append(str(HERE.parent / "unit"))
from png import png
from shaders import colour
from verilate import run

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/queries").resolve()
run(folder, "test_queries", HERE)
for name in ("leaves", "spheres"):
    picture = json.loads((folder / f"{name}.json").read_text())
    hits = json.loads((folder / f"{name}-rtl.json").read_text())
    pixels = [colour(ray, hit) for ray, hit in zip(picture["rays"], hits, strict=True)]
    png(folder / f"{name}-rtl.png", picture["width"], picture["height"], pixels)
    if (folder / f"{name}-rtl.png").read_bytes() != (folder / f"{name}.png").read_bytes():
        sys.exit(f"{name}-rtl.png is not {name}.png")
    print(f"{name}-rtl.png is {name}.png")
