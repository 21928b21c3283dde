//! The modules around units, whose text is written by hand: counts and widths are their parameters.

use raypath_hdl::verilog::RAM_TEXT;

/// The cache.
pub const CACHE: &str = include_str!("rtl/raypath_cache.sv");

/// The comment at its head.
pub const CACHE_DOC: &str = "A cache of lines of a scene. A request of a line under way joins those that wait for it, \
                             and others go on. A line is stored whole before the first of its blocks is answered. A line \
                             with an error is answered with the error, and then all lines become invalid.";

/// The text of each module by its name, those that it instantiates before it.
pub const MODULES: [(&str, &str); 4] = [
    ("raypath_ram_1r1w", RAM_TEXT),
    ("raypath_queue", include_str!("../hardware/raypath_queue.sv")),
    ("raypath_arbiter", include_str!("rtl/raypath_arbiter.sv")),
    ("raypath_cache", CACHE),
];
