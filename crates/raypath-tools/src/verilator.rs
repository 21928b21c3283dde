//! SystemVerilog compiled by Verilator, and run as a process.

use crate::files::{read, temporary_folder, write};
use crate::verilator_coverage::{CoveragePoint, points};
use crate::{Program, Sources, ToolError, verilator_main, verilator_stream};
use raypath_hdl::Module;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use tempfile::NamedTempFile;

pub(crate) static VERILATOR: Program = Program {
    name: "verilator",
    expected: "Verilator 5.006 or newer",
    install: "apt-get install verilator g++ make",
    version: &["verilator", "--version"],
};

/// Bytes buffered in either direction.
const BUFFER: usize = 1 << 16;

/// How Verilator's model is compiled.
#[derive(Debug, Clone)]
pub struct Options {
    /// The optimisation level, `-O`, of the C++ that runs in every cycle. 0 compiles in a third of the time of 1, and
    /// simulates about 30,000 cycles of the default datapath a second; 3 is for measuring speed.
    pub c_optimisation: u32,
    /// Whether the C++ may use all instructions of this machine (`-march=native`).
    pub native: bool,
    /// The number of compilers that run at a time.
    pub jobs: usize,
    /// Whether lines and branches are counted, for [`Verilated::coverage`].
    pub coverage: bool,
    /// A folder that keeps compiled programs, so that none is compiled twice from the same texts. By default the one
    /// that the environment variable `RAYPATH_VERILATED` names.
    pub kept: Option<PathBuf>,
}

impl Default for Options {
    fn default() -> Self {
        let jobs = std::thread::available_parallelism().map_or(1, usize::from);
        let kept = std::env::var_os("RAYPATH_VERILATED").map(PathBuf::from);
        Self { c_optimisation: 0, native: false, jobs, coverage: false, kept }
    }
}

/// A module's SystemVerilog, compiled into a program.
///
/// A reset ends before the first cycle. Registers without a reset and memories begin with 0 in [`run`](Self::run), and
/// with random values in [`run_randomly`](Self::run_randomly). Where Verilog leaves a choice, it is that of
/// [`raypath_hdl::Simulator`], so that both agree from the first cycle on for all stimuli if they begin with 0.
#[derive(Debug)]
pub struct Verilated {
    program: PathBuf,
    inputs: usize,
    outputs: usize,
}

impl Verilated {
    /// Writes `top` into `folder` and compiles it there with the default options.
    ///
    /// # Errors
    /// Verilator is missing or fails; a file cannot be written.
    pub fn build(top: &Arc<Module>, folder: &Path) -> Result<Self, ToolError> {
        Self::build_with(top, folder, &Options::default())
    }

    /// Writes `top` into `folder` and compiles it there.
    ///
    /// # Errors
    /// As for [`Self::build`].
    pub fn build_with(top: &Arc<Module>, folder: &Path, options: &Options) -> Result<Self, ToolError> {
        Self::build_sources(&Sources::write(top, folder)?.files, top, folder, options)
    }

    /// Compiles existing files in `folder`. `top` gives the name and the ports.
    ///
    /// # Errors
    /// As for [`Self::build`].
    pub fn build_sources(files: &[PathBuf], top: &Module, folder: &Path, options: &Options) -> Result<Self, ToolError> {
        let program = compile(files, top, &verilator_main::main_file(top), folder, options)?;
        Ok(Self { program, inputs: verilator_main::input_words(top), outputs: top.outputs().len() })
    }

    /// Runs a cycle for each frame of inputs: `rst_ni`, if the module has one, then the inputs in the order of
    /// declaration. In each cycle the inputs settle, `on_outputs` gets the cycle's number and the outputs in the order
    /// of declaration, and the clock rises. `rst_ni` is asynchronous. Every run begins in the initial state.
    ///
    /// # Errors
    /// A frame has a wrong number of words; the program fails, as it does when an assertion fails.
    pub fn run(
        &self,
        frames: impl IntoIterator<Item = Vec<u64>, IntoIter: Send>,
        on_outputs: impl FnMut(usize, &[u64]),
    ) -> Result<(), ToolError> {
        self.run_from(&[ZEROS.to_string()], frames, on_outputs)
    }

    /// As [`run`](Self::run), but registers without a reset and memories begin with random values, which follow from
    /// the seed: what hardware shows must not depend on them.
    ///
    /// # Errors
    /// As for [`Self::run`].
    pub fn run_randomly(
        &self,
        seed: u32,
        frames: impl IntoIterator<Item = Vec<u64>, IntoIter: Send>,
        on_outputs: impl FnMut(usize, &[u64]),
    ) -> Result<(), ToolError> {
        self.run_from(&[initial_state(seed)], frames, on_outputs)
    }

