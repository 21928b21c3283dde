use raypath_ppa::Setting;

/// What a report made by hand says of its tools.
pub fn setting() -> Setting {
    Setting {
        synthesis: "Yosys 1".to_string(),
        timing: "OpenSTA 2".to_string(),
        library: "cells".to_string(),
        nand2: "NAND".to_string(),
        buffer: "BUF".to_string(),
        load_ff: 10.0,
        period_ns: 7.5,
        unit_period_ns: None,
    }
}
