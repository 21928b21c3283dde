//! Which job is where: what makes the order of many jobs inductive. The checker's scoreboard is compared with every place
//! that holds a job, from the oldest to the newest.
//!
//! Lemmas are assertions of the proof alone, and are proved together with the checker's own: an assertion set that holds
//! in the first cycles and follows from itself in the cycles before holds always.

use raypath_rtl::{Config, Control, Datapath};

/// Lemmas for the whole pipeline, as text that stands in its module beside the checker of its order.
pub fn of_pipeline(datapath: &Datapath, config: Config) -> String {
    let mut steps: Vec<String> = (0..datapath.steps().count())
        .filter_map(|step| datapath.module(step))
        .map(|module| format!("{}.", module.name().replacen("raypath", "u", 1)))
        .collect();
    let (latency, full) = (steps.len(), capacity(datapath, config));
    let mut lemmas = Lemmas::new(full, latency);
    steps.reverse();
    let mut first = 0;
    if config.control == Control::Credit {
        lemmas.exit(&steps[0], full - 1);
        first = 1;
        let credits = lemmas.see("credits", bits(full), "u_credit.count_q");
        let available = lemmas.see("available", 1, "u_credit.available_q");
        lemmas.say(format!("{credits} + lemma_count == {full}"));
        lemmas.say(format!("{available} == ({credits} != 0)"));
    }
    for (place, step) in steps.iter().enumerate().skip(first) {
        // The oldest job has waited in vain once in each step behind it, at most.
        let behind = latency - 1 - place;
        match config.control {
            Control::Skid => lemmas.skid_buffer(place, step, behind),
            Control::Credit => {
                let valid = lemmas.see(&format!("valid_{place}"), 1, &format!("{step}valid_q"));
                lemmas.place(&valid, &format!("{step}opcode_q"), Some(behind));
            }
        }
    }
    lemmas.end()
}

/// Lemmas for the module of the exit alone. Its environment counts as the checker does.
pub fn of_exit(datapath: &Datapath, config: Config) -> String {
    let full = capacity(datapath, config);
    let mut lemmas = Lemmas::new(full, 1);
    lemmas.exit("", full - 1);
    lemmas.say("environment_q == lemma_count".to_string());
    lemmas.end()
}

/// How many jobs fit into a pipeline.
pub fn capacity(datapath: &Datapath, config: Config) -> usize {
    let latency = datapath.latency() as usize;
    match config.control {
        Control::Skid => 2 * latency,
        Control::Credit => latency + 1,
    }
}

/// Text as it grows, place by place, the oldest job's first.
struct Lemmas {
    full: usize,
    patience: usize,
    nets: String,
    said: Vec<String>,
    /// Places whose jobs have been counted: `before_0` to this one.
    before: usize,
}

impl Lemmas {
    fn new(full: usize, patience: usize) -> Self {
        let mut lemmas = Self { full, patience, nets: String::new(), said: Vec::new(), before: 0 };
        lemmas.see("count", bits(full + 1), "u_order_properties.count_q");
        lemmas.see("inside", 2 * full + 2, "u_order_properties.inside_q");
        lemmas.see("waits", bits(patience + 1), "u_order_properties.waits_q");
        lemmas.counter("'0".to_string());
        lemmas
    }

    /// A net for one inside an instance. Yosys connects it as it flattens (attribute `hierconn`); where there is none of
    /// that name it is free, and lemmas fail.
    fn see(&mut self, name: &str, width: usize, inner: &str) -> String {
        self.nets += &format!("  logic [{}:0] lemma_{name};\n", width - 1);
        if inner.contains('.') {
            self.nets += &format!("  (* hierconn *) logic [{}:0] \\{inner} ;\n", width - 1);
        }
        self.nets += &format!("  assign lemma_{name} = \\{inner} ;\n");
        format!("lemma_{name}")
    }

    fn say(&mut self, lemma: String) {
        self.said.push(lemma);
    }

    /// How many jobs are older than what comes next. Wide enough for every place at once.
    fn counter(&mut self, count: String) {
        let high = bits(2 * self.full + 2) - 1;
        self.nets += &format!("  logic [{high}:0] before_{0};\n  assign before_{0} = {count};\n", self.before);
    }

