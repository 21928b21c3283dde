//! Operations, ports, units and registers of a datapath.

use crate::Datapath;
use crate::memory::{reference, reference_mut, required_text};
use crate::status::{Failure, RAYPATH_OK, Status, address_or_null, status, value_or_zero};
use raypath_embed::Card;
use raypath_ops::PortKind;
use raypath_rtl::{Registers, Units};
use std::ffi::{CString, c_char};

/// An operation of a datapath.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OperationInfo {
    /// The name. It is valid while the datapath is open.
    pub name: *const c_char,
    /// The value of the ports `opcode_i` and `opcode_o`.
    pub opcode: u64,
    /// The number of input ports, without those of the handshake and the opcode.
    pub inputs: usize,
    /// The number of output ports.
    pub outputs: usize,
    /// Cycles between two jobs of this operation if nothing stalls.
    pub initiation_interval: u32,
}

/// A port of `raypath_port` is a floating-point number.
pub const RAYPATH_PORT_NUMBER: i32 = 0;
/// One truth value, or several, one per bit.
pub const RAYPATH_PORT_FLAGS: i32 = 1;
/// An unsigned word.
pub const RAYPATH_PORT_WORD: i32 = 2;

/// A port of an operation.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Port {
    /// The name without direction suffix, for example `ray_origin_x`. It is valid while the datapath is open.
    pub name: *const c_char,
    /// One of `RAYPATH_PORT_…`.
    pub kind: i32,
    /// The width of the port's word in bits; of a number, that of the IEEE 754 layout.
    pub width: u32,
}

/// Counts of units and registers.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct Cost {
    /// Encoders to the recoded format.
    pub encoders: u32,
    /// Adders.
    pub adders: u32,
    /// Multipliers.
    pub multipliers: u32,
    /// Comparators.
    pub comparators: u32,
    /// Decoders from the recoded format.
    pub decoders: u32,
    /// Flip-flops.
    pub flip_flops: u64,
}

/// The configuration and the added operations in words. Valid while the datapath is open; NULL after an error.
///
/// # Safety
/// `datapath` is NULL or an open datapath.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_description(datapath: *const Datapath) -> *const c_char {
    // SAFETY: by the contract of this function.
    address_or_null(|| Ok(unsafe { reference("datapath", datapath)? }.description.as_ptr()))
}

/// A digest of the configuration and the added operations, 64 hexadecimal digits: equal for equal configurations of one
/// release. Valid while the datapath is open; NULL after an error.
///
/// # Safety
/// `datapath` is NULL or an open datapath.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_digest(datapath: *const Datapath) -> *const c_char {
    // SAFETY: by the contract of this function.
    address_or_null(|| Ok(unsafe { reference("datapath", datapath)? }.digest.as_ptr()))
}

/// Cycles from the acceptance of a job to its outcome in an empty pipeline; 0 after an error.
///
/// # Safety
/// `datapath` is NULL or an open datapath.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_latency(datapath: *const Datapath) -> u32 {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("datapath", datapath)? }.embedded.netlist().latency()))
}

/// The number of jobs that fit while the sink is not ready; 0 after an error.
///
/// # Safety
/// `datapath` is NULL or an open datapath.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_capacity(datapath: *const Datapath) -> usize {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("datapath", datapath)? }.embedded.shape().capacity()))
}

/// The coordinates of a Euclidean beat; an angular one has half as many. 0 without distance operations and after an
/// error.
///
/// # Safety
/// `datapath` is NULL or an open datapath.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_lanes(datapath: *const Datapath) -> usize {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("datapath", datapath)? }.embedded.lanes()))
}

/// The number of operations; 0 after an error.
///
/// # Safety
/// `datapath` is NULL or an open datapath.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_operation_count(datapath: *const Datapath) -> usize {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("datapath", datapath)? }.operations.len()))
}

/// Sets `*operation` to the operation at `index`, in the order of opcodes.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for an index from `raypath_operation_count` on; `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `datapath` is NULL or an open datapath; `operation` is NULL or points to an operation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_operation(
    datapath: *const Datapath,
    index: usize,
    operation: *mut OperationInfo,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (datapath, operation) =
            unsafe { (reference("datapath", datapath)?, reference_mut("operation", operation)?) };
        let (id, text) = datapath.operation_at(index)?;
        let (name, opcode) = (text.name.as_ptr(), id.opcode());
        let (inputs, outputs) = (text.inputs.len(), text.outputs.len());
        let initiation_interval = datapath.embedded.shape().interval(opcode) as u32;
        *operation = OperationInfo { name, opcode, inputs, outputs, initiation_interval };
        Ok(RAYPATH_OK)
    })
}

