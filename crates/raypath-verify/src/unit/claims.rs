//! The modules of the unit whose control is proved, with their properties and the faults that the proofs must refute.

use super::bindings;
use super::setting::Setting;
use crate::control::Method;
use raypath_hdl::Module;

/// What is claimed of a module, and how it is proved.
pub struct Claim {
    /// The module.
    pub module: &'static str,
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
];
