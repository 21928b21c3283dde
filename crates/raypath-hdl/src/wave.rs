//! Waveforms of a simulation as FST files, for GTKWave, Surfer and other viewers.

use crate::verilog::RAM;
use crate::{Module, Probe, Simulator};
use fst_writer::{
    FstBodyWriter, FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalId, FstSignalType, FstVarDirection,
    FstVarType,
};
use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::NamedTempFile;

/// A waveform that cannot be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("waveform {}: {problem}", path.display())]
pub struct WaveError {
    /// The file.
    pub path: PathBuf,
    /// The error.
    pub problem: String,
}

/// A writer of the signals that a [`Simulator`] observes, with the clock and the reset of the top module. A cycle takes
/// 10 ns.
///
/// [`finish`](Self::finish) creates the file. A writer that failed or is dropped before leaves no file.
///
/// ```no_run
/// # fn waves(module: &std::sync::Arc<raypath_hdl::Module>) -> Result<(), Box<dyn std::error::Error>> {
/// use raypath_hdl::Simulator;
/// use raypath_hdl::wave::WaveWriter;
/// let mut simulator = Simulator::observing(module, |_| true)?;
/// let mut waves = WaveWriter::create("run.fst", &simulator)?;
/// for cycle in 0..100 {
///     simulator.cycle();
///     waves.sample(&simulator, cycle)?;
/// }
/// waves.finish()?;
/// # Ok(())
/// # }
/// ```
pub struct WaveWriter {
    /// The path as given, for errors.
    path: PathBuf,
    /// The path of the file: the target if `path` is a symbolic link.
    target: PathBuf,
    /// `None` after an error. It writes to a temporary file, which is removed on drop.
    body: Option<Body>,
    clock: Option<FstSignalId>,
    reset: Option<Wave>,
    waves: Vec<(Probe, Wave)>,
    /// The least cycle that may be sampled next.
    next_cycle: u64,
}

/// A signal in the file, with the value that was written last.
struct Wave {
    id: FstSignalId,
    width: u32,
    shown: Option<u64>,
}

type Body = FstBodyWriter<BufWriter<NamedTempFile>>;

const NS_PER_CYCLE: u64 = 10;

/// The maximum size in bytes of the changes in memory.
const FLUSH_AT: usize = 1 << 20;

impl WaveWriter {
    /// Starts a file for the signals that `simulator` observes, and makes its folder. It will replace a regular file at
    /// `path`, or the target of a symbolic link.
    ///
    /// # Errors
    /// A path to something else, or a file that cannot be created.
    pub fn create(path: impl AsRef<Path>, simulator: &Simulator) -> Result<Self, WaveError> {
        let path = path.as_ref().to_path_buf();
        let folder = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        folder.map_err(|problem| failed(&path, &problem))?;
        let target = target(&path)?;
        Self::begin(path.clone(), target, simulator).map_err(|problem| failed(&path, &problem))
    }

    /// Writes the header to a temporary file in the folder of `target`.
    fn begin(path: PathBuf, target: PathBuf, simulator: &Simulator) -> fst_writer::Result<Self> {
        let info = FstInfo {
            start_time: 0,
            timescale_exponent: -9,
            version: concat!("raypath-hdl ", env!("CARGO_PKG_VERSION")).to_string(),
            date: String::new(), // none, because equal runs give equal files
            file_type: FstFileType::Verilog,
        };
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let create = |path: &Path| File::options().read(true).write(true).create_new(true).open(path);
        let file = tempfile::Builder::new().suffix(".part").make_in(folder, create)?;
        let header = FstHeaderWriter::new(BufWriter::new(file), &info)?;
        let mut scopes =
            Scopes { header, by_scope: signals_by_scope(simulator), ids: HashMap::new(), waves: Vec::new() };

        let top = simulator.module();
        scopes.header.scope(top.name(), top.name(), FstScopeType::Module)?;
        let clock = top.is_clocked().then(|| scopes.bit("clk_i")).transpose()?;
        let reset = top.has_reset().then(|| scopes.bit("rst_ni")).transpose()?;
        scopes.write_all(top)?;
        let (body, waves) = (Some(scopes.header.finish()?), scopes.waves);
        let reset = reset.map(|id| Wave { id, width: 1, shown: None });
        Ok(Self { path, target, body, clock, reset, waves, next_cycle: 0 })
    }

