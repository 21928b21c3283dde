//! A configuration from the arguments of a class.

use crate::error::value_error;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use raypath_rtl::{Config, Preset, parameters};
use raypath_sim::configuration;
use std::path::{Path, PathBuf};

/// Parameters of something around a datapath: what it is, their names, and a function that sets one of them.
pub struct Around<'o> {
    pub of: &'static str,
    pub names: &'o [&'o str],
    pub set: &'o mut dyn FnMut(&str, &str) -> Result<(), String>,
}

/// The configuration of a preset or of TOML, changed by keywords.
pub fn chosen(
    preset: Option<&str>,
    config: Option<&Bound<'_, PyAny>>,
    flags: Option<&Bound<'_, PyDict>>,
    mut around: Around<'_>,
) -> PyResult<Config> {
    let mut chosen = match (preset, config) {
        (Some(_), Some(_)) => return Err(value_error("preset and config are given, expected at most one of them")),
        (Some(name), None) => name.parse::<Preset>().map_err(value_error)?.config,
        (None, Some(config)) => configured(config, &mut around)?,
        (None, None) => Config::DEFAULT,
    };
    for (name, value) in flags.into_iter().flatten() {
        set(&mut chosen, &name.extract::<String>()?, &value, &mut around)?;
    }
    Ok(chosen)
}

/// A configuration as TOML.
pub fn toml(config: &Config) -> String {
    parameters().map(|known| format!("{} = \"{}\"\n", known.name, known.get(config))).collect()
}

/// A configuration as text, or in the file of this path.
fn configured(config: &Bound<'_, PyAny>, Around { names, set, .. }: &mut Around<'_>) -> PyResult<Config> {
    match config.extract::<String>() {
        Ok(text) if text.contains('=') || text.is_empty() => {
            configuration::parse_with(&text, Path::new("config"), names, *set)
        }
        Ok(path) => configuration::read_with(path.as_ref(), names, *set),
        Err(_) => configuration::read_with(&config.extract::<PathBuf>()?, names, *set),
    }
    .map_err(value_error)
}

/// Sets the parameter that a keyword names.
fn set(config: &mut Config, keyword: &str, value: &Bound<'_, PyAny>, around: &mut Around<'_>) -> PyResult<()> {
    let text = match value.cast::<PyBool>() {
        Ok(value) => value.is_true().to_string(),
        Err(_) => value.str()?.to_string(),
    };
    let is_named = |name: &str| name.replace('-', "_") == keyword;
    let result = if let Some(name) = around.names.iter().find(|name| is_named(name)) {
        (around.set)(name, &text)
    } else if let Some(parameter) = parameters().find(|parameter| is_named(parameter.name)) {
        parameter.set(config, &text)
    } else {
        let names = around.names.iter().copied().chain(parameters().map(|parameter| parameter.name));
        let names: Vec<String> = names.map(|name| name.replace('-', "_")).collect();
        let problem = format!("'{keyword}' is not a flag of {}, expected {}", around.of, names.join(", "));
        return Err(PyTypeError::new_err(problem));
    };
    result.map_err(|problem| value_error(format!("{keyword}: {problem}")))
}