    /// As [`run_randomly`](Self::run_randomly), but no reset ends before the first cycle: the frames have it.
    ///
    /// # Errors
    /// As for [`Self::run`].
    pub fn run_from_power_up(
        &self,
        seed: u32,
        frames: impl IntoIterator<Item = Vec<u64>, IntoIter: Send>,
        on_outputs: impl FnMut(usize, &[u64]),
    ) -> Result<(), ToolError> {
        self.run_from(&[format!("-{}", initial_state(seed))], frames, on_outputs)
    }

    /// As [`run`](Self::run), with the coverage of the run. The program must have been built with
    /// [`Options::coverage`].
    ///
    /// # Errors
    /// As for [`Self::run`]; the program counts nothing.
    pub fn coverage(
        &self,
        frames: impl IntoIterator<Item = Vec<u64>, IntoIter: Send>,
        on_outputs: impl FnMut(usize, &[u64]),
    ) -> Result<Vec<CoveragePoint>, ToolError> {
        let folder = temporary_folder()?;
        let file = folder.path().join("coverage.dat");
        self.run_from(&[ZEROS.to_string(), file.display().to_string()], frames, on_outputs)?;
        points(&read(&file)?)
    }

    fn run_from(
        &self,
        arguments: &[String],
        frames: impl IntoIterator<Item = Vec<u64>, IntoIter: Send>,
        on_outputs: impl FnMut(usize, &[u64]),
    ) -> Result<(), ToolError> {
        let (process, input, output) = start(&self.program, arguments)?;
        let frames = frames.into_iter();
        // A thread writes while this one reads, so that neither side waits for the other with a full pipe.
        let (sent, received, status) = std::thread::scope(|scope| {
            // Moved into the scope: after a panic the process ends before the scope waits for the writer.
            let mut process = process;
            let writer = scope.spawn(|| self.send(frames, input));
            let received = self.receive(BufReader::with_capacity(BUFFER, output), on_outputs);
            (writer.join(), received, process.0.wait())
        });
        let status = status.map_err(|problem| failed(&self.program, problem))?;
        let sent = sent.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        let received = received?;
        if !status.success() || sent != received {
            let output = format!("{status} after {received} of {sent} cycles");
            return Err(ended(&self.program, output));
        }
        Ok(())
    }

    /// Measures `times` runs of the model through all frames, without the pipes. Returns the seconds of each run.
    ///
    /// # Errors
    /// As for [`Self::run`].
    pub fn time(&self, frames: impl Iterator<Item = Vec<u64>>, times: usize) -> Result<Vec<f64>, ToolError> {
        let failed = |problem| failed(&self.program, problem);
        let (mut process, input, mut output) = start(&self.program, &[ZEROS.to_string(), times.to_string()])?;
        // The program reads all frames before it writes anything.
        self.send(frames, input)?;
        let mut text = String::new();
        output.read_to_string(&mut text).map_err(failed)?;
        let status = process.0.wait().map_err(failed)?;
        let seconds: Vec<f64> = text.lines().map_while(|line| line.parse().ok()).collect();
        if !status.success() || seconds.len() != times {
            let output = format!("{status} after {} of {times} runs", seconds.len());
            return Err(ended(&self.program, output));
        }
        Ok(seconds)
    }

