//! The traversal unit around a datapath: opening, arrays of rays, generation.

use crate::memory::{free, reference, reference_mut, required_text, text};
use crate::query::raypath_unit_trace_with;
use crate::status::{RAYPATH_OK, Status, address_or_null, status};
use raypath_embed::{Front, Queries, Unit as Embedded, UnitHit, UnitRay};
use std::ffi::{CString, c_char};
use std::path::Path;
use std::ptr;

/// A traversal unit: a ray goes in, its closest or any hit comes out. It does not change, so any number of threads may
/// use it at once, until `raypath_unit_close`.
pub struct Unit {
    pub(crate) embedded: Embedded,
    description: CString,
    digest: CString,
}

/// The parameters of a traversal unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct UnitParameters {
    /// Rays in flight.
    pub contexts: u32,
    /// Entries of the stack of each ray.
    pub stack: u32,
    /// Bytes of a block of the scene: 128, and with `node = "quantised"` 64.
    pub block_bytes: u32,
    /// Bits of a beat of the memory; a block has 8 · `block_bytes` / `memory_width` beats.
    pub memory_width: u32,
    /// Bits of the id of a ray.
    pub id_width: u32,
    /// Bits of an address.
    pub address_width: u32,
    /// Cycles of a division.
    pub divider_latency: u32,
    /// Cycles of a read of the memories of a step: 1 or 2.
    pub ram_latency: u32,
    /// Whether scenes have instances: 0 or 1.
    pub instances: u32,
    /// What it has of ray queries: 0 for `queries = "none"`, 1 for "flags", 2 for "full".
    pub queries: u32,
    /// Whether front faces run clockwise: 0 or 1.
    pub clockwise_front: u32,
    /// Whether the memories of a step have parity: 0 or 1.
    pub parity: u32,
}

/// `raypath_unit_hit`: no triangle is hit.
pub const RAYPATH_UNIT_MISS: u32 = 0;
/// A triangle is hit.
pub const RAYPATH_UNIT_HIT: u32 = 1;
/// A procedural box is hit, as the caller decided.
pub const RAYPATH_UNIT_PROCEDURAL: u32 = 2;
/// The ray is refused: a direction that cannot be inverted, a value that is not finite, a negative `t_min`, flags that
/// have no meaning together.
pub const RAYPATH_UNIT_REFUSED: u32 = 3;
/// The memory reported an error, or there is nothing at an address.
pub const RAYPATH_UNIT_MEMORY: u32 = 4;
/// The scene is not valid.
pub const RAYPATH_UNIT_SCENE: u32 = 5;
/// The ray has read as many nodes or triangles as it may.
pub const RAYPATH_UNIT_LIMIT: u32 = 6;

/// The `instance` of a `raypath_unit_hit` whose triangle is in none.
pub const RAYPATH_UNIT_NO_INSTANCE: u32 = 0xffff_ffff;

/// A bit of `flags` of `raypath_unit_ray`: every triangle counts as opaque.
pub const RAYPATH_RAY_OPAQUE: u32 = 1;
/// Every triangle counts as non-opaque.
pub const RAYPATH_RAY_NO_OPAQUE: u32 = 2;
/// The ray ends with the first block of triangles with a hit.
pub const RAYPATH_RAY_TERMINATE_ON_FIRST_HIT: u32 = 4;
/// Without an effect on traversal.
pub const RAYPATH_RAY_SKIP_CLOSEST_HIT_SHADER: u32 = 8;
/// Back faces are not hit.
pub const RAYPATH_RAY_CULL_BACK_FACING_TRIANGLES: u32 = 16;
/// Front faces are not hit.
pub const RAYPATH_RAY_CULL_FRONT_FACING_TRIANGLES: u32 = 32;
/// Triangles that count as opaque are not hit.
pub const RAYPATH_RAY_CULL_OPAQUE: u32 = 64;
/// Triangles that count as non-opaque are not hit.
pub const RAYPATH_RAY_CULL_NO_OPAQUE: u32 = 128;
/// Triangles are not hit.
pub const RAYPATH_RAY_SKIP_TRIANGLES: u32 = 256;
/// Procedural boxes are not hit.
pub const RAYPATH_RAY_SKIP_AABBS: u32 = 512;

/// A bit of `flags` of `raypath_unit_instance`: faces are not culled.
pub const RAYPATH_INSTANCE_FACING_CULL_DISABLE: u32 = 1;
/// Front and back faces are exchanged.
pub const RAYPATH_INSTANCE_FLIP_FACING: u32 = 2;
/// Its geometries count as opaque.
pub const RAYPATH_INSTANCE_FORCE_OPAQUE: u32 = 4;
/// Its geometries count as non-opaque.
pub const RAYPATH_INSTANCE_FORCE_NO_OPAQUE: u32 = 8;

