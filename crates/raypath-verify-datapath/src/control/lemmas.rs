//! Lemmas that make the order of many jobs inductive. They compare the checker's scoreboard with each register that
//! holds a job, from the oldest job to the newest.
//!
//! Lemmas are assertions in the proof only, not in the emitted design. They are proved together with the checker's
//! assertions.

use raypath_hdl::{MemoryInfo, Module};
use raypath_rtl::{Config, Control, DatapathNetlist};

/// The lemmas for the whole pipeline, as text to insert into its module.
pub fn of_pipeline(datapath: &DatapathNetlist, config: Config) -> String {
    let mut steps: Vec<Step> = (0..datapath.steps().count())
        .filter_map(|step| datapath.module(step))
        .map(|module| Step::new(format!("{}.", module.name().replacen("raypath", "u", 1)), module))
        .collect();
    let (latency, full) = (datapath.latency() as usize, datapath.capacity() as usize);
    let mut lemmas = Lemmas::new(datapath, latency);
    steps.reverse();
    let mut first = 0;
    if config.microarchitecture.control == Control::Credit {
        lemmas.exit(&steps[0], full - 1);
        first = 1;
        let credits = lemmas.observe("credits", bits(full), "u_credit.count_q");
        let available = lemmas.observe("available", 1, "u_credit.available_q");
        lemmas.assert(format!("{credits} + lemma_count == {full}"));
        lemmas.assert(format!("{available} == ({credits} != 0)"));
    }
    if datapath.interval() > 1 {
        if config.microarchitecture.control == Control::Skid {
            lemmas.skid_buffer(0, &steps[0], latency - 1);
        }
        steps.reverse();
        lemmas.positions(datapath, config, &steps);
        return lemmas.end();
    }
    for (index, step) in steps.iter().enumerate().skip(first) {
        // The oldest job has been refused at most once in each step behind it.
        let behind = latency - 1 - index;
        match config.microarchitecture.control {
            Control::Skid => lemmas.skid_buffer(index, step, behind),
            Control::Credit => {
                let buffer = if config.microarchitecture.clock_gating { "" } else { "u_register." };
                let valid = lemmas.observe(&format!("valid_{index}"), 1, &format!("{}{buffer}valid_q", step.path));
                let opcode = lemmas.observe_opcode(&format!("opcode_{index}"), step, "u_register.data_q");
                lemmas.slot(&valid, &opcode, Some(behind));
            }
        }
    }
    lemmas.end()
}

/// The lemmas for the exit's module. Its environment counts jobs as the checker does.
pub fn of_exit(datapath: &DatapathNetlist) -> String {
    let mut lemmas = Lemmas::new(datapath, 1);
    if let Some(module) = datapath.module(datapath.steps().count() - 1) {
        let step = Step::new(String::new(), module);
        match module.memories().first() {
            Some(memory) => lemmas.deep_exit(&step, module, memory),
            None => lemmas.exit(&step, lemmas.full - 1),
        }
    }
    lemmas.assert("environment_q == lemma_count".to_string());
    lemmas.end()
}

/// The words of a memory as a net, to insert into [`RAM`](raypath_hdl::verilog::RAM).
pub const WORDS: &str = "  logic [Depth*Width-1:0] all_words;\n  \
     for (genvar place = 0; place < Depth; place = place + 1) begin : g_words\n    \
     assign all_words[place*Width +: Width] = words[place];\n  end\n";

/// A step of the pipeline.
struct Step {
    /// The path of its instance, with a dot at the end.
    path: String,
    /// The width of the data registers in its buffer, whose highest bits are the opcode; 0 if it has its own.
    width: u32,
}

impl Step {
    fn new(path: String, module: &Module) -> Self {
        Self { path, width: module.bank_width() }
    }
}

