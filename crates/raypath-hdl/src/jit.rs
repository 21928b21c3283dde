//! Native code for a flat netlist. Only this module uses Cranelift, and only this file has `unsafe` code.
#![allow(unsafe_code)]

mod operators;

use crate::Error;
use crate::flatten::Flat;
use crate::graph::Operation;
use crate::netlist::{Driver, SignalId};
use cranelift_codegen::ir::types::I64;
use cranelift_codegen::ir::{
    AbiParam, FuncRef, InstBuilder, MemFlagsData, StackSlot, StackSlotData, StackSlotKind, Value,
};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Module, default_libcall_names};
use operators::Word;

/// A compiled netlist.
pub struct Code {
    /// Present until dropped; owns the memory that `cycle` points into.
    module: Option<JITModule>,
    cycle: Cycle,
    registers: usize,
    io: usize,
    memory: usize,
}

type Cycle = extern "C" fn(*const u64, *mut u64, *mut u64, *mut u64);

/// The number of operations from which on the results of a function are cached at each of its calls. The function is
/// called again only if an argument has changed, so idle hardware costs little.
const MIN_CACHED_OPERATIONS: usize = 64;

impl Code {
    /// Compiles a netlist and the functions that it calls.
    pub fn new(flat: &Flat, inputs: usize) -> Result<Self, Error> {
        let mut compiler = Compiler::new()?;
        let mut functions = Vec::new();
        for (place, function) in flat.functions.iter().enumerate() {
            let parameters = flat.calls.iter().find(|(f, _)| *f == place).map_or(0, |(_, call)| call.inputs.len());
            functions.push(compiler.define(function, &[], Frame::Function { inputs: parameters })?);
        }
        let (cached, memory) = cached(flat);
        let id = compiler.define(flat, &functions, Frame::Cycle { inputs, cached: &cached })?;
        compiler.module.finalize_definitions().map_err(codegen)?;
        let address = compiler.module.get_finalized_function(id);
        // SAFETY: `define` gave this function four pointer parameters, no result, and the host's C convention.
        let cycle = unsafe { std::mem::transmute::<*const u8, Cycle>(address) };
        let io = inputs + flat.outputs.len() + flat.observed.len();
        Ok(Self { module: Some(compiler.module), cycle, registers: flat.registers.len(), io, memory })
    }

    /// Words of memory between cycles that [`run`](Self::run) needs, all 0 at first.
    pub fn memory(&self) -> usize {
        self.memory
    }

    /// Evaluates one cycle: reads `current` registers and the inputs in `io`; writes `next` registers and the outputs
    /// and observed signals in `io`, which follow the inputs. `memory` is only for the code itself.
    pub fn run(&self, current: &[u64], next: &mut [u64], io: &mut [u64], memory: &mut [u64]) {
        assert_eq!((current.len(), next.len(), io.len()), (self.registers, self.registers, self.io));
        assert_eq!(memory.len(), self.memory);
        // The code touches the words that the four lengths cover and no others; the slices do not overlap.
        (self.cycle)(current.as_ptr(), next.as_mut_ptr(), io.as_mut_ptr(), memory.as_mut_ptr());
    }
}

/// The position in memory of each cached call, and the size of the memory in words. A cached call has a word that is 1
/// after the first call, then its arguments, then its results.
fn cached(flat: &Flat) -> (Vec<Option<usize>>, usize) {
    let mut words = 0;
    let places = flat.calls.iter().map(|(function, call)| {
        let function = &flat.functions[*function];
        (function.nodes.len() >= MIN_CACHED_OPERATIONS).then(|| {
            let place = words;
            words += 1 + call.inputs.len() + function.outputs.len();
            place
        })
    });
    (places.collect(), words)
}

impl Drop for Code {
    fn drop(&mut self) {
        if let Some(module) = self.module.take() {
            // SAFETY: `cycle` is private and only called by `run`, which borrows self.
            unsafe { module.free_memory() };
        }
    }
}

/// How a function receives and returns values.
#[derive(Clone, Copy)]
enum Frame<'f> {
    /// `(current, next, io, memory)`; inputs come first in `io`. Where in `memory` each call is cached.
    Cycle { inputs: usize, cached: &'f [Option<usize>] },
    /// Each input a parameter; the last parameter points to where the outputs go.
    Function { inputs: usize },
}

struct Compiler {
    module: JITModule,
    context: cranelift_codegen::Context,
    builder: FunctionBuilderContext,
}

