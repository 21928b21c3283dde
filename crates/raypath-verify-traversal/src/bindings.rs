//! The names by which the properties see the inside of a module.

use super::setting::Setting;
use raypath_hdl::Module;
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::{Queries, StepParameters, UnitParameters};
use std::fmt::Write as _;

/// The bits of a word with the values 0 to `count` - 1.
fn bits(count: u32) -> u32 {
    count.next_power_of_two().trailing_zeros().max(1)
}

/// A signal of the module, or one inside of its instances, which is declared.
fn seen(text: &mut String, path: &str, width: u32) -> String {
    if path.contains('.') {
        let _ = writeln!(text, "  (* hierconn *) logic [{}:0] \\{path} ;", width - 1);
    }
    format!("\\{path} ")
}

/// The registers of a queue at this path: `p_head`, `p_tail`, `p_valid`, how many words wait in its memory, `p_count`,
/// the word at one address of it, `p_stored` at `p_slot`, the word at its output, `p_front`, and what it reads at other
/// addresses, `p_other`. Words have W bits.
pub fn of_queue(path: &str, queue: &Module, depth: u32) -> String {
    let (mut text, address) = (String::new(), bits(depth));
    let width: u32 = columns(queue).iter().map(|(_, width)| width).sum();
    let mut of = |name: &str, width: u32| seen(&mut text, &format!("{path}{name}"), width);
    let [head, tail, slot] = ["head_q", "tail_q", "u_words.slot"].map(|name| of(name, address));
    let valid = of("valid_q", 1);
    let [stored, front, other] = ["word_q", "read_data_o", "other"].map(|name| of(&format!("u_words.{name}"), width));
    let _ = write!(
        text,
        "  localparam int W = {width};\n  \
         wire [8:0] p_head = {head}, p_tail = {tail}, p_slot = {slot};\n  \
         wire [8:0] p_count = p_tail - p_head + (p_tail < p_head ? 9'd{depth} : 9'd0);\n  \
         wire p_valid = {valid};\n  \
         wire [W-1:0] p_stored = {stored}, p_front = {front}, p_other = {other};\n"
    );
    text
}

/// The columns of a queue.
fn columns(queue: &Module) -> Vec<(&str, u32)> {
    let ports = queue.inputs().iter().filter(|port| port.name != "push_i" && port.name != "pop_i");
    ports.map(|port| (port.name.trim_end_matches("_i"), queue.signal(port.signal).width)).collect()
}

/// The word that enters a queue, and the word at its output.
pub fn queue_words(_: &Setting, queue: &Module) -> String {
    let ports = |suffix: &str| {
        let names: Vec<String> = columns(queue).iter().map(|(name, _)| format!("{name}_{suffix}")).collect();
        names.join(", ")
    };
    format!("  wire [W-1:0] p_word_in = {{{}}}, p_word_out = {{{}}};\n", ports("i"), ports("o"))
}

/// The width of a context.
fn context_width(module: &Module) -> String {
    format!("  localparam int W = {};\n", module.port_width("context_i").unwrap_or(1))
}

/// The contexts that were never used begin with this one; there are N contexts.
pub fn contexts(_: &Setting, _: &Module) -> String {
    "  wire [8:0] p_fresh_q = has_fresh_q ? fresh_q : 9'(N);\n".to_string()
}

