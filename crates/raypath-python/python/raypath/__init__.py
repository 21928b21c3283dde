"""An open hardware ray-tracer datapath: its models, generator, renderer and vector search.

A :class:`Datapath` computes arrays of jobs, bit for bit as the hardware does, and writes the hardware. A
:class:`Pipeline` adds clock cycles. A :class:`Unit` is the traversal unit around a datapath: a ray goes in, its hit
comes out; a :class:`UnitModel` adds clock cycles. :func:`render` and :func:`trace` work on a :class:`Scene`,
:meth:`Unit.search` on vectors.

Example:
    >>> import numpy as np, raypath
    >>> datapath = raypath.Datapath(preset="paper")
    >>> rays = raypath.rays(np.float32([[0, 0, -5]]), np.float32([[0, 0, 1]]))
    >>> hits = datapath.quadbox(rays, np.float32([[[[-1, -1, -1], [1, 1, 1]]] * 4]))
    >>> hits.tmin
    array([[4., 4., 4., 4.]], dtype=float32)
"""

from raypath._queries import Candidates, Geometry, Instance, InstanceFlags, Query, RayFlags, UnitStatus
from raypath._raypath import (
    RAY,
    UNIT_RAY,
    VERSION,
    Datapath,
    Job,
    Outcome,
    Pipeline,
    QuadboxHits,
    Rendering,
    SavedGraph,
    Scene,
    Trace,
    TriangleHits,
    Unit,
    UnitHits,
    UnitModel,
    UnitOutputs,
    UnitScene,
    UnitSearch,
    operations,
    parameters,
    presets,
    rays,
    read_card,
    read_graph,
    render,
    trace,
)

__version__ = VERSION

__all__ = [
    "RAY",
    "UNIT_RAY",
    "Candidates",
    "Datapath",
    "Geometry",
    "Instance",
    "InstanceFlags",
    "Job",
    "Outcome",
    "Pipeline",
    "QuadboxHits",
    "Query",
    "RayFlags",
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
    "UnitStatus",
    "__version__",
    "operations",
    "parameters",
    "presets",
    "rays",
    "read_card",
    "read_graph",
    "render",
    "trace",
]
