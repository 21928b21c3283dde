//! The modules around units, whose text is written by hand: counts and widths are their parameters.

use raypath_hdl::verilog::RAM_TEXT;

/// The text of each module by its name, those that it instantiates before it.
pub const MODULES: [(&str, &str); 4] = [
    ("raypath_ram_1r1w", RAM_TEXT),
    ("raypath_queue", include_str!("../hardware/raypath_queue.sv")),
    ("raypath_arbiter", include_str!("rtl/raypath_arbiter.sv")),
    ("raypath_cache", include_str!("rtl/raypath_cache.sv")),
];
