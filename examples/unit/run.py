"""Builds the output of `raypath generate --unit` and traces the rays of a picture: python3 run.py FOLDER.

FOLDER has the files of `generate --unit`, scene.bin, rays.txt and hits.txt. The hits go to rtl-hits.txt there."""

import pathlib
import sys

from verilate import run

run(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/unit").resolve(), "test_unit")
