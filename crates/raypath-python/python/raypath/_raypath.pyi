import os
from collections.abc import Sequence
from typing import Any, Literal, final

import numpy as np
from numpy.typing import NDArray

_Float32 = NDArray[np.float32]
_Rays = NDArray[np.void]
_Row = dict[str, Any]

__all__ = [
    "RAY",
    "UNIT_RAY",
    "VERSION",
    "Datapath",
    "Job",
    "Outcome",
    "Pipeline",
    "QuadboxHits",
    "Rendering",
    "Search",
    "Trace",
    "TriangleHits",
    "Unit",
    "UnitHits",
    "UnitModel",
    "UnitOutputs",
    "UnitScene",
    "main",
    "operations",
    "parameters",
    "presets",
    "rays",
    "render",
    "rust_seconds",
    "search",
    "trace",
]

RAY: np.dtype[np.void]
UNIT_RAY: np.dtype[np.void]
VERSION: str

def main(arguments: Sequence[str]) -> int: ...
def rust_seconds(
    operation: str, first: NDArray[Any], second: NDArray[Any], repetitions: int
) -> tuple[float, float, float]: ...
def operations() -> list[_Row]: ...
def parameters() -> list[_Row]: ...
def presets() -> list[_Row]: ...
def rays(origins: _Float32, directions: _Float32, extent: float | _Float32 | None = None) -> _Rays: ...

@final
class Datapath:
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
        unit_latency: Literal[1, 2, 3] = ...,
        clock_gating: bool = ...,
        multiplier: Literal["booth", "inferred"] = ...,
        tag: int = ...,
        barycentrics: bool = ...,
        culling: Literal["back", "front", "none"] = ...,
        facing: bool = ...,
        range: bool = ...,
        conservative: bool = ...,
        quantised_boxes: bool = ...,
        accumulators: Literal[1, 2, 4, 8, 16] = ...,
        exception_flags: bool = ...,
    ) -> Datapath: ...
    @property
    def latency(self) -> int: ...
    @property
    def flip_flops(self) -> int: ...
    @property
    def lanes(self) -> int: ...
    @property
    def operations(self) -> list[str]: ...
    @property
    def config(self) -> str: ...
    def quadbox(self, rays: _Rays, boxes: _Float32) -> QuadboxHits: ...
    def triangle(self, rays: _Rays, triangles: _Float32) -> TriangleHits: ...
    def euclidean(self, a: _Float32, b: _Float32) -> _Float32: ...
    def angular(self, q: _Float32, c: _Float32) -> tuple[_Float32, _Float32]: ...
    def run(self, operation: str, /, **ports: Any) -> dict[str, NDArray[Any]]: ...
    def generate(self, folder: str | os.PathLike[str]) -> int: ...
    def schedule(self) -> list[_Row]: ...
    def units(self) -> list[_Row]: ...
    def registers(self) -> list[_Row]: ...
    def ports(self) -> list[_Row]: ...
    def _repr_svg_(self) -> str: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class QuadboxHits:
    @property
    def array(self) -> NDArray[np.void]: ...
    @property
    def is_intersect(self) -> NDArray[np.bool_]: ...
    @property
    def tmin(self) -> _Float32: ...
    @property
    def box_index(self) -> NDArray[np.uint8]: ...
    def __len__(self) -> int: ...

@final
class TriangleHits:
    @property
    def array(self) -> NDArray[np.void]: ...
    @property
    def triangle_hit(self) -> NDArray[np.bool_]: ...
    @property
    def t_num(self) -> _Float32: ...
    @property
    def t_denom(self) -> _Float32: ...
    def __len__(self) -> int: ...

@final
class Job:
    @staticmethod
    def quadbox(ray: Any, boxes: _Float32) -> Job: ...
    @staticmethod
    def triangle(ray: Any, triangle: _Float32) -> Job: ...
    @staticmethod
    def euclidean(a: _Float32, b: _Float32, *, mask: int | None = None, reset: bool = True) -> Job: ...
    @staticmethod
    def angular(q: _Float32, c: _Float32, *, mask: int | None = None, reset: bool = True) -> Job: ...
    @staticmethod
    def words(datapath: Datapath, operation: str, /, **ports: Any) -> Job: ...
    @staticmethod
    def timing(datapath: Datapath, operation: str) -> Job: ...

@final
class Outcome:
    @property
    def tag(self) -> int: ...
    @property
    def operation(self) -> str: ...
    @property
    def values(self) -> dict[str, Any]: ...

@final
class Pipeline:
    def __new__(cls, datapath: Datapath) -> Pipeline: ...
    @property
    def occupancy(self) -> int: ...
    @property
    def output_valid(self) -> bool: ...
    def offer(self, job: Job, tag: int = 0) -> bool: ...
    def step(self, output_ready: bool = True) -> Outcome | None: ...
    def skip(self, cycles: int) -> int: ...
    def input_ready(self, operation: str) -> bool: ...
    def reset(self) -> None: ...

