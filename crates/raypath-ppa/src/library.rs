//! A cell library: the areas of its cells, and the cells that the synthesis script names.

use crate::Error;
use crate::function::truth_table;
use crate::liberty::{self, Group};
use crate::logic::{ClockGate, Logic};
use raypath_tools::{Program, ToolError, digest, text};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The default cell library, of Debian's package `qflow-tech-osu018`.
pub const DEFAULT_LIBRARY: &str = "/usr/share/qflow/tech/osu018/osu018_stdcells.lib";

static OSU018: Program = Program {
    name: DEFAULT_LIBRARY,
    expected: "this cell library, or another by --liberty",
    install: "apt-get install qflow-tech-osu018",
    version: &[],
};

/// A cell library, parsed from a Liberty file.
#[derive(Debug)]
pub struct Library {
    /// The library's own name.
    pub name: String,
    /// The Liberty text, without the cells that are not usable.
    pub text: String,
    /// The digest of the text.
    pub digest: String,
    /// The usable cells, by name.
    pub cells: BTreeMap<String, Cell>,
    /// The name of the smallest NAND of two inputs, the unit of gate equivalents.
    pub nand2: String,
    /// The name of the buffer that drives every input: the one of strength 2, or the smallest.
    pub buffer: String,
    /// The load of every output: the capacitance of ten inputs of the buffer, in whole femtofarads.
    pub load: f64,
    pub(crate) tie: Option<Tie>,
    /// The strongest integrated clock gate with a latch, and without an input for tests: the largest.
    pub(crate) clock_gate: Option<ClockGateCell>,
    /// The femtofarads of the unit of capacitances.
    pub(crate) femtofarads: f64,
}

/// The properties of a cell that a measurement needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The area in the library's unit, which is µm² in all known libraries.
    pub area: f64,
    /// Whether it is a flip-flop.
    pub is_flip_flop: bool,
    /// Whether it is a clock gate.
    pub is_clock_gate: bool,
    /// The names of its output pins.
    pub outputs: Vec<String>,
    /// Its behaviour, if it is a gate or a flip-flop on a rising edge.
    pub(crate) logic: Option<Logic>,
}

/// The cell of clock gates, and its pins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClockGateCell {
    pub name: String,
    pub clock: String,
    pub enable: String,
    pub output: String,
}

/// The cells and pins for the constants 1 and 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tie {
    pub one: (String, String),
    pub zero: (String, String),
}

/// The limit on an unpacked library. Commercial libraries with current sources come near it.
const MAX_TEXT: u64 = 256 << 20;

