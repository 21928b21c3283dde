//! The modules around units, whose text is written by hand: their properties in modules that instantiate them, and for
//! each property faults that it must find.

use crate::proofs::{ASSERTION, Obligation, only};
use raypath_hdl::verilog::RAM_TEXT;
use raypath_tools::ToolError;
use raypath_traversal::system::rtl;
use raypath_verify::Error;
use raypath_verify::safety::{CheckResult, Method, ModuleTexts, RESET, TextFault};

/// What is claimed of a module.
struct Claim {
    module: &'static str,
    /// The module that instantiates it, with its environment and its properties.
    properties: &'static str,
    method: Method,
    /// The cycles in which a fault must be refuted.
    cycles: u32,
    /// A property that is checked in more cycles by itself.
    alone: Option<(&'static str, u32)>,
    /// Further parameters of the properties: texts and their replacements.
    further: &'static [&'static [[&'static str; 2]]],
    /// What happens in some run.
    happens: &'static str,
    /// Faults: the property that must be refuted by itself, a text of the module, and its replacement.
    faults: &'static [(&'static str, &'static str, &'static str)],
}

macro_rules! claims {
    ($($module:literal: $file:literal, $method:expr, $cycles:literal, $alone:expr, $further:expr; $happens:literal; {
        $($property:ident: $from:literal => $to:literal;)*
    })*) => {
        const CLAIMS: &[Claim] = &[$(Claim {
            module: $module,
            properties: include_str!($file),
            method: $method,
            cycles: $cycles,
            alone: $alone,
            further: $further,
            happens: $happens,
            faults: &[$((stringify!($property), $from, $to)),*],
        }),*];
    };
}

claims! {
    "raypath_arbiter": "system/arbiter.sv", Method::Unbounded, 24, None, &[&[["N = 4", "N = 2"]], &[["N = 4", "N = 3"]]];
        "p_waits && p_others_q == N - 2"; {
        one_hot: "from & (~from + One)" => "from";
        valid: "valid_i & held_q" => "held_q";
        always_one: "(later != '0) ? later : valid_i" => "later";
        stays: "held_q <= ready_i ? '0 : grant_o" => "held_q <= '0";
        fair: "valid_i & after_q" => "'0";
        fair: "~(grant_o | (grant_o - One))" => "~(grant_o - One)";
    }
    "raypath_guard": "system/guard.sv", Method::Inductive, 24, None,
        &[&[["BEATS = 2", "BEATS = 1"]], &[["T = 1", "T = 2"]]];
        "p_dead_q && !timed_out && p_begins"; {
        reads: "(req_addr_i >= first_i)" => "(req_addr_i != first_i)";
        reads: "<= end_i)" => "< end_i)";
        reads: "held_q & ~sends" => "held_q";
        address: "if (accepts) begin" => "if (req_valid_i) begin";
        beats: "open_q[k] & ~ends & times_out" => "open_q[k] & times_out";
        beats: "(fails_q[k] & ~ends)" => "fails_q[k]";
        own: "(begins & (fails | times_out))" => "begins";
        error: "has_failed | mem_rsp_error_i" => "mem_rsp_error_i";
        forwards: "dead_q | ~has_failed" => "1'b1";
        nothing_new: "accepts & (~is_inside | dead_q)" => "accepts & ~is_inside";
        nothing_late: "mem_rsp_valid_i & ~dead_q)" => "mem_rsp_valid_i)";
        no_underflow: "OwedWidth'(Beats)" => "OwedWidth'(1)";
        no_underflow: "- OwedWidth'(receives)" => "- OwedWidth'(mem_rsp_valid_i)";
        falls: "clear_i & idle_o" => "clear_i";
        in_time: "waited_q >= timeout_i" => "waited_q > timeout_i";
        in_time: "(is_owed & ~mem_rsp_valid_i & ~dead_q)" => "(is_owed & ~dead_q)";
        answered: "(begins & (fails | times_out))" => "(begins & fails)";
        answered: "if (fails_q[k-1])" => "if (fails_q[k-1] & req_valid_i)";
    }
    "raypath_cache": "system/cache.sv", Method::Bounded(18), 36, Some(("in_time", 36)),
        &[&[["BEATS = 2", "BEATS = 1"], ["R = 2", "R = 3"]], &[["WAYS = 1", "WAYS = 2"]], &[["LINE = 1", "LINE = 2"]]];
        "p_here && rsp_error && p_rest_q[p_tag] == 1"; {
        whole: "{request_line_q, OffsetBits'(0)}" => "{request_line_q, OffsetBits'(1)}";
        once: "request_valid_q & ~(mem_req_valid_o & mem_req_ready_i)" => "request_valid_q";
        real_request: "else if (walk_q == WalkLoad) walk_tag_q <= follower;" => "";
        without_pause: "takes_walk | takes_hit | (read_valid_q & ~read_ends)" => "takes_walk | takes_hit";
        own_data: "{1'b1, look_label});" => "{1'b1, word[Low+WayWidth+:LabelWidth]});";
        own_data: "invalidate_i | fails |" => "fails |";
        own_data: "& ~(|is_victim) & ~is_read" => "& ~is_read";
        own_data: "line_q == look_line_q" => "place_q == place";
        own_data: "read_beat_q <= read_beat_q + OneBeat" => "read_beat_q <= read_beat_q";
        own_data: "invalidate_i | fails | (clears_q" => "invalidate_i | (clears_q";
        own_data: "error_q | (receives & mem_rsp_error_i)" => "error_q";
        real_error: "takes_walk & has_error" => "takes_walk | has_error";
        in_time: "walk_q == WalkIdle) & filled_valid" => "walk_q == WalkIdle) & filled_valid & look_valid_q";
        none_lost: "& (walk_tag_q != walk_tail)" => "& 1'b0";
        none_lost: "~look_valid_q & ~(|is_busy)" => "~(|is_busy)";
    }
    "raypath_rings": "system/rings.sv", Method::Inductive, 16, None,
        &[&[["D = 512", "D = 1024"], ["A = 32", "A = 40"]]];
        "p_is_good && p_is_write && hit_tail == 1 && p_size == 1 && p_used + p_writing == 2"; {
        four: "(held_q < Reads)" => "(held_q <= Reads)";
        four: "(writing_q < Writes)" => "(writing_q <= Writes)";
        read_allowed: "(rays_used > 32'(reading_q))" => "(rays_used >= 32'(reading_q))";
        read_allowed: "enable_i & (error_q" => "(error_q";
        write_allowed: "< 33'(hit_places)" => "<= 33'(hit_places)";
        write_allowed: "~hits_are_wrong & hits_fit" => "hits_fit";
        read_inside: "(ray_end <= Places)" => "(ray_end <= Places + 59'd1)";
        read_inside: "& 20'(ray_places - 21'd1)" => "& 20'(ray_places)";
        write_inside: "(hit_tail_q[19:0] + 20'(writing_q))" => "hit_tail_q[19:0]";
        write_inside: "(hit_end <= Places)" => "1'b1";
        read_stays: "(held_q < Reads) & (~request_valid_q | read_ready_i)" => "(held_q < Reads)";
        write_stays: "aw_valid_q & ~m_axi_awready" => "1'b0";
        own_data: "w_record_q <= hit_record_i" => "w_record_q <= ~hit_record_i";
        each_once: "stores | (w_valid_q & ~w_ends)" => "stores";
        head: "32'(record_ends)" => "32'(pushes)";
        tail: "m_axi_bvalid & ~write_fails & ~drops_q" => "m_axi_bvalid & ~write_fails";
        tail: "| write_fails | times_out[1]" => "| write_fails";
        in_time: "(waited_q >= timeout_i)" => "(waited_q > timeout_i)";
        in_time: "!enable_i && !is_late" => "!enable_i && !late_q";
        own_ray: "(record_fails | late_q)" => "record_fails";
        cause: "enable_i && rays_are_wrong" => "rays_are_wrong";
        cause: "error_q <= ErrorRead" => "error_q <= ErrorWrite";
        first_error: "if (clear_error_i && !enable_i &&" => "if (clear_error_i &&";
        idle_alone: "(held_q == 3'd0) & (inside_q == '0)" => "(inside_q == '0)";
        idle_alone: "& (writing_q == 3'd0)" => "";
        never_full: "33'(hits_used) + 33'(writing_q)" => "33'(hits_used)";
    }
}

impl Claim {
    /// The module, if need be with a fault, the modules below it, and these properties.
    fn obligation(
        &self,
        name: String,
        properties: &str,
        fault: Option<(&'static str, &'static str)>,
        method: Method,
    ) -> Result<Obligation, Error> {
        let below = ["raypath_queue", self.module].map(|name| (name.to_string(), rtl::text(name).to_string()));
        let mut texts =
            ModuleTexts::of([("raypath_ram_1r1w".to_string(), RAM_TEXT.to_string())].into_iter().chain(below));
        if let Some((from, to)) = fault
            && !texts.insert(TextFault { module: self.module, from, to })
        {
            return Err(ToolError::unexpected("a fault", from, format!("a text of {}", self.module)).into());
        }
        let (inside, _) = properties.rsplit_once("endmodule").unwrap_or((properties, ""));
        let text = format!("{}{inside}{RESET}endmodule\n", texts.with(self.module, ""));
        let expected = if fault.is_none() && name != NEVER { CheckResult::Holds } else { CheckResult::Fails };
        let top = format!("{}_properties", self.module);
        Ok(Obligation::new(format!("{}: {name}", self.module), top, text, method, expected))
    }

