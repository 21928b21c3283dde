#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Writes the AXI4-Lite block and the C header of the device's registers from `raypath_device.rdl`.

    scripts/registers.py           writes both files
    scripts/registers.py --check   writes nothing; fails if a file is not what it would write

The package `systemrdl-compiler` reads the RDL. The text follows the directions of each field:

    sw = r,  hw = na               a constant: the reset value
    sw = r,  hw = w                an input: what the register shows
    sw = rw, hw = r                an output: a setting
    sw = w,  hw = r, singlepulse   an output: 1 for a cycle after a 1 was written
    posedge intr, woclr            an input: its rise sets the bit, until a 1 is written
    a regfile with `events`        a counter of 64 bits
"""

import sys
from pathlib import Path
from string import Template
from textwrap import indent, wrap

from systemrdl import RDLCompiler
from systemrdl.node import RegfileNode

ROOT = Path(__file__).resolve().parent.parent
RTL = ROOT / "crates/raypath-traversal/src/system/rtl"
SOURCE = RTL / "raypath_device.rdl"
BLOCK = RTL / "raypath_device_registers.sv"
HEADER = ROOT / "software/raypath_device_registers.h"


BLOCK_TEXT = Template("""\
module raypath_device_registers #(
  parameter logic [31:0] Units = 1
) (
$ports
);

  // The number of each register: its offset without the low two bits.
$words

  // ---- The bus ------------------------------------------------------------------
  // Address and data of a write, and the address of a read, are kept until they are answered. So
  // no output depends on an input of the same cycle.
  logic        aw_valid_q;
  logic        w_valid_q;
  logic        b_valid_q;
  logic        ar_valid_q;
  logic        r_valid_q;
  logic [9:0]  aw_word_q;
  logic [9:0]  ar_word_q;
  logic [31:0] w_data_q;
  logic [3:0]  w_strobe_q;
  logic [31:0] r_data_q;
  logic [31:0] read_data;
  logic        writes;
  logic        reads;
  logic [31:0] mask;
  logic [31:0] data;

  logic unused_address;
  assign unused_address = ^{s_axi_awaddr[1:0], s_axi_araddr[1:0], s_axi_awprot, s_axi_arprot};

  assign writes = aw_valid_q & w_valid_q & (~b_valid_q | s_axi_bready);
  assign reads  = ar_valid_q & (~r_valid_q | s_axi_rready);
  assign mask   = {{8{w_strobe_q[3]}}, {8{w_strobe_q[2]}}, {8{w_strobe_q[1]}}, {8{w_strobe_q[0]}}};
  assign data   = w_data_q & mask;

  assign s_axi_awready = ~aw_valid_q;
  assign s_axi_wready  = ~w_valid_q;
  assign s_axi_bvalid  = b_valid_q;
  assign s_axi_bresp   = 2'b00;
  assign s_axi_arready = ~ar_valid_q;
  assign s_axi_rvalid  = r_valid_q;
  assign s_axi_rdata   = r_data_q;
  assign s_axi_rresp   = 2'b00;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      aw_valid_q <= 1'b0;
      w_valid_q  <= 1'b0;
      b_valid_q  <= 1'b0;
      ar_valid_q <= 1'b0;
      r_valid_q  <= 1'b0;
    end else begin
      aw_valid_q <= aw_valid_q ? ~writes : s_axi_awvalid;
      w_valid_q  <= w_valid_q ? ~writes : s_axi_wvalid;
      b_valid_q  <= writes | (b_valid_q & ~s_axi_bready);
      ar_valid_q <= ar_valid_q ? ~reads : s_axi_arvalid;
      r_valid_q  <= reads | (r_valid_q & ~s_axi_rready);
    end
  end

  always_ff @(posedge clk_i) begin
    if (!aw_valid_q) aw_word_q <= s_axi_awaddr[11:2];
    if (!ar_valid_q) ar_word_q <= s_axi_araddr[11:2];
    if (reads) r_data_q <= read_data;
    if (!w_valid_q) begin
      w_data_q   <= s_axi_wdata;
      w_strobe_q <= s_axi_wstrb;
    end
  end

  // ---- Settings -------------------------------------------------------------------