    /// Sends frames and returns their number. If the program has ended, that is no error here: its status tells more.
    fn send(&self, frames: impl Iterator<Item = Vec<u64>>, input: ChildStdin) -> Result<usize, ToolError> {
        let mut pipe = BufWriter::with_capacity(BUFFER, input);
        let mut sent = 0;
        for frame in frames {
            if frame.len() != self.inputs {
                return Err(ToolError::Frame { cycle: sent, found: frame.len(), expected: self.inputs });
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

    /// Receives frames of outputs and returns their number.
    fn receive(&self, mut pipe: impl Read, mut on_outputs: impl FnMut(usize, &[u64])) -> Result<usize, ToolError> {
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

/// A module with a stream of words in and one out, compiled into a program whose standard input and output are these
/// streams, in bytes: the other side of a host.
#[derive(Debug)]
pub struct VerilatedStream {
    program: PathBuf,
}

impl VerilatedStream {
    /// Compiles existing files in `folder`. The ports of `top` besides clock and reset are `data_i`, `valid_i`,
    /// `ready_o` and `data_o`, `valid_o`, `ready_i`; data have 8 or 32 bits.
    ///
    /// # Errors
    /// As for [`Verilated::build`].
    pub fn build(files: &[PathBuf], top: &Module, folder: &Path, options: &Options) -> Result<Self, ToolError> {
        Ok(Self { program: compile(files, top, &verilator_stream::main_file(top), folder, options)? })
    }

    /// Starts the program with random values in registers and memories, which follow from the seed. `host` gets the two
    /// streams; when it returns, the input is closed and the program ends.
    ///
    /// # Errors
    /// The program cannot be started or fails; the host's errors.
    pub fn run<T>(
        &self,
        seed: u32,
        host: impl FnOnce(ChildStdin, ChildStdout) -> io::Result<T>,
    ) -> Result<T, ToolError> {
        let (mut process, input, output) = start(&self.program, &[initial_state(seed)])?;
        let result = host(input, output).map_err(|problem| failed(&self.program, problem))?;
        let status = process.0.wait().map_err(|problem| failed(&self.program, problem))?;
        match status.success() {
            true => Ok(result),
            false => Err(ended(&self.program, status.to_string())),
        }
    }
}

/// Compiles files with a C++ program around them, unless the program is kept. Returns its path.
fn compile(
    files: &[PathBuf],
    top: &Module,
    main_text: &str,
    folder: &Path,
    options: &Options,
) -> Result<PathBuf, ToolError> {
    let kept = kept_program(files, top, main_text, options)?;
    if let Some(kept) = kept.as_deref().filter(|kept| kept.exists()) {
        return Ok(kept.to_path_buf());
    }
    // Verilator's makefile runs in a folder of its own.
    let folder = &folder.canonicalize().map_err(|problem| ToolError::file(folder, "find", problem))?;
    let main = folder.join("main.cpp");
    write(&main, main_text)?;
    let objects = folder.join("obj");
    let mut command = Command::new("verilator");
    let fixed = "--cc --exe --build --assert -O3 --x-assign 0 --x-initial unique --prefix Vtop";
    command.args(fixed.split(' '));
    // Half of the C++ runs once, at the start, and is not worth optimising. In one file it gets the level of the rest.
    let optimisation = options.c_optimisation;
    let levels = format!("OPT_FAST=-O{optimisation} OPT_GLOBAL=-O{optimisation} OPT_SLOW=-O0");
    command.args(["-MAKEFLAGS", &levels, "-j", &options.jobs.max(1).to_string()]);
    if optimisation < 2 {
        // Most of the time goes into the header, which every file includes: one file is faster than many. With the
        // limit 0, Verilator 5.006 splits the file at each constant.
        command.args(["--output-split", "1000000000"]);
    }
    if options.coverage {
        command.arg("--coverage-line");
    }
    if options.native {
        command.args(["-CFLAGS", "-march=native"]);
    }
    command.args(["--top-module", top.name(), "-Mdir"]).arg(&objects).args(files).arg(&main);
    VERILATOR.output(&mut command)?;
    let program = objects.join("Vtop");
    if let Some(kept) = kept {
        keep(&program, &kept).map_err(|problem| ToolError::file(&kept, "write", problem))?;
    }
    Ok(program)
}

/// The first argument of a program, for an initial state of zeros. Others are seeds of a random one.
const ZEROS: u32 = 0;

/// The first argument of a program that begins with random values. Verilator's generator has seeds from 1 to 2³¹ - 1.
fn initial_state(seed: u32) -> String {
    (seed % (u32::MAX / 2) + 1).to_string()
}

/// Starts a program with pipes in both directions.
fn start(program: &Path, arguments: &[String]) -> Result<(Process, ChildStdin, ChildStdout), ToolError> {
    let failed = |problem| failed(program, problem);
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut process = Process(command.spawn().map_err(failed)?);
    match (process.0.stdin.take(), process.0.stdout.take()) {
        (Some(input), Some(output)) => Ok((process, input, output)),
        _ => Err(failed(io::Error::from(ErrorKind::BrokenPipe))),
    }
}

fn ended(program: &Path, output: String) -> ToolError {
    ToolError::Failed { program: program.display().to_string(), about: None, output }
}

/// The place of the program of these texts in the folder of kept programs, if there is one.
fn kept_program(files: &[PathBuf], top: &Module, main: &str, options: &Options) -> Result<Option<PathBuf>, ToolError> {
    let Options { c_optimisation, native, coverage, kept: Some(folder), .. } = options else {
        return Ok(None);
    };
    let mut key = DefaultHasher::new();
    (VERILATOR.version()?, top.name(), main, c_optimisation, native, coverage).hash(&mut key);
    for file in files {
        read(file)?.hash(&mut key);
    }
    Ok(Some(folder.join(format!("{:016x}", key.finish()))))
}

/// Keeps a program. It appears complete or not at all.
fn keep(program: &Path, kept: &Path) -> io::Result<()> {
    let folder = kept.parent().unwrap_or(kept);
    fs::create_dir_all(folder)?;
    let copy = NamedTempFile::new_in(folder)?.into_temp_path();
    fs::copy(program, &copy)?;
    copy.persist(kept).map_err(|problem| problem.error)
}

/// A process that is killed when this is dropped.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        // Both fail if it has ended and has been waited for.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn failed(path: &Path, problem: io::Error) -> ToolError {
    ToolError::file(path, "run", problem)
}
