//! Emitted text, compiled by Verilator and run as a process.

use crate::sources::{Sources, write};
use crate::{CosimError, harness, tool};
use raypath_hdl::Module;
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::Arc;

pub(crate) const VERILATOR: &str = "apt-get install verilator g++ make";

/// Bytes buffered in either direction.
const BUFFER: usize = 1 << 16;

/// How to build.
#[derive(Debug, Clone)]
pub struct Options {
    /// The `-O` with which the C++ that runs in every cycle is compiled: 0 is built in a third of the time of 1 and runs
    /// some 30,000 cycles of the datapath a second all the same; 3 is for measuring speed.
    pub c_optimisation: u32,
    /// Whether the C++ may use all instructions of this machine (`-march=native`).
    pub native: bool,
    /// Compilers at a time.
    pub jobs: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { c_optimisation: 0, native: false, jobs: std::thread::available_parallelism().map_or(1, usize::from) }
    }
}

/// A module's text as a program.
///
/// Registers without a reset begin with 0, and a reset has just ended: what Verilog leaves open is chosen as
/// [`raypath_hdl::Simulator`] chooses it, so that both agree from the first cycle on, whatever the stimuli.
#[derive(Debug)]
pub struct Verilated {
    program: PathBuf,
    inputs: usize,
    outputs: usize,
}

impl Verilated {
    /// Prints `top` into `folder` and compiles it there.
    pub fn build(top: &Arc<Module>, folder: &Path) -> Result<Self, CosimError> {
        Self::build_with(top, folder, &Options::default())
    }

    /// The same with options.
    pub fn build_with(top: &Arc<Module>, folder: &Path, options: &Options) -> Result<Self, CosimError> {
        Self::build_sources(&Sources::write(top, folder)?.files, top, folder, options)
    }

    /// Compiles text that exists already, in `folder`. Of `top`, name and ports are taken.
    pub fn build_sources(
        files: &[PathBuf],
        top: &Module,
        folder: &Path,
        options: &Options,
    ) -> Result<Self, CosimError> {
        // Verilator's makefile runs in a folder of its own.
        let folder = &folder.canonicalize().map_err(|problem| failed(folder, problem))?;
        let main = folder.join("main.cpp");
        write(&main, &harness::main_file(top))?;
        let objects = folder.join("obj");
        let mut command = Command::new("verilator");
        command.args([
            "--cc",
            "--exe",
            "--build",
            "--assert",
            "-O3",
            "--x-assign",
            "0",
            "--x-initial",
            "0",
            "--prefix",
            "Vtop",
        ]);
        // Half of the C++ runs once, at the beginning: it is not worth a compiler's time.
        let optimisation = options.c_optimisation;
        let levels = format!("OPT_FAST=-O{optimisation} OPT_GLOBAL=-O{optimisation} OPT_SLOW=-O0");
        command.args(["-MAKEFLAGS", &levels, "-j", &options.jobs.max(1).to_string()]);
        if optimisation == 0 {
            // Then most of the time is the header's, which every file reads again: one file for all.
            command.args(["--output-split", "0"]);
        }
        if options.native {
            command.args(["-CFLAGS", "-march=native"]);
        }
        command.args(["--top-module", top.name(), "-Mdir"]).arg(&objects).args(files).arg(&main);
        tool::run(&mut command, VERILATOR)?;
        Ok(Self { program: objects.join("Vtop"), inputs: harness::input_words(top), outputs: top.outputs().len() })
    }