    /// A place with one job, if `full`: it is the next one of the scoreboard.
    fn place(&mut self, full: &str, opcode: &str, waits_at_most: Option<usize>) {
        let before = self.before;
        let opcode = self.see(&format!("opcode_{before}"), 2, opcode);
        self.nets += &format!(
            "  logic [{}:0] from_{before};\n  assign from_{before} = lemma_inside >> {{before_{before}, 1'b0}};\n",
            2 * self.full + 1
        );
        self.said.push(format!("!{full} || from_{before}[1:0] == {opcode}"));
        if let Some(most) = waits_at_most {
            self.said.push(format!("!{full} || before_{before} != 0 || lemma_waits <= {most}"));
        }
        self.before += 1;
        self.counter(format!("before_{before} + {full}"));
    }

    /// The front's job is older than the spare's.
    fn skid_buffer(&mut self, place: usize, step: &str, behind: usize) {
        let front = self.see(&format!("front_{place}"), 1, &format!("{step}u_skid.front_full_q"));
        let empty = self.see(&format!("empty_{place}"), 1, &format!("{step}u_skid.spare_empty_q"));
        self.nets += &format!("  logic spare_{place};\n  assign spare_{place} = !{empty};\n");
        self.said.push(format!("{front} || {empty}"));
        self.place(&front, &format!("{step}opcode_q"), Some(behind));
        self.place(&format!("spare_{place}"), &format!("{step}opcode_spare_q"), None);
    }

    /// The front, then as many stored jobs as are waiting, from the place that the read pointer names on, round.
    fn exit(&mut self, step: &str, depth: usize) {
        let front = self.see("front", 1, &format!("{step}u_exit.front_full_q"));
        let waiting = self.see("waiting", bits(depth), &format!("{step}u_exit.waiting_q"));
        let write = self.see("write", depth, &format!("{step}u_exit.write_q"));
        let read = self.see("read", depth, &format!("{step}u_exit.read_q"));
        let stored: Vec<String> = (0..depth)
            .map(|place| self.see(&format!("store_{place}"), 2, &format!("{step}opcode_store_{place}_q")))
            .collect();
        let stored: Vec<&str> = stored.iter().rev().map(String::as_str).collect();
        let high = 2 * depth - 1;
        self.nets += &format!("  logic [{high}:0] stored;\n  assign stored = {{{}}};\n", stored.join(", "));
        let turned = |place: usize| match place {
            0 => format!("({{{}{{{read}[0]}}}} & stored)", 2 * depth),
            _ => format!(
                "({{{}{{{read}[{place}]}}}} & {{stored[{}:0], stored[{high}:{}]}})",
                2 * depth,
                2 * place - 1,
                2 * place
            ),
        };
        let turned: Vec<String> = (0..depth).map(turned).collect();
        self.nets += &format!("  logic [{high}:0] in_turn;\n  assign in_turn = {};\n", turned.join("\n    | "));
        self.nets += &format!(
            "  logic [{high}:0] unused;\n  assign unused = {{{}{{1'b1}}}} << {{{waiting}, 1'b0}};\n",
            2 * depth
        );
        self.nets +=
            &format!("  logic [{high}:0] write_back;\n  assign write_back = {{{write}, {write}}} >> {waiting};\n");
        self.place(&front, &format!("{step}opcode_q"), None);
        self.said.push(format!("{front} || {waiting} == 0"));
        self.said.push(format!("!{front} || lemma_waits < {}", self.patience));
        self.said.push(format!("{waiting} <= {depth}"));
        for pointer in [&write, &read] {
            self.said.push(format!("{pointer} != 0 && ({pointer} & ({pointer} - 1)) == 0"));
        }
        self.said.push(format!("write_back[{}:0] == {read}", depth - 1));
        self.said.push(format!("((in_turn ^ lemma_inside[2 +: {}]) & ~unused) == 0", 2 * depth));
        self.before += 1;
        self.counter(format!("before_{} + {waiting}", self.before - 1));
    }

    fn end(mut self) -> String {
        self.said.push(format!("lemma_count == before_{}", self.before));
        self.said.push(format!("lemma_count <= {}", self.full));
        self.said.push("(lemma_inside >> {lemma_count, 1'b0}) == 0".to_string());
        self.said.push("lemma_count != 0 || lemma_waits == 0".to_string());
        let said: Vec<String> = self.said.iter().map(|lemma| format!("({lemma})")).collect();
        format!("{}  always_comb lemmas: assert ({});\n", self.nets, said.join("\n    && "))
    }
}

/// Bits of a number.
fn bits(number: usize) -> usize {
    (usize::BITS - number.leading_zeros()) as usize
}
