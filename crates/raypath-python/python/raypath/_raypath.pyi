import builtins
import os
from collections.abc import Iterator, Sequence
from typing import Any, Literal, TypedDict, final, overload

import numpy as np
from numpy.typing import NDArray

from raypath._queries import Geometry, Instance, Query

_Float32 = NDArray[np.float32]
# Arrays of any type whose values float32 has, or float64 or uint32 where the docstring says so.
_Numbers = NDArray[np.number[Any]]
_Rays = NDArray[np.void]
_Ray = np.void | _Rays
# What selects one hit, or several.
_Number = int | np.integer[Any]
_Several = slice | NDArray[np.integer[Any]] | NDArray[np.bool_] | Sequence[int]

_Text = dict[str, str]

class _Units(TypedDict):
    step: int
    stage: str
    encode: int
    add: int
    sum: int
    mul: int
    compare: int
    decode: int

class _Schedule(_Units):
    operation: str
    work: str

class _Registers(TypedDict):
    step: int
    stage: str
    live: int
    data: int
    control: int
    state: int
    flip_flops: int

class _Port(TypedDict):
    operation: str
    direction: Literal["input", "output"]
    name: str
    kind: Literal["number", "flags", "word"]
    width: int

class _Traced(TypedDict):
    kind: str
    rays: int
    hits: int
    quadbox: int
    triangle: int
    behind: int
    nodes: int
    leaves: int

class _Timing(TypedDict):
    in_flight: int
    memory_latency: int
    agents: int
    cycles: int
    jobs: int
    triangle: int
    quadbox: int
    euclidean: int
    angular: int
    jobs_per_cycle: float
    agents_per_cycle: float
    mean_latency: float
    fetches: int
    accepted: int
    refused: int
    starved_memory: int
    starved_outcomes: int
    starved_both: int

class _UnitParameters(TypedDict):
    contexts: int
    stack: int
    memory_width: int
    id_width: int
    address_width: int
    divider_latency: int
    ram_latency: int
    node_limit: int
    node: Literal["wide4", "quantised", "wide8"]
    instances: bool
    nested_instances: bool
    queries: Literal["none", "flags", "full"]
    parity: bool
    front: Literal["counter-clockwise", "clockwise"]
    search: str

class _Simulation(TypedDict):
    cycles: int
    rays: int
    boxes: int
    triangles: int
    steps: int
    fetches: int
    beats: int
    cache_hits: int
    cache_merges: int
    cache_misses: int
    rays_in_flight: float
    jobs_per_cycle: float

class _Hit(TypedDict):
    status: int
    primitive: int
    instance: int
    t: float
    t_num: float
    t_denom: float
    u: float
    v: float
    back_face: bool
    nodes: int
    triangles: int
    geometry: int
    custom_index: int
    shader_offset: int

class _Candidate(TypedDict):
    is_box: bool
    is_opaque: bool
    primitive: int
    geometry: int
    instance: int
    custom_index: int
    shader_offset: int
    t: float
    u: float
    v: float
    back_face: bool
    origin: list[float]
    direction: list[float]

class _Run(TypedDict):
    accepted: int
    hits: UnitHits
    hit_ids: NDArray[np.uint64]
    hit_cycles: NDArray[np.uint64]
    request_addresses: NDArray[np.uint32]
    request_cycles: NDArray[np.uint64]

__all__ = [
    "RAY",
    "UNIT_RAY",
    "VERSION",
    "Datapath",
    "Job",
    "Outcome",
    "Pipeline",
    "QuadboxHits",
    "RayQuery",
    "Rendering",
    "SavedGraph",
    "Scene",
    "Trace",
    "TriangleHits",
    "Unit",
    "UnitHits",
    "UnitModel",
    "UnitOutputs",
    "UnitScene",
    "UnitSearch",
    "main",
    "operations",
    "parameters",
    "presets",
    "rays",
    "read_card",
    "read_graph",
    "render",
    "rust_seconds",
    "trace",
]

RAY: np.dtype[np.void]
UNIT_RAY: np.dtype[np.void]
VERSION: str

def main(arguments: Sequence[str]) -> int:
    """Runs the command line `arguments`, the first of which is the name of the program, and returns the exit code."""

def rust_seconds(
    operation: str, first: NDArray[Any], second: NDArray[Any], repetitions: int
) -> tuple[float, float, float]:
    """The shortest times in seconds in which Rust computes the jobs of an operation on one thread.

    Args:
        operation: "quadbox", "triangle" or "euclidean".
        first: the rays of n jobs, or a float32 array of shape (n, 16).
        second: the boxes, the triangles, or a float32 array of shape (n, 16).
        repetitions: the number of measurements.

    Returns:
        Three times: of ``raypath_model::pack``, ``Batch`` and ``unpack`` for jobs in the types of ``raypath_ops``, in
        chunks that fit into the cache; of ``Batch`` alone, for blocks of jobs that are packed in memory before; of
        ``raypath_embed`` for the given arrays. The first and the third include the allocation of their results."""

def operations() -> list[_Text]:
    """The operations that ``Datapath(with_=...)`` adds to those of the paper.

    Returns:
        A row for each operation: ``operation`` and ``purpose``."""

def parameters() -> list[_Text]:
    """The parameters of a configuration, which are keywords of ``Datapath``.

    Returns:
        A row for each parameter: ``keyword``, ``values``, ``default``, ``meaning`` and ``group``."""

def presets() -> list[_Text]:
    """The presets: named configurations.

    Returns:
        A row for each preset: ``preset``, ``options`` (what differs from the first, as options of the command line) and
        ``purpose``."""

def read_card(text: str) -> dict[str, Any]:
    """Reads a card, the text that ``raypath card`` writes, as a dictionary.

    Raises:
        ValueError: another text, or another version of it."""

def rays(origins: _Numbers, directions: _Numbers, extent: float | _Numbers | None = None) -> _Rays:
    """Rays as the datapath expects them, from origins, directions and extents.

    A ray reaches the points ``origin + t * direction`` for ``0 < t <= extent``. Distances of all operations are in
    units of the direction's length, which may be any except 0.

    Args:
        origins: float32 array of shape (n, 3).
        directions: float32 array of shape (n, 3).
        extent: a number of at least 0 for all rays, or a float32 array of shape (n,).

    Returns:
        A structured array of shape (n,) with 64 bytes per ray and the fields of the C structure ``raypath_ray``:
        ``origin``, ``direction``, ``inverse``, ``extent``, ``shear``, ``kx``, ``ky``, ``kz``.

    Raises:
        ValueError: another type or shape; in a row, a direction that is zero, not finite or too short to invert, an
            origin that is not finite, or an extent that is negative or NaN. The message names the row.

    Example:
        >>> import numpy as np, raypath
        >>> origins = np.array([[0, 0, -5]], np.float32)
        >>> directions = np.array([[0, 0, 2]], np.float32)
        >>> rays = raypath.rays(origins, directions, extent=10)
        >>> rays["inverse"], rays["kz"]
        (array([[inf, inf, 0.5]], dtype=float32), array([2], dtype=uint32))"""

