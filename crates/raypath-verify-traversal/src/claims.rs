//! The modules of the unit whose control is proved: the properties of each, and for each property faults that it must
//! find.

use super::bindings;
use super::setting::{Setting, Variant};
use raypath_hdl::Module;
use raypath_verify::safety::Method;

/// What is claimed of a module, and how it is proved.
#[derive(Clone, Copy)]
pub struct Claim {
    /// The module.
    pub module: &'static str,
    /// The unit that it is taken from.
    pub variant: Variant,
    /// Environment, assertions and, after a line with [`LEMMAS`], what makes them inductive.
    pub properties: &'static str,
    /// The path of the queue whose words the lemmas see, with its module.
    pub queue: Option<(&'static str, &'static str)>,
    /// The text that binds the names in the properties to the module.
    pub bindings: fn(&Setting, &Module) -> String,
    /// What happens in some run of the module: the proof that it never does must be refuted, otherwise the environment
    /// permits too little.
    pub happens: &'static str,
    /// Faults: the property that must be refuted by itself, a text of the module of the least unit, and its faulty
    /// replacement.
    pub faults: &'static [(&'static str, &'static str, &'static str)],
}

/// The beginning of the comment before the lemmas.
const LEMMAS: &str = "  // Lemmas.";

impl Claim {
    /// The properties without the lemmas.
    pub fn stated(&self) -> &'static str {
        self.properties.split(LEMMAS).next().unwrap_or_default()
    }

    /// The method of the proof.
    pub fn method(&self) -> Method {
        if self.properties.contains(LEMMAS) { Method::Inductive } else { Method::Unbounded }
    }
}

/// The queues of the unit: the first has a claim with faults, and the others differ in the width of words and in depth.
const QUEUES: [(Variant, &str); 17] = [
    (Variant::Plain, "raypath_unit_free"),
    (Variant::Plain, "raypath_unit_starts"),
    (Variant::Plain, "raypath_unit_arrivals"),
    (Variant::Plain, "raypath_unit_tested"),
    (Variant::Plain, "raypath_unit_continues"),
    (Variant::Plain, "raypath_unit_requests"),
    (Variant::Plain, "raypath_unit_ended"),
    (Variant::Queries, "raypath_unit_decided"),
    (Variant::Queries, "raypath_unit_asked"),
    (Variant::Searches, "raypath_search_found"),
    (Variant::Searches, "raypath_search_kept"),
    (Variant::Searches, "raypath_search_bursts"),
    (Variant::Searches, "raypath_search_sent"),
    (Variant::Searches, "raypath_search_codes"),
    (Variant::Searches, "raypath_search_keys"),
    (Variant::Searches, "raypath_search_entries"),
    (Variant::Searches, "raypath_search_nodes"),
];

/// Whether the properties of a module are all that it must do: of queues, and of the scheduler.
pub fn properties_suffice(module: &Module) -> bool {
    QUEUES.iter().any(|(_, queue)| *queue == module.name()) || module.name() == "raypath_unit_scheduler"
}

/// The claims about the other queues.
pub fn queues() -> impl Iterator<Item = Claim> {
    let claim = |&(variant, module)| Claim { module, variant, queue: Some(("", module)), faults: &[], ..CLAIMS[0] };
    QUEUES[1..].iter().map(claim)
}

/// Modules about which the same is claimed, with the same faults, as in the plain unit.
const ALIKE: [(Variant, &str); 10] = [
    (Variant::Instances, "raypath_unit_walk"),
    (Variant::Quantised, "raypath_unit_walk"),
    (Variant::Queries, "raypath_unit_walk"),
    (Variant::Queries, "raypath_unit_distance"),
    (Variant::Queries, "raypath_unit_blocks"),
    (Variant::Instances, "raypath_unit_distance"),
    (Variant::Quantised, "raypath_unit_distance"),
    (Variant::Eight, "raypath_unit_distance"),
    (Variant::Eight, "raypath_unit_blocks"),
    (Variant::Eight, "raypath_unit_walk"),
];

/// The claims about these modules.
pub fn alike() -> impl Iterator<Item = Claim> {
    let claim = |(variant, module)| Some(Claim { variant, ..*CLAIMS.iter().find(|claim| claim.module == module)? });
    ALIKE.into_iter().filter_map(claim)
}

macro_rules! claims {
    ($($module:literal in $variant:ident: $properties:expr, $queue:expr, $bindings:ident; $happens:literal; {
        $($property:ident: $from:literal => $to:literal;)*
    })*) => {
        /// The claims: module, unit, properties, queue, bindings, what happens, and faults by property.
        pub const CLAIMS: &[Claim] = &[$(Claim {
            module: $module,
            variant: Variant::$variant,
            properties: $properties,
            queue: $queue,
            bindings: bindings::$bindings,
            happens: $happens,
            faults: &[$((stringify!($property), $from, $to)),*],
        }),*];
    };
}

