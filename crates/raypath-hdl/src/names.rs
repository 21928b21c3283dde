//! Valid names for the printed text.

use std::collections::HashSet;

/// The words of SystemVerilog (IEEE 1800-2017, Annex B).
const KEYWORDS: &str = "
    accept_on alias always always_comb always_ff always_latch and assert assign assume automatic before begin bind
    bins binsof bit break buf bufif0 bufif1 byte case casex casez cell chandle checker class clocking cmos config
    const constraint context continue cover covergroup coverpoint cross deassign default defparam design disable
    dist do edge else end endcase endchecker endclass endclocking endconfig endfunction endgenerate endgroup
    endinterface endmodule endpackage endprimitive endprogram endproperty endspecify endsequence endtable endtask
    enum event eventually expect export extends extern final first_match for force foreach forever fork forkjoin
    function generate genvar global highz0 highz1 if iff ifnone ignore_bins illegal_bins implements implies import
    incdir include initial inout input inside instance int integer interconnect interface intersect join join_any
    join_none large let liblist library local localparam logic longint macromodule matches medium modport module
    nand negedge nettype new nexttime nmos nor noshowcancelled not notif0 notif1 null or output package packed
    parameter pmos posedge primitive priority program property protected pull0 pull1 pulldown pullup
    pulsestyle_ondetect pulsestyle_onevent pure rand randc randcase randsequence rcmos real realtime ref reg
    reject_on release repeat restrict return rnmos rpmos rtran rtranif0 rtranif1 s_always s_eventually s_nexttime
    s_until s_until_with scalared sequence shortint shortreal showcancelled signed small soft solve specify
    specparam static string strong strong0 strong1 struct super supply0 supply1 sync_accept_on sync_reject_on table
    tagged task this throughout time timeprecision timeunit tran tranif0 tranif1 tri tri0 tri1 triand trior trireg
    type typedef union unique unique0 unsigned until until_with untyped use uwire var vectored virtual void wait
    wait_order wand weak weak0 weak1 while wildcard wire with within wor xnor xor
";

/// The words of C++ beside those that are of SystemVerilog too, and two more that Verilator treats alike.
const CPP_KEYWORDS: &str = "
    abort alignas alignof and_eq asm auto bitand bitor bool catch char char16_t char32_t char8_t co_await co_return
    co_yield compl concept const_cast consteval constexpr constinit decltype delete double dynamic_cast explicit false
    float friend goto inline long mutable namespace noexcept not_eq nullptr operator or_eq override private public
    register reinterpret_cast requires short sizeof static_assert static_cast switch template thread_local throw true
    try typeid typename using volatile wchar_t xor_eq
";

/// Words that Verilator 5.006 was seen to warn about where signals are public, as cocotb makes them (`SYMRSVDWORD`).
const CPP_COMMON_WORDS: &str = "
    atomic_cancel atomic_commit atomic_noexcept cdecl deque far huge iterator list map near pascal queue sc_in sc_signal
    set stack synchronized transaction_safe transaction_safe_dynamic uint32_t uint8_t vector
";

/// Reserves and returns `name`, or `name_2` and so on if it is taken.
pub fn fresh(taken: &mut HashSet<String>, name: &str) -> String {
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    let mut names = std::iter::once(name.to_string()).chain(numbered);
    names.find(|name| taken.insert(name.clone())).unwrap_or_default()
}

/// The reason why `name` is not a valid identifier in SystemVerilog for Verilator, or `None` if it is valid.
pub fn problem(name: &str) -> Option<&'static str> {
    let mut characters = name.chars();
    let first_fits = characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
    if !first_fits || !characters.all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Some("is not an identifier: letters, digits and underscores, no digit first");
    }
    let is_among = |words: &str| words.split_ascii_whitespace().any(|word| word == name);
    if name.contains("__") {
        Some("has two underscores in a row, which Verilator keeps for itself")
    } else if is_among(KEYWORDS) {
        Some("is a keyword of SystemVerilog")
    } else if is_among(CPP_KEYWORDS) {
        Some("is a keyword of C++, which Verilator refuses")
    } else if is_among(CPP_COMMON_WORDS) {
        Some("is a common word of C++, which Verilator warns about")
    } else {
        None
    }
}
