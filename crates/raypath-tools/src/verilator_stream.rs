//! The C++ program around a module with a stream of words in and one out, as a host sees it on an FPGA.

use raypath_hdl::Module;

/// The text of `main.cpp` for a module with the ports `data_i`, `valid_i`, `ready_o` and `data_o`, `valid_o`,
/// `ready_i`.
///
/// Bytes at standard input become words of `data_i`, and words of `data_o` become bytes at standard output, the least
/// significant byte first. In about half of the cycles, in a fixed order, `ready_i` is 0. While no byte is there, the
/// clock goes on until nothing has happened for many cycles; then the program waits. It ends after the end of the
/// input. The argument is the seed of random values in registers and memories.
pub fn main_file(top: &Module) -> String {
    let bytes = top.port_width("data_i").unwrap_or(8) / 8;
    format!(
        r#"#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <poll.h>
#include <unistd.h>

#include "Vtop.h"
#include "verilated.h"

int main(int argc, char** argv) {{
  // More cycles than a job spends in any datapath.
  const unsigned kQuiet = 1000;
  VerilatedContext context;
  context.randReset(2);
  context.randSeed(argc > 1 ? std::atoi(argv[1]) : 1);
  Vtop top{{&context}};
  for (int level : {{1, 0, 1}}) {{
    top.rst_ni = level;
    top.eval();
  }}
  bool is_open = true;
  bool offers = false;
  uint32_t word = 0;
  uint32_t random = 1;
  unsigned quiet = 0;
  while (is_open || offers || quiet < kQuiet) {{
    if (is_open && !offers) {{
      struct pollfd input = {{0, POLLIN, 0}};
      const bool waits = quiet >= kQuiet;
      if (waits && std::fflush(stdout) != 0) return 1;
      if (poll(&input, 1, waits ? -1 : 0) > 0) {{
        uint8_t bytes[{bytes}];
        unsigned count = 0;
        for (ssize_t got = 1; count < {bytes} && got > 0; count += got > 0 ? got : 0) {{
          got = read(0, bytes + count, {bytes} - count);
        }}
        offers = count == {bytes};
        is_open = offers;
        word = 0;
        for (unsigned byte = {bytes}; byte-- > 0;) word = word << 8 | bytes[byte];
      }}
    }}
    random = random * 1664525u + 1013904223u;
    top.clk_i = 0;
    top.valid_i = offers;
    top.data_i = offers ? word : 0;
    top.ready_i = random >> 31;
    top.eval();
    const bool takes = offers && top.ready_o;
    const bool sends = top.valid_o && top.ready_i;
    if (sends) {{
      uint32_t sent = top.data_o;
      for (unsigned byte = 0; byte < {bytes}; ++byte, sent >>= 8) {{
        if (std::putchar(sent & 0xff) == EOF) return 1;
      }}
    }}
    top.clk_i = 1;
    top.eval();
    if (takes) offers = false;
    quiet = takes || top.valid_o ? 0 : quiet + 1;
  }}
  top.final();
  return std::fflush(stdout) == 0 ? 0 : 1;
}}
"#
    )
}
