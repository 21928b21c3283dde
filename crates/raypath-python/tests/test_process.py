"""Properties of the whole process: memory, the interpreter lock, Ctrl-C, the command line."""

import copy
import multiprocessing
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pandas
import pytest
from helpers import f32

import raypath

TRIANGLE = f32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]])

INPUTS_ARE_NOT_COPIED = """
import resource
import numpy as np, raypath
jobs = 1_000_000
datapath = raypath.Datapath()
rays = raypath.rays(np.zeros((jobs, 3), np.float32), np.ones((jobs, 3), np.float32))
boxes = np.ones((jobs, 4, 2, 3), np.float32)
boxes.flags.writeable = rays.flags.writeable = False
datapath.quadbox(rays[:1000], boxes[:1000])
in_use = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
# Room for the results (24 MB), but not for another array of rays (64 MB) or boxes (96 MB).
resource.setrlimit(resource.RLIMIT_AS, (in_use + jobs * 24 + (16 << 20),) * 2)
hits = datapath.quadbox(rays, boxes)
assert hits.is_intersect.all() and hits.tmin[-1, 0] == 1
for view in (hits.is_intersect, hits.tmin, hits.box_index):
    assert view.base is hits.array
try:
    boxes.copy()
except MemoryError:
    print("done")
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_inputs_are_not_copied() -> None:
    """A process that has no room for a copy of the inputs computes them."""
    found = subprocess.run([sys.executable, "-c", INPUTS_ARE_NOT_COPIED], capture_output=True, text=True, check=False)
    assert (found.stdout, found.stderr) == ("done\n", "")


@pytest.mark.parametrize("is_model", [False, True])
def test_the_interpreter_lock_is_released(datapath: raypath.Datapath, is_model: bool) -> None:
    """Another thread of Python runs while an array is computed, and while a model runs."""
    vectors, model = np.ones((2000, 20_000), np.float32), raypath.UnitModel(raypath.Unit("compact"))
    started, finished = threading.Event(), threading.Event()

    def work() -> None:
        started.set()
        model.run(1_000_000) if is_model else datapath.euclidean(vectors, vectors)
        finished.set()

    thread = threading.Thread(target=work)
    thread.start()
    started.wait()
    turns = 0
    while not finished.is_set():
        time.sleep(0.001)
        turns += 1
    thread.join()
    assert turns >= 3


@pytest.mark.parametrize(
    "work",
    [
        "raypath.Unit(search='k=16,m=64').search(*(np.ones((n, 128), np.float32) for n in (200_000, 20_000)))",
        "raypath.render(raypath.Scene(vertices, faces), size=(4000, 4000), samples=2, ao=9)",
        "raypath.Scene(random((2_000_000, 3)), np.arange(1_998_000).reshape(-1, 3))",
        "raypath.Unit().scene(random((600_000, 3, 3)))",
        "raypath.Datapath(format='fp16').euclidean(np.ones((40_000, 400)), np.ones((40_000, 400)))",
        "[unit.trace(scene, rays) for _ in range(99)]",
        "raypath.UnitModel(unit).run(10**12)",
    ],
)
def test_interrupt(work: str) -> None:
    """Ctrl-C stops long work with ``KeyboardInterrupt``, in a fraction of a second."""
    program = f"""
import time
import numpy as np, raypath
vertices, faces = np.float32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]])
random = lambda shape: np.random.default_rng(1).random(shape, np.float32)
unit = raypath.Unit("compact")
scene = unit.scene(random((1000, 3, 3)))
rays = scene.rays(random((300_000, 3)), random((300_000, 3)) - np.float32(0.5))
print("ready", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("interrupted")
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60)[0] == "interrupted\n"


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_pickles() -> None:
    """Objects of other processes are equal."""
    unit = raypath.Unit("compact", contexts=16, barycentrics=True)
    memory = unit.scene(TRIANGLE[None])
    rays = memory.rays(f32([[0, 0, 4], [9, 0, 4]]), f32([[0, 0, -1], [0, 0, -1]]))
    scene = raypath.Scene(TRIANGLE, np.array([[0, 1, 2]]))
    hits = raypath.trace(scene, raypath.rays(rays["origin"].copy(), rays["direction"].copy()), timed=2)
    again = pickle.loads(pickle.dumps((unit, memory, scene, hits)))
    assert [repr(one) for one in again] == [repr(unit), repr(memory), repr(scene), repr(hits)]
    assert (again[1].data, again[1].root, again[1].reach) == (memory.data, memory.root, memory.reach)
    np.testing.assert_array_equal(again[3].array, hits.array)
    assert again[3].timing == hits.timing
    datapath = raypath.Datapath()
    pipeline, model = raypath.Pipeline(datapath), raypath.UnitModel(unit)
    assert pipeline.offer(raypath.Job.timing(datapath, "quadbox"), tag=7)
    pipeline.skip(5)
    model.step(rays[0], 3)
    for copied, copied_model in (copy.deepcopy((pipeline, model)), pickle.loads(pickle.dumps((pipeline, model)))):
        assert copied.skip(100) == 7
        outcome = copied.step()
        assert outcome is not None
        assert outcome.tag == 7
        assert copied_model.save() == model.save()
    with pytest.raises(ValueError, match="expected those that a model saved"):
        pipeline.restore(b"bytes")
    # A process that was forked has none of the threads with which its parent has traced.
    for way in ("spawn", "fork"):
        with multiprocessing.get_context(way).Pool(1) as pool:
            found = pool.apply_async(unit.trace, (memory, rays)).get(60)
        np.testing.assert_array_equal(found.array, unit.trace(memory, rays).array)


