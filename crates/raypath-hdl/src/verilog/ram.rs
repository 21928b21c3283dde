//! The module that memories are instances of.

/// The name of the module that memories are instances of. A design can replace it by another one with the same ports.
pub const RAM: &str = "raypath_ram_1r1w";

/// Its text, without the head.
pub const RAM_TEXT: &str = include_str!("raypath_ram_1r1w.sv");

/// Its head comment.
pub const RAM_DOC: &str = "A memory with one write port and one read port. Read data appears after the clock edge at \
                           which read_enable_i is 1, and stays until the next read; with ReadLatency \
                           = 2 an output register shows it one clock edge later. A read of the word that is written at \
                           the same edge returns its old value. The words have no initial value and no reset. An \
                           address must be less than Depth. To use a memory macro, replace this module by a wrapper \
                           with the same parameters, ports and rules.";
