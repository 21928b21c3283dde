#!/usr/bin/env python3
"""Writes two scenes of more than a million triangles, as binary PLY: terrain.ply, a fractal landscape, and crowd.ply,
72 of the mesh of crates/raypath-render/tests/data/suzanne.ply.gz, turned at random. Argument: the folder."""

import gzip
import math
import random
import struct
import sys
from array import array
from pathlib import Path

SIDE = 729  # Vertices of a side of the landscape.


def write(path: Path, vertices: list[tuple[float, float, float]], triangles: list[tuple[int, int, int]]) -> None:
    lines = [f"element vertex {len(vertices)}", *(f"property float {axis}" for axis in "xyz")]
    lines += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    faces = b"".join(struct.pack("<Biii", 3, *triangle) for triangle in triangles)
    coordinates = array("f", [x for vertex in vertices for x in vertex]).tobytes()
    path.write_bytes("\n".join(["ply", "format binary_little_endian 1.0", *lines]).encode() + coordinates + faces)
    print(f"wrote {path}, {len(triangles)} triangles")


def terrain() -> tuple[list[tuple[float, float, float]], list[tuple[int, int, int]]]:
    rng = random.Random(1)
    octaves = [[[rng.uniform(-1, 1) for _ in range(2 ** k + 2)] for _ in range(2 ** k + 2)] for k in range(2, 9)]

    def height(x: float, y: float) -> float:
        total = 0.0
        for k, grid in enumerate(octaves, 2):
            (i, u), (j, v) = ((int(at * 2**k), at * 2**k % 1) for at in (x, y))
            low, high = (row[j] * (1 - v) + row[j + 1] * v for row in grid[i : i + 2])
            total += (low * (1 - u) + high * u) / 2**k
        return total

    at = [k / (SIDE - 1) for k in range(SIDE)]
    vertices = [(x, height(x * 0.999, z * 0.999), z) for x in at for z in at]
    corners = [(i * SIDE + j, (i + 1) * SIDE + j) for i in range(SIDE - 1) for j in range(SIDE - 1)]
    return vertices, [triangle for a, b in corners for triangle in ((a, a + 1, b), (b, a + 1, b + 1))]


def crowd() -> tuple[list[tuple[float, float, float]], list[tuple[int, int, int]]]:
    packed = Path(__file__).parent.parent / "crates/raypath-render/tests/data/suzanne.ply.gz"
    lines = gzip.decompress(packed.read_bytes()).decode().split("end_header\n")[1].splitlines()
    split = next(k for k, line in enumerate(lines) if len(line.split()) == 4)
    own = [tuple(map(float, line.split())) for line in lines[:split]]
    faces = [tuple(map(int, line.split()[1:])) for line in lines[split:]]
    rng, vertices, triangles = random.Random(2), [], []
    for number in range(72):
        angle, tilt = rng.uniform(0, 2 * math.pi), rng.uniform(-0.5, 0.5)
        c, s, d, t = math.cos(angle), math.sin(angle), math.cos(tilt), math.sin(tilt)
        triangles += [(a + len(vertices), b + len(vertices), e + len(vertices)) for a, b, e in faces]
        for x, y, z in own:
            y, z = d * y - t * z, t * y + d * z
            vertices.append((c * x + s * z + number % 9, y, c * z - s * x + number // 9))
    return vertices, triangles


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for name, scene in (("terrain", terrain), ("crowd", crowd)):
        write(folder / f"{name}.ply", *scene())
