//! The names by which the properties see the inside of a module.

use super::setting::Setting;
use raypath_hdl::Module;
use std::fmt::Write as _;

/// The registers of a queue, whose memory is expanded, at this path: `p_head`, `p_tail`, `p_valid`, its `p_words`, of W
/// bits each, of which `p_count` wait, and the word at its output, `p_front`.
pub fn of_queue(path: &str, queue: &Module, depth: u32) -> String {
    let mut text = String::new();
    let columns: Vec<(&str, u32)> = columns(queue);
    let width: u32 = columns.iter().map(|(_, width)| width).sum();
    let mut seen = |name: String, width: u32| {
        if !path.is_empty() {
            let _ = writeln!(text, "  (* hierconn *) logic [{}:0] \\{path}{name} ;", width - 1);
        }
        format!("\\{path}{name} ")
    };
    let register = |name: &str| {
        queue.registers().iter().find(|register| queue.signal(register.signal).name.as_deref() == Some(name))
    };
    let width_of = |name: &str| register(name).map_or(1, |register| queue.signal(register.signal).width);
    let [head, tail, valid] = ["head_q", "tail_q", "valid_q"].map(|name| seen(name.to_string(), width_of(name)));
    let front: Vec<String> = columns.iter().map(|(name, width)| seen(format!("words_{name}"), *width)).collect();
    let slots: Vec<String> = (0..depth)
        .rev()
        .flat_map(|slot| columns.iter().map(move |(name, width)| (format!("words_{name}_{slot}_q"), *width)))
        .map(|(name, width)| seen(name, width))
        .collect();
    let _ = write!(
        text,
        "  localparam int W = {width};\n  \
         wire [8:0] p_head = {head}, p_tail = {tail};\n  \
         wire [8:0] p_count = p_tail - p_head + (p_tail < p_head ? 9'd{depth} : 9'd0);\n  \
         wire p_valid = {valid};\n  \
         wire [{high}:0] p_words = {{{}}};\n  \
         wire [W-1:0] p_front = {{{}}};\n",
        slots.join(", "),
        front.join(", "),
        high = depth * width - 1,
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
pub fn context_width(_: &Setting, module: &Module) -> String {
    format!("  localparam int W = {};\n", module.port_width("context_i").unwrap_or(1))
}

pub fn nothing(_: &Setting, _: &Module) -> String {
    String::new()
}

/// The contexts that were never used begin with this one; there are N contexts.
pub fn contexts(_: &Setting, _: &Module) -> String {
    "  wire [8:0] p_fresh_q = has_fresh_q ? fresh_q : 9'(N);\n".to_string()
}

/// The beats of a block.
pub fn blocks(setting: &Setting, module: &Module) -> String {
    let beats = 1024 / setting.unit.parameters.memory_width;
    context_width(setting, module) + &format!("  localparam int BEATS = {beats};\n")
}

/// Whether the words of the triangle are those of its place in the block.
pub fn issue(_: &Setting, _: &Module) -> String {
    let word = |k: usize| {
        let (second, third) = (k + 9, k + 18);
        format!("triangle_{k}_o == (place_o == 0 ? word_{k}_i : place_o == 1 ? word_{second}_i : word_{third}_i)")
    };
    let words: Vec<String> = (0..9).map(word).collect();
    format!("  wire p_same_words = is_node_o\n    || ({});\n", words.join("\n      && "))
}

/// The values that a ray ends with, those that its hit shows, and those that are kept for the context that is
/// followed. A short proof takes some of them.
pub fn hits(setting: &Setting, _: &Module) -> String {
    const VALUES: [(&str, &str, u32, bool); 7] = [
        ("back_face", "back_face", 1, true),
        ("t", "extent", 32, true),
        ("triangle", "triangle", 32, true),
        ("t_num", "t_num", 32, true),
        ("t_denom", "t_denom", 32, true),
        ("nodes", "nodes", 32, false),
        ("triangles", "triangles", 32, false),
    ];
    let values = if setting.is_wide { &VALUES[..] } else { &VALUES[..1] };
    let width: u32 = 2 + values.iter().map(|(_, _, width, _)| width).sum::<u32>();
    let mut given = "status_i".to_string();
    let mut shown = "status_o".to_string();
    for (name, field, width, is_of_hit) in values {
        let mask = if *is_of_hit { format!(" & {{{width}{{status_i == 2'd1}}}}") } else { String::new() };
        let _ = write!(given, ", next_{field}_i{mask}");
        let _ = write!(shown, ", {name}_o");
    }
    let kept = (0..setting.unit.parameters.contexts).fold("0".to_string(), |others, context| {
        let names: String = values.iter().map(|(name, ..)| format!(", hits_{name}_{context}_q")).collect();
        format!("p_context_q == {context} ? {{hits_status_{context}_q{names}}}\n    : {others}")
    });
    format!(
        "  localparam int V = {width};\n  \
         wire [V-1:0] p_values_in = {{{given}}}, p_values_out = {{{shown}}};\n  \
         wire [V-1:0] p_stored;\n  assign p_stored = {kept};\n"
    )
}

/// The stages of the divider, and the fraction that is kept for the triangle that is followed, or its lowest bits.
pub fn distance(setting: &Setting, module: &Module) -> String {
    let latency = setting.unit.parameters.divider_latency;
    let width = module.port_width("context_i").unwrap_or(1) + 5;
    let mut text = context_width(setting, module);
    for stage in 1..=latency {
        let _ = writeln!(text, "  (* hierconn *) logic \\u_divider.valid_{stage}_q ;");
        let _ = writeln!(text, "  (* hierconn *) logic [{}:0] \\u_divider.tag_{stage}_q ;", width - 1);
    }
    let stages = |name: &str| {
        let names: Vec<String> = (1..=latency).rev().map(|stage| format!("\\u_divider.{name}_{stage}_q ")).collect();
        names.join(", ")
    };
    let fraction = |suffix: &str| match setting.is_wide {
        true => format!("{{fractions_t_num{suffix}, fractions_t_denom{suffix}}}"),
        false => format!("{{fractions_t_num{suffix}[0], fractions_t_denom{suffix}[0]}}"),
    };
    let kept = (0..4 * setting.unit.parameters.contexts).fold("0".to_string(), |others, place| {
        format!("p_place_q == {place} ? {}\n    : {others}", fraction(&format!("_{place}_q")))
    });
    let (bits, given) = match setting.is_wide {
        true => (64, "{t_num_i, t_denom_i}"),
        false => (2, "{t_num_i[0], t_denom_i[0]}"),
    };
    let _ = write!(
        text,
        "  localparam int LATENCY = {latency}, T = {width}, F = {bits};\n  \
         wire [LATENCY-1:0] p_stages = {{{}}};\n  \
         wire [LATENCY*T-1:0] p_tags = {{{}}};\n  \
         wire [F-1:0] p_fraction_in = {given}, p_fraction_out = {};\n  \
         wire [F-1:0] p_stored;\n  assign p_stored = {kept};\n",
        stages("valid"),
        stages("tag"),
        fraction(""),
    );
    text
}

/// The cycles from a ray's entry to its constants: one for each of five quotients, one for the operands, and the
/// divider's.
pub fn set_up(setting: &Setting, module: &Module) -> String {
    let latency = setting.unit.parameters.divider_latency + 6;
    context_width(setting, module) + &format!("  localparam int LATENCY = {latency};\n")
}