@final
class Datapath:
    """A datapath: a configuration with its operations, netlist and models.

    It does not change, so that threads can share it. Its methods release the interpreter lock while they compute.
    Arrays of jobs start with accumulators of zero.

    Inputs are arrays of the stated shape. C-contiguous arrays of the stated type are not copied; others are converted
    if every value stays what it is, and raise ``ValueError`` if not. NaN and infinity are computed as the hardware
    computes them; every NaN in a result is the canonical NaN.

    Args:
        preset: the name of a configuration that the others change; ``raypath.presets()`` lists them. "paper" if neither
            it nor ``config`` is given.
        config: in place of a preset, the path of a TOML file, or its text, which contains "=".
        with_: the names of operations besides those of the paper; ``raypath.operations()`` lists them.
        flags: the options of the command line, with ``_`` in place of ``-``, such as ``lanes=64`` or
            ``control="credit"``; ``raypath.parameters()`` lists them.

    Raises:
        ValueError: a value that a flag does not have; a configuration that cannot be built.
        TypeError: a keyword that is not a flag.

    Example:
        >>> import raypath
        >>> raypath.Datapath(lanes="none", control="credit").flip_flops
        7104"""
    def __new__(
        cls,
        preset: str | None = None,
        *,
        config: str | os.PathLike[str] | None = None,
        with_: str | Sequence[str] | None = None,
        lanes: int | Literal["none"] = ...,
        rules: Literal["paper", "chisel", "bounds"] = ...,
        box_bits: int = ...,
        format: str = ...,
        rounding: Literal["unit", "sum"] = ...,
        io: Literal["ieee", "recoded"] = ...,
        registers: Literal["ieee", "recoded"] = ...,
        control: Literal["skid", "credit"] = ...,
        sharing: Literal["union", "segregated"] = ...,
        units: Literal["shared", "disjoint"] = ...,
        interval: Literal[1, 2, 4, 8] = ...,
        unit_latency: int | str = ...,
        delay_lines: int = ...,
        clock_gating: bool = ...,
        multiplier: Literal["booth", "inferred"] = ...,
        tag: int = ...,
        barycentrics: bool = ...,
        edges: Literal["shared", "once"] = ...,
        culling: Literal["back", "front", "none"] = ...,
        facing: bool = ...,
        range: bool = ...,
        conservative: bool = ...,
        quantised_boxes: bool = ...,
        accumulators: Literal[1, 2, 4, 8, 16] = ...,
        exception_flags: bool = ...,
    ) -> Datapath: ...
    @property
    def latency(self) -> int:
        """Cycles from the acceptance of a job to its outcome in an empty pipeline."""
    @property
    def flip_flops(self) -> int:
        """The number of flip-flops of the netlist."""
    @property
    def lanes(self) -> int:
        """The coordinates of a Euclidean beat, 0 without distances. An angular beat has half as many."""
    @property
    def operations(self) -> list[str]:
        """The names of the operations, in the order of their opcodes."""
    @property
    def config(self) -> str:
        """The configuration as TOML, which ``Datapath(config=...)`` and ``--config`` read."""
    def quadbox(self, rays: _Rays, boxes: _Numbers) -> QuadboxHits:
        """Tests each ray against four boxes, and sorts the four boxes of each job.

        Args:
            rays: n rays of ``raypath.rays``.
            boxes: float32 array of shape (n, 4, 2, 3): for each ray four boxes, of which each is min and max.

        Returns:
            n outcomes with the attributes ``is_intersect``, ``tmin`` and ``box_index``, each of shape (n, 4).

        Raises:
            ValueError: another type or shape; a datapath without the operation.

        Example:
            >>> import numpy as np, raypath
            >>> rays = raypath.rays(np.float32([[0, 0, -5]]), np.float32([[0, 0, 1]]))
            >>> near, far, aside = [[-1, -1, -1], [1, 1, 1]], [[-1, -1, 7], [1, 1, 9]], [[4, 4, 4], [5, 5, 5]]
            >>> hits = raypath.Datapath().quadbox(rays, np.float32([[far, aside, near, aside]]))
            >>> hits.is_intersect, hits.box_index
            (array([[ True,  True, False, False]]), array([[2, 0, 1, 3]], dtype=uint8))"""
    def triangle(self, rays: _Rays, triangles: _Numbers) -> TriangleHits:
        """Tests each ray against a triangle, which is hit from the side where its vertices run counter-clockwise.

        Args:
            rays: n rays of ``raypath.rays``. Their extents are not tested.
            triangles: float32 array of shape (n, 3, 3): for each ray three vertices.

        Returns:
            n outcomes with the attributes ``triangle_hit``, ``t_num`` and ``t_denom``, each of shape (n,).

        Raises:
            ValueError: another type or shape; a datapath without the operation.

        Example:
            >>> import numpy as np, raypath
            >>> rays = raypath.rays(np.float32([[0, 0, -5]]), np.float32([[0, 0, 1]]))
            >>> hit = raypath.Datapath().triangle(rays, np.float32([[[-1, -1, 0], [0, 1, 0], [1, -1, 0]]]))
            >>> hit.triangle_hit, hit.t_num / hit.t_denom
            (array([ True]), array([5.], dtype=float32))"""
    def euclidean(self, a: _Numbers, b: _Numbers) -> _Float32:
        """The squared Euclidean distance of each pair of vectors, added in the order of the hardware.

        Args:
            a: float32 array of shape (n, k), for any k of at least 1. Vectors are divided into beats of ``lanes``
                coordinates, of which the last is masked.
            b: float32 array of the same shape.

        Returns:
            A float32 array of shape (n,).

        Raises:
            ValueError: another type or shape; a datapath without the operation.

        Example:
            >>> import numpy as np, raypath
            >>> raypath.Datapath().euclidean(np.zeros((2, 40), np.float32), np.full((2, 40), 2, np.float32))
            array([160., 160.], dtype=float32)"""
    def angular(self, q: _Numbers, c: _Numbers) -> tuple[_Float32, _Float32]:
        """The dot product of each query with its candidate, and the squared norm of the candidate.

        The cosine of the angle is ``dot / sqrt(norm * norm_of_query)``; the datapath does not divide.

        Args:
            q: float32 array of shape (n, k), for any k of at least 1.
            c: float32 array of the same shape.

        Returns:
            Two float32 arrays of shape (n,): the dot products and the squared norms.

        Raises:
            ValueError: another type or shape; a datapath without the operation.

        Example:
            >>> import numpy as np, raypath
            >>> dot, norm = raypath.Datapath().angular(np.float32([[1, 2]]), np.float32([[3, 4]]))
            >>> dot, norm
            (array([11.], dtype=float32), array([25.], dtype=float32))"""
    def run(self, operation: str, /, **ports: Any) -> dict[str, NDArray[Any]]:
        """Computes n jobs of any operation, in order, from the values at its input ports.

        This copies its inputs, and is slower than the methods of the paper's operations.

        Args:
            operation: the name of the operation.
            ports: for each input port (``ports()`` lists them) an array of shape (n,), or a number that counts for all
                jobs. Numbers in binary32 are float32 arrays. Flags, words, and the bits of numbers in other formats are
                arrays of integers or truth values; bits beyond the width of a port are ignored.

        Returns:
            For each output port an array of shape (n,): float32, bool for a single flag, or uint64.

        Raises:
            ValueError: a datapath without the operation; a port that is missing or unknown; another type or shape.
            KeyboardInterrupt: after Ctrl-C.

        Example:
            >>> import numpy as np, raypath
            >>> datapath = raypath.Datapath(lanes=2)
            >>> beat = {"euclidean_a_0": np.float32([1, 2]), "euclidean_a_1": 0, "euclidean_b_0": 0, "euclidean_b_1": 0}
            >>> found = datapath.run("euclidean", euclidean_mask=0b11, euclidean_reset_accum=False, **beat)
            >>> found["euclidean_accumulator"]
            array([1., 5.], dtype=float32)"""
    def generate(self, folder: str | os.PathLike[str]) -> int:
        """Writes SystemVerilog, assertions, wrapper, manifests and a picture of the pipeline, as ``raypath generate``
        does.

        Args:
            folder: the folder to write to, which is created if it does not exist.

        Returns:
            The number of files.

        Raises:
            OSError: a file or folder that cannot be written; then no file is changed."""
    def card(self) -> dict[str, Any]:
        """The figures for architecture simulators, as ``raypath card`` writes them, without measured ones.

        Returns:
            The document as a dictionary; ``absent`` says why a value is None."""
    def schedule(self) -> list[_Schedule]:
        """The work of each operation in each step of the pipeline (Table VII of the paper).

        Returns:
            A row for each step and operation, for example for ``pandas.DataFrame``: ``step`` (0 is the input's
            registers), ``stage`` (its name: "2", or "2.1" if a stage has several steps), ``operation``, ``work`` (a
            description; empty if values only pass through) and the number of units of each kind."""
    def units(self) -> list[_Units]:
        """The floating-point units of each step of the pipeline, counted in the netlist (Table VIII of the paper).

        Returns:
            A row for each step: ``step``, ``stage``, and the number of units of each kind: ``encode``, ``add``,
            ``mul``, ``compare``, ``decode``."""
    def registers(self) -> list[_Registers]:
        """The register bits after each step of the pipeline, counted in the netlist.

        Returns:
            A row for each step: ``step``, ``stage``, ``live`` (bits of a job), ``data``, ``control`` and ``state``
            (flip-flops by purpose), and ``flip_flops``, the sum of the three."""
    def ports(self) -> list[_Port]:
        """The ports of each operation, without those of the handshake and the opcode.

        Returns:
            A row for each port: ``operation``, ``direction`` ("input" or "output"), ``name``, ``kind`` ("number",
            "flags" or "word") and ``width`` in bits."""
    def _repr_svg_(self) -> str: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class QuadboxHits:
    """The outcomes of n jobs of a ray against four boxes.

    The four boxes of a job are sorted: hits before misses, nearer before farther, equal distances by index.

    They have a length, iterate, and index: by a field's name, by a number for one, by a slice or an array for
    several. ``pandas.DataFrame(hits.array)`` has a column for each field of one number."""
    def __new__(cls, array: NDArray[np.void], timing: _Timing | None = None) -> QuadboxHits: ...
    @property
    def array(self) -> NDArray[np.void]:
        """The structured array of shape (n,), of which the other attributes are views."""
    @property
    def is_intersect(self) -> NDArray[np.bool_]:
        """bool array of shape (n, 4): whether the box at each position of the order is hit."""
    @property
    def tmin(self) -> _Float32:
        """float32 array of shape (n, 4): the distance at which the ray enters the box at each position, in units of the
        direction's length; 0 if the ray begins inside, infinity for a miss."""
    @property
    def box_index(self) -> NDArray[np.uint8]:
        """uint8 array of shape (n, 4): the index of the box at each position among those of the job, 0 to 3."""
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[np.void]: ...
    @overload
    def __getitem__(self, key: str, /) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, key: _Number, /) -> np.void: ...
    @overload
    def __getitem__(self, key: _Several, /) -> QuadboxHits: ...

