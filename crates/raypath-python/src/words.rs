//! Values at the ports of an operation, as arrays or numbers of Python and as words.

use crate::array::items;
use crate::error::value_error;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::basic::CompareOp;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use raypath_embed::{Datapath, OperationId};
use raypath_float::Format;
use raypath_ops::{Port, PortKind};

/// The values of one port.
enum Values {
    One(u64),
    Each(Vec<u64>),
}

/// The words of jobs, job after job in the order of the operation's ports, and the number of jobs. Numbers count for
/// all jobs; there is one job if no value is an array.
pub fn words_of(
    datapath: &Datapath,
    operation: OperationId,
    values: Option<&Bound<'_, PyDict>>,
) -> PyResult<(Vec<u64>, usize)> {
    let ports = datapath.inputs(operation);
    let format = datapath.config().semantics.format;
    let expected = || ports.iter().map(|port| port.name.as_str()).collect::<Vec<_>>().join(", ");
    for name in values.iter().flat_map(|values| values.keys()) {
        let name: String = name.cast_into::<PyString>()?.extract()?;
        if !ports.iter().any(|port| port.name == name) {
            return Err(value_error(format!("{operation} has no input '{name}', expected {}", expected())));
        }
    }
    let mut columns = Vec::new();
    let mut jobs: Option<(usize, &str)> = None;
    for port in ports {
        let value = values.map(|values| values.get_item(&port.name)).transpose()?.flatten();
        let value = value.ok_or_else(|| {
            value_error(format!("{operation}: no value for '{}', expected values for {}", port.name, expected()))
        })?;
        let column = values_of(&value, port, format)?;
        if let Values::Each(words) = &column {
            match jobs {
                Some((count, like)) if count != words.len() => {
                    let (name, found) = (&port.name, words.len());
                    let problem = format!("{name}: found shape ({found},), expected ({count},) as {like}");
                    return Err(value_error(problem));
                }
                _ => jobs = Some((words.len(), &port.name)),
            }
        }
        columns.push(column);
    }
    let count = jobs.map_or(1, |(count, _)| count);
    let mut words = Vec::with_capacity(count * columns.len());
    for job in 0..count {
        words.extend(columns.iter().map(|column| match column {
            Values::One(word) => *word,
            Values::Each(words) => words[job],
        }));
    }
    Ok((words, count))
}

/// Numbers in binary32 are floats or float32 arrays. All other values, and the bits of numbers in other formats, are
/// integers, or arrays of integers or truth values.
fn values_of(value: &Bound<'_, PyAny>, port: &Port, format: Format) -> PyResult<Values> {
    let name = &port.name;
    let is_array = value.getattr_opt("ndim")?.map_or(PyResult::Ok(false), |ndim| Ok(ndim.extract::<usize>()? > 0))?;
    if port.kind == PortKind::Number && format == Format::BINARY32 {
        if is_array {
            return Ok(Values::Each(items::<f32>(value, name)?.iter().map(|x| x.to_bits().into()).collect()));
        }
        let number: f64 =
            value.extract().map_err(|_| value_error(format!("{name}: found {value}, expected a number")))?;
        return Ok(Values::One((number as f32).to_bits().into()));
    }
    let problem =
        |_| value_error(format!("{name}: found {value}, expected integers of at least 0, or an array of them"));
    if !is_array {
        return value.extract().map(Values::One).map_err(problem);
    }
    // NumPy converts all integer types; a negative one has no conversion to uint64 that keeps its value.
    let numpy = value.py().import("numpy")?;
    let is_whole = ["b", "u", "i"].contains(&value.getattr("dtype")?.getattr("kind")?.extract::<String>()?.as_str());
    if !is_whole || value.rich_compare(0, CompareOp::Lt)?.call_method0("any")?.is_truthy()? {
        return Err(problem(pyo3::exceptions::PyValueError::new_err("")));
    }
    let array = numpy.call_method1("ascontiguousarray", (value, "u8"))?;
    let array = array
        .cast_into::<PyArray1<u64>>()
        .map_err(|_| value_error(format!("{name}: found an array of several dimensions, expected shape (n,)")))?;
    Ok(Values::Each(array.readonly().as_slice()?.to_vec()))
}

/// The values of each output port in arrays, from the words of all outcomes.
pub fn outcomes<'py>(py: Python<'py>, ports: &[Port], format: Format, words: &[u64]) -> PyResult<Bound<'py, PyDict>> {
    let outcomes = PyDict::new(py);
    for (index, port) in ports.iter().enumerate() {
        let column = words.iter().skip(index).step_by(ports.len());
        let array = match port.kind {
            PortKind::Number if format == Format::BINARY32 => {
                PyArray1::from_iter(py, column.map(|&word| f32::from_bits(word as u32))).into_any()
            }
            PortKind::Flags if port.width == Some(1) => {
                PyArray1::from_iter(py, column.map(|&word| word == 1)).into_any()
            }
            _ => PyArray1::from_iter(py, column.copied()).into_any(),
        };
        outcomes.set_item(&port.name, array)?;
    }
    Ok(outcomes)
}