$settings

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
$setting_resets
    end else if (writes) begin
      case (aw_word_q)
$setting_writes
        default: ;
      endcase
    end
  end

$pulses

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
$pulse_resets
    end else begin
$pulse_writes
    end
  end

$outputs

  // ---- Interrupts -----------------------------------------------------------------
  // An event is not lost if it comes while its bit is cleared.
  logic $span levels;
  logic $span levels_q;
  logic $span cleared;
  logic $span interrupt_status_q;

  assign levels  = {$levels};
  assign cleared = (writes && aw_word_q == WordInterruptStatus) ? data$span : '0;
  assign irq_o   = |(interrupt_status_q & interrupt_enable_q);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      levels_q           <= '0;
      interrupt_status_q <= '0;
    end else begin
      levels_q           <= levels;
      interrupt_status_q <= (levels & ~levels_q) | (interrupt_status_q & ~cleared);
    end
  end

  // ---- Counters -------------------------------------------------------------------
  localparam logic [31:0] Counters = $counters;

$counts

  assign events = {
$events
  };

  for (genvar k = 0; k < Counters; k++) begin : g_counters
    logic [63:0] count_q;
    logic [7:0]  sum;

    always_comb begin
      sum = '0;
      for (int unsigned u = 0; u < Units; u++) sum = sum + 8'(events[k*Units+u]);
    end

    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) count_q <= '0;
      else count_q <= control_clear_counts_q ? '0 : count_q + 64'(sum);
    end

    assign counts[k*64+:64] = count_q;
  end

$count_values

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) cycles <= '0;
    else cycles <= control_clear_counts_q ? '0 : cycles + 64'(count_cycles_i);
  end

  // ---- What is read ---------------------------------------------------------------
  always_comb begin
    case (ar_word_q)
$reads
    endcase
  end

endmodule : raypath_device_registers
""")

HEADER_TEXT = Template("""\
/* SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * The registers of raypath_device. Generated by scripts/registers.py from raypath_device.rdl; do not edit.
 *
 * NAME is an offset in bytes. NAME_FIELD_MASK are the bits of a field, and NAME_FIELD_SHIFT is the lowest one.
 * In a register of 64 bits, the low word comes first.
 */

#ifndef RAYPATH_DEVICE_REGISTERS_H
#define RAYPATH_DEVICE_REGISTERS_H

$definitions

#endif
""")

# AXI4-Lite, by the names of its specification.
BUS = """
input awvalid 1, output awready 1, input awaddr 12, input awprot 3,
input wvalid 1, output wready 1, input wdata 32, input wstrb 4, output bvalid 1, input bready 1, output bresp 2,
input arvalid 1, output arready 1, input araddr 12, input arprot 3,
output rvalid 1, input rready 1, output rdata 32, output rresp 2
"""


class Register:
    """A register, with the names that both texts use."""

    def __init__(self, node, file):
        """Reads a register, which may be in a regfile."""
        self.file = file
        self.part = node.inst_name
        self.name = f"{file.inst_name}_{node.inst_name}" if file else node.inst_name
        self.word = "Word" + "".join(part.capitalize() for part in self.name.split("_"))
        self.offset = node.absolute_address
        self.fields = sorted(node.fields(), key=lambda field: field.low)
        self.description = (file or node).get_property("desc")
        self.events = file.get_property("events") if file else None
        self.is_interrupt = any(field.get_property("intr") for field in self.fields)
        # The fields that are stored are next to each other.
        stored = [f for f in self.fields if f.is_sw_writable and not f.get_property("singlepulse")]
        self.low, self.high = (stored[0].low, stored[-1].high) if stored else (0, -1)
        assert self.high + 1 - self.low == sum(field.width for field in stored), self.name
        self.reset = sum(field.get_property("reset") << field.low - self.low for field in stored)

    def field_name(self, field):
        """Gives the name of a field's port, without its direction."""
        name = self.name if self.file is None else self.file.inst_name
        return name if field.inst_name == "value" else f"{name}_{field.inst_name}"

    def bits(self, high, low):
        """Gives the selection of bits of the bus."""
        return f"[{low}]" if high == low else "" if high - low == 31 else f"[{high}:{low}]"

    def value(self, field):
        """Gives the expression of what software reads from a field."""
        if self.events:
            return f"{self.file.inst_name}[{'63:32' if self.part == 'high' else '31:0'}]"
        if self.low <= field.low <= self.high:
            is_all = (field.low, field.high) == (self.low, self.high)
            return f"{self.name}_q" + ("" if is_all else self.bits(field.high, field.low))
        if field.is_hw_writable:
            return self.field_name(field) + "_i"
        return f"{field.width}'h{field.get_property('reset'):x}"

    def read(self):
        """Gives the expression of the register's 32 bits."""
        shown = [(field.high, field.low, self.value(field)) for field in reversed(self.fields)]
        if self.high >= 0:
            shown = [(self.high, self.low, f"{self.name}_q")]
        parts, end = [], 32
        for high, low, value in shown:
            parts += [f"{end - high - 1}'d0"] * (end - high > 1) + [value]
            end = low
        parts += [f"{end}'d0"] * (end > 0)
        return parts[0] if len(parts) == 1 else "{" + ", ".join(parts) + "}"


