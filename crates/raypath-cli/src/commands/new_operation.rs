//! `raypath new-operation`: a crate for an operation of one's own.

use crate::error::CliError;
use clap::Args;
use raypath_rtl::is_identifier;
use raypath_sim::files::{in_folder, write_all};
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct Arguments {
    /// The name of the operation, in snake_case
    name: String,
    /// The folder of the crate, which must not exist; NAME by default
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// The checkout that this program was built from.
const CHECKOUT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
const TEMPLATE: &str = include_str!("new_operation/template.rs");

/// Writes the crate.
///
/// # Errors
/// A name that a datapath cannot have; a folder that exists; a checkout that is gone.
pub fn run(Arguments { name, folder }: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    if !is_identifier(name) {
        let expected = "expected small letters, digits and _, the first a letter";
        return Err(CliError::unusable(format!("'{name}' is not a name of an operation, {expected}")));
    }
    let folder = folder.clone().unwrap_or_else(|| name.into());
    if folder.exists() {
        return Err(CliError::unusable(format!("{}: exists, expected a new folder", folder.display())));
    }
    let raypath = Path::new(CHECKOUT).join("crates/raypath");
    let missing = |problem| {
        let expected = "expected the checkout of raypath from which this program was built";
        CliError::unusable(format!("{}: {problem}, {expected}", raypath.display()))
    };
    let raypath = raypath.canonicalize().map_err(missing)?;
    let lock = std::fs::read_to_string(raypath.join("../../Cargo.lock")).map_err(missing)?;
    let camel: String = name.split('_').map(capitalised).collect();
    let text = TEMPLATE.replace("point_plane", name).replace("PointPlane", &camel);
    let files = [("Cargo.toml", manifest(name, &raypath)), ("Cargo.lock", lock), ("src/main.rs", text)];
    write_all(&in_folder(&folder, files.map(|(path, text)| (path.into(), text)).to_vec()))?;
    let folder = folder.display();
    writeln!(out, "Wrote {folder}: the operation is in src/main.rs. Next: cd {folder} && cargo run --release")?;
    Ok(())
}

/// The manifest. A crate outside of the workspace does not get the profiles of raypath's own manifest.
fn manifest(name: &str, raypath: &Path) -> String {
    format!(
        "[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[dependencies]\n\
         raypath = {{ path = {raypath:?}, features = [\"workbench\"] }}\n\n[features]\nfull = [\"raypath/full\"]\n\n\
         # The compiler of simulated netlists runs for milliseconds.\n[profile.release.package]\n\
         cranelift-codegen = {{ opt-level = 0 }}\ncranelift-assembler-x64 = {{ opt-level = 0 }}\n"
    )
}

fn capitalised(word: &str) -> String {
    let (first, rest) = word.split_at(word.len().min(1));
    first.to_ascii_uppercase() + rest
}
