//! Readers of meshes and rays.

use raypath_ops::Ray;
use raypath_render::{Format, Goal, Mesh, Scene, Tracer, Tracing, UnitErrors, parse_mesh, parse_rays, write_rays};
use raypath_tools::MemoryLimit;
use raypath_traversal::blocks::NodeKind;
use std::path::Path;

/// Larger meshes are read, but neither written nor traced, so that an input takes milliseconds.
const MAX_TRIANGLES: usize = 500;

/// libFuzzer ends a run that takes 2 GiB.
pub const LIMIT: MemoryLimit = MemoryLimit::of(256 << 20);

pub fn obj(bytes: &[u8]) -> bool {
    mesh(Format::Obj, bytes)
}

pub fn gltf(bytes: &[u8]) -> bool {
    mesh(Format::Gltf, bytes)
}

pub fn ply(bytes: &[u8]) -> bool {
    mesh(Format::Ply, bytes)
}

pub fn stl(bytes: &[u8]) -> bool {
    mesh(Format::Stl, bytes)
}

/// A mesh is the same after it was written as OBJ, and a ray through it has no impossible hit.
fn mesh(format: Format, bytes: &[u8]) -> bool {
    let Ok(mesh) = parse_mesh(format, bytes, Path::new("mesh"), LIMIT) else { return false };
    if mesh.triangles().len() <= MAX_TRIANGLES && mesh.positions().len() <= 3 * MAX_TRIANGLES {
        let again = parse_mesh(Format::Obj, obj_text(&mesh).as_bytes(), Path::new("again.obj"), LIMIT);
        assert_eq!(again.as_ref().map(corners), Ok(corners(&mesh)));
        trace(mesh);
    }
    true
}

/// The bits of the corners of all triangles, which do not depend on the numbering of vertices.
fn corners(mesh: &Mesh) -> Vec<[[u32; 3]; 3]> {
    (0..mesh.triangles().len() as u32).map(|index| mesh.corners(index).map(|corner| corner.map(f32::to_bits))).collect()
}

fn obj_text(mesh: &Mesh) -> String {
    let vertices = mesh.positions().iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = mesh.triangles().iter().map(|corners| {
        let [a, b, c] = corners.map(|corner| corner + 1);
        format!("f {a} {b} {c}\n")
    });
    vertices.chain(faces).collect()
}

fn trace(mesh: Mesh) {
    let count = mesh.triangles().len() as u32;
    let Ok(scene) = Scene::new(mesh) else { return };
    for nodes in [NodeKind::Wide4, NodeKind::Quantised] {
        // A box may have no quantised bounds.
        if let Ok(scene) = scene.clone().through_unit_of(nodes) {
            trace_corners(&scene, count);
        }
    }
    trace_corners(&scene, count);
}

/// Rays from two corners of the scene towards its centre: the unit ends none with an error.
fn trace_corners(scene: &Scene, triangles: u32) {
    let bounds = scene.bounds();
    let mut tracer = Tracer::new(scene, Tracing { two_sided: true, ..Tracing::default() });
    for corner in [bounds.min, bounds.max] {
        let centre = bounds.centre();
        let direction = std::array::from_fn(|axis| centre[axis] - corner[axis]);
        let Ok(ray) = Ray::new(corner, direction, f32::INFINITY) else { continue };
        if let Some(hit) = tracer.trace(&ray, Goal::Closest) {
            assert!(hit.triangle < triangles && hit.t >= 0.0, "{hit:?}");
        }
        assert_eq!(tracer.counts().errors, UnitErrors::default());
    }
}

/// Rays are the same after they were written.
pub fn rays(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let Ok(rays) = parse_rays(text, Path::new("rays.txt")) else { return false };
    let mut written = Vec::new();
    // Writing to memory cannot fail.
    let _ = write_rays(&mut written, &rays);
    let again = parse_rays(&String::from_utf8_lossy(&written), Path::new("again.txt"));
    assert_eq!(again.map(|rays| format!("{rays:?}")), Ok(format!("{rays:?}")));
    true
}