@final
class TriangleHits:
    """The outcomes of n jobs of a ray against a triangle.

    The distance to the triangle is ``t_num / t_denom``, in units of the direction's length. The datapath does not
    divide.

    They have a length, iterate, and index: by a field's name, by a number for one, by a slice or an array for
    several. ``pandas.DataFrame(hits.array)`` has a column for each field of one number."""
    def __new__(cls, array: NDArray[np.void], timing: _Timing | None = None) -> TriangleHits: ...
    @property
    def array(self) -> NDArray[np.void]:
        """The structured array of shape (n,), of which the other attributes are views."""
    @property
    def triangle_hit(self) -> NDArray[np.bool_]:
        """bool array of shape (n,): whether the ray hits the triangle."""
    @property
    def t_num(self) -> _Float32:
        """float32 array of shape (n,): the numerator of the distance."""
    @property
    def t_denom(self) -> _Float32:
        """float32 array of shape (n,): the denominator of the distance."""
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[np.void]: ...
    @overload
    def __getitem__(self, key: str, /) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, key: _Number, /) -> np.void: ...
    @overload
    def __getitem__(self, key: _Several, /) -> TriangleHits: ...

@final
class Job:
    """A job for a ``Pipeline``. The static methods make jobs."""
    @staticmethod
    def quadbox(ray: _Ray, boxes: _Numbers) -> Job:
        """A ray against four boxes.

        Args:
            ray: an item of ``raypath.rays``.
            boxes: float32 array of shape (4, 2, 3).

        Raises:
            ValueError: another type or shape."""
    @staticmethod
    def triangle(ray: _Ray, triangle: _Numbers) -> Job:
        """A ray against a triangle.

        Args:
            ray: an item of ``raypath.rays``.
            triangle: float32 array of shape (3, 3).

        Raises:
            ValueError: another type or shape."""
    @staticmethod
    def euclidean(a: _Numbers, b: _Numbers, *, mask: int | None = None, reset: bool = True) -> Job:
        """A beat of a Euclidean distance: the squared distance of up to ``lanes`` coordinates is added to the accumulator.

        Args:
            a: float32 array of shape (k,), with k at most the lanes of the datapath. Further lanes are masked.
            b: float32 array of the same shape.
            mask: bit i says whether coordinate i counts; all if it is None.
            reset: whether the accumulator is zero for the next beat.

        Raises:
            ValueError: another type or shape; more than 64 coordinates."""
    @staticmethod
    def angular(q: _Numbers, c: _Numbers, *, mask: int | None = None, reset: bool = True) -> Job:
        """A beat of an angular distance: dot product and squared norm of up to ``lanes / 2`` coordinates are added to the
        accumulators.

        Args:
            q: float32 array of shape (k,), with k at most half the lanes of the datapath. Further lanes are masked.
            c: float32 array of the same shape.
            mask: bit i says whether coordinate i counts; all if it is None.
            reset: whether the accumulators are zero for the next beat.

        Raises:
            ValueError: another type or shape; more than 64 coordinates."""
    @staticmethod
    def words(datapath: Datapath, operation: str, /, **ports: Any) -> Job:
        """A job of any operation of a datapath, from the values at its input ports.

        Args:
            datapath: the datapath of the pipeline.
            operation: the name of the operation.
            ports: a number for each input port, as for ``Datapath.run``.

        Raises:
            ValueError: a datapath without the operation; a port that is missing or unknown; arrays of other than one
                item."""
    @staticmethod
    def timing(datapath: Datapath, operation: str) -> Job:
        """A job of an operation without values, for its exact timing. Accumulators do not change.

        Args:
            datapath: the datapath of the pipeline.
            operation: the name of the operation.

        Raises:
            ValueError: a datapath without the operation."""

@final
class Outcome:
    """The outcome of a job that left a ``Pipeline``."""
    @property
    def tag(self) -> int:
        """The tag with which the job was offered."""
    @property
    def operation(self) -> str:
        """The name of the operation."""
    @property
    def values(self) -> dict[str, Any]:
        """The values by name: those of the arrays of ``Datapath`` for the paper's operations (``is_intersect``, ``tmin``
        and ``box_index`` have four items), ``accumulator`` or ``dot_product`` and ``norm`` with ``reset_accum`` for
        beats, those at the output ports for jobs of words, none for jobs without values."""