impl Compiler {
    fn new() -> Result<Self, Error> {
        let flags = [
            ("opt_level", "speed"),
            ("enable_verifier", if cfg!(debug_assertions) { "true" } else { "false" }),
            ("unwind_info", "false"),
        ];
        let module = JITModule::new(JITBuilder::with_flags(&flags, default_libcall_names()).map_err(codegen)?);
        let context = module.make_context();
        Ok(Self { module, context, builder: FunctionBuilderContext::new() })
    }

    fn define(&mut self, flat: &Flat, functions: &[FuncId], frame: Frame<'_>) -> Result<FuncId, Error> {
        let parameters = match frame {
            Frame::Cycle { .. } => 4,
            Frame::Function { inputs } => inputs + 1,
        };
        let mut signature = self.module.make_signature();
        signature.params = vec![AbiParam::new(I64); parameters];
        let id = self.module.declare_anonymous_function(&signature).map_err(codegen)?;
        self.context.func.signature = signature;

        let callees: Vec<FuncRef> =
            functions.iter().map(|&f| self.module.declare_func_in_func(f, &mut self.context.func)).collect();
        let mut builder = FunctionBuilder::new(&mut self.context.func, &mut self.builder);
        let block = builder.create_block();
        builder.append_block_params_for_function_params(block);
        builder.switch_to_block(block);
        builder.seal_block(block);
        let parameters = builder.block_params(block).to_vec();
        Body { builder, flat, frame, parameters, callees, values: Vec::new(), results: vec![None; flat.calls.len()] }
            .emit(self.module.target_config());
        self.module.define_function(id, &mut self.context).map_err(codegen)?;
        self.module.clear_context(&mut self.context);
        Ok(id)
    }
}

fn codegen(error: impl std::fmt::Display) -> Error {
    Error::Codegen(error.to_string())
}

/// A store that follows the computation of its operands.
enum Store {
    Register(usize),
    Output(usize),
    Observed(usize),
}

/// The body of one function.
struct Body<'a> {
    builder: FunctionBuilder<'a>,
    flat: &'a Flat,
    frame: Frame<'a>,
    parameters: Vec<Value>,
    callees: Vec<FuncRef>,
    /// By node.
    values: Vec<Word>,
    /// By call that has been made: where its outputs are.
    results: Vec<Option<Results>>,
}

/// Where the outputs of a call are.
#[derive(Clone, Copy)]
enum Results {
    Stack(StackSlot),
    Memory(usize),
}

