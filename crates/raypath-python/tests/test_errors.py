"""Wrong arguments: the message names the argument, what was found and what was expected."""

from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
from helpers import f32

import raypath

RAYS: Any = raypath.rays(np.zeros((4, 3), np.float32), np.ones((4, 3), np.float32))
ONES: Any = np.ones((4, 3), np.float32)
BOXES: Any = np.zeros((4, 4, 2, 3), np.float32)
PAIR: Any = np.zeros((4, 40), np.float32)
FACES: Any = np.zeros((1, 3), np.uint32)
NAN: Any = np.full((4, 3), np.nan, np.float32)
BYTES: Any = np.zeros((4, 40), np.int8)
SEARCHES = raypath.Unit(search="k=4,m=8,dimensions=64")
SCENE: Any = raypath.Scene(f32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))

ARRAYS: list[tuple[Callable[[Any], Any], str]] = [
    (
        lambda d: d.quadbox(RAYS, np.full(BOXES.shape, 0.1)),
        r"boxes: found a float64 array .* float32 .* change: boxes.astype",
    ),
    (lambda d: d.quadbox(RAYS, BOXES[:, :, :, :2]), r"boxes: found .* \(4, 4, 2, 2\), expected .* \(n, 4, 2, 3\)"),
    (lambda d: d.quadbox(RAYS, BOXES[0]), r"boxes: found .* \(4, 2, 3\), expected .* \(n, 4, 2, 3\)"),
    (lambda d: d.quadbox(RAYS, BOXES[:3]), r"boxes: found shape \(3, 4, 2, 3\), expected \(4, 4, 2, 3\)"),
    (lambda d: d.quadbox(RAYS, np.full(BOXES.shape, 1e300)), r"boxes: found a float64 array"),
    (lambda d: d.quadbox(RAYS, BOXES.astype(complex)), r"boxes: found a complex128 array"),
    (lambda d: d.quadbox(RAYS, BOXES.tolist()), r"boxes: found list, expected .* float32"),
    (lambda d: d.quadbox(RAYS, None), r"boxes: found NoneType"),
    (lambda d: d.quadbox(ONES, BOXES), r"rays: found a float32 array of shape \(4, 3\), expected .* raypath.RAY"),
    (lambda d: d.triangle(RAYS, np.zeros((4, 3, 4), np.float32)), r"triangles: .* expected .* \(n, 3, 3\)"),
    (lambda d: d.euclidean(PAIR, PAIR[:, :39]), r"b: found .*"),
    (lambda d: d.euclidean(PAIR, PAIR[:3]), r"b: found shape \(3, 40\), expected \(4, 40\) as a"),
    (lambda d: d.euclidean(PAIR[0], PAIR[0]), r"a: found .* \(40,\), expected .* \(n, k\)"),
    (lambda d: d.euclidean(PAIR[:, :0].copy(), PAIR[:, :0].copy()), r"a: found shape \(4, 0\), expected at least 1"),
    (lambda d: d.angular(PAIR, np.full(PAIR.shape, 2**24 + 1)), r"c: found a int64 array .*c.astype"),
    (lambda d: raypath.rays(ONES, ONES[:2]), r"directions: found shape \(2, 3\), expected \(4, 3\)"),
    (lambda d: raypath.rays(ONES, ONES, ONES[:3, 0].copy()), r"extent: found shape \(3,\), expected \(4,\)"),
    (lambda d: raypath.rays(ONES, ONES, "far"), r"extent: found far, expected a number"),  # type: ignore[arg-type]
    (lambda d: raypath.rays(ONES, 0 * ONES), r"row 0: direction \(0, 0, 0\) is zero"),
    (lambda d: raypath.rays(ONES, NAN), r"row 0: direction \(NaN, NaN, NaN\) is not finite"),
    (lambda d: raypath.rays(NAN, ONES), r"row 0: origin .* is not finite"),
    (lambda d: raypath.rays(ONES, ONES, f32([1, 2, np.nan, 3])), r"row 2: extent NaN"),
    (lambda d: raypath.rays(ONES, ONES, -1.0), r"row 0: extent -1"),
    (lambda d: d.run("sphere"), r"'sphere' is not an operation of this datapath, expected triangle, quadbox"),
    (lambda d: d.run("quadbox"), r"quadbox: no value for 'ray_origin_x'"),
    (lambda d: d.run("quadbox", radius=1), r"quadbox has no input 'radius', expected ray_origin_x"),
    (lambda d: d.run("euclidean", **ports(d, euclidean_a_0=np.full(3, 0.1))), r"euclidean_a_0: found a float64"),
    (lambda d: d.run("euclidean", **ports(d, euclidean_mask=-1)), r"euclidean_mask: found -1, expected integers"),
    (lambda d: d.run("euclidean", **ports(d, euclidean_mask=np.array([-1]))), r"euclidean_mask: found"),
    (lambda d: d.run("euclidean", **ports(d, euclidean_mask=np.zeros((2, 2), int))), r"euclidean_mask: .*\(n,\)"),
    (lambda d: d.run("euclidean", **ports(d, euclidean_mask=np.array([1.5]))), r"euclidean_mask: found"),
    (
        lambda d: d.run("euclidean", **ports(d, euclidean_a_0=ONES[0], euclidean_a_1=ONES[:2, 0].copy())),
        r"euclidean_a_1: found shape \(2,\), expected \(3,\) as euclidean_a_0",
    ),
    (lambda d: raypath.Job.quadbox(RAYS, BOXES[0]), r"ray: found 4 rays, expected 1"),
    (lambda d: raypath.Job.quadbox(RAYS[0], BOXES), r"boxes: found .* expected .* \(4, 2, 3\)"),
    (lambda d: raypath.Job.triangle(RAYS[0], ONES), r"triangle: found .* expected .* \(3, 3\)"),
    (lambda d: raypath.Job.euclidean(PAIR[0], PAIR[0, :3]), r"b: found shape \(3,\), expected \(40,\)"),
    (lambda d: raypath.Job.angular(np.zeros(65, np.float32), np.zeros(65, np.float32)), r"q: found 65 coordinates"),
    (lambda d: raypath.Job.timing(d, "sphere"), r"'sphere' is not an operation"),
    (lambda d: raypath.Job.words(d, "euclidean", **ports(d, euclidean_a_0=ONES[0])), r"expected one job"),
    (lambda d: raypath.Pipeline(d).offer(raypath.Job.euclidean(PAIR[0], PAIR[0])), r"a beat of 40 and 40 coord"),
    (lambda d: raypath.Scene(ONES, FACES + np.uint32(4)), r"triangle 0 names vertex 4, expected less than 4"),
    (lambda d: raypath.Scene(ONES, FACES.astype(np.int32) - 1), r"faces: found a int32 array .* expected .* uint32"),
    (lambda d: raypath.Scene(ONES, FACES.astype(np.int64) - 1), r"faces: found a int64 array .* expected .* uint32"),
    (lambda d: raypath.Scene(NAN, FACES), r"vertex 0 has x = NaN"),
    (lambda d: raypath.Scene(ONES, FACES[:0]), r"0 triangles, expected at least 1"),
    (lambda d: raypath.render(SCENE, size=(0, 5)), r"size: found 0 x 5"),
    (lambda d: raypath.render(SCENE, eye=(0, 0, 0)), r"camera: eye and target are both"),
    (lambda d: raypath.render(SCENE, samples=65), r"65 x 65 samples"),
    (lambda d: raypath.render(SCENE, ao=5000), r"ao: found 5000"),
    (lambda d: raypath.render(SCENE, size=(4, 4), rays_in_flight=0, timed=1), r"0 agents in flight"),
    (lambda d: raypath.render(SCENE, datapath=raypath.Datapath("half")), r"datapath: found .*fp16.* fp32"),
    (lambda d: raypath.trace(SCENE, ONES), r"rays: found a float32 array"),
    (lambda d: raypath.UnitHits(ONES), r"array: found another object, expected the structured array"),
    (lambda d: raypath.Unit().search(PAIR, PAIR, k=1), r"a unit without searches, expected .*search="),
    (lambda d: SEARCHES.search(PAIR, PAIR[:, :3].copy(), k=1), r"queries of 3 dimensions, expected 40"),
    (lambda d: SEARCHES.search(PAIR, PAIR, k=5), r"5 neighbours requested, expected 1 to 4"),
    (lambda d: SEARCHES.search(PAIR, PAIR.astype(np.float16), k=1), r"queries: found another type"),
    (lambda d: SEARCHES.search(NAN, ONES, k=1), r"base: vector 0, coordinate 0: found NaN"),
    (lambda d: SEARCHES.search(PAIR, PAIR, k=1, metric="x"), r"metric `x`, expected"),  # type: ignore[arg-type]
    (lambda d: SEARCHES.search(PAIR, PAIR, k=1, index="x"), r"index: found 'x'"),  # type: ignore[arg-type]
    (lambda d: SEARCHES.search(PAIR, PAIR, k=1, index="hnsw", metric="dot"), r"for dot products"),
    (lambda d: SEARCHES.search(PAIR, PAIR, k=1, index="hnsw", ef=99), r"99 candidates in a job .* 1 to 8"),
    (lambda d: SEARCHES.search(BYTES, BYTES, k=1, scale=0.0), r"scale: found 0, expected a finite number above 0"),
    (lambda d: SEARCHES.search(np.tile(PAIR, 2), np.tile(PAIR, 2), k=1), r"80 dimensions in a job .* 1 to 64"),
    (lambda d: raypath.read_graph("/nonexistent"), r"/nonexistent: No such file"),
    (lambda d: raypath.read_graph(__file__), r"test_errors.py: .*an index of hnswlib"),
    (lambda d: raypath.Datapath("graphics").euclidean(PAIR, PAIR), r"'euclidean' is not an operation"),
    (lambda d: raypath.Datapath("large"), r"'large' is not a valid preset, expected paper"),
    (lambda d: raypath.Datapath(lanes=7), r"lanes: '7' is not a valid number of lanes, expected none, 2, 4"),
    (lambda d: raypath.Datapath("paper", config="lanes = 4"), r"preset and config are given"),
    (lambda d: raypath.Datapath(config="lanes = 3"), r"config:1: lanes: '3'"),
    (lambda d: raypath.Datapath(config="missing.toml"), r"missing.toml: No such file"),
    (lambda d: raypath.Datapath(with_="cone"), r"'cone' is not an added operation, expected .*sphere"),
    (
        lambda d: raypath.Datapath(rules="chisel", quantised_boxes=True),
        r"quantised-boxes: true is not available with rules chisel, because .*; expected rules paper",
    ),
]