@final
class Pipeline:
    """The cycle-exact model of a datapath, whose jobs carry a tag. In every cycle it accepts and delivers what the
    hardware does.

    A cycle consists of at most one accepted ``offer``, then a ``step``. A pipeline belongs to one thread at a time.

    Args:
        datapath: the datapath, which other pipelines may share.

    Example:
        >>> import raypath
        >>> datapath = raypath.Datapath()
        >>> pipeline = raypath.Pipeline(datapath)
        >>> pipeline.offer(raypath.Job.timing(datapath, "quadbox"), tag=7)
        True
        >>> pipeline.skip(100)
        12
        >>> pipeline.step().tag
        7"""
    def __new__(cls, datapath: Datapath) -> Pipeline: ...
    @property
    def occupancy(self) -> int:
        """The number of jobs inside, with the one that was accepted in this cycle."""
    @property
    def output_valid(self) -> bool:
        """Whether there is an outcome at the output in this cycle."""
    def offer(self, job: Job, tag: int = 0) -> bool:
        """Offers a job in this cycle.

        Args:
            job: the job, of an operation of the datapath.
            tag: an integer of 0 to 2**64 - 1 that its outcome carries.

        Returns:
            Whether the job is accepted in this cycle. A second job in a cycle is not.

        Raises:
            ValueError: a datapath without the operation; a beat of more coordinates than the datapath has lanes."""
    def step(self, output_ready: bool = True) -> Outcome | None:
        """One clock cycle: the job that was accepted enters, and an outcome may leave.

        Args:
            output_ready: whether the outcome at the output leaves in this cycle.

        Returns:
            The outcome that leaves, or None."""
    def skip(self, cycles: int) -> int:
        """Advances cycles in which nothing else is offered and the sink is not ready, and stops in the first with an
        outcome at the output.

        Args:
            cycles: the maximum number of cycles.

        Returns:
            The number of cycles."""
    def input_ready(self, operation: str) -> bool:
        """Whether a job of an operation would be accepted in this cycle.

        Raises:
            ValueError: a datapath without the operation."""
    def save(self) -> bytes:
        """The whole state as bytes, for ``restore``."""
    def restore(self, state: bytes) -> None:
        """Takes over a state that a pipeline of an equal datapath saved, in this release of raypath.

        Raises:
            ValueError: other bytes. Then nothing changes."""
    def reset(self) -> None:
        """A cycle of reset: all jobs are lost, and the accumulators are zero."""

@final
class RayQuery:
    """Rays that wait for verdicts on candidates; ``raypath.Query`` has the interface."""
    def advance(self, verdicts: NDArray[np.void] | None = None) -> NDArray[np.void] | None:
        """Gives verdicts on the candidates before, one for each, and returns the next; None where all rays have ended."""
    def hits(self) -> UnitHits:
        """The hits of all rays, which have ended."""

@final
class UnitScene:
    """A scene in memory, as a ``Unit`` reads it.

    Args:
        data: the bytes, the first of which has the address 0; ``Unit.scene`` and ``raypath scene`` make them.
        root: the child word of the root, which ``raypath scene`` prints.
        within: the corners of the scene's box and its reach, for warnings of rays from further away.
        node: the kind of its nodes, ``"wide4"``, ``"quantised"`` or ``"wide8"``; a unit that reads others refuses it.
        queries: those that it needs, ``"none"``, ``"flags"`` or ``"full"``; a unit that has less refuses it.

    Raises:
        ValueError: a root of more than 32 bits; another node or queries."""
    def __new__(
        cls,
        data: bytes,
        root: int,
        within: tuple[Sequence[float], Sequence[float], float] | None = None,
        node: Literal["wide4", "quantised", "wide8"] | None = None,
        queries: Literal["none", "flags", "full"] | None = None,
    ) -> UnitScene: ...
    @property
    def reach(self) -> float | None:
        """The greatest distance, along any axis, between the origin of a ray and a vertex; None for bytes from elsewhere."""
    @property
    def data(self) -> bytes:
        """The bytes, from address 0 on. Each access makes a copy."""
    @property
    def root(self) -> int:
        """The child word of the root, with which each ray begins."""
    def rays(
        self,
        origins: _Numbers,
        directions: _Numbers,
        *,
        t_min: float = 0.0,
        t_max: float = ...,
        flags: int = 0,
        cull_mask: int = 255,
        base: int = 0,
    ) -> _Rays:
        """Rays as the unit takes them, for this scene.

        Directions of any length are allowed, and distances are in units of it. The unit refuses a ray with a direction
        that cannot be inverted, a value that is not finite, or a negative ``t_min``: its hit has the status 3, as has
        that of a ray whose flags have no meaning together.

        Args:
            origins: float32 array of shape (n, 3).
            directions: float32 array of shape (n, 3).
            t_min: hits count beyond this distance.
            t_max: hits count below this distance; infinity reaches everything.
            flags: ``raypath.RayFlags``.
            cull_mask: 8 bits; with ``instances`` and ``queries``, instances count whose mask has one of them.
            base: with ``address_width`` above 32, the bits of every address above its lower 32. The memory of
                ``trace`` has the addresses of base 0.

        Returns:
            A structured array of shape (n,) with the fields of the C structure ``raypath_unit_ray``: ``origin``,
            ``direction``, ``t_min``, ``t_max``, ``flags``, ``cull_mask``, ``root`` and ``base``. A field can be changed
            for each ray.

        Raises:
            ValueError: another type or shape, or a word of more than 32 bits."""
    def __len__(self) -> int: ...

@final
class UnitHits:
    """The hits of n rays of a ``Unit``.

    A ray without a hit has ``primitive``, ``geometry`` and ``instance`` -1 and ``t`` infinity; its other values are 0,
    except for ``status``, ``nodes`` and ``triangles``.

    They have a length, iterate, and index: by a field's name, by a number for one, by a slice or an array for
    several. ``pandas.DataFrame(hits.array)`` has a column for each field of one number."""
    def __new__(cls, array: NDArray[np.void], timing: _Timing | None = None) -> UnitHits: ...
    @property
    def array(self) -> NDArray[np.void]:
        """The structured array of shape (n,), of which the other attributes are views."""
    @property
    def status(self) -> NDArray[np.uint32]:
        """uint32 array of shape (n,): a ``UnitStatus``: 0 miss, 1 hit of a triangle, 2 of a box, 3 ray refused, 4 error of
        the memory, 5 error of the scene, 6 limit of work."""
    @property
    def primitive(self) -> NDArray[np.int32]:
        """int32 array of shape (n,): the index, in its geometry, of the triangle that is hit; -1 for a miss."""
    @property
    def instance(self) -> NDArray[np.int32]:
        """int32 array of shape (n,): with ``instances``, the index of the triangle's instance; -1 for a triangle in no
        instance, and for a miss."""
    @property
    def t(self) -> _Float32:
        """float32 array of shape (n,): the distance of the hit in units of the direction's length; infinity for a miss."""
    @property
    def t_num(self) -> _Float32:
        """float32 array of shape (n,): the numerator of the distance."""
    @property
    def t_denom(self) -> _Float32:
        """float32 array of shape (n,): the denominator of the distance; negative if the vertices run clockwise as the
        ray's origin sees them."""
    @property
    def u(self) -> _Float32:
        """float32 array of shape (n,): with ``barycentrics``, the weight of the triangle's second vertex at the hit;
        0 otherwise. The weights of the three vertices add up to 1."""
    @property
    def v(self) -> _Float32:
        """float32 array of shape (n,): with ``barycentrics``, the weight of the third vertex."""
    @property
    def back_face(self) -> NDArray[np.bool_]:
        """bool array of shape (n,): whether the ray hits the triangle from behind."""
    @property
    def nodes(self) -> NDArray[np.uint32]:
        """uint32 array of shape (n,): the nodes that the ray has read."""
    @property
    def triangles(self) -> NDArray[np.uint32]:
        """uint32 array of shape (n,): the triangles that the ray has read."""
    @property
    def geometry(self) -> NDArray[np.int32]:
        """int32 array of shape (n,): the index of the triangle's geometry; -1 for a miss."""
    @property
    def custom_index(self) -> NDArray[np.uint32]:
        """uint32 array of shape (n,): with ``instances`` and ``queries``, the custom index of the instance; 0 otherwise."""
    @property
    def shader_offset(self) -> NDArray[np.uint32]:
        """uint32 array of shape (n,): with ``instances`` and ``queries``, the offset of the instance into the shader table;
        0 otherwise."""
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[np.void]: ...
    @overload
    def __getitem__(self, key: str, /) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, key: _Number, /) -> np.void: ...
    @overload
    def __getitem__(self, key: _Several, /) -> UnitHits: ...

