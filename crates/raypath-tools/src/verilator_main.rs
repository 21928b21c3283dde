//! The C++ program around the model that Verilator compiles.

use raypath_hdl::Module;

/// The text of `main.cpp` for a top module.
///
/// The program reads a frame of inputs from standard input for each cycle, and writes a frame of outputs. Words have 64
/// bits in the machine's byte order, which is little-endian where Verilator runs.
///
/// The first argument is the seed of random values in registers and memories, or 0 for zeros. If it is negative, no reset
/// ends before the first frame.
///
/// In a program that counts coverage, the second argument is the file to write it to. In another it is a number: the
/// program first reads all frames, runs them that many times and writes the seconds that each run took, a line each.
/// This measures the model without the pipes.
pub fn main_file(top: &Module) -> String {
    let mut drive = String::new();
    let mut words = 0;
    let mut set = |name: &str, width: u32| {
        // Parts of wide ports, which Verilator has as words of 32 bits.
        if let Some((wide, low)) = part_of_vector(top, name) {
            for word in 0..width / 32 {
                drive += &format!("    top.{wide}[{}] = in[{words}] >> {};\n", low / 32 + word, 32 * word);
            }
        } else {
            drive += &format!("    top.{name} = in[{words}] & {:#x}u;\n", u64::MAX >> (64 - width));
        }
        words += 1;
    };
    if top.has_reset() {
        set("rst_ni", 1);
    }
    for port in top.inputs() {
        set(&port.name, top.signal(port.signal).width);
    }
    let outputs = top.outputs().iter().enumerate();
    let sample: String = outputs.map(|(word, port)| format!("    out[{word}] = top.{};\n", port.name)).collect();
    let fall = if top.is_clocked() { "    top.clk_i = 0;\n" } else { "" };
    let rise = if top.is_clocked() { "    top.clk_i = 1;\n    top.eval();\n" } else { "" };
    // A reset ends before the first frame, as in the simulator of the netlist.
    let reset = if top.has_reset() {
        "  for (int level : {1, 0, 1}) {\n    if (seed < 0) break;\n    top.rst_ni = level;\n    top.eval();\n  }\n"
    } else {
        ""
    };
    let (inputs, outputs) = (input_words(top).max(1), top.outputs().len().max(1));
    format!(
        r#"#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "Vtop.h"
#include "verilated.h"

int main(int argc, char** argv) {{
  VerilatedContext context;
  const int seed = argc > 1 ? std::atoi(argv[1]) : 0;
  context.randReset(seed ? 2 : 0);
  context.randSeed(seed ? seed : 1);
  Vtop top{{&context}};
  static uint64_t in[{inputs}];
  static uint64_t out[{outputs}];
{reset}  if (argc > 2 && !VM_COVERAGE) {{
    std::vector<uint64_t> frames;
    while (std::fread(in, sizeof in, 1, stdin) == 1) frames.insert(frames.end(), in, in + {inputs});
    for (long times = std::strtol(argv[2], nullptr, 10); times > 0; --times) {{
      auto begin = std::chrono::steady_clock::now();
      for (const uint64_t* in = frames.data(); in != frames.data() + frames.size(); in += {inputs}) {{
{fall}{drive}    top.eval();
{rise}      }}
      std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      std::printf("%.9f\n", seconds.count());
    }}
    top.final();
    return std::fflush(stdout) == 0 ? 0 : 1;
  }}
  while (std::fread(in, sizeof in, 1, stdin) == 1) {{
{fall}{drive}    top.eval();
{sample}    if (std::fwrite(out, sizeof out, 1, stdout) != 1) return 1;
{rise}  }}
  top.final();
#if VM_COVERAGE
  if (argc > 2) context.coveragep()->write(argv[2]);
#endif
  return std::fflush(stdout) == 0 ? 0 : 1;
}}
"#
    )
}

/// The vector that the text has in the place of an input port, and the port's lowest bit in it.
fn part_of_vector<'t>(top: &'t Module, port: &str) -> Option<(&'t str, u32)> {
    let group = top.text().inputs.iter().find(|group| group.contains(port))?;
    let select = group.select(port)?;
    let (_, low) = select.strip_prefix('[')?.strip_suffix(']')?.split_once(':')?;
    Some((&group.name, low.parse().ok()?))
}

/// Words in a frame of inputs. A frame without inputs still takes one word on the pipe.
pub fn input_words(top: &Module) -> usize {
    usize::from(top.has_reset()) + top.inputs().len()
}
