//! SystemVerilog simulated with the values 0, 1 and unknown, by Yosys and Icarus Verilog.
//!
//! In the simulation semantics of SystemVerilog, `if` and `case` with an unknown condition take one branch, which hides
//! the unknown value. Yosys therefore rewrites the text first: each branch becomes `?:`, whose value is unknown where
//! its operands differ, and a memory becomes registers and multiplexers. Icarus Verilog simulates the result. A value
//! that is known there is known, and the same, in a simulation of the original text.

use crate::files::write;
use crate::{Program, ToolError, Yosys};
use raypath_hdl::Module;
use raypath_hdl::text::PortGroup;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;

pub(crate) static ICARUS: Program = Program {
    name: "iverilog",
    expected: "Icarus Verilog 11 or newer",
    install: "apt-get install iverilog",
    version: &["iverilog", "-V"],
};

/// The names of files.
const REWRITTEN: &str = "rewritten.v";
const BENCH: &str = "bench.v";
const FRAMES: &str = "frames.txt";
const PROGRAM: &str = "bench.vvp";

/// A module's SystemVerilog, compiled for simulation with unknown values.
///
/// Registers and memories begin with unknown values. Unlike a [`Verilated`](crate::Verilated) module, it gets no reset
/// before the first frame.
#[derive(Debug)]
pub struct FourState {
    folder: PathBuf,
    /// The widths of `rst_ni`, if there is one, and of the inputs.
    inputs: Vec<u32>,
    outputs: usize,
}

/// A word at a port; none if one of its bits is unknown.
pub type KnownWord = Option<u64>;

impl FourState {
    /// Compiles a text in `folder`. `top` gives the name and the ports.
    ///
    /// # Errors
    /// Yosys or Icarus Verilog is missing or fails; a file cannot be written.
    pub fn build(text: &str, top: &Module, folder: &Path) -> Result<Self, ToolError> {
        let folder = folder.canonicalize().map_err(|problem| ToolError::file(folder, "find", problem))?;
        write(&folder.join("printed.sv"), text)?;
        let script = format!(
            "read_verilog -sv printed.sv\nhierarchy -top {}\nproc -noopt -norom\npmuxtree\nmemory_collect\nmemory_map\n\
             opt_clean\nwrite_verilog -noattr {REWRITTEN}\n",
            top.name()
        );
        write(&folder.join("rewrite.ys"), &script)?;
        Yosys::find(None)?.run(&folder, "rewrite.ys", top.name(), &AtomicBool::new(false))?;
        write(&folder.join(BENCH), &bench(top))?;
        let mut command = Command::new("iverilog");
        command.current_dir(&folder).args(["-g2012", "-s", "bench", "-o", PROGRAM, BENCH, REWRITTEN]);
        ICARUS.output(&mut command)?;
        let inputs = input_widths(top).map(|(_, width)| width).collect();
        Ok(Self { folder, inputs, outputs: top.outputs().len() })
    }

    /// Runs a cycle for each frame of inputs: `rst_ni`, if the module has one, then the inputs in the order of
    /// declaration. In each cycle the inputs settle, `on_outputs` gets the cycle's number and the outputs in the order
    /// of declaration, and the clock rises. The run ends when `on_outputs` returns false.
    ///
    /// # Errors
    /// A frame has a wrong number of words; the program fails.
    pub fn run(
        &self,
        frames: impl IntoIterator<Item = Vec<KnownWord>>,
        mut on_outputs: impl FnMut(usize, &[KnownWord]) -> bool,
    ) -> Result<(), ToolError> {
        let (path, count) = (self.folder.join(FRAMES), self.write_frames(frames)?);
        let failed = |problem| ToolError::file(&self.folder.join(PROGRAM), "run", problem);
        let input = File::open(&path).map_err(|problem| ToolError::file(&path, "read", problem))?;
        let mut command = Command::new("vvp");
        command.current_dir(&self.folder).args(["-n", PROGRAM]).stdin(input).stdout(Stdio::piped());
        let mut process = command.spawn().map_err(failed)?;
        let mut seen = 0;
        for line in process.stdout.take().into_iter().flat_map(|output| BufReader::new(output).lines()) {
            let line = line.map_err(failed)?;
            // In hexadecimal, `x` and `X` are digits with unknown bits, `z` and `Z` digits that nothing drives.
            let words: Vec<KnownWord> = line.split(' ').map(|word| u64::from_str_radix(word, 16).ok()).collect();
            if words.len() != self.outputs {
                return Err(ToolError::unexpected("vvp", line, format!("{} words", self.outputs)));
            }
            seen += 1;
            if !on_outputs(seen - 1, &words) {
                // It fails if the program has ended.
                let _ = process.kill();
                process.wait().map_err(failed)?;
                return Ok(());
            }
        }
        let status = process.wait().map_err(failed)?;
        if !status.success() || seen != count {
            let output = format!("{status} after {seen} of {count} cycles");
            return Err(ToolError::Failed { program: "vvp".to_string(), about: None, output });
        }
        Ok(())
    }