/// The words of a block: the memory and the reader that have them, the stem of its ports, the first word for a kind of
/// nodes, and the bits of a word that are followed. A port for whether a child exists is 0 for kind 0, or, of eight, for
/// a byte of 0.
type BlockWords = (&'static str, &'static str, &'static str, fn(NodeKind) -> usize, u32);

const WORDS: [BlockWords; 4] = [
    ("jobs", "job", "word", |_| 0, 1),
    ("jobs", "job", "exists", NodeKind::child_word, 6),
    ("children", "child", "child", NodeKind::child_word, 1),
    ("indices", "index", "index", NodeKind::index_word, 1),
];

/// The beats of a block, and what is kept of each for the context that is followed: the lowest bits of its words.
pub fn blocks(setting: &Setting, module: &Module) -> String {
    let UnitParameters { contexts, memory_width, ram_latency, step: StepParameters { node, .. }, .. } =
        setting.unit.parameters;
    let (beats, per_beat) = (8 * node.block_bytes() / memory_width, memory_width as usize / 32);
    let mut text = context_width(module)
        + &format!(
            "  localparam int BEATS = {beats};\n  (* anyconst *) logic [W-1:0] p_context;\n  logic [3:0] p_beats_q;\n"
        );
    let mut right = Vec::new();
    for (place, beat) in (0..WORDS.len()).flat_map(|place| (0..beats as usize).map(move |beat| (place, beat))) {
        let (memory, reader, stem, first, bits_of_word) = WORDS[place];
        let words = (0..).map(|k| match stem {
            "exists" if node == NodeKind::Wide8 => (format!("{stem}_{k}_o"), first(node) + 2 + k / 4, 8 * (k % 4), 8),
            _ => (format!("{stem}_{k}_o"), first(node) + k, 0, bits_of_word),
        });
        let words = words.take_while(|(port, ..)| module.port_width(port).is_some());
        let (shown, given): (Vec<String>, Vec<String>) = words
            .filter(|(_, word, ..)| word / per_beat == beat)
            .map(|(port, word, low, bits_of_word)| {
                let data = format!("data_i[{} +: {bits_of_word}]", 32 * (word % per_beat) + low);
                (format!("{port}[0]"), if bits_of_word == 1 { data } else { format!("{data} != 0") })
            })
            .unzip();
        if shown.is_empty() {
            continue;
        }
        let name = format!("{memory}_{beat}");
        let latency = if reader == "child" { ram_latency } else { 1 };
        if !text.contains(&format!("u_{name}.slot ")) {
            let slot = seen(&mut text, &format!("u_{name}.slot"), bits(contexts));
            let _ = writeln!(text, "  always_comb assume ({slot}== p_context);");
        }
        let _ = writeln!(
            text,
            "  wire p_{stem}_{beat};\n  p_kept #(.B ({}), .LATENCY ({latency})) p_keeps_{stem}_{beat} (.clk_i, .rst_ni,\n    \
             .ignored (1'b0), .stored ('0), \
             .writes (valid_i && context_i == p_context && p_beats_q == {beat}), .stays (),\n    \
             .reads ({reader}_read_i && {reader}_context_i == p_context), .right (p_{stem}_{beat}),\n    \
             .given ({{{}}}),\n    .shown ({{{}}}));",
            shown.len(),
            given.join(", "),
            shown.join(", "),
        );
        right.push(format!("p_{stem}_{beat}"));
    }
    text + &format!("  wire p_right = {};\n", right.join(" && "))
}

/// The sources of answers.
fn sources(setting: &Setting) -> (bool, String) {
    let has_candidates = setting.unit.parameters.step.features.queries == Queries::Full;
    (has_candidates, format!("  localparam int S = {};\n", if has_candidates { 6 } else { 5 }))
}

pub fn scheduler(setting: &Setting, _: &Module) -> String {
    sources(setting).1
}

/// The verdicts that wait, whether a step ends with a candidate, and the cycles of a stage, with registers of its own
/// between them.
pub fn walk(setting: &Setting, _: &Module) -> String {
    let (has_candidates, text) = sources(setting);
    let latency = setting.unit.parameters.ram_latency;
    let early = match latency {
        1 => "  wire p_early = 1'b1;\n",
        _ => {
            "  wire p_early = prepares_1_q == p_steps_q[0] && (!p_steps_q[0] || prepared_context_1_q == p_contexts_q[0])
    && finishes_1_q == p_steps_q[2] && (!p_steps_q[2] || finished_context_1_q == p_contexts_q[2]);\n"
        }
    };
    let [valid, taken, asks, context] = match has_candidates {
        true => ["decided_valid", "scheduler_grant[5]", "asks_o", "decided_context"],
        false => ["1'b0", "1'b0", "1'b0", "0"],
    };
    text + &format!(
        "  wire p_verdict_valid = {valid}, p_verdict_taken = {taken}, p_candidate = {asks};\n  \
         wire [W-1:0] p_verdict_context = {context};\n  localparam int L = {latency};\n"
    ) + early
}

/// The words that are kept for one context: of the closest hit, and of the state.
pub fn candidates(setting: &Setting, module: &Module) -> String {
    let contexts = bits(setting.unit.parameters.contexts);
    let [tested, state] = ["tested_", "next_"].map(|stem| {
        let fields =
            module.inputs().iter().filter(|port| port.name.starts_with(stem) && port.name != "tested_context_i");
        fields.map(|port| module.signal(port.signal).width).sum::<u32>()
    });
    format!("  localparam int T = {tested}, V = {state};\n")
        + &of_memory("tested", contexts, tested)
        + &of_memory("states", contexts, state)
}

/// Whether the words of the triangle are those of its place in the block.
pub fn issue(setting: &Setting, _: &Module) -> String {
    let nodes = setting.unit.parameters.step.node;
    let (jobs, triangles) = (nodes.children() / 4, nodes.triangles_per_block());
    let jobs = format!("  localparam logic [1:0] NODE_JOBS = {jobs}, TRIANGLES = {triangles};\n");
    let is_instance = if nodes == NodeKind::Quantised { " || is_instance_i" } else { "" };
    let word = |k: usize| {
        let (vertex, axis) = (k / 3, k % 3);
        let others = match nodes {
            NodeKind::Wide4 | NodeKind::Wide8 => format!("place_o == 1 ? word_{}_i : word_{}_i", k + 9, k + 18),
            NodeKind::Quantised => {
                let [a, b, c, d] = [9, 6, 3, 0].map(|first| format!("word_{}_i", first + axis));
                let [high, low] = [1, 0].map(|bit| format!("word_15_i[{}]", 2 * vertex + bit));
                format!("{high} ? ({low} ? {a} : {b}) : {low} ? {c} : {d}")
            }
        };
        format!("triangle_{k}_o == (place_o == 0{is_instance} ? word_{k}_i : {others})")
    };
    let words: Vec<String> = (0..9).map(word).collect();
    jobs + &format!("  wire p_same_words = is_node_o\n    || ({});\n", words.join("\n      && "))
}

/// The word at one address of a memory: `<name>_stored` at `<name>_slot`.
fn of_memory(name: &str, address: u32, width: u32) -> String {
    let mut text = String::new();
    let (slot, word) =
        (seen(&mut text, &format!("u_{name}.slot"), address), seen(&mut text, &format!("u_{name}.word_q"), width));
    let _ = write!(text, "  wire [{}:0] p_{name}_slot = {slot};\n  wire [{}:0]", address - 1, width - 1);
    text + &format!(" p_{name}_stored = {word};\n")
}

/// The values that a ray ends with, and those that its hit shows: name, field, width, and whether a ray without a hit
/// has 0.
const VALUES: [(&str, &str, u32, bool); 7] = [
    ("t", "extent", 32, true),
    ("primitive", "primitive", 32, true),
    ("t_num", "t_num", 32, true),
    ("t_denom", "t_denom", 32, true),
    ("back_face", "back_face", 1, true),
    ("nodes", "nodes", 32, false),
    ("triangles", "triangles", 32, false),
];

/// The values that a ray ends with, those that its hit shows, and those that are kept for one context.
pub fn hits(setting: &Setting, _: &Module) -> String {
    let width: u32 = 3 + VALUES.iter().map(|(_, _, width, _)| width).sum::<u32>();
    let (mut given, mut shown) = ("status_i".to_string(), "status_o".to_string());
    for (name, field, width, is_of_hit) in VALUES {
        let mask = if is_of_hit { format!(" & {{{width}{{status_i == 3'd1}}}}") } else { String::new() };
        let _ = write!(given, ", next_{field}_i{mask}");
        let _ = write!(shown, ", {name}_o");
    }
    of_memory("hits", bits(setting.unit.parameters.contexts), width)
        + &format!(
            "  localparam int V = {width};\n  wire [V-1:0] p_values_in = {{{given}}}, p_values_out = {{{shown}}};\n"
        )
}

/// The stages of a divider, of which `p_stages` have a quotient, and their tags of T bits.
fn of_divider(setting: &Setting, tag: u32) -> String {
    let latency = setting.unit.parameters.divider_latency;
    let mut text = format!("  localparam int LATENCY = {latency}, T = {tag};\n");
    let mut stages = |name: &str, width: u32| {
        let stage = |stage: u32| seen(&mut text, &format!("u_divider.{name}_{stage}_q"), width);
        (1..=latency).rev().map(stage).collect::<Vec<String>>().join(", ")
    };
    let (valid, tags) = (stages("valid", 1), stages("tag", tag));
    text + &format!("  wire [LATENCY-1:0] p_stages = {{{valid}}};\n  wire [LATENCY*T-1:0] p_tags = {{{tags}}};\n")
}

/// The stages of the divider, which carry a context, whether it has a hit, and which quotient it is.
pub fn weights(setting: &Setting, module: &Module) -> String {
    let width = module.port_width("context_i").unwrap_or(1);
    context_width(module) + &of_divider(setting, width + 2)
}

/// The stages of the divider with what their tags tell of a triangle, and the fraction that is kept at one place.
pub fn distance(setting: &Setting, module: &Module) -> String {
    let width = module.port_width("context_i").unwrap_or(1);
    let places = module.port_width("place_i").unwrap_or(1);
    let numbers = if setting.unit.parameters.step.features.barycentrics { 4 } else { 2 };
    let numbers = &["t_num", "t_denom", "u_num", "v_num"][..numbers];
    let all = |name: &dyn Fn(&&str) -> String| numbers.iter().map(name).collect::<Vec<_>>().join(", ");
    let (given, shown) = (all(&|name| format!("{name}_i")), all(&|name| format!("fractions_{name}")));
    let mut text = context_width(module) + &of_divider(setting, width + places + 3);
    let place = format!("{{tag[T-1 -: W], 2'(tag[3 +: {places}])}}");
    for (high, name, of) in
        [(0, "p_is_last", "tag[2]"), (width + 1, "p_place", &place), (width - 1, "p_context", "tag[T-1 -: W]")]
    {
        let _ = writeln!(text, "  function automatic [{high}:0] {name}(input [T-1:0] tag); {name} = {of}; endfunction");
    }
    text += &of_memory("fractions", width + places, 32 * numbers.len() as u32);
    let _ = writeln!(
        text,
        "  localparam int F = {};\n  wire [F-1:0] p_fraction_in = {{{given}}}, p_fraction_out = {{{shown}}};\n  \
         wire [W+1:0] p_slot = {{p_fractions_slot[{places} +: W], 2'(p_fractions_slot[0 +: {places}])}};",
        32 * numbers.len(),
    );
    text
}

/// The cycles from a ray's entry to its constants: one for each of five quotients, one for the operands, and the
/// divider's.
pub fn set_up(setting: &Setting, module: &Module) -> String {
    let latency = setting.unit.parameters.divider_latency + 6;
    context_width(module) + &format!("  localparam int LATENCY = {latency};\n")
}

/// The lowest bits of the words that pass, at the inputs and at the outputs, and the place of the job.
pub fn decoder(setting: &Setting, module: &Module) -> String {
    let nodes = setting.unit.parameters.step.node;
    let words = |name: &dyn Fn(u32) -> String| (0..9).map(name).collect::<Vec<String>>().join(", ");
    let given = words(&|k| match nodes {
        NodeKind::Wide8 => format!("(is_instance_i ? word_{}_i[0] : triangle_{k}_i[0])", nodes.matrix_word(k as usize)),
        _ => format!("word_{k}_i[0]"),
    });
    let shown = words(&|k| format!("word_{k}_o[0]"));
    let (place, shown_place, width) = match nodes {
        NodeKind::Wide8 => (", is_node_i ? window_i : place_i, is_last_i", ", place_o, is_last_o", 12),
        _ => (", place_i, is_last_i", ", place_o, is_last_o", 11),
    };
    context_width(module)
        + &format!(
            "  localparam int D = {width};\n  wire [D-1:0] p_words_in = {{{given}{place}}};\n  \
             wire [D-1:0] p_words_out = {{{shown}{shown_place}}};\n"
        )
}

/// What the part that derives constants returns: `p_known` with its context, whether it is for an instance, and the
/// lowest bits of the constants.
pub fn rays(setting: &Setting, module: &Module) -> String {
    const CONSTANTS: [&str; 9] = ["inv_x", "inv_y", "inv_z", "shear_x", "shear_y", "shear_z", "kx", "ky", "kz"];
    let has_instances = setting.unit.parameters.step.features.instances;
    let (part, is_instance, is_inside, given, shown) = match has_instances {
        true => ("entries", "entries_is_instance", "job_inside_i", ", @_is_instance", ", start_is_instance_o"),
        false => ("set_up", "1'b0", "1'b0, p_instances_stay = 1'b1", "", ""),
    };
    let width = module.port_width("start_context_o").unwrap_or(1);
    let constants = CONSTANTS.map(|name| format!("@_{name}[0]")).join(", ");
    format!(
        "  localparam int A = {width}, LATENCY = {};\n  (* anyconst *) logic [A-1:0] p_context;\n  \
         always_comb assume (p_context < N);\n  wire [A-1:0] p_known_context = @_context;\n  \
         wire p_known = @_valid, p_set_up_ready = @_ready;\n  \
         wire p_is_instance = {is_instance}, p_is_inside = {is_inside};\n  \
         wire [W-1:0] p_known_word = {{@_context, @_is_refused{given}}};\n  \
         wire [W-1:0] p_start_word = {{start_context_o, start_is_refused_o{shown}}};\n  \
         wire [8:0] p_constants = {{{constants}}};\n",
        setting.unit.parameters.ram_latency,
    )
    .replace('@', part)
}

/// The candidates of a word of a list that is read, `p_old`, and written, `p_new`, with their marks, and the addresses
/// of both. Contexts have W bits, and the numbers of words B.
pub fn list(_: &Setting, module: &Module) -> String {
    let width = module.port_width("context_i").unwrap_or(1);
    let of_words = module.port_width("clear_candidate_i").map_or(1, |bits| bits - 4);
    let mut text = format!("  localparam int W = {width}, B = {of_words};\n");
    let all = |stem: &str, fields: [&str; 2]| {
        let entry = |k: u32| format!("{stem}_{}_{k}, {stem}_{}_{k}", fields[0], fields[1]);
        (0..16).rev().map(entry).collect::<Vec<_>>().join(", ")
    };
    for (name, stem) in [("old", "candidates"), ("new", "new")] {
        let marks: Vec<String> = (0..16).rev().map(|k| format!("{stem}_expanded_{k}")).collect();
        let _ = write!(
            text,
            "  wire [15:0][63:0] p_{name} = {{{}}};\n  wire [15:0] p_{name}_expanded = {{{}}};\n",
            all(stem, ["key", "index"]),
            marks.join(", ")
        );
    }
    let [read, written] = ["read_address_i", "write_address_i"]
        .map(|port| seen(&mut text, &format!("u_candidates.{port}"), width + of_words));
    let reads = seen(&mut text, "u_candidates.read_enable_i", 1);
    text + &format!("  wire [W+B-1:0] p_read = {read}, p_written = {written};\n  wire p_reads = {reads};\n")
}

/// The branches of a search: how many there are, `p_count`, and the word at one address of their memory, `p_stored` at
/// `p_slot`. Contexts have W bits.
pub fn branches(setting: &Setting, module: &Module) -> String {
    let width = module.port_width("context_i").unwrap_or(1);
    let mut text = format!("  localparam int W = {width};\n");
    let [slot, stored] =
        [("slot", width + 5), ("word_q", 37)].map(|(name, bits)| seen(&mut text, &format!("u_branches.{name}"), bits));
    let contexts = setting.unit.parameters.search.0.map_or(1, |search| search.contexts);
    let counts =
        (1..contexts).fold("count_0_q".to_string(), |rest, k| format!("p_context == {k} ? count_{k}_q : {rest}"));
    text + &format!(
        "  (* anyconst *) logic [W-1:0] p_context;\n  wire [5:0] p_count = {counts};\n  \
         wire [W+4:0] p_slot = {slot};\n  wire [36:0] p_stored = {stored};\n"
    )
}

/// The memory of compared indices: the word at one address of it, `p_stored` at `p_slot`, and the word that was read,
/// `p_shown`. Contexts have W bits, and the numbers of sets S.
pub fn compared(setting: &Setting, module: &Module) -> String {
    let width = module.port_width("block_context_i").unwrap_or(1);
    let sets = setting.unit.parameters.search.0.map_or(1, |search| bits(search.remembered / 8));
    let mut text = format!("  localparam int W = {width}, S = {sets};\n");
    let slot = seen(&mut text, "u_compared.slot", width + sets);
    let [stored, shown] = ["word_q", "read_q"].map(|name| seen(&mut text, &format!("u_compared.{name}"), 256));
    text + &format!("  wire [W+S-1:0] p_slot = {slot};\n  wire [255:0] p_stored = {stored}, p_shown = {shown};\n")
}
