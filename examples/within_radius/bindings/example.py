"""A job of within_radius: points at distances 1 to 4, and the radius 2.5."""

# Before raypath, which then has the operation.
import within_radius  # noqa: F401, I001
import numpy as np
import raypath

datapath = raypath.Datapath(with_="within_radius")
points = {f"point_{i}_{axis}": np.float32([i + 1 if axis == "x" else 0]) for i in range(4) for axis in "xyz"}
found = datapath.run("within_radius", query_x=0, query_y=0, query_z=0, radius=np.float32([2.5]), **points)
print(f"near, as four bits: {found['is_near'][0]:x}")
