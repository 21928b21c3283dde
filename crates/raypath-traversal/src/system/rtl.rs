//! The modules around units, whose text is written by hand: counts and widths are their parameters.

use raypath_hdl::verilog::RAM_TEXT;

/// The name, the comment at the head and the text of each module, those that it instantiates before it. In some,
/// names between the signs `@` stand for what the configuration of the unit says.
const MODULES: [[&str; 3]; 10] = [
    ["raypath_ram_1r1w", "", RAM_TEXT],
    ["raypath_queue", "", include_str!("../hardware/raypath_queue.sv")],
    [
        "raypath_arbiter",
        "Round robin: the inputs after the one that was taken last come first.",
        include_str!("rtl/raypath_arbiter.sv"),
    ],
    [
        "raypath_cache",
        "A cache of lines of a scene. A request of a line under way joins those that wait for it, and others go on. A \
         line is stored whole before the first of its blocks is answered. A line with an error is answered with the \
         error, and then all lines become invalid.",
        include_str!("rtl/raypath_cache.sv"),
    ],
    [
        "raypath_guard",
        "Reads of a memory that may be anything: those outside of a region, and those that the memory does not answer \
         in time, are answered with errors. After a timeout nothing is read until the memory has given what it owes.",
        include_str!("rtl/raypath_guard.sv"),
    ],
    ["raypath_cluster", "", include_str!("rtl/raypath_cluster.sv")],
    ["raypath_unit_axi", "", include_str!("rtl/raypath_unit_axi.sv")],
    [
        "raypath_device_registers",
        "The registers of the device, of which raypath_device.rdl is the description.",
        include_str!("rtl/raypath_device_registers.sv"),
    ],
    [
        "raypath_rings",
        "Rays are read from a ring in memory, and hits are written to another. Software that writes nonsense to the \
         registers meets an error; nothing outside of the rings is read or written.",
        include_str!("rtl/raypath_rings.sv"),
    ],
    [
        "raypath_device",
        "A cluster of traversal units with registers, rings of rays and hits in memory, and an interrupt.",
        include_str!("rtl/raypath_device.sv"),
    ],
];

/// The text of a module; empty if there is none of the name.
pub fn text(name: &str) -> &'static str {
    MODULES.iter().find(|[known, ..]| *known == name).map_or("", |[.., text]| text)
}

/// The name, the comment and the text of some modules.
pub(crate) fn below(names: &[&str]) -> Vec<[String; 3]> {
    let modules = MODULES.iter().filter(|[name, ..]| names.contains(name));
    modules.map(|module| module.map(str::to_string)).collect()
}
