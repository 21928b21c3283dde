//! Memories in Verilator, and in Yosys, which infers them.

use crate::verilator::compare::{agree, agree_side_by_side};
use crate::verilator::netlists::{Contents, netlist};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::{Builder, Module, expand_memories};
use raypath_tools::{Sources, Yosys};
use std::fs;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A stack of wide words, and a memory whose depth is no power of two.
fn memories() -> Arc<Module> {
    let m = Builder::new("memories");
    let (push, pop, data) = (m.input("push_i", 1), m.input("pop_i", 1), m.input("data_i", 64));
    let address = m.input("address_i", 4);
    m.section("Stack");
    let top = m.register("top_q", 4).reset_to(0);
    let below = (top.wire() - m.constant(4, 1)).named("below");
    top.next_when(push ^ pop, push.mux(top.wire() + m.constant(4, 1), below));
    let stack = m.memory("u_stack", 16, &[("first", 64), ("second", 64), ("third", 33), ("flag", 1)]);
    stack.write(push, top.wire(), &[data, data + data, data.lower(33), data.any()]);
    let word = stack.read(pop, below);
    m.section("Table");
    let table = m.memory("u_table", 11, &[("entry", 64)]);
    table.write(pop, address, &[word[0] ^ word[1]]);
    let entry = table.read(push, address ^ top.wire());
    for (name, wire) in [("second_o", word[1]), ("third_o", word[2]), ("flag_o", word[3]), ("entry_o", entry[0])] {
        m.output(name, wire);
    }
    m.finish().expect("memories")
}

#[test]
fn memories_agree() {
    agree(&memories(), &mut ChaCha8Rng::seed_from_u64(1), 20_000);
}

#[test]
fn expanded_memories_agree() {
    agree(&expand_memories(&memories()).expect("registers"), &mut ChaCha8Rng::seed_from_u64(1), 5_000);
}

#[test]
fn random_netlists_with_memories() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    agree_side_by_side((0..8).map(|seed| {
        let contents = Contents { operators: 40, registers: 1, memories: 1 + seed % 3, ..Contents::default() };
        netlist(&format!("netlist{seed}"), &mut random, &contents)
    }));
}

/// Runs commands on the text of a module, without the files of its folder, and returns what they write to `out.txt`.
fn in_yosys(top: &Arc<Module>, commands: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let sources = Sources::write(top, folder.path()).expect("sources");
    let files: Vec<String> = sources.files.iter().map(|file| file.display().to_string()).collect();
    let read = format!("read_verilog -sv {}\nhierarchy -top {}\n", files.join(" "), top.name());
    fs::write(folder.path().join("run.ys"), read + &commands.join("\n") + "\n").expect("a script");
    let yosys = Yosys::find(None).expect("Yosys");
    let stop = AtomicBool::new(false);
    yosys.run(folder.path(), "run.ys", top.name(), &stop).unwrap_or_else(|fault| panic!("{fault}"));
    fs::read_to_string(folder.path().join("out.txt")).expect("the output")
}

/// Each memory becomes one cell whose read port is synchronous and shows old data. No flip-flops hold words or columns.
#[test]
fn yosys_infers_memories() {
    let commands = ["proc", "flatten", "opt", "memory_dff", "memory_collect", "opt_clean", "tee -o out.txt dump"];
    let found = in_yosys(&memories(), &commands);
    let count = |what: &str| found.lines().filter(|line| line.trim().starts_with(what)).count();
    assert_eq!(count("cell $mem_v2 "), 2, "{found}");
    for parameter in ["RD_CLK_ENABLE 1'1", "RD_TRANSPARENCY_MASK 1'0", "WR_PORTS 1"] {
        assert_eq!(count(&format!("parameter \\{parameter}")), 2, "{parameter}");
    }
    // Yosys finds out that the stack never reads the word that it writes.
    for parameter in
        ["SIZE 16", "INIT 2592'x", "RD_COLLISION_X_MASK 1'1", "SIZE 11", "INIT 704'x", "RD_COLLISION_X_MASK 1'0"]
    {
        assert_eq!(count(&format!("parameter \\{parameter}")), 1, "{parameter}");
    }
    let flip_flops = found.lines().filter(|line| line.contains("cell $") && line.contains("dff")).count();
    assert_eq!(flip_flops, 1, "only the stack's pointer");
}

/// A memory of 256 words of 16 bits is one block RAM of an FPGA.
#[test]
fn a_memory_fits_a_block_ram() {
    let m = Builder::new("block");
    let (enable, address) = (m.input("enable_i", 1), m.input("address_i", 8));
    let memory = m.memory("u_memory", 256, &[("high", 7), ("low", 9)]);
    let data = m.input("data_i", 16);
    memory.write(enable, address, &[data.upper(7), data.lower(9)]);
    let word = memory.read(!enable, address);
    m.output("data_o", m.concat(&word));
    let commands = ["synth_ice40 -run begin:map_ffs", "select -assert-count 1 t:SB_RAM40_4K", "tee -o out.txt stat"];
    let found = in_yosys(&m.finish().expect("a memory"), &commands);
    assert!(!found.to_lowercase().contains("dff"), "{found}");
}
