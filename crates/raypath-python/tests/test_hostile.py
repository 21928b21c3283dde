"""Arrays of any shape, type, order and alignment: a call refuses them, or returns what it returns for plain copies."""

import random
from typing import Any, Callable

import numpy as np
import pytest

import raypath

SHAPES: dict[str, tuple[tuple[int, ...], str]] = {
    "boxes": ((4, 2, 3), "f4"),
    "triangles": ((3, 3), "f4"),
    "vectors": ((5,), "f4"),
    "points": ((3,), "f4"),
    "faces": ((3,), "u4"),
}
SEARCHES = raypath.Unit(search="k=1,m=9,dimensions=64")
RAYS: Any = raypath.rays(np.zeros((6, 3), np.float32), np.ones((6, 3), np.float32))


def hostile(rng: random.Random, kind: str) -> Any:
    """An array for an argument of this kind, or what is none."""
    tail, code = SHAPES[kind]
    rows = rng.choice([0, 1, 2, 6, 6, 6, 6])
    shape = (rows, *tail)
    array: Any = np.frombuffer(rng.randbytes(4 * int(np.prod(shape))), code).reshape(shape).copy()
    change = rng.randrange(16)
    if change == 0:
        with np.errstate(all="ignore"):
            return array.astype(rng.choice(["f8", ">f4", "f2", "i4", "u8", "c8", "?", "O", "S4"]))
    if change == 1:
        return np.asfortranarray(array)
    if change == 2:
        return array[::-1]
    if change == 3:
        return array[..., :-1]
    if change == 4:
        return np.broadcast_to(array[:1], (max(rows, 1), *tail)) if rows else array
    if change == 5:
        array.flags.writeable = False
        return array
    if change == 6:
        memory = np.zeros(array.nbytes + 8, np.uint8)
        odd = memory[1 : 1 + array.nbytes].view(code).reshape(shape)
        odd[...] = array
        return odd
    if change == 7:
        return rng.choice([None, 3, "text", array.tolist(), b"bytes", memoryview(array), array[0] if rows else array])
    if change == 8:
        return np.ma.masked_array(array)
    if change == 9:
        return array.reshape(1, *shape)
    if change == 10:
        wide = np.zeros((rows, *tail, 2), code)
        wide[..., 0] = array
        return wide[..., 0]
    return array


def plain(value: Any) -> Any:
    """A copy with the usual layout."""
    return np.array(value, order="C", copy=True) if isinstance(value, np.ndarray) else value


CALLS: dict[str, tuple[tuple[str, ...], Callable[..., Any]]] = {
    "quadbox": (("boxes",), lambda d, boxes: d.quadbox(RAYS, boxes)),
    "triangle": (("triangles",), lambda d, triangles: d.triangle(RAYS, triangles)),
    "euclidean": (("vectors", "vectors"), lambda d, a, b: d.euclidean(a, b)),
    "angular": (("vectors", "vectors"), lambda d, a, b: d.angular(a, b)),
    "rays": (("points", "points"), lambda d, a, b: raypath.rays(a, b)),
    "quadbox_of_any_rays": (("points", "boxes"), lambda d, rays, boxes: d.quadbox(rays, boxes)),
    "search": (("vectors", "vectors"), lambda d, a, b: SEARCHES.search(a, b, k=1)),
    "trace": (("points", "faces"), lambda d, vertices, faces: raypath.trace(raypath.Scene(vertices, faces), RAYS)),
}


def outcome(call: Callable[..., Any], datapath: raypath.Datapath, arguments: list[Any]) -> str:
    """The bytes of a result, or the kind of an error with a message. Nothing else may happen."""
    try:
        result = call(datapath, *arguments)
    except (ValueError, TypeError) as problem:
        return type(problem).__name__ if str(problem) else "no message"
    arrays = result if isinstance(result, tuple) else [result]
    return repr([np.asarray(array).tobytes() if isinstance(array, np.ndarray) else None for array in arrays])


@pytest.mark.parametrize("name", CALLS)
def test_arrays_are_refused_or_read_as_their_copies(datapath: raypath.Datapath, name: str) -> None:
    """Results of an accepted array are those of its copy, and inputs are not changed."""
    kinds, call = CALLS[name]
    rng = random.Random(1)
    outcomes = set()
    for _ in range(400):
        arguments = [hostile(rng, kind) for kind in kinds]
        copies = [plain(argument) for argument in arguments]
        found = outcome(call, datapath, arguments)
        outcomes.add(found[:10])
        for argument, copy in zip(arguments, copies):
            if isinstance(argument, np.ndarray) and argument.dtype != object:
                assert argument.tobytes() == copy.tobytes()
        if found.startswith("["):
            assert found == outcome(call, datapath, copies)
    assert "ValueError" in outcomes
    assert "no message" not in outcomes
    # Random indices are those of no vertex, and random rays are rays of no datapath.
    assert name in ("quadbox_of_any_rays", "trace") or any(found.startswith("[") for found in outcomes)
