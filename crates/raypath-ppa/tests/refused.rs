//! Cell libraries that are refused, or of which some cells are left out.

use flate2::{Compression, write::GzEncoder};
use raypath_ppa::{Error, Library};
use raypath_tools::ToolError;
use std::io::Write;
use std::path::Path;

const CELLS: &str = r#"library (small) {
  capacitive_load_unit (1, ff);
  cell (BUF) { area : 1.5;
    pin (A) { direction : input; capacitance : 2; } pin (Y) { direction : output; function : "A"; } }
  cell (NAND) { area : 2.5;
    pin (A) { direction : input; } pin (B) { direction : input; }
    pin (Y) { direction : output; function : "!(A B)"; } }
  cell (OTHER) { area : 1; pin (P) { direction : input; } }
}
"#;

fn read(text: &str) -> Result<Library, String> {
    Library::read_from(text.as_bytes(), Path::new("small.lib")).map_err(|error| error.to_string())
}

/// Such numbers would become areas, loads and clocks of `inf` and `NaN`, and reports that cannot be read again.
#[test]
fn invalid_numbers_are_refused() {
    assert!(read(CELLS).is_ok_and(|library| (library.nand2_area(), library.load) == (2.5, 20.0)));
    for number in ["inf", "NaN", "-1", "1e999", "1e13", "two", ""] {
        let error = read(&CELLS.replace("2.5", number)).expect_err(number);
        let expected = format!("small.lib:5: found area '{number}' in cell NAND, expected a number from 0 to 1e12");
        assert_eq!(error, expected);
        let error = read(&CELLS.replace("capacitance : 2", &format!("capacitance : {number}"))).expect_err(number);
        assert!(error.starts_with(&format!("small.lib:3: found capacitance '{number}' in cell BUF")), "{error}");
    }
    let error = read(&CELLS.replace("2.5", "0")).expect_err("no area");
    assert_eq!(error, "small.lib:5: found NAND without an area, expected one above 0, the unit of gate counts");
    let error = read(&CELLS.replace("(1, ff)", "(inf, ff)")).expect_err("no unit");
    assert!(error.starts_with("small.lib:3: found a load of inf fF"), "{error}");
}

/// The second cell's area would count for the first one, which was chosen for its own.
#[test]
fn two_cells_of_one_name_are_refused() {
    let error = read(&CELLS.replace("cell (OTHER) { area : 1;", "cell (NAND) { area : 0;")).expect_err("two NANDs");
    assert_eq!(error, "small.lib:8: found another cell NAND, expected one cell of each name");
}

/// A message shows the beginning of the found text, with control characters escaped.
#[test]
fn messages_are_short_and_harmless() {
    let error = read(&CELLS.replace("2.5", &format!("\u{1b}[2J{}", "9".repeat(100_000)))).expect_err("no number");
    assert!(error.len() < 200 && error.contains(r"\u{1b}[2J999"), "{error}");
}

/// Names go into scripts, where `x[exec touch y]` would be a command to OpenSTA, and a line end one to Yosys.
#[test]
fn names_that_scripts_would_execute_are_excluded() {
    for name in ["x[exec touch y]", "a b", "a;b", "a\nshell b", "$a", "a$b", "1a", "é"] {
        let quoted = format!("(\"{name}\")");
        let without = read(&CELLS.replace("(OTHER)", &quoted)).expect("a library");
        assert!(without.cell(name).is_none() && !without.text.contains(&quoted), "{name}");
        let without = read(&CELLS.replace("(P)", &quoted)).expect("a library");
        assert!(without.cell("OTHER").is_none() && !without.text.contains(&quoted), "{name}");
        let error = read(&CELLS.replace("(NAND)", &quoted)).expect_err("the only NAND");
        assert!(error.ends_with("no NAND with two inputs in this library, expected one"), "{error}");
    }
}

/// 300 MiB in about 300 KiB.
#[test]
fn a_gzip_bomb_is_an_error() {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    let blanks = vec![b' '; 1 << 20];
    (0..300).for_each(|_| encoder.write_all(&blanks).expect("compressed"));
    let bomb = encoder.finish().expect("compressed");
    assert!(bomb.len() < 2 << 20);
    let error = Library::read_from(bomb.as_slice(), Path::new("bomb.lib.gz")).expect_err("a bomb");
    let Error::Tool(ToolError::File { problem, .. }) = &error else { panic!("{error}") };
    assert_eq!(problem.kind(), std::io::ErrorKind::FileTooLarge, "{error}");
}
