// SPDX-License-Identifier: MIT OR Apache-2.0
// The memory: blocks return after any time and in any order, their beats interleaved. Of a block that is not there,
// some beats are errors, with any data.

module raypath_agent_memory import raypath_agent_pkg::*; (raypath_unit_if bus);

  typedef struct packed {
    bit [31:0]   due, left;  // the cycle from which on beats may come, and their number
    bit [7:0]    tag, errors;
    bit [1023:0] data;
  } block_t;

  int     request_stall = 20, beat_gap = 10, latency = 60;  // percent, percent, cycles at most
  int     block_bytes, now = 0, start, place;
  block_t blocks[$];  // that are owed
  block_t block;

  initial begin
    void'($value$plusargs("request_stall=%d", request_stall));
    void'($value$plusargs("beat_gap=%d", beat_gap));
    void'($value$plusargs("latency=%d", latency));
  end

  always @(posedge bus.clk_i or negedge bus.rst_ni) begin
    if (!bus.rst_ni) begin
      bus.mem_req_ready_i <= 1'b0;
      bus.mem_rsp_valid_i <= 1'b0;
      blocks.delete();
    end else begin
      now++;
      bus.mem_req_ready_i <= !chance(request_stall);
      if (bus.mem_req_valid_o && bus.mem_req_ready_i) begin
        block.due    = now + $urandom_range(latency);
        block.left   = block_bytes * 8 / $bits(bus.mem_rsp_data_i);
        block.tag    = bus.mem_req_tag_o;
        block.errors = '0;
        if (raypath_agent_block(bus.mem_req_addr_o, block.data) == 0) begin
          block.data   = {32{$urandom}};
          block.errors = $urandom | 1 << $urandom_range(block.left - 1);
        end
        blocks.push_back(block);
      end
      bus.mem_rsp_valid_i <= 1'b0;
      start = blocks.size() == 0 || chance(beat_gap) ? -1 : $urandom_range(blocks.size() - 1);
      for (int i = 0; start >= 0 && i < blocks.size(); i++) begin
        place = (start + i) % blocks.size();
        block = blocks[place];
        if (block.due <= now) begin
          bus.mem_rsp_valid_i <= 1'b1;
          bus.mem_rsp_tag_i   <= block.tag;
          bus.mem_rsp_error_i <= block.errors[0];
          bus.mem_rsp_data_i  <= block.data;
          block.data   = block.data >> $bits(bus.mem_rsp_data_i);
          block.errors = block.errors >> 1;
          block.left   = block.left - 1;
          if (block.left == 0) blocks.delete(place);
          else blocks[place] = block;
          break;
        end
      end
    end
  end

endmodule : raypath_agent_memory
