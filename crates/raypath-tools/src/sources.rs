//! A module's SystemVerilog as files.

use crate::ToolError;
use crate::files::write;
use raypath_hdl::Module;
use raypath_hdl::verilog::{self, Source};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A module's SystemVerilog on disk.
#[derive(Debug, Clone)]
pub struct Sources {
    /// A file for each module; a module comes after those that it instantiates.
    pub files: Vec<PathBuf>,
    /// All modules in one file, in a folder `all` of its own, so that its name never collides with another file's.
    pub all: PathBuf,
    /// The name of the top module.
    pub top: String,
}

impl Sources {
    /// Writes `top` and all modules below it into `folder`.
    ///
    /// # Errors
    /// A module cannot be printed, or a file cannot be written.
    pub fn write(top: &Arc<Module>, folder: &Path) -> Result<Self, ToolError> {
        let mut files = Vec::new();
        let mut all = String::new();
        for Source { name, text } in verilog::sources(top, &[])? {
            let path = folder.join(format!("{name}.sv"));
            write(&path, &text)?;
            files.push(path);
            all += &text;
        }
        let folder = folder.join("all");
        std::fs::create_dir_all(&folder).map_err(|problem| ToolError::file(&folder, "create the folder", problem))?;
        let path = folder.join(format!("{}.sv", top.name()));
        write(&path, &all)?;
        Ok(Self { files, all: path, top: top.name().to_string() })
    }

    /// Writes `text` to `path` and adds the file to [`Self::files`], not to [`Self::all`]: for assertions that are
    /// bound to the modules.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, path: PathBuf, text: &str) -> Result<(), ToolError> {
        write(&path, text)?;
        self.files.push(path);
        Ok(())
    }

    /// Runs all linters: Verilator on the separate files, Yosys and slang on the joined file, which has the same text.
    ///
    /// # Errors
    /// A linter is missing, or reports anything.
    pub fn lint(&self) -> Result<(), ToolError> {
        crate::lint_verilator(&self.files, &self.top, &[])?;
        crate::lint_yosys(&self.all, &self.top)?;
        crate::lint_slang(std::slice::from_ref(&self.all))
    }
}
