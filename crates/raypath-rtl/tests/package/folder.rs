//! A folder with the files that `raypath generate` writes.

use raypath_hdl::verilog;
use raypath_rtl::{DatapathNetlist, Preset};
use std::path::{Path, PathBuf};

/// The configurations of these tests: all operations and fewer, other widths, both kinds of control.
pub const PRESETS: [&str; 4] = ["paper", "graphics", "half", "credit"];

pub fn preset(name: &str) -> DatapathNetlist {
    let preset: Preset = name.parse().expect("a preset");
    DatapathNetlist::new(preset.config).expect("a datapath")
}

/// A folder with all files; `files` has those of `raypath_rtl::package`, by path.
#[derive(Debug)]
pub struct Written {
    pub folder: tempfile::TempDir,
    pub files: Vec<(PathBuf, String)>,
}

pub fn write(datapath: &DatapathNetlist) -> Written {
    let folder = tempfile::tempdir().expect("a folder");
    let files = raypath_rtl::package::files(datapath, &["Made by a test.".to_string()]).expect("files");
    let module = |name: &str, text: String| put(&folder.path().join(format!("rtl/{name}.sv")), &text);
    for source in verilog::sources(datapath.top(), &[]).expect("modules") {
        module(&source.name, source.text);
    }
    let properties = format!("{}_properties.sv", datapath.top().name());
    put(&folder.path().join(properties), &datapath.properties().to_string());
    for (path, text) in &files {
        put(&folder.path().join(path), text);
    }
    Written { folder, files }
}

impl Written {
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The text of a file of this crate.
    pub fn text(&self, name: &str) -> &str {
        let found = self.files.iter().find(|(path, _)| path.as_path() == Path::new(name));
        &found.unwrap_or_else(|| panic!("no {name}")).1
    }

    /// The files of `raypath_wrapper.f`, in order.
    pub fn listed(&self) -> Vec<PathBuf> {
        self.text("raypath_wrapper.f").lines().map(|file| self.path().join(file)).collect()
    }
}

fn put(path: &Path, text: &str) {
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    std::fs::write(path, text).expect("a file");
}
