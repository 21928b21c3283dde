//! The modules of the unit whose control is proved, with their properties and the faults that the proofs must refute.

use super::bindings;
use super::setting::{Setting, Variant};
use raypath_hdl::Module;
use raypath_verify::safety::Method;

/// What is claimed of a module, and how it is proved.
pub struct Claim {
    /// The module.
    pub module: &'static str,
    /// The unit that it is taken from.
    pub variant: Variant,
    /// Environment, assertions and, after a line with [`LEMMAS`], what makes them inductive.
    pub properties: &'static str,
    /// The path of the queue whose words the lemmas see, with its module.
    pub queue: Option<(&'static str, &'static str)>,
    /// Whether all memories of the module become registers, besides those of the queue.
    pub expands: bool,
    /// The text that binds the names in the properties to the module.
    pub bindings: fn(&Setting, &Module) -> String,
    /// The method of the proof.
    pub method: Method,
    /// What happens in some run of the module: the proof that it never does must be refuted, otherwise the environment
    /// permits too little.
    pub happens: &'static str,
    /// Faults, as a text of the module and its replacement in the module of the least parameters: each must be refuted
    /// without the lemmas.
    pub faults: &'static [(&'static str, &'static str)],
}

/// The beginning of the comment before the lemmas.
pub const LEMMAS: &str = "  // Lemmas.";

const QUEUE_FAULTS: &[(&str, &str)] = &[
    // A word is at the output for less than it takes.
    ("valid_q <= read | (valid_q & ~pop_i)", "valid_q <= read"),
    // The word at the output is overwritten.
    ("(head_q != tail_q) & (~valid_q | pop_i)", "head_q != tail_q"),
    // A word is left out.
    ("head_q <= head_q + 3'd1", "head_q <= head_q + 3'd2"),
    // A word is read although none waits.
    ("(head_q != tail_q) & (~valid_q | pop_i)", "~valid_q | pop_i"),
    // The last word of the memory is not written.
    ("push_i & (tail_q == 3'd7)", "push_i & (tail_q == 3'd6)"),
];

const fn queue(module: &'static str) -> Claim {
    Claim {
        module,
        variant: Variant::Plain,
        properties: include_str!("properties/queue.sv"),
        queue: Some(("", module)),
        expands: true,
        bindings: bindings::queue_words,
        method: Method::Inductive,
        happens: "p_follows_q && p_leaves && p_ahead_q == 0",
        faults: QUEUE_FAULTS,
    }
}