@final
class Unit:
    """A traversal unit around a datapath: a ray goes in, its closest or any hit comes out.

    It does not change, so that threads can share it. Its methods release the interpreter lock while they compute.

    Args:
        preset: the name of a configuration of the datapath, as for ``Datapath``. Distance operations are left out.
        config: in place of a preset, the path of a TOML file, or its text, which contains "=".
        flags: the options of ``raypath generate --unit``, with ``_`` in place of ``-``: ``contexts``, ``stack``,
            ``node``, ``memory_width``, ``id_width``, ``address_width``, ``divider_latency``, ``ram_latency``, ``node_limit``,
            ``front``, and those of the datapath. ``instances=True`` for scenes of two levels; ``queries="flags"`` for geometries that are opaque or not, and
            masks and flags of instances; ``queries="full"`` for candidates and procedural boxes, too.

    Raises:
        ValueError: a value that a flag does not have; a datapath that the unit does not have.
        TypeError: a keyword that is not a flag.

    Example:
        >>> import numpy as np, raypath
        >>> unit = raypath.Unit("compact", contexts=16)
        >>> scene = unit.scene(np.float32([[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]]))
        >>> rays = scene.rays(np.float32([[0, 0, 4], [9, 0, 4]]), np.float32([[0, 0, -2], [0, 0, -1]]))
        >>> hits = unit.trace(scene, rays)
        >>> hits.status, hits.t
        (array([1, 0], dtype=uint32), array([ 2., inf], dtype=float32))"""
    def __new__(
        cls,
        preset: str | None = None,
        *,
        config: str | os.PathLike[str] | None = None,
        contexts: int = ...,
        stack: Literal[2, 4, 8, 16, 32] = ...,
        memory_width: Literal[128, 256, 512, 1024] = ...,
        id_width: int = ...,
        address_width: int = ...,
        divider_latency: int = ...,
        ram_latency: Literal[1, 2] = ...,
        node_limit: int = ...,
        node: Literal["wide4", "quantised", "wide8"] = ...,
        instances: bool = ...,
        nested_instances: bool = ...,
        queries: Literal["none", "flags", "full"] = ...,
        parity: bool = ...,
        front: Literal["counter-clockwise", "clockwise"] = ...,
        search: str = ...,
        registers: Literal["ieee", "recoded"] = ...,
        control: Literal["skid", "credit"] = ...,
        sharing: Literal["union", "segregated"] = ...,
        unit_latency: int | str = ...,
        barycentrics: bool = ...,
        edges: Literal["shared", "once"] = ...,
    ) -> Unit: ...
    @property
    def parameters(self) -> _UnitParameters:
        """The parameters of the unit by their keywords, without those of the datapath."""
    @property
    def latency(self) -> int:
        """The latency of the datapath inside in cycles."""
    @property
    def flip_flops(self) -> int:
        """The number of flip-flops of the unit, with its datapath."""
    def _repr_svg_(self) -> str: ...
    def scene(
        self,
        triangles: _Numbers | list[Geometry],
        *,
        reach: float | None = None,
        instances: _Numbers | list[Instance] | None = None,
    ) -> UnitScene:
        """A scene of triangles in the layout that this unit reads, with its nodes, as ``raypath scene`` writes it.

        Args:
            triangles: float32 array of shape (n, 3, 3): three vertices for each triangle, counter-clockwise as seen
                from its front, with finite coordinates of magnitude at most 2**40. Or a list of ``raypath.Geometry``,
                for a unit with ``queries``.
            reach: with instances, the greatest distance, along any axis, between the origin of a ray and a vertex. Rays
                from further away may lose hits at the edges of instances. 16 times the longest side by default.
            instances: the places of the triangles in the scene, for a unit with ``instances``: a float64 array of shape
                (m, 3, 4), an affine matrix from the triangles to the scene for each place. The last number of each row
                is the translation, and numbers have a magnitude of at most 2**40. Or a list of ``raypath.Instance``.

        Raises:
            ValueError: another type or shape; a coordinate out of range; no triangle, or too many; no instance, one
                that is too far away, a matrix without an inverse, or a unit without ``instances`` or ``queries`` that
                the scene needs."""
    def group(self, instances: list[Instance], *, reach: float | None = None) -> UnitScene:
        """A scene of scenes of this unit, placed by instances. In a unit with ``nested_instances`` the scenes may have
        instances themselves, in any number of levels.

        Args:
            instances: a list of ``raypath.Instance``, each with its ``scene``. Hits report the position in the list.
            reach: as in ``scene``. A scene that has instances must have been built for the reach that it has at its
                places.

        Raises:
            ValueError: what ``scene`` raises; an instance without a scene, a scene of other nodes, or one that was built
                for a smaller reach."""
    def trace(self, scene: UnitScene, rays: _Rays) -> UnitHits:
        """Traces rays by the functional model, without time. Of candidates, triangles are accepted and boxes ignored; see
        ``query``.

        Args:
            scene: the memory that the unit reads. An address outside of it is an error of the memory.
            rays: rays of ``scene.rays``.

        Returns:
            n hits with the attributes ``status``, ``primitive``, ``t`` and others, each of shape (n,). They have the
            bits of the hardware, for any memory and any number of contexts. All cores work on them.

        Raises:
            ValueError: another type or shape; a ray with ``flags``, a ``cull_mask`` or a ``base`` out of range.
            KeyboardInterrupt: after Ctrl-C.

        Warns:
            UserWarning: a ray begins beyond the ``reach`` of the scene."""
    def query(self, scene: UnitScene, rays: _Rays, *, flags: int = 0) -> Query:
        """Rays whose caller decides about candidates, for a unit with ``queries="full"``.

        Args:
            scene: the memory that the unit reads.
            rays: rays of ``scene.rays``.
            flags: ``raypath.RayFlags`` beside those of the rays.

        Returns:
            A ``raypath.Query``: iterate over it for candidates, and then take its ``hits``.

        Raises:
            ValueError: another type or shape; a ray with ``flags``, a ``cull_mask`` or a ``base`` out of range.

        Warns:
            UserWarning: a ray begins beyond the ``reach`` of the scene."""
    def simulate(
        self,
        scene: UnitScene,
        rays: _Rays,
        *,
        latency: int = 100,
        bandwidth: int | None = None,
        cache: int | None = None,
        cache_ways: int = 4,
        cache_line: int | None = None,
        cache_misses: int = 32,
        units: int = 1,
        shared_cache: int | None = None,
    ) -> tuple[UnitHits, _Simulation]:
        """Traces rays by the cycle-exact model with a memory, and measures. Rays are offered in order as soon as the unit
        is ready, and hits are taken at once.

        Args:
            scene: the memory that the unit reads.
            rays: rays of ``scene.rays``.
            latency: cycles from a request to the first beat of its block, 1 to 1,000,000; with a cache, of a miss.
            bandwidth: the bytes that arrive from the memory in a cycle, 1 to 65,536; as many as the unit takes by
                default.
            cache: the bytes of the cache of each unit; none by default.
            shared_cache: the bytes of a cache that all units share, behind those of the units; none by default.
            cache_ways: the ways of the caches: 1, 2, 4 or 8.
            cache_line: the bytes of a line of the caches: a block, or 2 or 4; a block by default.
            cache_misses: the lines that a cache fetches at a time: a power of two from 2 to 64.
            units: the units that share the memory, 1 to 64.

        Returns:
            The hits, as those of ``trace``, and a dictionary of what was measured: ``cycles``, ``rays``, ``boxes`` and
            ``triangles`` (jobs of the datapath), ``steps``, ``fetches``, ``beats`` (of the memory), ``cache_hits``,
            ``cache_merges`` (requests that joined a miss), ``cache_misses``, ``rays_in_flight`` (the mean) and
            ``jobs_per_cycle``.

        Raises:
            ValueError: another type or shape; an argument out of range.
            KeyboardInterrupt: after Ctrl-C."""
    def card(self) -> dict[str, Any]:
        """The figures for architecture simulators, as ``Datapath.card`` has them."""
    def search(
        self,
        base: _Numbers | NDArray[np.float16] | NDArray[np.int8] | SavedGraph,
        queries: _Numbers | NDArray[np.float16] | NDArray[np.int8],
        k: int = 10,
        *,
        metric: Literal["euclidean", "dot", "cosine"] = "euclidean",
        index: Literal["hnsw", "boxes", "keys"] | None = None,
        ef: int | None = None,
        connections: int = 16,
        ef_construction: int = 200,
        seed: int = 1,
        scale: float = 1.0,
        bound: float = ...,
        radius: float | None = None,
        latency: int | None = None,
    ) -> UnitSearch:
        """Finds the nearest vectors of each query by jobs of the unit, which needs ``search`` among its parameters, as
        ``raypath.Unit(search="k=32,m=64")``.

        Without a graph, a query is compared with all vectors. A graph is searched best-first, from its lowest layer on.

        Args:
            base: the vectors: an array of shape (n, d) of float32, float16, or int8 with a ``scale``, as they are in
                memory; or a ``raypath.SavedGraph``.
            queries: an array of shape (m, d), of the same type. With a ``SavedGraph``, their type is that of the elements in
                memory, to which its vectors are rounded.
            k: the most neighbours of a query, 1 to n and to the ``k`` of the unit.
            metric: "euclidean", "dot" or "cosine". Dot products and cosines are ordered from the greatest.
            index: None, "hnsw" to build a graph of an array, or, for float32 and a unit with ``trees=1`` in ``search``, a
                tree: of "boxes" around vectors of 1 to 3 dimensions, of which those within ``radius`` are found; or of
                "keys" (d = 1), of which the first k in each range are found in ascending order: a query is the least and
                the greatest key, so queries have the shape (m, 2), and distances are the keys.
            ef: the candidates that are kept in a graph, k to the ``m`` of the unit; 5 * k, if the unit has as many.
            connections: the connections of a vector in the graph, 2 to 255; twice as many in its lowest layer.
            ef_construction: the candidates that are kept during construction, 1 to 65,536.
            seed: the seed of the graph.
            scale: an integer of int8 stands for as many times this.
            bound: only vectors are neighbours whose rank is at most this: the squared distance of the elements, minus
                the dot product, or the rank of the cosine. Trees have their own.
            radius: the greatest distance of a neighbour in a tree of boxes.
            latency: cycles of the memory, with which the jobs run through the cycle-exact model, too; None for the
                functional model alone.

        Returns:
            The neighbours (``ids``, ``distances``), the work (``evaluations``, ``beats``, ``bytes``, ``expansions``,
            ``seconds``), the ``timing``, and what hardware reads (``memory``, ``jobs``).

        Raises:
            ValueError: another type or shape; a number that is not finite; an argument out of range; a unit without
                searches.
            KeyboardInterrupt: after Ctrl-C.

        Example:
            >>> import numpy as np, raypath
            >>> unit = raypath.Unit(search="k=8,m=16,dimensions=64")
            >>> base = np.float16([[0, 0], [3, 4], [1, 0]])
            >>> found = unit.search(base, base[:1], k=3)
            >>> found.ids, found.distances
            (array([[0, 2, 1]]), array([[0., 1., 5.]], dtype=float32))"""
    def generate(self, folder: str | os.PathLike[str]) -> int:
        """Writes SystemVerilog, assertions, the AXI4 wrapper and manifests, as ``raypath generate --unit`` does.

        Args:
            folder: the folder to write to, which is created if it does not exist.

        Returns:
            The number of files.

        Raises:
            OSError: a file or folder that cannot be written; then no file is changed."""
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class UnitOutputs:
    """The outputs of a ``UnitModel`` in a cycle."""
    @property
    def idle(self) -> bool:
        """Whether no ray is in the unit."""
    @property
    def ray_ready(self) -> bool:
        """Whether a ray is accepted in this cycle."""
    @property
    def hit_id(self) -> int | None:
        """The number of the ray that has ended, or None."""
    @property
    def hit(self) -> _Hit | None:
        """Its hit, with the fields of ``UnitHits``, or None."""
    @property
    def candidate(self) -> tuple[int, int, _Candidate] | None:
        """A candidate at the outputs: the tag of its verdict, the number of its ray, and its fields by name; or None."""
    @property
    def request(self) -> tuple[int, int] | None:
        """The address of a block that is requested and the tag of its response, or None."""
    @property
    def searches_idle(self) -> bool:
        """Whether no job of a search is in the unit."""
    @property
    def job_ready(self) -> bool:
        """Whether a job of a search is accepted in this cycle."""
    @property
    def result(self) -> dict[str, Any] | None:
        """A result of a search: the number of its job, its ``rank`` from 0, ``index`` and ``distance`` (None if the job has
        no neighbours), whether it is the ``last``, and with the last the ``status``: 0 complete, 1 refused, 2 an error of
        the memory. Or None."""
    @property
    def vector_request(self) -> tuple[int, int] | None:
        """The address of a block of 64 bytes that a search requests and the tag of its response, or None."""