/// Sets `*port` to an input port of the operation at `operation`.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for an index that is too high; `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `datapath` is NULL or an open datapath; `port` is NULL or points to a port.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_input(
    datapath: *const Datapath,
    operation: usize,
    index: usize,
    port: *mut Port,
) -> Status {
    // SAFETY: the same contract.
    status(|| unsafe { set_port(datapath, operation, index, port, true) })
}

/// Sets `*port` to an output port of the operation at `operation`.
///
/// Errors: those of `raypath_input`.
///
/// # Safety
/// That of `raypath_input`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_output(
    datapath: *const Datapath,
    operation: usize,
    index: usize,
    port: *mut Port,
) -> Status {
    // SAFETY: the same contract.
    status(|| unsafe { set_port(datapath, operation, index, port, false) })
}

/// The number of steps of the pipeline: with units of one step, the stages of the paper's Table VII. 0 after an error.
///
/// # Safety
/// `datapath` is NULL or an open datapath.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_step_count(datapath: *const Datapath) -> usize {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("datapath", datapath)? }.embedded.netlist().steps().count()))
}

/// Sets `*cost` to the units of a step and the registers after it, counted in the netlist.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for a step from `raypath_step_count` on; `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `datapath` is NULL or an open datapath; `cost` is NULL or points to a cost.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_step_cost(datapath: *const Datapath, step: usize, cost: *mut Cost) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (datapath, cost) = unsafe { (reference("datapath", datapath)?, reference_mut("cost", cost)?) };
        let netlist = datapath.embedded.netlist();
        let steps = netlist.steps().count();
        if step >= steps {
            return Err(Failure::argument(format!("step {step}, expected 0 to {}", steps - 1)));
        }
        *cost = cost_of(netlist.units(step), netlist.registers(step));
        Ok(RAYPATH_OK)
    })
}

/// Sets `*cost` to the units and flip-flops of the whole datapath, counted in the netlist.
///
/// Errors: `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// That of `raypath_step_cost`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_cost(datapath: *const Datapath, cost: *mut Cost) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (datapath, cost) = unsafe { (reference("datapath", datapath)?, reference_mut("cost", cost)?) };
        let netlist = datapath.embedded.netlist();
        let units: Units = (0..netlist.steps().count()).map(|step| netlist.units(step)).sum();
        *cost = Cost { flip_flops: datapath.embedded.flip_flops(), ..cost_of(units, Registers::default()) };
        Ok(RAYPATH_OK)
    })
}

/// Sets `*value` to a number of a card, the JSON that `raypath card` writes. `pointer` is a JSON pointer, for example
/// `/operations/quadbox/pj_per_job`. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for another text, another version of it, or no number there, with the reason that the
/// card states; `RAYPATH_ERROR_NULL`. Then `*value` is not changed.
///
/// # Safety
/// `json` and `pointer` are NULL or strings; `value` is NULL or points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_card_number(json: *const c_char, pointer: *const c_char, value: *mut f64) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (texts, value) = unsafe {
            ([required_text("json", json)?, required_text("pointer", pointer)?], reference_mut("value", value)?)
        };
        *value = Card::read(texts[0])?.number(texts[1])?;
        Ok(RAYPATH_OK)
    })
}

fn cost_of(units: Units, registers: Registers) -> Cost {
    let Units { encode, add, sum, multiply, compare, decode } = units;
    let [encoders, adders, multipliers, comparators, decoders] =
        [encode, add + sum, multiply, compare, decode].map(|count| count as u32);
    Cost { encoders, adders, multipliers, comparators, decoders, flip_flops: registers.flip_flops() }
}

/// # Safety
/// That of [`raypath_input`].
unsafe fn set_port(
    datapath: *const Datapath,
    operation: usize,
    index: usize,
    port: *mut Port,
    is_input: bool,
) -> Result<Status, Failure> {
    // SAFETY: by the contract of this function.
    let (datapath, port) = unsafe { (reference("datapath", datapath)?, reference_mut("port", port)?) };
    let (id, text) = datapath.operation_at(operation)?;
    let embedded = &datapath.embedded;
    let (ports, names): (_, &[CString]) =
        if is_input { (embedded.inputs(id), &text.inputs) } else { (embedded.outputs(id), &text.outputs) };
    let (Some(found), Some(name)) = (ports.get(index), names.get(index)) else {
        let problem = format!("port {index} of {id}, expected 0 to {}", ports.len().saturating_sub(1));
        return Err(Failure::argument(problem));
    };
    let kind = match found.kind {
        PortKind::Number => RAYPATH_PORT_NUMBER,
        PortKind::Flags => RAYPATH_PORT_FLAGS,
        PortKind::Word => RAYPATH_PORT_WORD,
    };
    let width = found.width.unwrap_or(embedded.config().semantics.format.ieee_width());
    *port = Port { name: name.as_ptr(), kind, width };
    Ok(RAYPATH_OK)
}
