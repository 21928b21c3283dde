//! The names by which the properties see the inside of a module.

use super::setting::{Setting, Variant};
use raypath_hdl::Module;
use raypath_traversal::blocks::NodeKind;
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

/// Whether the words of the triangle are those of its place in the block. A block of quantised nodes has one job.
pub fn issue(setting: &Setting, _: &Module) -> String {
    if setting.unit.parameters.step.node == NodeKind::Quantised {
        let one_job =
            "  wire [1:0] count_i = 0, place_o = 0;\n  wire is_last_o = 1, is_node_o = 1, p_same_words = 1;\n";
        return one_job.to_string();
    }
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

/// The stages of a divider, of which `p_stages` have a quotient, and their tags of T bits.
fn of_divider(setting: &Setting, tag: u32) -> String {
    let latency = setting.unit.parameters.divider_latency;
    let mut text = format!("  localparam int LATENCY = {latency}, T = {tag};\n");
    for stage in 1..=latency {
        let _ = writeln!(text, "  (* hierconn *) logic \\u_divider.valid_{stage}_q ;");
        let _ = writeln!(text, "  (* hierconn *) logic [{}:0] \\u_divider.tag_{stage}_q ;", tag - 1);
    }
    let stages = |name: &str| {
        let names: Vec<String> = (1..=latency).rev().map(|stage| format!("\\u_divider.{name}_{stage}_q ")).collect();
        names.join(", ")
    };
    let (valid, tags) = (stages("valid"), stages("tag"));
    text + &format!("  wire [LATENCY-1:0] p_stages = {{{valid}}};\n  wire [LATENCY*T-1:0] p_tags = {{{tags}}};\n")
}

/// The stages of the divider, which carry a context, whether it has a hit, and which quotient it is.
pub fn weights(setting: &Setting, module: &Module) -> String {
    let width = module.port_width("context_i").unwrap_or(1);
    context_width(setting, module) + &of_divider(setting, width + 2)
}

/// The stages of the divider with what their tags tell of a triangle, and the fraction that is kept for the triangle
/// that is followed, or its lowest bits. A block of quantised nodes has one triangle.
pub fn distance(setting: &Setting, module: &Module) -> String {
    let width = module.port_width("context_i").unwrap_or(1);
    let has_places = setting.unit.parameters.step.node != NodeKind::Quantised;
    let tag = width + if has_places { 5 } else { 2 };
    let mut text = context_width(setting, module) + &of_divider(setting, tag);
    let (is_last, place) = if has_places { ("tag[2]", "tag[T-1:3]") } else { ("1'b1", "{tag[T-1:2], 2'd0}") };
    for (bits, name, of) in [(0, "p_is_last", is_last), (width + 1, "p_place", place)] {
        let _ = writeln!(text, "  function automatic [{bits}:0] {name}(input [T-1:0] tag); {name} = {of}; endfunction");
    }
    let _ = writeln!(
        text,
        "  function automatic [W-1:0] p_context(input [T-1:0] tag); p_context = tag[T-1 -: W]; endfunction"
    );
    if !has_places {
        text += "  wire [1:0] place_i = 0;\n  wire is_last_i = 1;\n";
    }
    let fraction = |suffix: &str| match setting.is_wide {
        true => format!("{{fractions_t_num{suffix}, fractions_t_denom{suffix}}}"),
        false => format!("{{fractions_t_num{suffix}[0], fractions_t_denom{suffix}[0]}}"),
    };
    let per_context = if has_places { 4 } else { 1 };
    let kept = (0..per_context * setting.unit.parameters.contexts).fold("0".to_string(), |others, place| {
        format!("p_place_q == {} ? {}\n    : {others}", 4 / per_context * place, fraction(&format!("_{place}_q")))
    });
    let (bits, given) = match setting.is_wide {
        true => (64, "{t_num_i, t_denom_i}"),
        false => (2, "{t_num_i[0], t_denom_i[0]}"),
    };
    let _ = write!(
        text,
        "  localparam int F = {bits};\n  \
         wire [F-1:0] p_fraction_in = {given}, p_fraction_out = {};\n  \
         wire [F-1:0] p_stored;\n  assign p_stored = {kept};\n",
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

/// The words of a triangle at the inputs and at the outputs, or their lowest bits.
pub fn decoder(setting: &Setting, module: &Module) -> String {
    let bits = if setting.is_wide { 32 } else { 1 };
    let words = |name: &dyn Fn(u32) -> String| {
        let words: Vec<String> = (0..9).map(|k| format!("{}[{}:0]", name(k), bits - 1)).collect();
        words.join(", ")
    };
    let (given, shown) = (words(&|k| format!("word_{k}_i")), words(&|k| format!("triangle_{k}_o")));
    context_width(setting, module)
        + &format!("  localparam int D = {};\n  wire [D-1:0] p_words_in = {{{given}}};\n", 9 * bits)
        + &format!("  wire [D-1:0] p_words_out = {{{shown}}};\n")
}

/// A memory of `rays`: where it is written, for which context, its reader, where it is not shown, and for each column
/// what is written and where it is shown.
struct Kept {
    name: &'static str,
    writes: String,
    context: String,
    reader: [&'static str; 2],
    ignored: &'static str,
    columns: Vec<[String; 3]>,
}

/// The constants that become known, and what is kept for the context that is followed.
pub fn rays(setting: &Setting, module: &Module) -> String {
    let has_instances = setting.unit.parameters.step.features.instances;
    let part = if has_instances { "entries" } else { "set_up" };
    let width = module.port_width("start_context_o").unwrap_or(1);
    let columns = ["context", "is_refused", "is_instance"];
    let columns = if has_instances { &columns[..] } else { &columns[..2] };
    let all = |name: &dyn Fn(&str) -> String| columns.iter().map(|c| name(c)).collect::<Vec<_>>().join(", ");
    let mut text = format!(
        "  (* anyconst *) logic [{}:0] p_context;\n  always_comb assume (p_context < N);\n  \
         wire p_known = {part}_valid, p_set_up_ready = {part}_ready;\n  \
         wire [W-1:0] p_known_word = {{{}}}, p_start_word = {{{}}};\n",
        width - 1,
        all(&|column| format!("{part}_{column}")),
        all(&|column| format!("start_{column}_o")),
    );
    let memories = memories(part, has_instances);
    let _ = writeln!(text, "  wire [{}:0] p_right, p_stays;", memories.len() - 1);
    for (number, memory) in memories.iter().enumerate() {
        text += &kept(setting, module, number, memory);
    }
    text
}

/// The memories of `rays`, whose constants come from this part.
fn memories(part: &str, has_instances: bool) -> Vec<Kept> {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let columns = |columns: &[[&str; 3]]| columns.iter().map(|column| column.map(String::from)).collect::<Vec<_>>();
    let vector = |column: &str, given: &str, shown: &str| {
        AXES.map(|axis| [format!("{column}{axis}"), given.replace('*', axis), format!("job_{shown}_{axis}_o")]).to_vec()
    };
    let constants: Vec<[String; 3]> = CONSTANTS.map(|c| [c.into(), format!("{part}_{c}"), format!("job_{c}_o")]).into();
    let id = columns(&[["id", "id_i", "id_o"]]);
    let begins = columns(&[
        ["root", "root_i", "begin_root_o"],
        ["t_max", "entry_t_max_i", "begin_t_max_o"],
        ["any_hit", "any_hit_i", "begin_any_hit_o"],
    ]);
    let limits = columns(&[
        ["limits_t_min", "entry_t_min_i", "limits_t_min_o"],
        ["limits_cull_back", "cull_i[0]", "limits_cull_back_o"],
        ["limits_cull_front", "cull_i[1]", "limits_cull_front_o"],
    ]);
    let (outside, inside) = if has_instances { ("job_inside_i", "!job_inside_i") } else { ("1'b0", "1'b0") };
    let (job, step) = (["job_read_i", "job_context_i"], ["step_read_i", "step_context_i"]);
    let (limit, release) = (["limits_read_i", "limits_context_i"], ["release_i", "hit_context_i"]);
    let (at_entry, known) = ("p_enters".to_string(), format!("{part}_valid"));
    let (entering, context) = ("contexts_context".to_string(), format!("{part}_context"));
    let memory = |name, [writes, context]: [&String; 2], reader, ignored, columns| Kept {
        name,
        writes: writes.clone(),
        context: context.clone(),
        reader,
        ignored,
        columns,
    };
    let entry = [&at_entry, &entering];
    let mut all = vec![
        memory("ids", entry, release, "1'b0", id),
        memory("begins", entry, step, "1'b0", begins),
        memory("limits", entry, limit, "1'b0", limits),
        memory("origins", entry, job, outside, vector("origin_", "entry_origin_*_i", "origin")),
    ];
    if !has_instances {
        all.push(memory("constants", [&known, &context], job, outside, constants));
        return all;
    }
    let [of_scene, of_object] = ["!", ""].map(|not| format!("{known} && {not}{part}_is_instance"));
    let (enters, origin) = (format!("{part}_enters_instance"), format!("{part}_origin_context"));
    all.extend([
        memory("constants", [&of_scene, &context], job, outside, constants.clone()),
        memory("object_constants", [&of_object, &context], job, inside, constants),
        memory("object_origins", [&enters, &origin], job, inside, vector("", "entries_object_*", "origin")),
        memory("directions", entry, job, "1'b0", vector("dir_", "entry_dir_*_i", "dir")),
    ]);
    all
}

/// That a reader has what was written last: all its bits, or the lowest of each column.
fn kept(setting: &Setting, module: &Module, number: usize, memory: &Kept) -> String {
    let Kept { name, writes, context, reader: [reads, reader], ignored, columns } = memory;
    // With instances the memories are of the same kind, and the proof of all bits takes minutes.
    let is_wide = setting.is_wide && setting.variant == Variant::Plain;
    let bits = |column: &[String; 3]| if is_wide { module.port_width(&column[2]).unwrap_or(1) } else { 1 };
    let words = |word: &dyn Fn(&[String; 3]) -> String| {
        let words: Vec<String> = columns.iter().map(|column| format!("{}'({})", bits(column), word(column))).collect();
        format!("{{{}}}", words.join(", "))
    };
    let stored = (0..setting.unit.parameters.contexts).fold("0".to_string(), |others, place| {
        let words = words(&|column| format!("{name}_{}_{place}_q", column[0]));
        format!("p_context == {place} ? {words}\n    : {others}")
    });
    let (given, shown) = (words(&|column| column[1].clone()), words(&|column| column[2].clone()));
    let width: u32 = columns.iter().map(bits).sum();
    format!(
        "  wire [{high}:0] p_given_{number} = {given};\n  wire [{high}:0] p_shown_{number} = {shown};\n  \
         wire [{high}:0] p_stored_{number};\n  assign p_stored_{number} = {stored};\n  \
         p_kept #(.B ({width})) p_memory_{number} (.clk_i, .rst_ni, .writes ({writes} && {context} == p_context),\n    \
         .reads ({reads} && {reader} == p_context), .ignored ({ignored}), .given (p_given_{number}),\n    \
         .shown (p_shown_{number}), .stored (p_stored_{number}), .right (p_right[{number}]), \
         .stays (p_stays[{number}]));\n",
        high = width - 1,
    )
}

/// The constants of a ray.
const CONSTANTS: [&str; 9] = ["inv_x", "inv_y", "inv_z", "shear_x", "shear_y", "shear_z", "kx", "ky", "kz"];