@final
class UnitModel:
    """The cycle-exact model of a traversal unit. In every cycle its outputs are those of the hardware.

    A cycle is a ``step``. The caller is the memory: it answers requests with beats of blocks of 128 bytes, or 64
    with quantised nodes. A model belongs to one thread at a time.

    Args:
        unit: the unit, which other models may share.

    Example:
        >>> import numpy as np, raypath
        >>> unit = raypath.Unit(memory_width=1024)
        >>> scene = unit.scene(np.float32([[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]]))
        >>> model = raypath.UnitModel(unit)
        >>> outputs = model.step(scene.rays(np.float32([[0, 0, 4]]), np.float32([[0, 0, -1]]))[0], ray_id=7)
        >>> while outputs.hit is None:
        ...     response = None
        ...     if outputs.request:
        ...         address, tag = outputs.request
        ...         response = tag, scene.data[address : address + 128]
        ...     outputs = model.step(response=response)
        >>> outputs.hit_id, outputs.hit["t"], model.counts["boxes"], model.counts["triangles"]
        (7, 4.0, 1, 1)"""
    def __new__(cls, unit: Unit) -> UnitModel: ...
    @property
    def outputs(self) -> UnitOutputs:
        """The outputs in this cycle. They depend on earlier cycles alone."""
    @property
    def counts(self) -> dict[str, int]:
        """What the unit did since its last reset: ``cycles``, ``boxes`` and ``triangles`` (jobs of the datapath),
        ``steps``, ``fetches``, ``rays`` (that ended) and ``restarts`` (descents that began again, because the stack had
        lost a level); ``rays_inside`` and their sum over all cycles, ``ray_cycles``; the cycles in which a ray
        (``ray_stalls``), a hit, a request or a job waited."""
    def step(
        self,
        ray: _Ray | None = None,
        ray_id: int = 0,
        *,
        response: tuple[int, bytes] | None = None,
        response_error: bool = False,
        hit_ready: bool = True,
        candidate_ready: bool = True,
        verdict: tuple[int, bool, bool, float] | None = None,
        request_ready: bool = True,
        flush: bool = False,
        job: tuple[int, int] | None = None,
        result_ready: bool = True,
        vector_request_ready: bool = True,
        vector_response: tuple[int, bytes] | None = None,
        vector_response_error: bool = False,
    ) -> UnitOutputs:
        """One clock cycle.

        Args:
            ray: an item of ``scene.rays`` that is offered in this cycle. It is accepted if ``ray_ready`` is true; offer
                it again otherwise.
            ray_id: the number of the ray, with at most ``id_width`` bits, which comes out with its hit.
            response: the tag of a request and the bytes of a beat, an eighth of ``memory_width``. The beats of a block
                arrive in order, in any cycle after that of the request.
            response_error: whether the memory has no valid data for the beat.
            hit_ready: whether a hit at the outputs is taken. It stays there otherwise.
            candidate_ready: whether a candidate at the outputs is taken. It stays there otherwise.
            verdict: the tag of a candidate that was taken, whether it is accepted, whether its ray ends, and the distance
                of the hit of a box.
            request_ready: whether a request at the outputs is taken. It stays there otherwise.
            flush: drops all rays, from the next cycle until the unit is idle. Beats and verdicts that are owed must
                still come.
            job: the number and the address of a job of a search that is offered, in a unit with ``search``. It is
                accepted if the outputs say so.
            result_ready: whether a result at the outputs is taken. It stays there otherwise.
            vector_request_ready: the same for a request of a block of searches.
            vector_response: as ``response``, for requests of searches.
            vector_response_error: whether that beat has no valid data.

        Returns:
            The outputs in the cycle that has passed: with the defaults, what the unit has delivered.

        Raises:
            ValueError: an item that is not a ray; a number of too many bits; a beat of another size, or with the tag of
                no request that waits for one; a verdict with the tag of no candidate that was taken. Then no cycle
                passes."""
    def run(
        self,
        cycles: int,
        rays: _Rays | None = None,
        ray_ids: NDArray[np.integer[Any]] | None = None,
        *,
        scene: UnitScene | None = None,
        latency: int = 100,
        hit_ready: NDArray[np.bool_] | None = None,
        request_ready: NDArray[np.bool_] | None = None,
    ) -> _Run:
        """Many cycles at once: rays are offered in order, each until it is accepted, and a scene answers requests in
        order. Of candidates, triangles are accepted and boxes ignored.

        Args:
            cycles: the number of cycles.
            rays: rays of ``scene.rays``; none by default.
            ray_ids: uint64 array of shape (n,): the number of each ray; their places by default.
            scene: the memory; without one, requests are not answered.
            latency: cycles from a request that is taken to the first beat of its block, at least 1.
            hit_ready: bool array of shape (cycles,): whether a hit at the outputs is taken in each cycle; always by
                default.
            request_ready: the same for requests.

        Returns:
            A dictionary: ``accepted``, the number of rays that were accepted; ``hits``, those that were taken, with
            ``hit_ids`` and ``hit_cycles``; ``request_addresses`` and ``request_cycles`` of the requests that were
            taken. Cycles are numbered from 0 in each call.

        Raises:
            ValueError: another type or shape; a number of too many bits; a latency of 0.
            KeyboardInterrupt: after Ctrl-C."""
    def skip(self, cycles: int) -> int:
        """Advances cycles in which no ray is offered, no beat arrives and nothing is taken, and stops in the first with a
        hit, a candidate or a request at the outputs, or in which a ray is accepted and was not before. Cycles in which the unit
        waits for the memory take no time.

        Args:
            cycles: the maximum number of cycles.

        Returns:
            The number of cycles."""
    def save(self) -> bytes:
        """The whole state as bytes, for ``restore``. Blocks that ``run`` has not yet answered are not part of it."""
    def restore(self, state: bytes) -> None:
        """Takes over a state that a model of an equal unit saved, in this release of raypath.

        Raises:
            ValueError: other bytes. Then nothing changes."""
    def reset(self) -> None:
        """A cycle of reset: all rays are lost, and requests get no response."""