/// Opens a traversal unit and sets `*unit`. `toml` has the keys of a configuration file, and those of the unit:
/// `contexts`, `stack`, `node`, `memory-width`, `id-width`, `address-width`, `divider-latency`, `ram-latency`,
/// `instances`, `queries`, `parity`, `front`. For example `preset = "compact"`, `contexts = 16` and `instances = true` in a
/// line each; NULL is the default. Of the features, a unit has `barycentrics` alone. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_CONFIGURATION` with the line of `toml`, or for a datapath that the unit does not have;
/// `RAYPATH_ERROR_NULL`. Then `*unit` is not changed.
///
/// # Safety
/// `toml` is NULL or a string; `unit` is NULL or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_open(toml: *const c_char, unit: *mut *mut Unit) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (toml, unit) = unsafe { (text("toml", toml)?, reference_mut("unit", unit)?) };
        let embedded = Embedded::open(toml.unwrap_or_default())?;
        let description = CString::new(embedded.description()).unwrap_or_default();
        let digest = CString::new(embedded.digest()).unwrap_or_default();
        *unit = Box::into_raw(Box::new(Unit { embedded, description, digest }));
        Ok(RAYPATH_OK)
    })
}

/// Closes a unit. NULL is ignored. Models of the unit remain usable.
///
/// # Safety
/// `unit` is NULL or came from `raypath_unit_open` and was not closed; no other call uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_close(unit: *mut Unit) {
    // SAFETY: by the contract of this function.
    unsafe { free(unit) };
}

/// The parameters of the unit and of its datapath in words. Valid while the unit is open; NULL after an error.
///
/// # Safety
/// `unit` is NULL or an open unit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_description(unit: *const Unit) -> *const c_char {
    // SAFETY: by the contract of this function.
    address_or_null(|| Ok(unsafe { reference("unit", unit)? }.description.as_ptr()))
}

/// A digest of the configuration of the unit and of its datapath, 64 hexadecimal digits: equal for equal configurations
/// of one release. Valid while the unit is open; NULL after an error.
///
/// # Safety
/// `unit` is NULL or an open unit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_digest(unit: *const Unit) -> *const c_char {
    // SAFETY: by the contract of this function.
    address_or_null(|| Ok(unsafe { reference("unit", unit)? }.digest.as_ptr()))
}

/// Sets `*values` to the parameters of the unit.
///
/// Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
///
/// # Safety
/// `unit` is NULL or an open unit; `values` is NULL or points to a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_parameters(unit: *const Unit, values: *mut UnitParameters) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (unit, values) = unsafe { (reference("unit", unit)?, reference_mut("values", values)?) };
        let parameters = unit.embedded.parameters();
        *values = UnitParameters {
            contexts: parameters.contexts,
            stack: parameters.step.stack,
            block_bytes: parameters.step.node.block_bytes(),
            memory_width: parameters.memory_width,
            id_width: parameters.id_width,
            address_width: parameters.address_width,
            divider_latency: parameters.divider_latency,
            ram_latency: parameters.ram_latency,
            instances: parameters.step.features.instances.into(),
            queries: match parameters.step.features.queries {
                Queries::None => 0,
                Queries::Flags => 1,
                Queries::Full => 2,
            },
            clockwise_front: (parameters.step.front == Front::Clockwise).into(),
            parity: parameters.parity.into(),
        };
        Ok(RAYPATH_OK)
    })
}

/// Traces `count` rays through a scene of `size` bytes by the functional model, and sets a hit for each. The first byte
/// of the scene has the address 0; an address outside of it is an error of the memory, which ends a ray with
/// `RAYPATH_UNIT_MEMORY`. Of candidates, triangles are accepted and boxes ignored. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for flags, a mask or a base out of range, with the index of the ray;
/// `RAYPATH_ERROR_NULL`, `_ALIGNMENT`, `_OVERLAP` of the hits with another array. Then no hit is set.
///
/// # Safety
/// `unit` is NULL or an open unit; the arrays are NULL or have that many elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_trace(
    unit: *const Unit,
    scene: *const u8,
    size: usize,
    rays: *const UnitRay,
    count: usize,
    hits: *mut UnitHit,
) -> Status {
    // SAFETY: by the contract of this function.
    unsafe { raypath_unit_trace_with(unit, scene, size, rays, count, hits, None, ptr::null_mut()) }
}

/// Writes the hardware into a folder, as `raypath generate --unit` does: SystemVerilog, assertions, the AXI4 wrapper,
/// manifests. Creates the folder if it does not exist. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_IO` with the path; then no file has changed. `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `unit` is NULL or an open unit; `folder` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_generate(unit: *const Unit, folder: *const c_char) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (unit, folder) = unsafe { (reference("unit", unit)?, required_text("folder", folder)?) };
        unit.embedded.generate(Path::new(folder))?;
        Ok(RAYPATH_OK)
    })
}
