//! Tables: a list of rows, each a dictionary of the same keys.

use crate::error::exception;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use raypath_embed::Card;
use raypath_ops::PortKind;
use raypath_rtl::{self as rtl, PARAMETER_GROUPS, PRESETS, UnitKind, Units};

type Row<'py> = Bound<'py, PyDict>;

/// A row with these values.
macro_rules! row {
    ($py:expr, $($key:literal: $value:expr),* $(,)?) => {{
        let row = PyDict::new($py);
        $(row.set_item($key, $value)?;)*
        PyResult::Ok(row)
    }};
}
pub(crate) use row;

/// The presets: named configurations.
///
/// Returns:
///     A row for each preset: ``preset``, ``options`` (what differs from the first, as options of the command line) and
///     ``purpose``.
#[pyfunction]
pub fn presets(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let rows = PRESETS
        .iter()
        .map(|preset| row!(py, "preset": preset.name, "options": preset.config.options(), "purpose": preset.purpose));
    list(py, rows)
}

/// The parameters of a configuration, which are keywords of ``Datapath``.
///
/// Returns:
///     A row for each parameter: ``keyword``, ``values``, ``default``, ``meaning`` and ``group``.
#[pyfunction]
pub fn parameters(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let all =
        PARAMETER_GROUPS.iter().flat_map(|group| group.parameters.iter().map(move |parameter| (group, parameter)));
    let rows = all.map(|(group, parameter)| {
        row!(py, "keyword": parameter.name.replace('-', "_"), "values": parameter.values,
            "default": parameter.default(), "meaning": parameter.help(), "group": group.heading)
    });
    list(py, rows)
}

/// The operations that ``Datapath(with_=...)`` adds to those of the paper.
///
/// Returns:
///     A row for each operation: ``operation`` and ``purpose``.
#[pyfunction]
pub fn operations(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let added = raypath_oracle::added_operations();
    list(py, added.iter().map(|spec| row!(py, "operation": spec.name(), "purpose": spec.purpose())))
}

/// Reads a card, the text that ``raypath card`` writes, as a dictionary.
///
/// Raises:
///     ValueError: another text, or another version of it.
#[pyfunction]
pub fn read_card<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    card(py, &Card::read(text).map_err(exception)?)
}

pub fn card<'py>(py: Python<'py>, card: &Card) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (card.to_json(),))
}

pub fn schedule<'py>(py: Python<'py>, netlist: &rtl::DatapathNetlist) -> PyResult<Bound<'py, PyList>> {
    let steps = netlist.steps().enumerate();
    let rows = steps.flat_map(|(step, label)| {
        netlist.schedule(step).into_iter().map(move |note| {
            let row =
                row!(py, "step": step, "stage": label.to_string(), "operation": note.operation, "work": note.what)?;
            with_units(row, note.units)
        })
    });
    list(py, rows)
}

pub fn units<'py>(py: Python<'py>, netlist: &rtl::DatapathNetlist) -> PyResult<Bound<'py, PyList>> {
    let rows = netlist
        .steps()
        .enumerate()
        .map(|(step, label)| with_units(row!(py, "step": step, "stage": label.to_string())?, netlist.units(step)));
    list(py, rows)
}

pub fn registers<'py>(py: Python<'py>, netlist: &rtl::DatapathNetlist) -> PyResult<Bound<'py, PyList>> {
    let rows = netlist.steps().enumerate().map(|(step, label)| {
        let bits = netlist.registers(step);
        row!(py, "step": step, "stage": label.to_string(), "live": bits.live, "data": bits.data,
            "control": bits.control, "state": bits.state, "flip_flops": bits.flip_flops())
    });
    list(py, rows)
}

pub fn ports<'py>(py: Python<'py>, datapath: &raypath_embed::Datapath) -> PyResult<Bound<'py, PyList>> {
    let number = datapath.config().semantics.format.ieee_width();
    let rows = datapath.operations().into_iter().flat_map(|operation| {
        let (inputs, outputs) = (datapath.inputs(operation), datapath.outputs(operation));
        let ports = inputs.iter().map(|port| ("input", port)).chain(outputs.iter().map(|port| ("output", port)));
        ports.map(move |(direction, port)| {
            let kind = match port.kind {
                PortKind::Number => "number",
                PortKind::Flags => "flags",
                PortKind::Word => "word",
            };
            row!(py, "operation": operation.name(), "direction": direction, "name": &port.name, "kind": kind,
                "width": port.width.unwrap_or(number))
        })
    });
    list(py, rows)
}

fn with_units(row: Row<'_>, units: Units) -> PyResult<Row<'_>> {
    for kind in UnitKind::ALL {
        row.set_item(kind.stem(), units.of(kind))?;
    }
    Ok(row)
}

pub fn list<'py>(py: Python<'py>, rows: impl Iterator<Item = PyResult<Row<'py>>>) -> PyResult<Bound<'py, PyList>> {
    PyList::new(py, rows.collect::<PyResult<Vec<_>>>()?)
}