@final
class Scene:
    """A mesh with the tree of its boxes, which ``render`` and ``trace`` take.

    It does not change, so that threads can share it. A scene that was pickled builds its tree again.

    Args:
        vertices: float32 array of shape (n, 3): finite coordinates of magnitude at most 2**40.
        faces: uint32 array of shape (n, 3): the vertices of each triangle, counter-clockwise as seen from its front.

    Raises:
        ValueError: another type or shape; a face of a vertex that does not exist; a coordinate out of range.
        KeyboardInterrupt: after Ctrl-C. The building of a tree then ends in a thread of its own.

    Example:
        >>> import numpy as np, raypath
        >>> scene = raypath.Scene(np.float32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
        >>> rays = raypath.rays(np.float32([[0, 0, 4], [9, 0, 4]]), np.float32([[0, 0, -1], [0, 0, -1]]))
        >>> hits = raypath.trace(scene, rays)
        >>> hits.triangle, hits.t
        (array([ 0, -1], dtype=int32), array([ 4., inf], dtype=float32))"""
    def __new__(cls, vertices: _Numbers, faces: NDArray[np.integer[Any]]) -> Scene: ...
    def __len__(self) -> int: ...
    def __getnewargs__(self) -> tuple[_Float32, NDArray[np.uint32]]: ...

@final
class Rendering:
    """A rendered picture with its cost and its simulated timing."""
    @property
    def image(self) -> NDArray[np.uint8]:
        """uint8 array of shape (height, width, 3): sRGB pixels, rows from the top. Each access makes a new array."""
    @property
    def jobs(self) -> NDArray[np.uint32]:
        """uint32 array of shape (height, width): the number of jobs of each pixel, with its secondary rays. Each access
        makes a new array."""
    @property
    def rays(self) -> list[_Traced]:
        """A row for each kind of rays ("primary", "shadow", "occlusion") that were traced: ``kind``, ``rays``, ``hits``,
        the jobs ``quadbox``, ``triangle`` and ``behind`` (second jobs of triangles, for hits from behind), and the
        fetches ``nodes`` and ``leaves``."""
    @property
    def timing(self) -> _Timing | None:
        """The figures of the simulation (see ``raypath.render``), or None without ``timed``. An agent is a pixel."""
    def _repr_png_(self) -> bytes: ...