    /// Writes the values of the signals as those of clock cycle `cycle`. `simulator` must be the one given to
    /// [`create`](Self::create). After an error there will be no file, because a waveform with a gap would mislead.
    ///
    /// # Errors
    /// A cycle that is not greater than the previous one, or an error of the file.
    pub fn sample(&mut self, simulator: &Simulator, cycle: u64) -> Result<(), WaveError> {
        let Some(mut body) = self.body.take() else { return Err(self.broken()) };
        if cycle < self.next_cycle {
            let problem = format!("cycle {cycle} sampled after cycle {}", self.next_cycle - 1);
            return Err(wave_error(&self.path, problem));
        }
        if cycle >= u64::MAX / NS_PER_CYCLE {
            return Err(wave_error(&self.path, format!("cycle {cycle} is later than a waveform's times reach")));
        }
        self.next_cycle = cycle + 1;
        self.write_cycle(&mut body, simulator, cycle).map_err(|problem| failed(&self.path, &problem))?;
        self.body = Some(body);
        Ok(())
    }

    /// Completes the file and moves it to its path.
    ///
    /// # Errors
    /// A sample that failed before, or an error of the file.
    pub fn finish(mut self) -> Result<(), WaveError> {
        let Some(mut body) = self.body.take() else { return Err(self.broken()) };
        // The last cycle has the same duration as the others.
        body.time_change(self.next_cycle * NS_PER_CYCLE).map_err(|e| failed(&self.path, &e))?;
        let written = body.finish().map_err(|e| failed(&self.path, &e))?;
        let file = written.into_inner().map_err(|e| failed(&self.path, e.error()))?;
        file.persist(&self.target).map_err(|e| failed(&self.path, &e.error))?;
        Ok(())
    }

    fn broken(&self) -> WaveError {
        wave_error(&self.path, "incomplete, because a sample failed before".to_string())
    }

    fn write_cycle(&mut self, body: &mut Body, simulator: &Simulator, cycle: u64) -> fst_writer::Result<()> {
        if body.size() > FLUSH_AT {
            body.flush()?;
        }
        let rise = cycle * NS_PER_CYCLE;
        body.time_change(rise)?;
        if let Some(clock) = self.clock {
            body.signal_change(clock, b"1")?;
        }
        if let Some(reset) = &mut self.reset {
            reset.show(u64::from(!simulator.is_reset()), body)?;
        }
        for (probe, wave) in &mut self.waves {
            wave.show(simulator.peek(*probe), body)?;
        }
        if let Some(clock) = self.clock {
            body.time_change(rise + NS_PER_CYCLE / 2)?;
            body.signal_change(clock, b"0")?;
        }
        Ok(())
    }
}

impl Wave {
    fn show(&mut self, value: u64, body: &mut Body) -> fst_writer::Result<()> {
        if self.shown.replace(value) == Some(value) {
            return Ok(());
        }
        let mut digits = [b'0'; 64];
        let digits = &mut digits[..self.width as usize];
        for (bit, digit) in digits.iter_mut().rev().enumerate() {
            *digit = b'0' + (value >> bit & 1) as u8;
        }
        body.signal_change(self.id, digits)
    }
}

/// The hierarchy of the file during its construction.
struct Scopes<'s> {
    header: FstHeaderWriter<BufWriter<NamedTempFile>>,
    by_scope: HashMap<&'s str, Vec<(&'s str, u32, Probe)>>,
    /// The signal in the file for each probe. Signals that always have the same value share one.
    ids: HashMap<Probe, FstSignalId>,
    waves: Vec<(Probe, Wave)>,
}

/// The observed signals by the prefix of their scope, with entries for all enclosing scopes.
fn signals_by_scope(simulator: &Simulator) -> HashMap<&str, Vec<(&str, u32, Probe)>> {
    let mut by_scope: HashMap<&str, Vec<_>> = HashMap::new();
    for (name, width, probe) in simulator.probes() {
        let prefix = name.rfind('.').map_or(0, |dot| dot + 1);
        by_scope.entry(&name[..prefix]).or_default().push((&name[prefix..], width, probe));
        for (dot, _) in name.match_indices('.') {
            by_scope.entry(&name[..=dot]).or_default();
        }
    }
    by_scope
}