    /// The claim, with its parameters and, if these are wanted, with further ones; that what happens never does; and
    /// the faults.
    fn obligations(&self, is_thorough: bool) -> Result<Vec<Obligation>, Error> {
        let further = self.further.iter().filter(|_| is_thorough);
        let proofs = std::iter::once(&[][..]).chain(further.copied()).map(|parameters: &[[&str; 2]]| {
            let mut text = self.properties.to_string();
            parameters.iter().for_each(|[from, to]| text = text.replacen(from, to, 1));
            self.obligation(format!("{parameters:?}"), &text, None, self.method)
        });
        let stated = self.properties.split("  // Lemmas.").next().unwrap_or_default();
        let never = format!(
            "{}  always_comb never: assert (!({}));\nendmodule",
            stated.trim_end().trim_end_matches("endmodule").replace(ASSERTION[1], ": assume ("),
            self.happens
        );
        let never = self.obligation(NEVER.to_string(), &never, None, Method::Bounded(self.cycles));
        let faults = self.faults.iter().map(|(property, from, to)| {
            let name = format!("{property} with {to} in place of {from}");
            self.obligation(name, &only(stated, property), Some((from, to)), Method::Bounded(self.cycles))
        });
        let alone = self.alone.map(|(property, cycles)| {
            let name = format!("{property} in {cycles} cycles");
            self.obligation(name, &only(self.properties, property), None, Method::Bounded(cycles))
        });
        proofs.chain([never]).chain(alone).chain(faults).collect()
    }
}

const NEVER: &str = "never happens";

/// The obligations of all claims; with `is_thorough` for further parameters, too.
///
/// # Errors
/// A fault is not in the text of its module.
pub(crate) fn obligations(is_thorough: bool) -> Result<Vec<Obligation>, Error> {
    let all: Result<Vec<_>, Error> = CLAIMS.iter().map(|claim| claim.obligations(is_thorough)).collect();
    Ok(all?.into_iter().flatten().collect())
}