@final
class Trace:
    """The closest hits of n rays, and their simulated timing.

    They have a length, iterate, and index: by a field's name, by a number for one, by a slice or an array for
    several. ``pandas.DataFrame(hits.array)`` has a column for each field of one number."""
    def __new__(cls, array: NDArray[np.void], timing: _Timing | None = None) -> Trace: ...
    @property
    def array(self) -> NDArray[np.void]:
        """The structured array of shape (n,), of which the other attributes are views."""
    @property
    def triangle(self) -> NDArray[np.int32]:
        """int32 array of shape (n,): the index of the triangle that is hit; -1 for a miss."""
    @property
    def t(self) -> _Float32:
        """float32 array of shape (n,): the distance of the hit in units of the direction's length; infinity for a miss."""
    @property
    def t_num(self) -> _Float32:
        """float32 array of shape (n,): the numerator of the distance; 0 for a miss."""
    @property
    def t_denom(self) -> _Float32:
        """float32 array of shape (n,): the denominator of the distance; 0 for a miss."""
    @property
    def back_face(self) -> NDArray[np.bool_]:
        """bool array of shape (n,): whether the ray hits the triangle from behind."""
    @property
    def timing(self) -> _Timing | None:
        """The figures of the simulation (see ``raypath.render``), or None without ``timed``. An agent is a ray."""
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[np.void]: ...
    @overload
    def __getitem__(self, key: str, /) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, key: _Number, /) -> np.void: ...
    @overload
    def __getitem__(self, key: _Several, /) -> Trace: ...

@final
class SavedGraph:
    """Vectors with the lowest layer of an HNSW graph, which ``raypath.read_graph`` reads. It does not change."""
    @property
    def vectors(self) -> NDArray[np.float32]:
        """float32 array of shape (n, d): the vectors, in the order of their labels. Each access makes a new array."""
    @property
    def neighbours(self) -> list[list[int]]:
        """The indices of the vectors near each vector, a list for each."""
    @property
    def degree(self) -> int:
        """The most neighbours of a vector."""
    @property
    def entry(self) -> int:
        """The index of the vector with which a search begins."""

@final
class UnitSearch:
    """The neighbours of m queries, as a unit finds them."""
    @property
    def ids(self) -> NDArray[np.int64]:
        """int64 array of shape (m, k): the indices of the neighbours of each query, the best first. -1 where there are
        fewer. Each access makes a new array."""
    @property
    def distances(self) -> NDArray[np.float32]:
        """float32 array of shape (m, k): their Euclidean distances, dot products, or cosines; NaN where there is no
        neighbour. Each access makes a new array."""
    @property
    def evaluations(self) -> int:
        """The number of vectors that were compared with queries."""
    @property
    def beats(self) -> int:
        """The number of their beats, each a job of the datapath."""
    @property
    def bytes(self) -> int:
        """The number of bytes that were read."""
    @property
    def expansions(self) -> int:
        """The number of candidates whose neighbours were read."""
    @property
    def seconds(self) -> float:
        """The wall-clock time of the functional model in seconds."""
    @property
    def memory(self) -> builtins.bytes:
        """What the unit read: vectors, lists and jobs, the first byte at address 0. Each access makes a copy."""
    @property
    def jobs(self) -> NDArray[np.uint32]:
        """uint32 array of shape (m,): the addresses of the jobs in ``memory``. Each access makes a new array."""
    @property
    def timing(self) -> dict[str, float] | None:
        """With ``latency``, what the cycle-exact model measured: ``cycles``, ``beats`` (of the datapath),
        ``memory_beats`` and ``beats_per_cycle``; otherwise None."""

def render(
    scene: Scene,
    *,
    eye: Sequence[float] | None = None,
    target: Sequence[float] = ...,
    up: Sequence[float] = ...,
    fov: float = 36.0,
    size: tuple[int, int] = ...,
    shadows: bool = False,
    ao: int = 0,
    samples: int = 1,
    two_sided: bool = False,
    seed: int = 1,
    datapath: Datapath | None = None,
    rays_in_flight: int = 256,
    memory_latency: int = 100,
    timed: int = 0,
) -> Rendering:
    """Renders a scene with the operations of a datapath; with ``timed``, also simulates the timing.

    The work is that of ``raypath render``: the box and triangle tests are jobs of the datapath; the stack of a ray, the
    division and the shading are done in software and take no time in the simulation. The simulation keeps
    ``rays_in_flight`` pixels before the pipeline, and every fetch of a node or leaf takes ``memory_latency`` cycles.

    Args:
        scene: the mesh.
        eye: the position of the camera; without it, the camera sees the whole mesh, and ``target``, ``up`` and ``fov``
            count for nothing.
        target: the point at which the camera looks; the origin by default.
        up: the direction that is upwards in the picture.
        fov: the vertical field of view in degrees, more than 0 and less than 180.
        size: width and height in pixels.
        shadows: whether to trace a ray from each hit towards the sun.
        ao: the number of ambient-occlusion rays from each hit, 0 to 4096.
        samples: samples per pixel along each axis, 1 to 64.
        two_sided: whether triangles are hit from behind too.
        seed: the seed of ambient-occlusion rays.
        datapath: a datapath in fp32 without features; the preset ``paper`` by default.
        rays_in_flight: the number of pixels in flight in the simulation, at least 1.
        memory_latency: cycles of a fetch in the simulation.
        timed: the number of evenly spread pixels that are simulated; none by default.

    Returns:
        The picture (``image``, also shown by notebooks), the jobs of each pixel (``jobs``), the rays with their hits
        and jobs by kind (``rays``) and the ``timing``. The latter has ``in_flight``, ``memory_latency``, ``agents``
        (simulated pixels), ``cycles``, ``jobs`` and the jobs of each operation, ``jobs_per_cycle``,
        ``agents_per_cycle``, ``mean_latency`` (of a job, in cycles), ``fetches``, and the use of the cycles: a job was
        ``accepted`` or ``refused``, or none was offered because all agents waited for memory (``starved_memory``), all
        for outcomes (``starved_outcomes``), or some for each (``starved_both``).

    Raises:
        ValueError: an argument out of range.
        KeyboardInterrupt: after Ctrl-C.

    Warns:

    Example:
        >>> import numpy as np, raypath
        >>> scene = raypath.Scene(np.float32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
        >>> picture = raypath.render(scene, eye=(0, 0, 4), size=(64, 48), timed=4000)
        >>> picture.image.shape, picture.timing["quadbox"]
        ((48, 64, 3), 3072)"""

def trace(
    scene: Scene,
    rays: _Rays,
    *,
    two_sided: bool = False,
    datapath: Datapath | None = None,
    rays_in_flight: int = 256,
    memory_latency: int = 100,
    timed: int = 0,
) -> Trace:
    """Traces rays to their closest hits with the operations of a datapath; with ``timed``, also simulates the timing.

    Args:
        scene: the mesh.
        rays: rays of ``raypath.rays``.
        two_sided: whether triangles are hit from behind too.
        datapath: a datapath in fp32 without features; the preset ``paper`` by default.
        rays_in_flight: the number of rays in flight in the simulation, at least 1.
        memory_latency: cycles of a fetch in the simulation.
        timed: the number of evenly spread rays that are simulated; none by default.

    Returns:
        The hits (``triangle``, ``t``, ``t_num``, ``t_denom``, ``back_face``) and the ``timing``, as that of
        ``raypath.render``.

    Raises:
        ValueError: another type or shape; an argument out of range.
        KeyboardInterrupt: after Ctrl-C.

    Warns:

    Example:
        See ``raypath.Scene``."""

def read_graph(path: str | os.PathLike[str]) -> SavedGraph:
    """Reads a graph that ``hnswlib`` saved (``save_index``, vectors of floats) or an ``IndexHNSWFlat`` of ``faiss``
    (``write_index``). Labels are 0 to the number of vectors - 1, in any order.

    Args:
        path: the file.

    Returns:
        The graph, which ``Unit.search`` searches.

    Raises:
        ValueError: a file that cannot be read, is no such graph, or takes more than 2 GiB of memory."""
