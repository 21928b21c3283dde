"""What decides about candidates, and colours hits: the shaders of both pictures. Numbers are Python's, in binary64, so
that models and RTL get the same verdicts."""

import math

SPHERES = [((x, 0.45 + 0.35 * ((x * 7 + z * 3) % 2), z), 0.45) for x in (-2.0, -1.0, 0.0, 1.0, 2.0) for z in (-1.0, 0.5)]


def leaf_is_there(u, v):
    """Whether a leaf's texture is opaque at these weights of its second and third vertex: two lobes and a stem."""
    lobes = any((u - a) ** 2 + (v - b) ** 2 < 0.035 for a, b in ((0.24, 0.42), (0.42, 0.24)))
    return lobes or abs(u - v) < 0.02


def sphere_distance(origin, direction, sphere):
    """Where a ray enters a sphere; None if it does not."""
    centre, radius = sphere
    offset = [o - c for o, c in zip(origin, centre)]
    a = sum(d * d for d in direction)
    b = sum(d * o for d, o in zip(direction, offset))
    root = b * b - a * (sum(o * o for o in offset) - radius * radius)
    t = (-b - math.sqrt(root)) / a if root > 0 else -1.0
    return t if t > 0 else None


def verdict(ray, is_box, primitive, u, v):
    """Whether a candidate of a ray (origin, direction) is a hit, and the distance of a box's."""
    if not is_box:
        return leaf_is_there(u, v), 0.0
    t = sphere_distance(*ray, SPHERES[primitive])
    return t is not None, t or 0.0


def colour(ray, hit):
    """The colour of a pixel from its hit (status, geometry, primitive, t), or of the sky."""
    origin, direction = ray
    status, geometry, primitive, t = hit
    if status not in (1, 2):
        return 150, 190, 230
    point = [o + t * d for o, d in zip(origin, direction)]
    if status == 2:
        centre, radius = SPHERES[primitive]
        light = max(0.2, sum(n * l for n, l in zip([(p - c) / radius for p, c in zip(point, centre)], (0.5, 0.7, 0.5))))
        base = ((220, 80, 60), (240, 180, 60), (90, 120, 220))[primitive % 3]
    elif geometry == 0:
        light, base = (1.0, 0.75)[(math.floor(point[0]) + math.floor(point[2])) % 2], (170, 160, 140)
    else:
        light, base = 0.6 + 0.4 * (primitive % 7) / 6, ((70, 140, 50), (120, 85, 55))[geometry - 1]
    return tuple(min(255, int(light * channel)) for channel in base)