/// Builds the text slot by slot, the oldest job's slot first.
struct Lemmas {
    /// The jobs that fit inside.
    full: usize,
    /// The bits of an opcode.
    width: usize,
    max_waits: usize,
    nets: String,
    lemmas: Vec<String>,
    /// The number of slots so far; the nets `before_0` to `before_N` count their jobs.
    before: usize,
}

impl Lemmas {
    fn new(datapath: &DatapathNetlist, max_waits: usize) -> Self {
        let (full, width) = (datapath.capacity() as usize, datapath.top().port_width("opcode_i").unwrap_or(0) as usize);
        let mut lemmas = Self { full, width, max_waits, nets: String::new(), lemmas: Vec::new(), before: 0 };
        lemmas.observe("count", bits(full + 1), "u_order_properties.count_q");
        lemmas.observe("inside", width * (full + 1), "u_order_properties.inside_q");
        lemmas.observe("waits", bits(max_waits + 1), "u_order_properties.waits_q");
        lemmas.counter("'0".to_string());
        lemmas
    }

    /// Declares a net for a signal inside an instance and returns its name. Yosys connects it when it flattens
    /// (attribute `hierconn`). If there is no such signal, the net is free and the lemmas fail.
    fn observe(&mut self, name: &str, width: usize, inner: &str) -> String {
        self.nets += &format!("  logic [{}:0] lemma_{name};\n", width - 1);
        if inner.contains('.') {
            self.nets += &format!("  (* hierconn *) logic [{}:0] \\{inner} ;\n", width - 1);
        }
        self.nets += &format!("  assign lemma_{name} = \\{inner} ;\n");
        format!("lemma_{name}")
    }

    /// The opcode in a data register of a step's buffer, or in the step's own register behind a clock gate.
    fn observe_opcode(&mut self, name: &str, step: &Step, register: &str) -> String {
        let Step { path, width } = step;
        if *width == 0 {
            let suffix = register.split_once(".data").map_or(register, |(_, suffix)| suffix);
            return self.observe(name, self.width, &format!("{path}opcode{suffix}"));
        }
        let net = format!("\\{path}{register} ");
        self.nets += &format!("  (* hierconn *) logic [{}:0] {net};\n", width - 1);
        let (high, low) = (width - 1, *width as usize - self.width);
        self.nets +=
            &format!("  logic [{}:0] lemma_{name};\n  assign lemma_{name} = {net}[{high}:{low}];\n", self.width - 1);
        format!("lemma_{name}")
    }

    fn assert(&mut self, lemma: String) {
        self.lemmas.push(lemma);
    }

    /// Declares the count of jobs older than the next slot's. Its width suffices for all slots.
    fn counter(&mut self, count: String) {
        let high = bits(2 * self.full + 2) - 1;
        self.nets += &format!("  logic [{high}:0] before_{0};\n  assign before_{0} = {count};\n", self.before);
    }

    /// Asserts that a slot's job, if `full`, is the next job of the scoreboard.
    fn slot(&mut self, full: &str, opcode: &str, max_waits: Option<usize>) {
        let before = self.before;
        self.nets += &format!(
            "  logic [{}:0] from_{before};\n  assign from_{before} = lemma_inside >> (32'd{} * before_{before});\n",
            self.width * (self.full + 1) - 1,
            self.width
        );
        self.lemmas.push(format!("!{full} || from_{before}[{}:0] == {opcode}", self.width - 1));
        if let Some(max_waits) = max_waits {
            self.lemmas.push(format!("!{full} || before_{before} != 0 || lemma_waits <= {max_waits}"));
        }
        self.before += 1;
        self.counter(format!("before_{before} + {full}"));
    }