impl Scopes<'_> {
    /// Writes the signals of the open scope of `top` and all scopes inside it, and closes it.
    fn write_all(&mut self, top: &Arc<Module>) -> fst_writer::Result<()> {
        self.module(top, "")?;
        let mut path = vec![(top.clone(), String::new(), 0)];
        while let Some((module, prefix, next)) = path.last_mut() {
            let Some(instance) = module.instances().get(*next) else {
                self.header.up_scope()?;
                path.pop();
                continue;
            };
            *next += 1;
            let (inside, prefix) = (instance.module.clone(), format!("{prefix}{}.", instance.name));
            if self.by_scope.contains_key(prefix.as_str()) {
                self.header.scope(&instance.name, inside.name(), FstScopeType::Module)?;
                self.module(&inside, &prefix)?;
                path.push((inside, prefix, 0));
            }
        }
        Ok(())
    }

    /// Writes the signals of the open scope of a module, and a scope for each of its memories.
    fn module(&mut self, module: &Module, prefix: &str) -> fst_writer::Result<()> {
        self.signals(prefix, |name| {
            if module.inputs().iter().any(|port| port.name == name) {
                FstVarDirection::Input
            } else if module.outputs().iter().any(|port| port.name == name) {
                FstVarDirection::Output
            } else {
                FstVarDirection::Implicit
            }
        })?;
        for memory in module.memories() {
            let prefix = format!("{prefix}{}.", memory.name);
            if self.by_scope.contains_key(prefix.as_str()) {
                self.header.scope(&memory.name, RAM, FstScopeType::Module)?;
                self.signals(&prefix, |_| FstVarDirection::Implicit)?;
                self.header.up_scope()?;
            }
        }
        Ok(())
    }

    fn signals(&mut self, prefix: &str, direction: impl Fn(&str) -> FstVarDirection) -> fst_writer::Result<()> {
        for (name, width, probe) in self.by_scope.get(prefix).into_iter().flatten() {
            let title = if *width == 1 { name.to_string() } else { format!("{name} [{}:0]", width - 1) };
            let known = self.ids.get(probe).copied();
            let kind = FstSignalType::bit_vec(*width);
            let id = self.header.var(title, kind, FstVarType::Logic, direction(name), known)?;
            if known.is_none() {
                self.ids.insert(*probe, id);
                self.waves.push((*probe, Wave { id, width: *width, shown: None }));
            }
        }
        Ok(())
    }

    fn bit(&mut self, name: &str) -> fst_writer::Result<FstSignalId> {
        self.header.var(name, FstSignalType::bit_vec(1), FstVarType::Logic, FstVarDirection::Input, None)
    }
}

/// The path of the file: `path`, or the target of a symbolic link. Anything but a regular file is an error, because
/// renaming would replace it.
fn target(path: &Path) -> Result<PathBuf, WaveError> {
    let found = match fs::symlink_metadata(path) {
        Err(problem) if problem.kind() == ErrorKind::NotFound => return Ok(path.to_path_buf()),
        Ok(found) if found.is_symlink() => {
            let target = path.canonicalize().map_err(|e| failed(path, &e))?;
            fs::metadata(&target).map(|found| (target, found))
        }
        other => other.map(|found| (path.to_path_buf(), found)),
    };
    match found.map_err(|e| failed(path, &e))? {
        (target, found) if found.is_file() => Ok(target),
        _ => Err(wave_error(path, "is not a regular file, expected a file or nothing".to_string())),
    }
}

/// An error with its causes.
fn failed(path: &Path, error: &dyn std::error::Error) -> WaveError {
    let causes = std::iter::successors(error.source(), |cause| cause.source());
    wave_error(path, causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}")))
}

fn wave_error(path: &Path, problem: String) -> WaveError {
    WaveError { path: path.to_path_buf(), problem }
}
