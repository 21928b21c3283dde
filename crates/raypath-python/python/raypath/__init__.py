"""An open hardware ray-tracer datapath: its models, generator, renderer and vector search.

A :class:`Datapath` computes arrays of jobs, bit for bit as the hardware does, and writes the hardware. A
:class:`Pipeline` adds clock cycles. :func:`render`, :func:`trace` and :func:`search` work on meshes and vectors.

Example:
    >>> import numpy as np, raypath
    >>> datapath = raypath.Datapath(preset="paper")
    >>> rays = raypath.rays(np.float32([[0, 0, -5]]), np.float32([[0, 0, 1]]))
    >>> hits = datapath.quadbox(rays, np.float32([[[[-1, -1, -1], [1, 1, 1]]] * 4]))
    >>> hits.tmin
    array([[4., 4., 4., 4.]], dtype=float32)
"""

from raypath._raypath import (
    RAY,
    VERSION,
    Datapath,
    Job,
    Outcome,
    Pipeline,
    QuadboxHits,
    Rendering,
    Search,
    Trace,
    TriangleHits,
    operations,
    parameters,
    presets,
    rays,
    render,
    search,
    trace,
)

__version__ = VERSION

__all__ = [
    "RAY",
    "Datapath",
    "Job",
    "Outcome",
    "Pipeline",
    "QuadboxHits",
    "Rendering",
    "Search",
    "Trace",
    "TriangleHits",
    "__version__",
    "operations",
    "parameters",
    "presets",
    "rays",
    "render",
    "search",
    "trace",
]