    /// The two slots of a skid buffer: the front's job is older than the spare's.
    fn skid_buffer(&mut self, index: usize, step: &Step, behind: usize) {
        let front = self.observe(&format!("front_{index}"), 1, &format!("{}u_skid.front_full_q", step.path));
        let empty = self.observe(&format!("empty_{index}"), 1, &format!("{}u_skid.spare_empty_q", step.path));
        let opcode = self.observe_opcode(&format!("opcode_{index}"), step, "u_skid.data_q");
        let spare = self.observe_opcode(&format!("opcode_spare_{index}"), step, "u_skid.data_spare_q");
        self.nets += &format!("  logic spare_{index};\n  assign spare_{index} = !{empty};\n");
        self.lemmas.push(format!("{front} || {empty}"));
        self.slot(&front, &opcode, Some(behind));
        self.slot(&format!("spare_{index}"), &spare, None);
    }

    /// The slots of an exit: the front, then the waiting jobs of the circular buffer from its read pointer on.
    fn exit(&mut self, step: &Step, depth: usize) {
        let (path, width) = (&step.path, self.width);
        let all = width * depth;
        let front = self.observe("front", 1, &format!("{path}u_exit.front_full_q"));
        let waiting = self.observe("waiting", bits(depth), &format!("{path}u_exit.waiting_q"));
        let write = self.observe("write", depth, &format!("{path}u_exit.write_q"));
        let read = self.observe("read", depth, &format!("{path}u_exit.read_q"));
        let stored: Vec<String> = (0..depth)
            .map(|index| self.observe_opcode(&format!("store_{index}"), step, &format!("u_exit.data_store_{index}_q")))
            .collect();
        let stored: Vec<&str> = stored.iter().rev().map(String::as_str).collect();
        let high = all - 1;
        self.nets += &format!("  logic [{high}:0] stored;\n  assign stored = {{{}}};\n", stored.join(", "));
        let turned = |index: usize| match index {
            0 => format!("({{{all}{{{read}[0]}}}} & stored)"),
            _ => format!(
                "({{{all}{{{read}[{index}]}}}} & {{stored[{}:0], stored[{high}:{}]}})",
                width * index - 1,
                width * index
            ),
        };
        let turned: Vec<String> = (0..depth).map(turned).collect();
        self.nets += &format!("  logic [{high}:0] in_turn;\n  assign in_turn = {};\n", turned.join("\n    | "));
        self.nets +=
            &format!("  logic [{high}:0] unused;\n  assign unused = {{{all}{{1'b1}}}} << (32'd{width} * {waiting});\n");
        self.nets +=
            &format!("  logic [{high}:0] write_back;\n  assign write_back = {{{write}, {write}}} >> {waiting};\n");
        let opcode = self.observe_opcode("opcode_front", step, "u_exit.data_q");
        self.slot(&front, &opcode, None);
        self.lemmas.push(format!("{front} || {waiting} == 0"));
        self.lemmas.push(format!("!{front} || lemma_waits < {}", self.max_waits));
        self.lemmas.push(format!("{waiting} <= {depth}"));
        for pointer in [&write, &read] {
            self.lemmas.push(format!("{pointer} != 0 && ({pointer} & ({pointer} - 1)) == 0"));
        }
        self.lemmas.push(format!("write_back[{}:0] == {read}", depth - 1));
        self.lemmas.push(format!("((in_turn ^ lemma_inside[{width} +: {all}]) & ~unused) == 0"));
        self.before += 1;
        self.counter(format!("before_{} + {waiting}", self.before - 1));
    }