claims! {
    "raypath_unit_free" in Plain: include_str!("properties/queue.sv"),
        Some(("", "raypath_unit_free")), queue_words; "p_follows_q && p_leaves && p_ahead_q == 0"; {
        progress: "valid_q <= read | (valid_q & ~pop_i)" => "valid_q <= read";
        order: "(head_q != tail_q) & (~valid_q | pop_i)" => "head_q != tail_q";
        order: "head_q <= head_q + 3'd1" => "head_q <= head_q + 3'd2";
        real_word: "(head_q != tail_q) & (~valid_q | pop_i)" => "~valid_q | pop_i";
        order: ".write_enable_i (push_i)" => ".write_enable_i (push_i & (tail_q != 3'd7))";
    }
    "raypath_unit_contexts" in Plain: include_str!("properties/contexts.sv"),
        Some(("u_free.", "raypath_unit_free")), contexts; "p_returns_q && p_takes"; {
        once: "has_fresh_q & ~is_last" => "has_fresh_q";
        progress: ".push_i (release_i)" => ".push_i (release_i & has_fresh_q)";
        returns: ".pop_i (take_i & ~has_fresh_q)" => ".pop_i (take_i)";
        once: "fresh_q <= fresh_q + 3'd1" => "fresh_q <= fresh_q + 3'd2";
    }
    "raypath_unit_scheduler" in Plain: include_str!("properties/scheduler.sv"),
        None, scheduler; "p_waits_q[14:12] == 4 && grant_o[4]"; {
        fair: "assign later = request_i[4:1] & after_q" => "assign later = 4'd0";
        fair: "{|grant[3:0]," => "{|grant[2:0],";
        one_hot: "later & (~later + 4'd1)" => "later";
        always_one: "request_i & (~request_i + 5'd1)" => "5'd0";
    }
    "raypath_unit_blocks" in Plain: include_str!("properties/blocks.sv"),
        None, blocks; "p_here && arrived_o && failed_o && !error_i"; {
        last_beat: "arrived = valid_i & (progress_beat == 2'd3)" => "arrived = valid_i & (progress_beat == 2'd2)";
        error: "next_failed = failed & (progress_beat != 2'd3)" => "next_failed = failed";
        error: "failed  = progress_failed | error_i" => "failed  = error_i";
        no_other: "arrived = valid_i & (progress_beat == 2'd3)" => "arrived = progress_beat == 2'd3";
        kept: ".write_enable_i (valid_i & (progress_beat == 2'd1))"
            => ".write_enable_i (valid_i & (progress_beat == 2'd2))";
    }
    "raypath_unit_issue" in Plain: include_str!("properties/issue.sv"),
        Some(("u_arrivals.", "raypath_unit_arrivals")), issue; "p_served && p_jobs_q == 2 && !p_failed"; {
        each_job: "assign ends = (leaves & is_last)" => "assign ends = leaves";
        takes: "take = arrivals_valid & (~busy_q | ends)" => "take = ~busy_q | ends";
        fault_only: "offer   = busy_q & ~failed_q" => "offer   = busy_q";
        each_job: "place_q <= take ? 2'd0 : next_place" => "place_q <= next_place";
        words: "if (take | leaves)" => "if (take | offer)";
        fault_only: "(fault & fault_taken_i)" => "fault";
    }
    "raypath_unit_hits" in Plain: include_str!("properties/hits.sv"),
        Some(("u_ended.", "raypath_unit_ended")), hits; "p_shows_q && ready_i"; {
        one_hit: "takes  = ended_valid & (~valid_q | ready_i)" => "takes  = ended_valid";
        one_hit: "valid_q <= takes | (valid_q & ~ready_i)" => "valid_q <= takes";
        one_hit: "valid_q <= takes | (valid_q & ~ready_i)" => "valid_q <= takes | valid_q";
        own_values: ".write_address_i (context_i)" => ".write_address_i (ended_context)";
    }
    "raypath_unit_walk" in Plain: include_str!("properties/walk.sv"),
        Some(("u_continues.", "raypath_unit_continues")), walk; "p_continues && p_follows_q && p_ahead_q == 0"; {
        one_request: "= goes_on & (finish_request_kind == raypath_unit_pkg::RequestContinue)"
            => "= finish_request_kind == raypath_unit_pkg::RequestContinue";
        one_request: "goes_on = finishes_q & ~flush_i" => "goes_on = finishes_q";
        flushed: "finishes_q & (flush_i | " => "finishes_q & (";
        two_reads: "<= prepared_context_q;" => "<= read_context;";
        two_reads: "prepares_q <= read;" => "prepares_q <= read & ~start_valid_i;";
        own_context: "(block_context_i &\n      {3{scheduler_grant[1]}})"
            => "(block_context_i & {3{scheduler_grant[0]}})";
    }
    "raypath_unit_distance" in Plain: include_str!("properties/distance.sv"),
        None, distance; "p_chosen_q && p_before_q == 0 && p_leaves"; {
        order: "moves   = ~has_hit_q | folds" => "moves   = 1'b1";
        order: "folds = has_hit_q & (~is_complete_q | taken_i)" => "folds = has_hit_q";
        real_block: "is_complete_q <= (folds & tag_q[2])" => "is_complete_q <= folds";
        real_triangle: "read  = divider_valid & moves" => "read  = divider_valid";
        fraction: ".write_address_i ({context_i, place_i})" => ".write_address_i ({context_i, ~place_i & place_i})";
    }
    "raypath_unit_set_up" in Plain: include_str!("properties/set_up.sv"),
        None, set_up; "valid_o && !p_inside_q[0]"; {
        every_five: "ready   = ~busy_q | is_last" => "ready   = 1'b1";
        once: "valid_o        = divider_valid & divider_tag[0]" => "valid_o        = divider_valid";
        every_five: "is_last = number_q == 3'd4" => "is_last = number_q == 3'd5";
        once: "has_operands_q <= busy_q" => "has_operands_q <= enters";
    }
    "raypath_unit_rays" in Plain: include_str!("properties/rays.sv"),
        Some(("u_starts.", "raypath_unit_starts")), rays; "p_follows_q && p_leaves && p_ahead_q == 0"; {
        accepts: "ready = set_up_ready & contexts_valid" => "ready = contexts_valid";
        kept: "(enters), .write_address_i (contexts_context)" => "(enters), .write_address_i (hit_context_i)";
        kept: ".read_enable_i (release_i)" => ".read_enable_i (start_taken_i)";
        progress: ".push_i (set_up_valid)" => ".push_i (set_up_valid & ~set_up_is_refused)";
        kept: ".write_address_i (set_up_context)" => ".write_address_i (contexts_context)";
    }
    "raypath_unit_rays" in Instances: concat!(include_str!("properties/rays_instances.sv"),
            include_str!("properties/rays.sv")),
        Some(("u_starts.", "raypath_unit_starts")), rays; "p_follows_q && p_leaves && p_ahead_q == 0"; {
        kept: ".write_enable_i (entries_valid & ~entries_is_instance)" => ".write_enable_i (entries_valid)";
        kept_in_instances: "job_inside_i ? object_constants_kx : constants_kx" => "constants_kx";
        kept: "job_inside_i ? object_origins_x : origins_origin_x" => "object_origins_x";
        order: "entries_is_refused, entries_is_instance})" => "entries_is_refused, 1'b0})";
    }
    "raypath_unit_scheduler" in Queries: include_str!("properties/scheduler.sv"),
        None, scheduler; "p_waits_q[17:15] == 5 && grant_o[5]"; {
        fair: "assign later = request_i[5:1] & after_q" => "assign later = 5'd0";
        always_one: "request_i & (~request_i + 6'd1)" => "6'd0";
    }
    "raypath_unit_candidates" in Queries: include_str!("properties/candidates.sv"),
        Some(("u_asked.", "raypath_unit_asked")), candidates; "p_shows_q && ready_i"; {
        one_candidate: "takes  = asked_valid & (~valid_q | ready_i)" => "takes  = asked_valid";
        own_values: ".write_address_i (tested_context_i)" => ".write_address_i (context_i)";
    }
    "raypath_unit_entries" in Instances: include_str!("properties/entries.sv"),
        None, set_up; "enters_instance_o && p_waits_q[3:0] == 9"; {
        new_ray_waits: "chosen = waits & ~(yields_q & free_i)" => "chosen = waits";
        own_origin: "if (is_origin)" => "if (transformed_valid_i)";
        every_five: "ready_o             = ready & ~chosen" => "ready_o             = ready";
        enters: "~transformed_is_last_i | (chosen & ready)" => "~transformed_is_last_i | chosen";
        own_context: "chosen ? transformed_context_i : context_i" => "chosen ? context_i : transformed_context_i";
    }
    "raypath_unit_blocks" in Quantised: include_str!("properties/blocks.sv"),
        None, blocks; "p_here && arrived_o && failed_o && !error_i"; {
        kept: ".write_enable_i (valid_i & progress_beat)" => ".write_enable_i (valid_i & ~progress_beat)";
    }
    "raypath_unit_decoder" in Quantised: include_str!("properties/decoder.sv"),
        None, decoder; "p_follows_q && p_ahead_q == 1"; {
        order: "advance = ~has_sums_q | ready_i" => "advance = 1'b1";
        shows: "read = advance & has_operands_q" => "read = has_operands_q";
        shows: "has_sums_q <= has_operands_q" => "has_sums_q <= has_operands_q | has_sums_q";
        order: "context_q <= operands_context_q" => "context_q <= context_i";
    }
    "raypath_unit_weights" in Quantised: include_str!("properties/weights.sv"),
        None, weights; "p_follows_q && p_leaves && p_ahead_q == 2"; {
        order: "ends = enters & is_second_q" => "ends = enters";
        order: "moves   = ~is_complete | ready_i" => "moves   = 1'b1";
        progress: "is_complete = divider_valid & divider_tag[0]" => "is_complete = divider_valid";
        both: "if (divider_valid & ~divider_tag[0])" => "if (divider_valid)";
        no_hit: "decode_ieee & {32{divider_tag[1]}}" => "decode_ieee";
    }
    "raypath_unit_issue" in Quantised: include_str!("properties/issue.sv"),
        Some(("u_arrivals.", "raypath_unit_arrivals")), issue; "p_served && p_jobs_q == 1 && !p_failed"; {
        each_job: "assign ends = (leaves & is_last)" => "assign ends = leaves";
        words: "is_second ? word_15_i[1:0]" => "~is_second ? word_15_i[1:0]";
        words: "is_second = place_q[0] & ~is_instance_i" => "is_second = place_q[0]";
    }
    "raypath_unit_issue" in Eight: include_str!("properties/issue.sv"),
        Some(("u_arrivals.", "raypath_unit_arrivals")), issue; "p_served && p_jobs_q == 1 && !p_failed"; {
        each_job: "(is_node ? 2'd2 : count_i)" => "(is_node ? 2'd1 : count_i)";
        each_job: "place_q <= take ? 2'd0 : next_place" => "place_q <= next_place";
    }
    "raypath_unit_decoder" in Eight: include_str!("properties/decoder.sv"),
        None, decoder; "p_follows_q && p_ahead_q == 1"; {
        order: "advance = ~has_sums_q | ready_i" => "advance = 1'b1";
        order: "is_last_q <= operands_is_last_q" => "is_last_q <= is_last_i";
    }
    "raypath_search_list" in Searches: include_str!("properties/list.sv"),
        None, list; "p_goes_q && inserts_q && !is_there"; {
        sorted: "is_before_0_t1  = {candidates_key_0, candidates_index_0}"
            => "is_before_0_t1  = {candidates_index_0, candidates_key_0}";
        kept: "is_before_15    = carried < is_before_15_t1" => "is_before_15    = 1'b1";
        lost: "inserts_on      = places &" => "inserts_on      = 1'b0 & places &";
        once: "places          = inserts_q & ~is_there" => "places          = inserts_q";
        limit: "limits_o        = clear | is_full" => "limits_o        = clear | places";
        best: "chosen     = can_expand & (~can_expand + 16'd1)" => "chosen     = can_expand";
        in_order: "restarts ? 4'd0 : place_q + 4'd1" => "restarts ? 4'd0 : place_q + 4'd2";
    }
    "raypath_search_branches" in Searches: include_str!("properties/branches.sv"),
        None, branches; "p_is_own_q && p_place == 1 && next_is_leaf_o"; {
        last: "read_count[4:0] - 5'd1" => "read_count[4:0]";
        last: "branches & ~count[5]" => "branches";
        last: "takes[1] | adds[1]" => "adds[1]";
    }
    "raypath_search_turns" in Searches: include_str!("properties/compared.sv"),
        None, compared; "has_burst_q && skips && p_asked_q && p_own && burst_index_q == p_index && !burst_is_outside_q"; {
        nothing_lost: "burst_is_compared_q &\n      is_known" => "burst_is_compared_q";
        nothing_lost: "enters & (|(remembered_q & free))" => "1'b0";
        nothing_lost: "((2'd1 << swept_q) & {2{sweeps_q}}" => "((2'd1 << swept_q) & {2{1'b0}}";
        nothing_lost: "new_way_7              = compared_way_6 | {32{sweep}}" => "new_way_7              = compared_way_6";
    }
}