impl Library {
    /// Reads a Liberty file, plain or compressed by gzip.
    ///
    /// # Errors
    /// The file cannot be read, is not a Liberty file, or is larger than 256 MiB when unpacked; the library lacks a
    /// buffer or a NAND of two inputs; an area or a capacitance is not a number; two cells have the same name.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let refused = |problem: std::io::Error| match problem.kind() {
            std::io::ErrorKind::NotFound if path == Path::new(DEFAULT_LIBRARY) => ToolError::Missing(&OSU018),
            _ => ToolError::file(path, "read", problem),
        };
        Self::read_from(File::open(path).map_err(refused)?, path)
    }

    /// Reads a stream as [`Library::read`] reads a file; `path` is for messages.
    ///
    /// # Errors
    /// As for [`Library::read`].
    pub fn read_from(stream: impl Read, path: &Path) -> Result<Self, Error> {
        Self::of(text(stream, MAX_TEXT).map_err(|problem| ToolError::file(path, "read", problem))?, path)
    }

    /// A library from its text; `path` is for messages.
    pub(crate) fn of(text: String, path: &Path) -> Result<Self, Error> {
        let library = liberty::read(&text).map_err(|wrong| Error::Liberty {
            path: path.to_path_buf(),
            line: wrong.line,
            found: wrong.found,
            expected: wrong.expected,
        })?;
        let (used, unused): (Vec<&Group<'_>>, Vec<&Group<'_>>) =
            library.of_kind("cell").partition(|cell| is_usable(cell));
        let wrong = |group: &Group<'_>, found: String, expected| {
            let line = text[..group.span.start].matches('\n').count() + 1;
            Error::Liberty { path: path.to_path_buf(), line, found, expected }
        };
        let mut cells = BTreeMap::new();
        for cell in &used {
            if let Some(found) = invalid_number(cell) {
                return Err(wrong(cell, found, "a number from 0 to 1e12"));
            }
            if cells.insert(cell.name().to_string(), Cell::of(cell)).is_some() {
                return Err(wrong(cell, format!("another cell {}", shortened(cell.name())), "one cell of each name"));
            }
        }
        let missing = |what: &str| Error::MissingCell { path: path.to_path_buf(), what: what.to_string() };
        let nand2 = nand2(&used).ok_or_else(|| missing("NAND with two inputs"))?;
        if area(nand2) == 0.0 {
            return Err(wrong(
                nand2,
                format!("{} without an area", nand2.name()),
                "one above 0, the unit of gate counts",
            ));
        }
        let nand2 = nand2.name().to_string();
        let buffer = buffer(&used).ok_or_else(|| missing("buffer"))?;
        let load = (10.0 * femtofarads(&library) * input_capacitance(buffer)).round();
        if !NUMBERS.contains(&load) {
            return Err(wrong(buffer, format!("a load of {load} fF"), "a unit and a capacitance for one up to 1e12"));
        }
        let buffer = buffer.name().to_string();
        let (tie, clock_gate) = (tie(&used), clock_gate(&used));
        let femtofarads = femtofarads(&library);
        let name = library.name().to_string();

        let mut kept = String::with_capacity(text.len());
        let mut reached = 0;
        for cell in unused {
            kept += &text[reached..cell.span.start];
            reached = cell.span.end;
        }
        kept += &text[reached..];
        let digest = digest(kept.as_bytes());
        Ok(Self { name, text: kept, digest, cells, nand2, buffer, load, tie, clock_gate, femtofarads })
    }

    /// The usable cell of this name.
    pub fn cell(&self, name: &str) -> Option<&Cell> {
        self.cells.get(name)
    }

    /// Whether it has clock gates, which the parameter `clock-gating` needs.
    pub fn has_clock_gates(&self) -> bool {
        self.clock_gate.is_some()
    }

    /// The area of [`Self::nand2`].
    pub fn nand2_area(&self) -> f64 {
        self.cells[&self.nand2].area
    }
}

impl Cell {
    fn of(cell: &Group<'_>) -> Self {
        Self {
            area: area(cell),
            is_flip_flop: cell.groups.iter().any(|group| group.kind == "ff" || group.kind == "ff_bank"),
            outputs: pins(cell, "output").into_iter().map(|pin| pin.name().to_string()).collect(),
            is_clock_gate: ClockGate::of(cell).is_some(),
            logic: Logic::of(cell),
        }
    }
}

fn area(cell: &Group<'_>) -> f64 {
    cell.attribute("area").and_then(|area| area.parse().ok()).unwrap_or(0.0)
}

fn pins<'g, 'a>(cell: &'g Group<'a>, direction: &str) -> Vec<&'g Group<'a>> {
    cell.of_kind("pin").filter(|pin| pin.attribute("direction") == Some(direction)).collect()
}

/// The truth table of a combinational cell with this many inputs and one output; None for any other cell.
fn gate(cell: &Group<'_>, inputs: usize) -> Option<u64> {
    let names: Vec<&str> = pins(cell, "input").iter().map(|pin| pin.name()).collect();
    match pins(cell, "output").as_slice() {
        [output] if names.len() == inputs && output.attribute("three_state").is_none() => {
            truth_table(output.attribute("function")?, &names)
        }
        _ => None,
    }
}

fn nand2<'g, 'a>(cells: &[&'g Group<'a>]) -> Option<&'g Group<'a>> {
    let nands = cells.iter().copied().filter(|cell| gate(cell, 2) == Some(0b0111));
    nands.min_by(|a, b| area(a).total_cmp(&area(b)))
}

/// The buffer of drive strength 2 by its name (`buf_2`, `BUFX2`; the shortest name, because clock buffers have longer
/// ones), or else the smallest buffer.
fn buffer<'g, 'a>(cells: &[&'g Group<'a>]) -> Option<&'g Group<'a>> {
    let buffers = || cells.iter().copied().filter(|cell| gate(cell, 1) == Some(0b10));
    let strength = |cell: &Group<'_>| cell.name().rsplit(|c: char| !c.is_ascii_digit()).next() == Some("2");
    let double = buffers().filter(|cell| strength(cell)).min_by_key(|cell| cell.name().len());
    double.or_else(|| buffers().min_by(|a, b| area(a).total_cmp(&area(b))))
}

