"""Draws two pictures through ray queries: python3 draw.py FOLDER [WIDTHxHEIGHT].

leaves.png is a tree whose leaves are cut out of triangles, spheres.png has procedural spheres beside triangles. FOLDER
also gets the RTL of the unit, and for each picture its scene, rays and hits, for run.py."""

import json
import math
import pathlib
import sys

import numpy as np

import raypath
from png import png
from shaders import SPHERES, colour, verdict

FLOOR = np.float32([[[-6, 0, -6], [-6, 0, 6], [6, 0, 6]], [[-6, 0, -6], [6, 0, 6], [6, 0, -6]]])


def leaves(count):
    """Triangles at random places in a crown, at random angles."""
    random = np.random.default_rng(7)
    centres = random.normal(0, 0.75, (count, 1, 3)) + [0, 2.1, 0]
    return (centres + random.uniform(-0.42, 0.42, (count, 3, 3))).astype(np.float32)


def trunk():
    """A trunk of eight sides."""
    ring = [(0.16 * math.cos(k * math.pi / 4), 0.16 * math.sin(k * math.pi / 4)) for k in range(9)]
    quads = [((a, 0, b), (a, 2, b), (c, 2, d), (c, 0, d)) for (a, b), (c, d) in zip(ring, ring[1:])]
    return np.float32([[p, q, r] for p, q, r, _ in quads] + [[p, r, s] for p, _, r, s in quads])


def camera(width, height, eye, target):
    """Origins and directions of the rays of a picture, row by row."""
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(forward, [0, 1, 0]) / np.linalg.norm(np.cross(forward, [0, 1, 0]))
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5)
    offsets = x[..., None] * right + y[..., None] * np.cross(right, forward)
    directions = (forward + 1.1 * offsets / height).reshape(-1, 3).astype(np.float32)
    return np.broadcast_to(np.float32(eye), directions.shape).copy(), directions


def trace(unit, scene, origins, directions):
    """The rays and their hits, as the RTL has them."""
    rays = list(zip(origins.astype(float).tolist(), directions.astype(float).tolist()))
    query = unit.query(scene, scene.rays(origins, directions))
    for candidates in query:
        asked = zip(candidates.ray, candidates.is_box, candidates.primitive, candidates.u, candidates.v)
        verdicts = [verdict(rays[ray], box, primitive, float(u), float(v)) for ray, box, primitive, u, v in asked]
        candidates.answer([accept for accept, _ in verdicts], t=np.float32([t for _, t in verdicts]))
    hits = query.hits
    return rays, list(zip(*(hits[name].tolist() for name in ("status", "geometry", "primitive", "t"))))


def main(folder, size="160x120"):
    width, height = map(int, size.split("x"))
    unit = raypath.Unit("compact", queries="full", barycentrics=True, memory_width=1024, contexts=32)
    unit.generate(folder)
    boxes = np.float32([[np.subtract(c, 1.001 * r), np.add(c, 1.001 * r)] for c, r in SPHERES])
    ground = raypath.Geometry(FLOOR)
    tree = [ground, raypath.Geometry(leaves(400), opaque=False), raypath.Geometry(trunk())]
    balls = [ground, raypath.Geometry(boxes=boxes)]
    pictures = [("leaves", tree, (0, 1.6, 5), (0, 1.7, 0)), ("spheres", balls, (0.5, 1.9, 4.5), (0, 0.4, 0))]
    for name, geometries, eye, target in pictures:
        scene = unit.scene(geometries)
        rays, hits = trace(unit, scene, *camera(width, height, eye, target))
        png(folder / f"{name}.png", width, height, [colour(ray, hit) for ray, hit in zip(rays, hits)])
        (folder / f"{name}.bin").write_bytes(scene.data)
        text = json.dumps({"width": width, "height": height, "root": scene.root, "rays": rays, "hits": hits})
        (folder / f"{name}.json").write_text(text)


if __name__ == "__main__":
    place = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/queries")
    place.mkdir(parents=True, exist_ok=True)
    main(place, *sys.argv[2:])
