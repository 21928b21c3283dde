//! Scenes of the traversal unit.

use crate::Unit;
use crate::memory::{array, free, reference, reference_mut};
use crate::status::{RAYPATH_OK, Status, address_or_null, status, value_or_zero};
use raypath_embed::{Bounds, SceneGeometry, SceneInput, SceneInstance, UnitScene};

/// A scene in memory, as a traversal unit reads it. It does not change, so any number of threads may use it at once,
/// until `raypath_scene_free`.
pub struct Scene(UnitScene);

/// Builds a scene in the layout that the unit reads, and sets `*scene`. Any thread may call it.
///
/// `vertices` has three numbers for each of `vertex_count` vertices, `indices` three vertices for each of
/// `triangle_count` triangles, counter-clockwise as seen from the front. Arrays after these may be NULL. `boxes` are
/// procedural boxes, for a unit with `queries = "full"`; one with a minimum above its maximum is the point in its middle.
/// `geometries` are those to which triangles and boxes belong in order; without, the triangles are one opaque geometry.
/// In a unit with `queries`, a triangle or a box is inactive that has a vertex or a corner whose x is NaN: it is not hit,
/// and counts in indices. With `instances` the scene has two levels, with all of it at each of `instance_count` places.
/// `reach` is the greatest distance, along any axis, between the origin of a ray and a vertex in a scene with instances;
/// 0 for 16 times its longest side. Rays from further away may lose hits at the edges of instances.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for an index of no vertex, a coordinate beyond 2^40, a matrix without an inverse, a
/// negative reach, nothing active, more than fits into 4 GiB, geometries with another number of triangles or boxes, a
/// word of an instance out of range, or what needs `instances` or `queries` for a unit without them;
/// `RAYPATH_ERROR_NULL`, `_ALIGNMENT`. Then `*scene` is not changed.
///
/// # Safety
/// `unit` is NULL or an open unit; the arrays are NULL or have that many elements; `scene` is NULL or points to a
/// pointer.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // arrays of C
pub unsafe extern "C" fn raypath_scene_build(
    unit: *const Unit,
    vertices: *const [f32; 3],
    vertex_count: usize,
    indices: *const [u32; 3],
    triangle_count: usize,
    boxes: *const Bounds,
    box_count: usize,
    geometries: *const SceneGeometry,
    geometry_count: usize,
    instances: *const SceneInstance,
    instance_count: usize,
    reach: f32,
    scene: *mut *mut Scene,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (unit, vertices, triangles, boxes, geometries, scene) = unsafe {
            (
                reference("unit", unit)?,
                array("vertices", vertices, vertex_count)?,
                array("indices", indices, triangle_count)?,
                array("boxes", boxes, box_count)?,
                array("geometries", geometries, geometry_count)?,
                reference_mut("scene", scene)?,
            )
        };
        // SAFETY: as above.
        let placed = || unsafe { array("instances", instances, instance_count) };
        let instances = if instances.is_null() && instance_count == 0 { None } else { Some(placed()?.to_vec()) };
        let reach = if reach == 0.0 { None } else { Some(reach) };
        let (vertices, triangles) = (vertices.to_vec(), triangles.to_vec());
        let (boxes, geometries) = (boxes.to_vec(), geometries.to_vec());
        let input = SceneInput { vertices, triangles, boxes, geometries, instances, reach };
        *scene = Box::into_raw(Box::new(Scene(unit.embedded.scene(input)?)));
        Ok(RAYPATH_OK)
    })
}

/// Builds a scene of scenes that `unit` reads, and sets `*scene`. Any thread may call it.
///
/// Each of `instance_count` instances places the scene whose number in `scenes` is its element of `members`. In a unit with
/// `nested-instances` the scenes may have instances themselves. Hits report the number of the instance. The scenes were
/// built for units with the same nodes, and are not needed afterwards. `reach` is that of `raypath_scene_build`; a scene
/// with instances must have been built for the reach that it has at its places.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for a scene that does not exist or has other nodes, no instance, a matrix, a word or a
/// reach out of range, a smaller reach, more than fits into 4 GiB or 64 levels, or a unit without what the scene needs;
/// `RAYPATH_ERROR_NULL`, `_ALIGNMENT`. Then `*scene` is not changed.
///
/// # Safety
/// `unit` is NULL or an open unit; the arrays are NULL or have that many elements; those of `scenes` are NULL or scenes;
/// `scene` is NULL or points to a pointer.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // arrays of C
pub unsafe extern "C" fn raypath_scene_group(
    unit: *const Unit,
    scenes: *const *const Scene,
    scene_count: usize,
    members: *const u32,
    instances: *const SceneInstance,
    instance_count: usize,
    reach: f32,
    scene: *mut *mut Scene,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (unit, scenes, members, instances, scene) = unsafe {
            (
                reference("unit", unit)?,
                array("scenes", scenes, scene_count)?,
                array("members", members, instance_count)?,
                array("instances", instances, instance_count)?,
                reference_mut("scene", scene)?,
            )
        };
        // SAFETY: as above.
        let member = |&member: &*const Scene| unsafe { reference("scenes", member) }.map(|Scene(scene)| scene);
        let scenes = scenes.iter().map(member).collect::<Result<Vec<&UnitScene>, _>>()?;
        let places: Vec<_> = members.iter().copied().zip(instances.iter().copied()).collect();
        let reach = if reach == 0.0 { None } else { Some(reach) };
        *scene = Box::into_raw(Box::new(Scene(unit.embedded.group(&scenes, &places, reach)?)));
        Ok(RAYPATH_OK)
    })
}

/// Frees a scene. NULL is ignored.
///
/// # Safety
/// `scene` is NULL or came from `raypath_scene_build` or `_group` and was not freed; no other call uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_scene_free(scene: *mut Scene) {
    // SAFETY: by the contract of this function.
    unsafe { free(scene) };
}

/// The bytes of a scene, the first of which has the address 0; NULL after an error. They are valid while the scene is.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_scene_data(scene: *const Scene) -> *const u8 {
    // SAFETY: by the contract of this function.
    address_or_null(|| Ok(unsafe { reference("scene", scene)? }.0.bytes.as_ptr()))
}

/// The number of its bytes; 0 after an error.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_scene_size(scene: *const Scene) -> usize {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("scene", scene)? }.0.bytes.len()))
}

/// The child word of its root, for `root` of a ray; 0 after an error.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_scene_root(scene: *const Scene) -> u32 {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("scene", scene)? }.0.root))
}

/// The reach for which it was built; 0 after an error.
///
/// # Safety
/// `scene` is NULL or a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_scene_reach(scene: *const Scene) -> f32 {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("scene", scene)? }.0.reach))
}