fn tie(cells: &[&Group<'_>]) -> Option<Tie> {
    let constant = |value: &str| {
        let mut pins = cells
            .iter()
            .filter(|cell| pins(cell, "input").is_empty())
            .flat_map(|cell| pins(cell, "output").into_iter().map(|pin| (cell.name().to_string(), pin)));
        let (cell, pin) = pins.find(|(_, pin)| pin.attribute("function") == Some(value))?;
        Some((cell, pin.name().to_string()))
    };
    Some(Tie { one: constant("1")?, zero: constant("0")? })
}

fn clock_gate(cells: &[&Group<'_>]) -> Option<ClockGateCell> {
    let gates = cells.iter().filter_map(|cell| Some((*cell, ClockGate::of(cell)?)));
    let (cell, gate) = gates.max_by(|(a, _), (b, _)| area(a).total_cmp(&area(b)))?;
    let [name, clock, enable, output] = [cell.name(), gate.clock, gate.enable, gate.output].map(str::to_string);
    Some(ClockGateCell { name, clock, enable, output })
}

/// The library's unit of capacitance, in femtofarads.
fn femtofarads(library: &Group<'_>) -> f64 {
    let unit = library.of_kind("capacitive_load_unit").next().map(|unit| unit.names.as_slice());
    match unit {
        Some([number, unit]) => {
            let scale = if unit.eq_ignore_ascii_case("ff") { 1.0 } else { 1000.0 };
            number.parse::<f64>().unwrap_or(1.0) * scale
        }
        _ => 1000.0,
    }
}

fn input_capacitance(cell: &Group<'_>) -> f64 {
    let input = pins(cell, "input").first().and_then(|pin| pin.attribute("capacitance"));
    input.and_then(|capacitance| capacitance.parse().ok()).unwrap_or(0.0)
}

/// Parts of the names of cells that synthesis must not choose, in libraries that do not mark them (`dont_use : true`):
/// sky130 contains cells for power gating and for probes.
const EXCLUDED: [&str; 2] = ["__lpflow_", "__probe"];

/// The range of areas and capacitances, in any unit.
const NUMBERS: std::ops::RangeInclusive<f64> = 0.0..=1e12;

/// Whether a measurement may use a cell.
fn is_usable(cell: &Group<'_>) -> bool {
    let marked = cell.attribute("dont_use") == Some("true") || EXCLUDED.iter().any(|part| cell.name().contains(part));
    !marked && is_name(cell.name()) && cell.of_kind("pin").all(|pin| is_name(pin.name()))
}

/// Whether a name is an identifier. Names of cells and pins go into scripts for Yosys and OpenSTA, where brackets,
/// dollars, semicolons and line ends would be commands.
fn is_name(name: &str) -> bool {
    let first = name.bytes().next();
    first.is_some_and(|first| first.is_ascii_alphabetic() || first == b'_')
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// Describes a cell's area, or a pin's capacitance, that is not a valid number. None if all are valid.
fn invalid_number(cell: &Group<'_>) -> Option<String> {
    let is_number = |text: &str| text.parse().is_ok_and(|number| NUMBERS.contains(&number));
    let wrong = |group: &Group<'_>, attribute| {
        let text = group.attribute(attribute).filter(|text| !is_number(text))?;
        Some(format!("{attribute} '{}' in cell {}", shortened(text), cell.name()))
    };
    wrong(cell, "area").or_else(|| cell.of_kind("pin").find_map(|pin| wrong(pin, "capacitance")))
}

/// The first 40 characters of a text from a file, escaped for a message.
fn shortened(text: &str) -> String {
    text.chars().take(40).flat_map(char::escape_debug).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELLS: &str = r#"
  cell ("inv_1") { area : 1.0; pin ("A") { direction : input; } pin ("Y") { direction : output; function : "!A"; } }
  cell ("nand2_2") { area : 3.0;
    pin ("A") { direction : input; } pin ("B") { direction : input; }
    pin ("Y") { direction : output; function : "!A | !B"; } }
  cell ("nand2_1") { area : 2.0;
    pin ("A") { direction : input; } pin ("B") { direction : input; }
    pin ("Y") { direction : output; function : "(!(A B))"; } }
  cell ("nand2_tiny") { area : 0.5; dont_use : true;
    pin ("A") { direction : input; } pin ("B") { direction : input; }
    pin ("Y") { direction : output; function : "(!(A B))"; } }
  cell ("lib__lpflow_nand2") { area : 0.4;
    pin ("A") { direction : input; } pin ("B") { direction : input; }
    pin ("Y") { direction : output; function : "(!(A B))"; } }
  cell ("tri_2") { area : 1.5;
    pin ("A") { direction : input; }
    pin ("Y") { direction : output; function : "A"; three_state : "!E"; } }
  cell ("clkbuf_2") { area : 1.6;
    pin ("A") { direction : input; capacitance : 0.5; } pin ("X") { direction : output; function : "A"; } }
  cell ("buf_2") { area : 1.7;
    pin ("A") { direction : input; capacitance : 0.0017; } pin ("X") { direction : output; function : "A"; } }
  cell ("buf_12") { area : 9.0;
    pin ("A") { direction : input; } pin ("X") { direction : output; function : "A"; } }
  cell ("tie") { area : 0.7;
    pin ("HI") { direction : output; function : "1"; } pin ("LO") { direction : output; function : "0"; } }
  cell ("dff") { area : 5.0; ff (IQ, IQN) { next_state : "D"; clocked_on : "CK"; }
    pin ("CK") { direction : input; } pin ("D") { direction : input; }
    pin ("Q") { direction : output; function : "IQ"; } pin ("QN") { direction : output; function : "IQN"; } }
"#;

    fn library(cells: &str, unit: &str) -> Result<Library, Error> {
        Library::of(format!("library (small) {{\n  {unit}\n{cells}}}\n"), Path::new("small.lib"))
    }

    #[test]
    fn cells_are_found_by_function() {
        let library = library(CELLS, "capacitive_load_unit (1.0, \"pf\");").expect("a library");
        assert_eq!((library.name.as_str(), library.nand2.as_str(), library.nand2_area()), ("small", "nand2_1", 2.0));
        assert_eq!((library.buffer.as_str(), library.load), ("buf_2", 17.0));
        let pin = |pin: &str| ("tie".to_string(), pin.to_string());
        assert_eq!(library.tie, Some(Tie { one: pin("HI"), zero: pin("LO") }));
        let dff = library.cell("dff").expect("a flip-flop");
        assert_eq!((dff.area, dff.is_flip_flop, dff.outputs.join(" ")), (5.0, true, "Q QN".to_string()));
        assert!(library.cell("inv_1").is_some_and(|cell| !cell.is_flip_flop));
    }

    #[test]
    fn unusable_cells_are_removed() {
        let library = library(CELLS, "").expect("a library");
        for name in ["nand2_tiny", "lib__lpflow_nand2"] {
            assert!(library.cell(name).is_none() && !library.text.contains(name), "{name}");
        }
        // The remaining text is still Liberty, with all other cells.
        assert_eq!(liberty::read(&library.text).expect("Liberty").of_kind("cell").count(), 9);
    }

    #[test]
    fn units_of_capacitance_and_other_buffers() {
        let few: String = CELLS.replace("\"buf_2\"", "\"buffer\"").replace("\"clkbuf_2\"", "\"clkbuf_1\"");
        let library = library(&few, "capacitive_load_unit (2, ff);").expect("a library");
        assert_eq!((library.buffer.as_str(), library.load), ("clkbuf_1", 10.0));
    }

    #[test]
    fn missing_cells_are_named() {
        let fails = |cells: &str| library(cells, "").expect_err("an error").to_string();
        assert_eq!(fails(""), "small.lib: no NAND with two inputs in this library, expected one");
        let no_buffer = CELLS.replace("function : \"A\"", "function : \"!A\"");
        assert_eq!(fails(&no_buffer), "small.lib: no buffer in this library, expected one");
        assert_eq!(fails("cell"), "small.lib:3: found '}', expected ':' or '('");
        let error = Library::read(Path::new("/nonexistent.lib")).expect_err("an error").to_string();
        assert!(error.starts_with("/nonexistent.lib: cannot read:"), "{error}");
    }

    #[test]
    fn plain_and_compressed() {
        let folder = tempfile::tempdir().expect("a folder");
        let text = format!("library (small) {{ {CELLS} }}");
        let plain = folder.path().join("plain.lib");
        std::fs::write(&plain, &text).expect("written");
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut encoder, text.as_bytes()).expect("compressed");
        let compressed = folder.path().join("compressed.lib.gz");
        std::fs::write(&compressed, encoder.finish().expect("compressed")).expect("written");
        let [plain, compressed] = [plain, compressed].map(|path| Library::read(&path).expect("a library"));
        assert_eq!((&plain.text, &plain.digest), (&compressed.text, &compressed.digest));
    }
}