impl Body<'_> {
    fn emit(mut self, target: cranelift_codegen::isa::TargetFrontendConfig) {
        let mut stores = self.stores().into_iter().peekable();
        for (place, node) in self.flat.nodes.iter().enumerate() {
            // Words in memory and arguments have zeros above their width.
            let outside = |value| Word { value, bits: node.width };
            let word = match &node.operation {
                Operation::Input(input) => outside(self.input(*input)),
                Operation::Register(register) => outside(self.load(self.parameters[0], *register)),
                Operation::Result { call, output } => outside(self.result(*call, *output)),
                Operation::Operator(driver) => self.operator(driver, node.width),
            };
            self.values.push(word);
            while let Some((_, store)) = stores.next_if(|(ready, _)| *ready == place) {
                self.emit_store(store);
            }
        }
        self.builder.ins().return_(&[]);
        self.builder.finalize(target);
    }

    /// Each store, and the node after which it can happen; in that order, so that few values are live at a time.
    fn stores(&self) -> Vec<(usize, Store)> {
        let mut stores = Vec::new();
        for (place, register) in self.flat.registers.iter().enumerate() {
            let enable = register.enable.unwrap_or(register.signal);
            let ready = register.signal.max(register.next).max(enable).index();
            stores.push((ready, Store::Register(place)));
        }
        let outputs = self.flat.outputs.iter().enumerate();
        stores.extend(outputs.map(|(place, id)| (id.index(), Store::Output(place))));
        let observed = self.flat.observed.iter().enumerate();
        stores.extend(observed.map(|(place, id)| (id.index(), Store::Observed(place))));
        stores.sort_by_key(|&(ready, _)| ready);
        stores
    }

    fn emit_store(&mut self, store: Store) {
        match (store, self.frame) {
            (Store::Register(place), Frame::Cycle { .. }) => {
                let register = &self.flat.registers[place];
                let mut value = self.clean(register.next);
                if let Some(enable) = register.enable {
                    let (enable, current) = (self.clean(enable), self.clean(register.signal));
                    value = self.builder.ins().select(enable, value, current);
                }
                self.store(value, self.parameters[1], place);
            }
            (Store::Output(place), Frame::Cycle { inputs, .. }) => {
                let value = self.clean(self.flat.outputs[place]);
                self.store(value, self.parameters[2], inputs + place);
            }
            (Store::Output(place), Frame::Function { inputs }) => {
                let value = self.clean(self.flat.outputs[place]);
                self.store(value, self.parameters[inputs], place);
            }
            (Store::Observed(place), Frame::Cycle { inputs, .. }) => {
                let slot = inputs + self.flat.outputs.len() + place;
                let value = self.clean(self.flat.observed[place]);
                self.store(value, self.parameters[2], slot);
            }
            (Store::Register(_) | Store::Observed(_), Frame::Function { .. }) => {
                unreachable!("functions have no registers and observe nothing")
            }
        }
    }

    fn word(&self, id: SignalId) -> Word {
        self.values[id.index()]
    }

    fn width(&self, id: SignalId) -> u32 {
        self.flat.nodes[id.index()].width
    }

    /// The operator that makes a signal, if it is one.
    fn driver(&self, id: SignalId) -> Option<&Driver> {
        match &self.flat.nodes[id.index()].operation {
            Operation::Operator(driver) => Some(driver),
            _ => None,
        }
    }

    fn input(&mut self, input: usize) -> Value {
        match self.frame {
            Frame::Cycle { .. } => self.load(self.parameters[2], input),
            Frame::Function { .. } => self.parameters[input],
        }
    }

    fn load(&mut self, base: Value, word: usize) -> Value {
        self.builder.ins().load(I64, MemFlagsData::trusted(), base, (word * 8) as i32)
    }

    fn store(&mut self, value: Value, base: Value, word: usize) {
        self.builder.ins().store(MemFlagsData::trusted(), value, base, (word * 8) as i32);
    }

    fn result(&mut self, call: usize, output: usize) -> Value {
        let results = match self.results[call] {
            Some(results) => results,
            None => self.call(call),
        };
        self.results[call] = Some(results);
        match results {
            Results::Stack(slot) => {
                let base = self.builder.ins().stack_addr(I64, slot, 0);
                self.load(base, output)
            }
            Results::Memory(place) => self.load(self.parameters[3], place + output),
        }
    }

    fn call(&mut self, call: usize) -> Results {
        let flat = self.flat;
        let (function, inputs) = (flat.calls[call].0, &flat.calls[call].1.inputs);
        let arguments: Vec<Value> = inputs.iter().map(|&id| self.clean(id)).collect();
        if let Frame::Cycle { cached, .. } = self.frame
            && let Some(place) = cached[call]
        {
            return self.call_if_changed(function, &arguments, place);
        }
        let bytes = self.flat.functions[function].outputs.len() as u32 * 8;
        let slot = self.builder.create_sized_stack_slot(StackSlotData::new(StackSlotKind::ExplicitSlot, bytes, 3));
        let outputs = self.builder.ins().stack_addr(I64, slot, 0);
        self.builder.ins().call(self.callees[function], &[arguments, vec![outputs]].concat());
        Results::Stack(slot)
    }

    /// A call that is skipped if its arguments are those of the last call.
    fn call_if_changed(&mut self, function: usize, arguments: &[Value], place: usize) -> Results {
        let memory = self.parameters[3];
        let one = self.constant(1);
        let now: Vec<Value> = std::iter::once(one).chain(arguments.iter().copied()).collect();
        let mut changed = self.constant(0);
        for (word, &value) in now.iter().enumerate() {
            let before = self.load(memory, place + word);
            let difference = self.builder.ins().bxor(value, before);
            changed = self.builder.ins().bor(changed, difference);
        }
        let (call, done) = (self.builder.create_block(), self.builder.create_block());
        self.builder.ins().brif(changed, call, &[], done, &[]);

        self.builder.switch_to_block(call);
        self.builder.seal_block(call);
        for (word, &value) in now.iter().enumerate() {
            self.store(value, memory, place + word);
        }
        let results = place + now.len();
        let outputs = self.builder.ins().iadd_imm_u(memory, (results * 8) as i64);
        self.builder.ins().call(self.callees[function], &[arguments, &[outputs]].concat());
        self.builder.ins().jump(done, &[]);

        self.builder.switch_to_block(done);
        self.builder.seal_block(done);
        Results::Memory(results)
    }

    fn constant(&mut self, value: u64) -> Value {
        self.builder.ins().iconst(I64, value as i64)
    }
}
