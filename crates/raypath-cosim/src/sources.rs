//! A module's text as files.

use crate::CosimError;
use raypath_hdl::{Module, verilog};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A module's SystemVerilog on disk.
#[derive(Debug, Clone)]
pub struct Sources {
    /// One file a module, those that are instantiated first.
    pub files: Vec<PathBuf>,
    /// All of it in one file, in a folder `all` so that it is none of the others whatever their names are.
    pub all: PathBuf,
    /// The name of the top module.
    pub top: String,
}

impl Sources {
    /// Prints `top` and all below it into `folder`.
    pub fn write(top: &Arc<Module>, folder: &Path) -> Result<Self, CosimError> {
        let mut files = Vec::new();
        let mut all = String::new();
        for module in verilog::modules(top)? {
            let text = verilog::print_module(&module, &[])?;
            let path = folder.join(format!("{}.sv", module.name()));
            write(&path, &text)?;
            files.push(path);
            all += &text;
        }
        let folder = folder.join("all");
        std::fs::create_dir_all(&folder).map_err(|problem| CosimError::File { path: folder.clone(), problem })?;
        let path = folder.join(format!("{}.sv", top.name()));
        write(&path, &all)?;
        Ok(Self { files, all: path, top: top.name().to_string() })
    }

    /// The sources with which all three front ends must be content: every file by itself in Verilator, all of it in one
    /// file in Verilator, Yosys and slang.
    pub fn lint(&self) -> Result<(), CosimError> {
        crate::lint_verilator(&self.files, &self.top, &[])?;
        crate::lint_verilator(std::slice::from_ref(&self.all), &self.top, &["-Wno-DECLFILENAME"])?;
        crate::lint_yosys(&self.all, &self.top)?;
        crate::lint_slang(std::slice::from_ref(&self.all))
    }
}

pub(crate) fn write(path: &Path, text: &str) -> Result<(), CosimError> {
    std::fs::write(path, text).map_err(|problem| CosimError::File { path: path.to_path_buf(), problem })
}