/// All claims.
pub const CLAIMS: &[Claim] = &[
    queue("raypath_unit_free"),
    queue("raypath_unit_starts"),
    queue("raypath_unit_arrivals"),
    queue("raypath_unit_tested"),
    queue("raypath_unit_continues"),
    queue("raypath_unit_requests"),
    queue("raypath_unit_ended"),
    Claim {
        module: "raypath_unit_contexts",
        variant: Variant::Plain,
        properties: include_str!("properties/contexts.sv"),
        queue: Some(("u_free.", "raypath_unit_free")),
        expands: false,
        bindings: bindings::contexts,
        method: Method::Inductive,
        happens: "p_returns_q && p_takes",
        faults: &[
            // A context that was used is given out as if it were new.
            ("has_fresh_q & ~is_last", "has_fresh_q"),
            // A released context is lost.
            (".push_i (release_i)", ".push_i (release_i & has_fresh_q)"),
            // A released context is lost when a new one is given out.
            (".pop_i (take_i & ~has_fresh_q)", ".pop_i (take_i)"),
            // A new context is left out.
            ("fresh_q <= fresh_q + 3'd1", "fresh_q <= fresh_q + 3'd2"),
        ],
    },
    Claim {
        module: "raypath_unit_scheduler",
        variant: Variant::Plain,
        properties: include_str!("properties/scheduler.sv"),
        queue: None,
        expands: false,
        bindings: bindings::nothing,
        method: Method::Unbounded,
        happens: "p_waits_q[14:12] == 4 && grant_o[4]",
        faults: &[
            // The lowest source is always first.
            ("assign later = request_i[4:1] & after_q", "assign later = 4'd0"),
            // The last source waits for ever.
            ("{|grant[3:0],", "{|grant[2:0],"),
            // Two are granted.
            ("later & (~later + 4'd1)", "later"),
            // Nothing is granted.
            ("request_i & (~request_i + 5'd1)", "5'd0"),
        ],
    },
    Claim {
        module: "raypath_unit_blocks",
        variant: Variant::Plain,
        properties: include_str!("properties/blocks.sv"),
        queue: None,
        expands: false,
        bindings: bindings::blocks,
        method: Method::Unbounded,
        happens: "p_here && arrived_o && failed_o && !error_i",
        faults: &[
            // A block arrives one beat too early.
            ("valid_i & (beat == 2'd3)", "valid_i & (beat == 2'd2)"),
            // An error stays for the next block.
            ("failed_0_q <= failed & ~failed_0_t1", "failed_0_q <= failed"),
            // An error is forgotten.
            ("failed      = failed_t1 | error_i", "failed      = error_i"),
            // A beat counts although it is not valid.
            ("valid_i & (beat == 2'd3)", "beat == 2'd3"),
        ],
    },
    Claim {
        module: "raypath_unit_issue",
        variant: Variant::Plain,
        properties: include_str!("properties/issue.sv"),
        queue: Some(("u_arrivals.", "raypath_unit_arrivals")),
        expands: false,
        bindings: bindings::issue,
        method: Method::Inductive,
        happens: "p_served && p_jobs_q == 2 && !p_failed",
        faults: &[
            // A block gives way with its first job.
            ("assign ends = (leaves & is_last)", "assign ends = leaves"),
            // A block is taken although none waits.
            ("take = arrivals_valid & (~busy_q | ends)", "take = ~busy_q | ends"),
            // A fault has jobs.
            ("offer   = busy_q & ~failed_q", "offer   = busy_q"),
            // The second block begins at another place.
            ("place_q <= take ? 2'd0 : place_q + 2'd1", "place_q <= place_q + 2'd1"),
            // The place moves while the job waits.
            ("if (take | leaves) begin", "if (take | offer) begin"),
            // A fault does not wait.
            ("(fault & fault_taken_i)", "fault"),
        ],
    },
    Claim {
        module: "raypath_unit_hits",
        variant: Variant::Plain,
        properties: include_str!("properties/hits.sv"),
        queue: Some(("u_ended.", "raypath_unit_ended")),
        expands: true,
        bindings: bindings::hits,
        method: Method::Inductive,
        happens: "p_shows_q && ready_i",
        faults: &[
            // A hit that waits is overwritten.
            ("takes  = ended_valid & (~valid_q | ready_i)", "takes  = ended_valid"),
            // A hit disappears.
            ("valid_q <= takes | (valid_q & ~ready_i)", "valid_q <= takes"),
            // A hit is shown twice.
            ("valid_q <= takes | (valid_q & ~ready_i)", "valid_q <= takes | valid_q"),
            // Values are those of another context.
            ("ends_i & (context_i == 3'd2)", "ends_i & (context_i == 3'd3)"),
        ],
    },
    Claim {
        module: "raypath_unit_walk",
        variant: Variant::Plain,
        properties: include_str!("properties/walk.sv"),
        queue: Some(("u_continues.", "raypath_unit_continues")),
        expands: false,
        bindings: bindings::nothing,
        method: Method::Inductive,
        happens: "p_continues && p_follows_q && p_ahead_q == 0",
        faults: &[
            // A ray continues although no step ends.
            ("finishes_q & (finish_request_kind == 2'd1)", "finish_request_kind == 2'd1"),
            // A ray that continues is lost.
            ("finishes_q & (finish_request_kind == 2'd1)", "1'b0"),
            // The step is that of the next ray.
            ("<= prepared_context_q;", "<= read_context;"),
            // An answer is taken without a step.
            ("prepares_q <= read;", "prepares_q <= read & ~start_valid_i;"),
            // A source's context is used for another.
            ("(block_context_i &\n      {3{scheduler_grant[1]}})", "(block_context_i & {3{scheduler_grant[0]}})"),
        ],
    },
    Claim {
        module: "raypath_unit_distance",
        variant: Variant::Plain,
        properties: include_str!("properties/distance.sv"),
        queue: None,
        expands: true,
        bindings: bindings::distance,
        method: Method::Inductive,
        happens: "p_chosen_q && p_before_q == 0 && p_leaves",
        faults: &[
            // A triangle is lost while a closest hit waits.
            ("moves   = ~has_hit_q | folds", "moves   = 1'b1"),
            // A closest hit that waits is overwritten.
            ("folds = has_hit_q & (~is_complete_q | taken_i)", "folds = has_hit_q"),
            // Each triangle ends its block.
            ("is_complete_q <= (folds & tag_q[2])", "is_complete_q <= folds"),
            // A triangle is read twice.
            ("read  = divider_valid & moves", "read  = divider_valid"),
            // The fraction is that of another place.
            ("(fractions_t_num_0_t1 == 5'd1)", "(fractions_t_num_0_t1 == 5'd2)"),
        ],
    },
    Claim {
        module: "raypath_unit_set_up",
        variant: Variant::Plain,
        properties: include_str!("properties/set_up.sv"),
        queue: None,
        expands: false,
        bindings: bindings::set_up,
        method: Method::Unbounded,
        happens: "valid_o && !p_inside_q[0]",
        faults: &[
            // A ray enters while another uses the divider.
            ("ready   = ~busy_q | is_last", "ready   = 1'b1"),
            // Each quotient is a ray's last one.
            ("valid_o        = divider_valid & divider_tag[0]", "valid_o        = divider_valid"),
            // A ray has one quotient more.
            ("is_last = number_q == 3'd4", "is_last = number_q == 3'd5"),
            // Operands enter with their ray, before they are known.
            ("has_operands_q <= busy_q", "has_operands_q <= enters"),
        ],
    },
    Claim {
        module: "raypath_unit_rays",
        variant: Variant::Plain,
        properties: include_str!("properties/rays.sv"),
        queue: Some(("u_starts.", "raypath_unit_starts")),
        expands: true,
        bindings: bindings::rays,
        method: Method::Inductive,
        happens: "p_follows_q && p_leaves && p_ahead_q == 0",
        faults: &[
            // A ray enters although another has just entered the set-up.
            ("ready = set_up_ready & contexts_valid", "ready = contexts_valid"),
            // A ray is kept at another context.
            ("enters & (contexts_context == 3'd2)", "enters & (contexts_context == 3'd3)"),
            // A number is read too late.
            ("    if (release_i) begin", "    if (start_taken_i) begin"),
            // A ray that is refused never starts.
            (".push_i (set_up_valid)", ".push_i (set_up_valid & ~set_up_is_refused)"),
            // A job has the constants of another ray.
            ("job_context_i[2] ? constants_kx_t2 : constants_kx_t1", "constants_kx_t2"),
        ],
    },
    Claim {
        module: "raypath_unit_rays",
        variant: Variant::Instances,
        properties: include_str!("properties/rays.sv"),
        queue: Some(("u_starts.", "raypath_unit_starts")),
        expands: true,
        bindings: bindings::rays,
        method: Method::Inductive,
        happens: "p_follows_q && p_leaves && p_ahead_q == 0",
        faults: &[
            // The constants outside are lost where a ray enters an instance.
            ("constants_inv_x_0_t1 = entries_valid & ~entries_is_instance", "constants_inv_x_0_t1 = entries_valid"),
            // A job in an instance has the constants outside.
            ("job_inside_i ? object_constants_kx : constants_kx", "constants_kx"),
            // A job outside has the origin in an instance.
            ("job_inside_i ? object_origins_x : origins_origin_x", "object_origins_x"),
            // A ray begins again where it enters an instance.
            (".is_instance_i (entries_is_instance)", ".is_instance_i (1'b0)"),
        ],
    },
    Claim {
        module: "raypath_unit_entries",
        variant: Variant::Instances,
        properties: include_str!("properties/entries.sv"),
        queue: None,
        expands: false,
        bindings: bindings::set_up,
        method: Method::Unbounded,
        happens: "enters_instance_o && p_waits_q[3:0] == 9",
        faults: &[
            // New rays never have their turn.
            ("chosen = waits & ~(yields_q & free_i)", "chosen = waits"),
            // The origin is that of another instance, or of none.
            ("if (is_origin) begin", "if (transformed_valid_i) begin"),
            // A new ray enters in an instance's turn.
            ("ready_o             = ready & ~chosen", "ready_o             = ready"),
            // A direction is taken although the set-up is not ready.
            ("~transformed_is_last_i | (chosen & ready)", "~transformed_is_last_i | chosen"),
            // Constants are those of the other context.
            ("chosen ? transformed_context_i : context_i", "chosen ? context_i : transformed_context_i"),
        ],
    },
    Claim {
        module: "raypath_unit_decoder",
        variant: Variant::Quantised,
        properties: include_str!("properties/decoder.sv"),
        queue: None,
        expands: false,
        bindings: bindings::decoder,
        method: Method::Unbounded,
        happens: "p_follows_q && p_ahead_q == 1",
        faults: &[
            // A block that waits is overwritten.
            ("advances = ~has_sums_q | ready_i", "advances = 1'b1"),
            // A block is at the outputs without a read.
            ("read = advances & has_operands_q", "read = has_operands_q"),
            // A block stays.
            ("has_sums_q <= has_operands_q", "has_sums_q <= has_operands_q | has_sums_q"),
            // A context is that of the next block.
            ("context_q    <= operands_context_q", "context_q    <= context_i"),
        ],
    },
    Claim {
        module: "raypath_unit_weights",
        variant: Variant::Quantised,
        properties: include_str!("properties/weights.sv"),
        queue: None,
        expands: false,
        bindings: bindings::weights,
        method: Method::Inductive,
        happens: "p_follows_q && p_leaves && p_ahead_q == 2",
        faults: &[
            // A ray gives way after its first quotient.
            ("ends = enters & is_second_q", "ends = enters"),
            // Weights that wait are overwritten.
            ("moves   = ~is_complete | ready_i", "moves   = 1'b1"),
            // Weights are complete with the first quotient.
            ("is_complete = divider_valid & divider_tag[0]", "is_complete = divider_valid"),
            // The second quotient takes the place of the first.
            ("if (divider_valid & ~divider_tag[0]) begin", "if (divider_valid) begin"),
            // A ray without a hit has weights.
            ("decode_ieee & {32{divider_tag[1]}}", "decode_ieee"),
        ],
    },
    Claim {
        module: "raypath_unit_distance",
        variant: Variant::Quantised,
        properties: include_str!("properties/distance.sv"),
        queue: None,
        expands: true,
        bindings: bindings::distance,
        method: Method::Inductive,
        happens: "p_chosen_q && p_before_q == 0 && p_leaves",
        faults: &[
            // A triangle is lost while a closest hit waits.
            ("moves   = ~has_hit_q | folds", "moves   = 1'b1"),
            // A closest hit that waits is overwritten.
            ("folds = has_hit_q & (~is_complete_q | taken_i)", "folds = has_hit_q"),
            // A closest hit that waits disappears.
            ("is_complete_q <= folds | (is_complete_q & ~taken_i)", "is_complete_q <= folds"),
            // A triangle is read twice.
            ("read  = divider_valid & moves", "read  = divider_valid"),
            // A context is that of the next triangle.
            ("context_q           <= tag_q[4:2]", "context_q           <= divider_tag[4:2]"),
        ],
    },
    Claim {
        module: "raypath_unit_issue",
        variant: Variant::Quantised,
        properties: include_str!("properties/issue.sv"),
        queue: Some(("u_arrivals.", "raypath_unit_arrivals")),
        expands: false,
        bindings: bindings::issue,
        method: Method::Inductive,
        happens: "p_served && !p_failed",
        faults: &[
            // A block gives way although its job waits.
            ("assign ends = leaves |", "assign ends = offer |"),
            // A block is taken although none waits.
            ("take = arrivals_valid & (~busy_q | ends)", "take = ~busy_q | ends"),
            // A fault has a job.
            ("offer  = busy_q & ~failed_q", "offer  = busy_q"),
            // A fault does not wait.
            ("(fault & fault_taken_i)", "fault"),
        ],
    },
];