    /// Runs a cycle for each frame of inputs: `rst_ni`, if there is one, then the inputs in the order of declaration.
    /// In each, the inputs settle, `on_outputs` gets the cycle's number and the outputs in the order of declaration, and
    /// the clock rises. `rst_ni` is asynchronous. Every run begins anew.
    pub fn run(
        &self,
        frames: impl IntoIterator<Item = Vec<u64>, IntoIter: Send>,
        on_outputs: impl FnMut(usize, &[u64]),
    ) -> Result<(), CosimError> {
        let failed = |problem| failed(&self.program, problem);
        let child = Command::new(&self.program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().map_err(failed)?;
        let mut process = Process(child);
        let (Some(input), Some(output)) = (process.0.stdin.take(), process.0.stdout.take()) else {
            return Err(failed(io::Error::from(ErrorKind::BrokenPipe)));
        };
        let frames = frames.into_iter();
        // Both pipes at once: neither side may wait for the other with a full pipe.
        let (sent, received, status) = std::thread::scope(|scope| {
            // In here, so that after a panic it ends before the scope waits for the writer, which waits for it.
            let mut process = process;
            let writer = scope.spawn(|| self.send(frames, input));
            let received = self.receive(BufReader::with_capacity(BUFFER, output), on_outputs);
            (writer.join(), received, process.0.wait())
        });
        let status = status.map_err(failed)?;
        let sent = sent.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        let received = received?;
        if !status.success() || sent != received {
            let output = format!("{status} after {received} of {sent} cycles");
            return Err(CosimError::Tool { tool: self.program.display().to_string(), output });
        }
        Ok(())
    }

    /// How long the model takes for these frames, in seconds, without the pipes: each of `times` runs through all of them.
    pub fn time(&self, frames: impl Iterator<Item = Vec<u64>>, times: usize) -> Result<Vec<f64>, CosimError> {
        let failed = |problem| failed(&self.program, problem);
        let mut command = Command::new(&self.program);
        command.arg(times.to_string()).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut process = Process(command.spawn().map_err(failed)?);
        let (Some(input), Some(mut output)) = (process.0.stdin.take(), process.0.stdout.take()) else {
            return Err(failed(io::Error::from(ErrorKind::BrokenPipe)));
        };
        // Nothing is written before all is read, so one pipe after the other.
        self.send(frames, input)?;
        let mut text = String::new();
        output.read_to_string(&mut text).map_err(failed)?;
        let status = process.0.wait().map_err(failed)?;
        let seconds: Vec<f64> = text.lines().map_while(|line| line.parse().ok()).collect();
        if !status.success() || seconds.len() != times {
            let output = format!("{status} after {} of {times} runs", seconds.len());
            return Err(CosimError::Tool { tool: self.program.display().to_string(), output });
        }
        Ok(seconds)
    }

    /// Gives the number of frames sent. A reader that has gone away is no error here: its status tells more.
    fn send(&self, frames: impl Iterator<Item = Vec<u64>>, input: ChildStdin) -> Result<usize, CosimError> {
        let mut pipe = BufWriter::with_capacity(BUFFER, input);
        let mut sent = 0;
        for frame in frames {
            if frame.len() != self.inputs {
                return Err(CosimError::Frame { cycle: sent, found: frame.len(), expected: self.inputs });
            }
            let words = if frame.is_empty() { &[0] } else { frame.as_slice() };
            sent += 1;
            for word in words {
                match pipe.write_all(&word.to_le_bytes()) {
                    Err(problem) if problem.kind() == ErrorKind::BrokenPipe => return Ok(sent),
                    other => other.map_err(|problem| failed(&self.program, problem))?,
                }
            }
        }
        match pipe.flush() {
            Err(problem) if problem.kind() != ErrorKind::BrokenPipe => Err(failed(&self.program, problem)),
            _ => Ok(sent),
        }
    }

    /// Gives the number of frames received.
    fn receive(&self, mut pipe: impl Read, mut on_outputs: impl FnMut(usize, &[u64])) -> Result<usize, CosimError> {
        let mut bytes = vec![0; 8 * self.outputs.max(1)];
        let mut words = vec![0; self.outputs];
        for cycle in 0.. {
            match pipe.read_exact(&mut bytes) {
                Err(problem) if problem.kind() == ErrorKind::UnexpectedEof => return Ok(cycle),
                other => other.map_err(|problem| failed(&self.program, problem))?,
            }
            for (word, bytes) in words.iter_mut().zip(bytes.as_chunks().0) {
                *word = u64::from_le_bytes(*bytes);
            }
            on_outputs(cycle, &words);
        }
        Ok(0)
    }
}

/// A process that does not outlive this.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        // Both fail where it has ended and been waited for, which is as it should be.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn failed(path: &Path, problem: io::Error) -> CosimError {
    CosimError::File { path: path.to_path_buf(), problem }
}