def test_hits_are_rows() -> None:
    """Hits have a length, iterate, and index by field, number, slice and mask; pandas takes them."""
    unit = raypath.Unit("compact")
    memory = unit.scene(TRIANGLE[None])
    hits = unit.trace(memory, memory.rays(f32([[0, 0, 4], [9, 0, 4]]), f32([[0, 0, -1], [0, 0, -1]])))
    assert (len(hits), [hit["primitive"] for hit in hits]) == (2, [0, -1])
    assert (hits["t"].tolist(), hits[0]["t"], hits[1]["t"]) == ([4, np.inf], 4, np.inf)
    assert (len(hits[1:]), hits[hits.primitive >= 0].primitive.tolist()) == (1, [0])
    assert pandas.DataFrame(hits.array)["t"].tolist() == [4, np.inf]
    with pytest.raises(IndexError):
        hits[2]


def test_arrays_that_lose_nothing_are_converted(datapath: raypath.Datapath) -> None:
    """Another type, order, byte order or alignment gives the same result, if float32 has every value."""
    values = np.random.default_rng(2).integers(-99, 99, (7, 40)).astype(np.float32)
    values[3, 4] = np.nan
    expected = datapath.euclidean(values, values[::-1].copy())
    memory = np.zeros(values.nbytes + 1, np.uint8)
    memory[1:].view(np.float32)[:] = values.ravel()
    unaligned = memory[1:].view(np.float32).reshape(values.shape)
    for same in (values.astype(np.float64), values.astype(np.float16), np.asfortranarray(values), values.astype(">f4")):
        np.testing.assert_array_equal(datapath.euclidean(same, values[::-1]), expected)
    np.testing.assert_array_equal(datapath.euclidean(unaligned, values[::-1]), expected)


def run(*arguments: str, cwd: Path) -> "subprocess.CompletedProcess[str]":
    """Runs ``python -m raypath``."""
    command = [sys.executable, "-m", "raypath", *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


def test_command_line(tmp_path: Path) -> None:
    """All commands are there; exit codes are those of the program."""
    found = run("configs", cwd=tmp_path)
    assert (found.returncode, found.stderr) == (0, "")
    presets = found.stdout.split("\n\n")[0].splitlines()[2:]
    # A row whose second cell is long goes on in a row without a name.
    names = [row.split()[1] for row in presets if not row.startswith("|  ")]
    assert names == [row["preset"] for row in raypath.presets()]
    assert run("--version", cwd=tmp_path).stdout == f"raypath {raypath.__version__}\n"
    assert "verify" in run("--help", cwd=tmp_path).stdout
    found = run("renders", cwd=tmp_path)
    assert found.returncode == 2
    assert "unrecognized subcommand 'renders'" in found.stderr
    found = run("render", "missing.obj", cwd=tmp_path)
    assert found.returncode == 2
    assert "missing.obj" in found.stderr


def test_console_script(tmp_path: Path) -> None:
    """The program ``raypath`` beside the interpreter writes the files that ``generate`` writes."""
    script = Path(sys.executable).with_name("raypath")
    subprocess.run([script, "generate", "--jobs", "10"], cwd=tmp_path, check=True, capture_output=True)
    raypath.Datapath().generate(tmp_path / "same")
    names = sorted(path.relative_to(tmp_path / "same") for path in (tmp_path / "same").rglob("*") if path.is_file())
    assert len(names) > 20
    for name in names:
        assert (tmp_path / "build" / name).read_text() == (tmp_path / "same" / name).read_text()


def test_interrupted_command(tmp_path: Path) -> None:
    """Ctrl-C ends a command with exit code 130 and leaves no file."""
    command = [sys.executable, "-m", "raypath", "render", "--size", "4000x4000", "--samples", "8"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert "triangles" in process.stdout.readline()
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, list(tmp_path.iterdir())) == (130, [])
    assert "stopped after" in errors