def ports(datapath: raypath.Datapath, **values: Any) -> dict[str, Any]:
    """A value for each input of a beat: 0, except for the given ones."""
    rows = (port for port in datapath.ports() if (port["operation"], port["direction"]) == ("euclidean", "input"))
    return dict.fromkeys((row["name"] for row in rows), 0) | values


@pytest.mark.parametrize(("call", "message"), ARRAYS, ids=[message[:50] for _, message in ARRAYS])
def test_value_errors(datapath: raypath.Datapath, call: Callable[[Any], Any], message: str) -> None:
    """Each call raises ``ValueError`` with the message."""
    with pytest.raises(ValueError, match=message):
        call(datapath)


def test_flags_that_do_not_exist() -> None:
    """A keyword that is not a flag, as Python's own functions."""
    with pytest.raises(TypeError, match="'lane' is not a flag of a datapath, expected lanes, rules"):
        raypath.Datapath(lane=4)  # type: ignore[call-arg]


def test_generate_writes_all_or_nothing(datapath: raypath.Datapath, tmp_path: Path) -> None:
    """A folder in place of a file: nothing is written."""
    (tmp_path / "raypath.sv").mkdir()
    with pytest.raises(OSError, match=r"raypath\.sv: cannot write"):
        datapath.generate(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["raypath.sv"]


def test_nan_is_computed(datapath: raypath.Datapath) -> None:
    """NaN in a job is not an error: the hardware computes with it. The result has the canonical NaN."""
    payload = np.array([0x7FC01234], np.uint32).view(np.float32).reshape(1, 1)
    distance = datapath.euclidean(payload, payload)
    assert distance.view(np.uint32).tolist() == [0x7FC00000]
    assert not datapath.triangle(RAYS, np.full((4, 3, 3), np.nan, np.float32)).triangle_hit.any()