    /// The slots of an exit with a memory: the front and the job behind it, the next, and the jobs in the memory, from
    /// its read pointer on.
    fn deep_exit(&mut self, step: &Step, module: &Module, memory: &MemoryInfo) {
        self.exit(step, 1);
        let next = self.observe("next_full", 1, "next_full_q");
        let opcode = self.observe("opcode_next", self.width, "opcode_next");
        self.slot(&next, &opcode, None);

        let (depth, width) = (memory.depth as usize, self.width);
        let bits_of_word: usize = memory.columns.iter().map(|column| module.signal(column.read).width as usize).sum();
        let words = self.observe("words", depth * bits_of_word, &format!("{}.all_words", memory.name));
        let address = bits(depth - 1);
        let [waiting, write, read] =
            [("in_memory", "waiting_q", address + 1), ("to", "write_q", address), ("from", "read_q", address)]
                .map(|(name, register, width)| self.observe(name, width, register));
        // Opcodes are the highest bits of a word.
        let opcodes: Vec<String> =
            (1..=depth).rev().map(|end| format!("{words}[{} -: {width}]", end * bits_of_word - 1)).collect();
        let high = depth * width - 1;
        let opcodes = opcodes.join(", ");
        let before = self.before;
        self.nets += &format!(
            "  logic [{high}:0] kept;\n  assign kept = {{{opcodes}}};\n  \
             logic [{high}:0] kept_in_turn;\n  assign kept_in_turn = {{kept, kept}} >> (32'd{width} * {read});\n  \
             logic [{high}:0] empty;\n  assign empty = '1 << (32'd{width} * {waiting});\n  \
             logic [{high}:0] expected;\n  assign expected = lemma_inside >> (32'd{width} * before_{before});\n"
        );
        self.assert(format!("!{next} || (lemma_front && lemma_waiting == 1)"));
        self.assert(format!("{waiting} == 0 || {next}"));
        self.assert(format!("{waiting} <= {}", self.full - 3));
        self.assert(format!("{write} == {address}'({read} + {waiting})"));
        self.assert("((kept_in_turn ^ expected) & ~empty) == 0".to_string());
        self.before += 1;
        self.counter(format!("before_{before} + {waiting}"));
    }

    /// The jobs before the exit of a folded pipeline: a slot for each position, whose opcode is in the registers before
    /// each step that reads it there.
    fn positions(&mut self, datapath: &DatapathNetlist, config: Config, steps: &[Step]) {
        let (interval, count) = (datapath.interval(), datapath.latency() - 1);
        let at = self.observe("at", count as usize, "u_rounds.at_q");
        for distance in 1..interval.min(count) {
            self.assert(format!("({at} & ({at} >> {distance})) == 0"));
        }
        if config.microarchitecture.control == Control::Credit {
            let recent = self.observe("recent", interval as usize - 1, "u_credit.recent_q");
            self.assert(format!("{recent} == {at}[{}:0]", interval - 2));
        }
        // The first position of each step after the input, and the opcode that it reads.
        let mut opcodes: Vec<(u32, String)> = Vec::new();
        for ((before, step), &start) in steps.iter().enumerate().zip(&datapath.starts()[1..]) {
            let opcode = self.observe(&format!("step_opcode_{before}"), self.width, &format!("{}opcode_q", step.path));
            opcodes.push((start, opcode));
        }
        for position in (0..count).rev() {
            let full = format!("{at}[{position}]");
            let holds = |(start, _): &&(u32, String)| (*start..start + interval).contains(&position);
            let held: Vec<String> = opcodes.iter().filter(holds).map(|(_, opcode)| opcode.clone()).collect();
            for pair in held.windows(2) {
                self.assert(format!("!{full} || {} == {}", pair[0], pair[1]));
            }
            if let Some(opcode) = held.first() {
                self.slot(&full, opcode, Some(position as usize));
            }
        }
    }

    fn end(mut self) -> String {
        self.lemmas.push(format!("lemma_count == before_{}", self.before));
        self.lemmas.push(format!("lemma_count <= {}", self.full));
        self.lemmas.push(format!("(lemma_inside >> (32'd{} * lemma_count)) == 0", self.width));
        self.lemmas.push("lemma_count != 0 || lemma_waits == 0".to_string());
        let lemmas: Vec<String> = self.lemmas.iter().map(|lemma| format!("({lemma})")).collect();
        format!("{}  always_comb lemmas: assert ({});\n", self.nets, lemmas.join("\n    && "))
    }
}

/// The number of bits of a number.
fn bits(number: usize) -> usize {
    (usize::BITS - number.leading_zeros()) as usize
}
