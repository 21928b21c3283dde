//! Datapaths, rays, generation.

use crate::memory::{array, free, reference, reference_mut, required_text, text};
use crate::status::{Failure, RAYPATH_OK, Status, status};
use raypath_embed::{Datapath as Embedded, OperationId, Ray};
use std::ffi::{CString, c_char};
use std::path::Path;

/// A datapath: a configuration with its operations, models and hardware. It does not change, so any number of threads
/// may use it at once, until `raypath_close`.
pub struct Datapath {
    pub(crate) embedded: Embedded,
    pub(crate) description: CString,
    pub(crate) digest: CString,
    pub(crate) operations: Vec<OperationText>,
}

/// The texts of an operation, which callers read while the datapath is open.
pub(crate) struct OperationText {
    pub name: CString,
    pub inputs: Vec<CString>,
    pub outputs: Vec<CString>,
}

impl Datapath {
    fn open(toml: &str, operations: &str) -> Result<Self, Failure> {
        let added: Vec<&str> = operations.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
        let embedded = Embedded::open(toml, &added)?;
        let text = |name: &str| CString::new(name).unwrap_or_default();
        let operations = embedded.operations().into_iter().map(|operation| OperationText {
            name: text(operation.name()),
            inputs: embedded.inputs(operation).iter().map(|port| text(&port.name)).collect(),
            outputs: embedded.outputs(operation).iter().map(|port| text(&port.name)).collect(),
        });
        let (description, digest) = (text(embedded.description()), text(&embedded.digest()));
        Ok(Self { description, digest, operations: operations.collect(), embedded })
    }

    /// The operation at an index in the order of opcodes, with its texts.
    pub(crate) fn operation_at(&self, index: usize) -> Result<(OperationId, &OperationText), Failure> {
        let id = self.embedded.operations().get(index).copied();
        let problem = || Failure::argument(format!("operation {index}, expected 0 to {}", self.operations.len() - 1));
        id.zip(self.operations.get(index)).ok_or_else(problem)
    }
}

/// Opens a datapath and sets `*datapath`. `toml` has the keys of a configuration file, for example
/// `preset = "credit"`; NULL is the default configuration. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_CONFIGURATION` with the line of `toml`; `RAYPATH_ERROR_NULL`. Then `*datapath` is not
/// changed.
///
/// # Safety
/// `toml` is NULL or a string; `datapath` is NULL or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_open(toml: *const c_char, datapath: *mut *mut Datapath) -> Status {
    // SAFETY: the same contract.
    unsafe { raypath_open_with(toml, std::ptr::null(), datapath) }
}

/// As `raypath_open`, with operations added to those of the paper: names as `raypath operations` lists them, separated
/// by commas; NULL for none.
///
/// Errors: those of `raypath_open`; `RAYPATH_ERROR_ARGUMENT` for an unknown name.
///
/// # Safety
/// That of `raypath_open`; `operations` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_open_with(
    toml: *const c_char,
    operations: *const c_char,
    datapath: *mut *mut Datapath,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (toml, operations, datapath) =
            unsafe { (text("toml", toml)?, text("operations", operations)?, reference_mut("datapath", datapath)?) };
        let opened = Datapath::open(toml.unwrap_or_default(), operations.unwrap_or_default())?;
        *datapath = Box::into_raw(Box::new(opened));
        Ok(RAYPATH_OK)
    })
}

/// Closes a datapath. NULL is ignored. Pipelines of the datapath remain usable.
///
/// # Safety
/// `datapath` is NULL or came from `raypath_open` and was not closed; no other call uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_close(datapath: *mut Datapath) {
    // SAFETY: by the contract of this function.
    unsafe { free(datapath) };
}

/// Sets `*ray` to the ray from `origin` along `direction` (three numbers each) with the length `extent` times that of
/// `direction`; infinity reaches everything. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for a direction that is zero, not finite or too short to invert, an origin that is
/// not finite, an extent that is negative or NaN; `RAYPATH_ERROR_NULL`. Then `*ray` is not changed.
///
/// # Safety
/// `origin` and `direction` are NULL or point to three numbers; `ray` is NULL or points to a ray.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_ray_init(
    ray: *mut Ray,
    origin: *const f32,
    direction: *const f32,
    extent: f32,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function. The numbers are copied before the ray is written.
        let (origin, direction) = unsafe { (array("origin", origin, 3)?, array("direction", direction, 3)?) };
        let made = Ray::new([origin[0], origin[1], origin[2]], [direction[0], direction[1], direction[2]], extent);
        // SAFETY: by the contract of this function.
        *unsafe { reference_mut("ray", ray)? } = made.map_err(|problem| Failure::argument(problem.to_string()))?;
        Ok(RAYPATH_OK)
    })
}

/// Writes the hardware into a folder, as `raypath generate` does: SystemVerilog, assertions, wrapper, manifests, a
/// picture. Creates the folder if it does not exist. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_IO` with the path; then no file has changed. `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `datapath` is NULL or an open datapath; `folder` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_generate(datapath: *const Datapath, folder: *const c_char) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (datapath, folder) = unsafe { (reference("datapath", datapath)?, required_text("folder", folder)?) };
        datapath.embedded.generate(Path::new(folder))?;
        Ok(RAYPATH_OK)
    })
}