def registers(top):
    """Lists the registers, also those of regfiles."""
    for node in top.children():
        if isinstance(node, RegfileNode):
            yield from (Register(child, node) for child in node.registers())
        else:
            yield Register(node, None)


def width(high, low=0):
    """Gives the range of a declaration."""
    return "" if high == low else f"[{high}:{low}]"


def table(depth, rows, separator=";", last=";"):
    """Aligns the columns of rows; a row of one column is a comment."""
    widths = [max(len(row[k]) for row in rows if len(row) > 1) for k in range(max(map(len, rows)) - 1)]
    lines = []
    for row in rows:
        columns = [column.ljust(width) for column, width in zip(row, widths) if width] if len(row) > 1 else ["//"]
        lines.append(" ".join([*columns, row[-1]]) + (separator if len(row) > 1 else ""))
    lines[-1] = lines[-1][: len(lines[-1]) - len(separator)] + last
    return indent("\n".join(lines), " " * depth)


def block(all_registers):
    """Writes the SystemVerilog block."""
    stored = [r for r in all_registers if r.high >= 0 and not r.is_interrupt]
    interrupt = next(r for r in all_registers if r.is_interrupt)
    levels = [f"{interrupt.field_name(field)}_i" for field in interrupt.fields]
    counters = [r.file.inst_name for r in all_registers if r.events == "units" and r.part == "low"]
    pulses = [(r.field_name(f) + "_q", r, f) for r in all_registers for f in r.fields if f.get_property("singlepulse")]

    settings, status, outputs = [], [], []
    for r in all_registers:
        for field in r.fields:
            name = r.field_name(field)
            if r.events or r.is_interrupt or field.get_property("singlepulse"):
                continue
            if r.part == "low":
                settings.append(("output", "logic", "[63:0]", name + "_o"))
                outputs.append(("assign", name + "_o", f"= {{{name}_high_q, {name}_low_q, {field.low}'d0}}"))
            elif field.is_sw_writable and field.is_hw_readable and not r.file:
                settings.append(("output", "logic", width(field.width - 1), name + "_o"))
                outputs.append(("assign", name + "_o", f"= {r.value(field)}"))
            elif field.is_hw_writable:
                status.append(("input", "logic", width(field.width - 1), name + "_i"))
    for name, _, _ in pulses:
        if name != "control_clear_counts_q":
            settings.append(("output", "logic", "", name[:-1] + "o"))
            outputs.append(("assign", name[:-1] + "o", f"= {name}"))

    bus = [port.split() for port in BUS.split(",")]
    ports = [
        ("input", "logic", "", "clk_i"),
        ("input", "logic", "", "rst_ni"),
        ("output", "logic", "", "irq_o"),
        ("AXI4-Lite, by the names of its specification.",),
        *((way, "logic", width(int(bits) - 1), f"s_axi_{name}") for way, name, bits in bus),
        ("Settings, and pulses of a cycle.",),
        *settings,
        ("What registers show.",),
        *status,
        ("The rise of a level sets its bit of interrupt_status.",),
        *(("input", "logic", "", name) for name in levels),
        ("Events that are counted; those of units have a bit for each unit.",),
        ("input", "logic", "", "count_cycles_i"),
        *(("input", "logic", "[Units-1:0]", f"count_{name}_i") for name in counters),
    ]
    counts = [
        ("logic", "[Counters*Units-1:0]", "events"),
        ("logic", "[Counters*64-1:0]", "counts"),
        *(("logic", "[63:0]", name) for name in ["cycles", *counters]),
    ]
    writes = [(f"{r.word}:", f"{r.name}_q <= ({r.name}_q & ~mask{b}) | data{b}") for r in stored
              for b in [r.bits(r.high, r.low)]]  # fmt: skip
    reads = [(f"{r.word}:", f"read_data = {r.read()}") for r in all_registers] + [("default:", "read_data = '0")]
    read_lines = table(6, reads).splitlines()
    return BLOCK_TEXT.substitute(
        ports=table(2, ports, ",", ""),
        words=table(2, [("localparam logic [9:0]", r.word, f"= 10'h{r.offset // 4:03x}") for r in all_registers]),
        settings=table(2, [("logic", width(r.high, r.low), f"{r.name}_q") for r in stored]),
        setting_resets=table(6, [(f"{r.name}_q", f"<= {r.high - r.low + 1}'h{r.reset:x}") for r in stored]),
        setting_writes=table(8, writes),
        pulses=table(2, [("logic", name) for name, _, _ in pulses]),
        pulse_resets=table(6, [(name, "<= 1'b0") for name, _, _ in pulses]),
        pulse_writes=table(6, [(n, f"<= writes & (aw_word_q == {r.word}) & data[{f.low}]") for n, r, f in pulses]),
        outputs=table(2, outputs),
        span=f"[{interrupt.high}:0]",
        levels=", ".join(reversed(levels)),
        counters=len(counters),
        counts=table(2, counts),
        events=indent(",\n".join(f"count_{name}_i" for name in reversed(counters)), "    "),
        count_values=table(2, [("assign", name, f"= counts[{k}*64+:64]") for k, name in enumerate(counters)]),
        reads="\n".join(
            part for line in read_lines for part in wrap(line, 100, subsequent_indent=" " * (line.find("= ") + 3))
        ),
    )


