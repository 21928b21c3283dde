//! Other people's programs.

use crate::CosimError;
use std::io::ErrorKind;
use std::process::Command;

/// Runs a command to its end and gives all that it printed; an error where it fails, or is not there.
pub fn run(command: &mut Command, install: &'static str) -> Result<String, CosimError> {
    let tool = command.get_program().to_string_lossy().into_owned();
    let result = command.output().map_err(|problem| match problem.kind() {
        ErrorKind::NotFound => CosimError::MissingTool { tool: tool.clone(), install },
        _ => CosimError::File { path: tool.clone().into(), problem },
    })?;
    let output = [result.stdout, result.stderr].concat();
    let output = String::from_utf8_lossy(&output).into_owned();
    if result.status.success() { Ok(output) } else { Err(CosimError::Tool { tool, output }) }
}