    /// Writes a line for each frame. Returns the number of frames.
    fn write_frames(&self, frames: impl IntoIterator<Item = Vec<KnownWord>>) -> Result<usize, ToolError> {
        let mut lines = String::new();
        let mut count = 0;
        for frame in frames {
            if frame.len() != self.inputs.len() {
                return Err(ToolError::Frame { cycle: count, found: frame.len(), expected: self.inputs.len() });
            }
            count += 1;
            // The first word is in the lowest bits.
            for (word, &width) in frame.iter().zip(&self.inputs).rev() {
                let digits = width.div_ceil(4) as usize;
                match word {
                    Some(word) => lines += &format!("{:0digits$x}", word & (u64::MAX >> (64 - width))),
                    None => lines += &"x".repeat(digits),
                }
            }
            lines.push('\n');
        }
        write(&self.folder.join(FRAMES), &lines)?;
        Ok(count)
    }
}

/// The names and widths of `rst_ni`, if there is one, and of the inputs.
fn input_widths(top: &Module) -> impl Iterator<Item = (&str, u32)> {
    let inputs = top.inputs().iter().map(|port| (port.name.as_str(), top.signal(port.signal).width));
    top.has_reset().then_some(("rst_ni", 1)).into_iter().chain(inputs)
}

/// The module around `top`. It reads a frame from standard input in each cycle, and writes the outputs.
fn bench(top: &Module) -> String {
    let mut ports: Vec<String> = top.is_clocked().then(|| ".clk_i (clk)".to_string()).into_iter().collect();
    let mut wires = String::new();
    let mut low = 0;
    let vector = top.text().input.as_ref();
    if let Some(group) = vector {
        let width: u32 = input_widths(top).filter(|(name, _)| is_member(group, name)).map(|(_, width)| width).sum();
        wires += &format!("  wire [{}:0] {};\n", width - 1, group.name);
        ports.push(format!(".{0} ({0})", group.name));
    }
    for (name, width) in input_widths(top) {
        let bits = format!("frame[{}:{low}]", low + width - 1);
        // Each word begins at a digit.
        low += width.next_multiple_of(4);
        match vector.and_then(|group| Some((group, group.members.iter().find(|(member, _)| member == name)?))) {
            Some((group, (_, select))) => wires += &format!("  assign {}{select} = {bits};\n", group.name),
            None => ports.push(format!(".{name} ({bits})")),
        }
    }
    let mut shown = Vec::new();
    for port in top.outputs() {
        wires += &format!("  wire [{}:0] {};\n", top.signal(port.signal).width - 1, port.name);
        ports.push(format!(".{0} ({0})", port.name));
        shown.push(port.name.as_str());
    }
    format!(
        r#"module bench;
  // The descriptor of standard input.
  localparam Input = 32'h8000_0000;
  reg clk;
  reg [{last}:0] frame;
{wires}  {name} top (
    {ports}
  );
  initial begin
    clk = 0;
    while ($fscanf(Input, "%h", frame) == 1) begin
      #1 $display("{format}", {shown});
      clk = 1;
      #1 clk = 0;
    end
    $finish(0);
  end
endmodule
"#,
        last = low.max(1) - 1,
        name = top.name(),
        ports = ports.join(",\n    "),
        format = vec!["%h"; shown.len()].join(" "),
        shown = shown.join(", "),
    )
}

fn is_member(group: &PortGroup, name: &str) -> bool {
    group.members.iter().any(|(member, _)| member == name)
}