@final
class UnitScene:
    def __new__(cls, data: bytes, root: int) -> UnitScene: ...
    @property
    def data(self) -> bytes: ...
    @property
    def root(self) -> int: ...
    def rays(
        self,
        origins: _Float32,
        directions: _Float32,
        *,
        t_min: float = 0.0,
        t_max: float = ...,
        any_hit: bool = False,
        cull: Literal["none", "back", "front", "both"] = "none",
    ) -> _Rays: ...
    def __len__(self) -> int: ...

@final
class UnitHits:
    @property
    def array(self) -> NDArray[np.void]: ...
    @property
    def status(self) -> NDArray[np.uint32]: ...
    @property
    def triangle(self) -> NDArray[np.uint32]: ...
    @property
    def instance(self) -> NDArray[np.uint32]: ...
    @property
    def t(self) -> _Float32: ...
    @property
    def t_num(self) -> _Float32: ...
    @property
    def t_denom(self) -> _Float32: ...
    @property
    def u(self) -> _Float32: ...
    @property
    def v(self) -> _Float32: ...
    @property
    def back_face(self) -> NDArray[np.bool_]: ...
    @property
    def nodes(self) -> NDArray[np.uint32]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    def __len__(self) -> int: ...

@final
class Unit:
    def __new__(
        cls,
        preset: str | None = None,
        *,
        config: str | os.PathLike[str] | None = None,
        contexts: int = ...,
        stack: Literal[2, 4, 8, 16, 32] = ...,
        memory_width: Literal[128, 256, 512, 1024] = ...,
        id_width: int = ...,
        divider_latency: int = ...,
        node: Literal["wide4", "quantised"] = ...,
        instances: bool = ...,
        registers: Literal["ieee", "recoded"] = ...,
        control: Literal["skid", "credit"] = ...,
        sharing: Literal["union", "segregated"] = ...,
        unit_latency: Literal[1, 2, 3] = ...,
        barycentrics: bool = ...,
    ) -> Unit: ...
    @property
    def parameters(self) -> _Row: ...
    def scene(
        self,
        triangles: _Float32,
        *,
        reach: float | None = None,
        instances: NDArray[np.float64] | None = None,
    ) -> UnitScene: ...
    def trace(self, scene: UnitScene, rays: _Rays) -> UnitHits: ...
    def simulate(
        self,
        scene: UnitScene,
        rays: _Rays,
        *,
        latency: int = 100,
        bandwidth: int | None = None,
        cache: int | None = None,
        cache_ways: int = 4,
        cache_line: int = 128,
        cache_latency: int = 8,
    ) -> tuple[UnitHits, _Row]: ...
    def generate(self, folder: str | os.PathLike[str]) -> int: ...

@final
class UnitOutputs:
    @property
    def ray_ready(self) -> bool: ...
    @property
    def hit_id(self) -> int | None: ...
    @property
    def hit(self) -> _Row | None: ...
    @property
    def request(self) -> tuple[int, int] | None: ...

@final
class UnitModel:
    def __new__(cls, unit: Unit) -> UnitModel: ...
    @property
    def outputs(self) -> UnitOutputs: ...
    @property
    def counts(self) -> dict[str, int]: ...
    def step(
        self,
        ray: Any = None,
        ray_id: int = 0,
        *,
        response: tuple[int, bytes] | None = None,
        response_error: bool = False,
        hit_ready: bool = True,
        request_ready: bool = True,
    ) -> UnitOutputs: ...
    def skip(self, cycles: int) -> int: ...
    def reset(self) -> None: ...

@final
class Rendering:
    @property
    def image(self) -> NDArray[np.uint8]: ...
    @property
    def jobs(self) -> NDArray[np.uint32]: ...
    @property
    def rays(self) -> list[_Row]: ...
    @property
    def timing(self) -> _Row | None: ...
    def _repr_png_(self) -> bytes: ...

@final
class Trace:
    @property
    def triangle(self) -> NDArray[np.int64]: ...
    @property
    def t(self) -> _Float32: ...
    @property
    def from_behind(self) -> NDArray[np.bool_]: ...
    @property
    def timing(self) -> _Row | None: ...
    def __len__(self) -> int: ...

@final
class Search:
    @property
    def ids(self) -> NDArray[np.int64]: ...
    @property
    def distances(self) -> NDArray[np.float64]: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def beats(self) -> int: ...
    @property
    def seconds(self) -> float: ...
    @property
    def timing(self) -> _Row | None: ...

def render(
    vertices: _Float32,
    faces: NDArray[np.uint32],
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
    timed: int = 50000,
) -> Rendering: ...
def trace(
    vertices: _Float32,
    faces: NDArray[np.uint32],
    rays: _Rays,
    *,
    two_sided: bool = False,
    datapath: Datapath | None = None,
    rays_in_flight: int = 256,
    memory_latency: int = 100,
    timed: int = 50000,
) -> Trace: ...
def search(
    vectors: _Float32,
    queries: _Float32,
    k: int = 10,
    *,
    metric: Literal["euclidean", "angular"] = "euclidean",
    index: Literal["hnsw"] | None = None,
    connections: int = 16,
    ef_construction: int = 200,
    ef: int | None = None,
    seed: int = 1,
    datapath: Datapath | None = None,
    queries_in_flight: int = 32,
    memory_latency: int = 100,
    timed: int | None = None,
) -> Search: ...