def header(all_registers):
    """Writes the C header."""
    lines = []
    for r in all_registers:
        if r.part == "high":
            continue
        name = f"count_{r.file.inst_name}" if r.events else r.file.inst_name if r.file else r.name
        macro = f"#define RAYPATH_DEVICE_{name.upper()}"
        lines += ["", f"/* {r.description}{' 64 bits.' if r.file else ''} */", f"{macro} 0x{r.offset:03x}u"]
        for field in r.fields:
            of_field = f"{macro}_{field.inst_name.upper()}"
            if not field.is_sw_writable and not field.is_hw_writable:
                lines.append(f"{of_field}_IS 0x{field.get_property('reset'):x}u")
            if field.inst_name != "value":
                mask = (1 << field.high + 1) - (1 << field.low)
                lines.append(f"{of_field}_MASK 0x{mask:08x}u /* {field.get_property('desc')} */")
            if field.width > 1 and field.inst_name != "value":
                lines.append(f"{of_field}_SHIFT {field.low}")
            for code in field.get_property("encode", default=[]):
                lines.append(f"{of_field}_{code.name.upper()} {code.value}u /* {code.rdl_desc} */")
    return HEADER_TEXT.substitute(definitions="\n".join(lines[1:]))


def main():
    """Writes or checks both files."""
    compiler = RDLCompiler()
    compiler.compile_file(str(SOURCE))
    all_registers = list(registers(compiler.elaborate().top))
    stale = False
    for path, text in {BLOCK: block(all_registers), HEADER: header(all_registers)}.items():
        if "--check" not in sys.argv[1:]:
            path.write_text(text)
        elif path.read_text() != text:
            stale = True
            print(f"{path.relative_to(ROOT)}: found another text than that of {SOURCE.name}, expected equal ones; run "
                  "scripts/registers.py", file=sys.stderr)  # fmt: skip
    sys.exit(stale)


if __name__ == "__main__":
    main()
