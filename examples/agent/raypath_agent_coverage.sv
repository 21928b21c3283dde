// SPDX-License-Identifier: MIT OR Apache-2.0
// Functional coverage of the channels; it drives nothing. Every simulator counts the bins of `bin_e`. With the macro
// RAYPATH_COVERGROUPS, covergroups have the same bins, and crosses of them.

`ifdef RAYPATH_COVERGROUPS
`define RAYPATH_SAMPLE(call) call;
`else
`define RAYPATH_SAMPLE(call)
`endif

module raypath_agent_coverage (raypath_unit_if bus);

  // Bins that follow one another are those of the values from 0 on.
  typedef enum int {
    RayWaits, RayTaken, HitWaits, HitTaken, RequestWaits, RequestTaken,
    Opaque, NoOpaque, FirstHit, SkipShader, CullBack, CullFront, CullOpaque, CullNoOpaque, SkipTriangles, SkipBoxes,
    NoFlag, Inside1, Inside2To15, InsideFrom16,
    Miss, Triangle, Box, Refused, MemoryError, SceneError, WorkLimit,
    Nodes0, Nodes1To7, Nodes8To31, NodesFrom32, FrontFace, BackFace, HitInOrder, HitOvertakes, FlushEmpty, FlushInside,
    LaterBeat, LaterBeatError, FirstBeat, FirstBeatError, Follows, Interleaves,
    Latency1, Latency2To31, LatencyFrom32, BlockInOrder, BlockOvertakes
  } bin_e;

  int        count[bin_e], now = 0, requested[256], latency;
  bit [63:0] ids[$];                  // of the rays inside, the oldest first
  bit [7:0]  tags[$], tag, last_tag;  // of the requests without a beat, the oldest first; of beats
  bit        begun[256], is_first, is_late;

`ifdef RAYPATH_COVERGROUPS
  covergroup channels_cg with function sample(int number, bit is_taken);
    channel: coverpoint number {bins ray = {0}; bins hit = {1}; bins request = {2};}
    transfer: coverpoint is_taken {bins waits = {0}; bins taken = {1};}
    channel_transfer: cross channel, transfer;
  endgroup

  covergroup rays_cg with function sample(bit [9:0] flags, int count_inside);
    flag: coverpoint flags {
      bins none = {0}; bins one[] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512}; bins several = default;
    }
    rays_inside: coverpoint count_inside {bins one = {1}; bins few = {[2:15]}; bins many = {[16:$]};}
  endgroup

  covergroup hits_cg with function sample(bit [2:0] value, bit [31:0] read, bit is_back, bit is_second);
    status: coverpoint value {
      bins miss = {0}; bins triangle = {1}; bins box = {2}; bins refused = {3}; bins memory = {4}; bins scene = {5};
      bins work = {6}; illegal_bins none = {7};
    }
    outcome: coverpoint value {bins miss = {0}; bins triangle = {1};}
    nodes: coverpoint read {bins none = {0}; bins few = {[1:7]}; bins some = {[8:31]}; bins many = {[32:$]};}
    face: coverpoint is_back iff (value == 1) {bins front = {0}; bins back = {1};}
    order: coverpoint is_second {bins in_order = {0}; bins overtakes = {1};}
    outcome_nodes: cross outcome, nodes;
    outcome_order: cross outcome, order;
  endgroup

  covergroup beats_cg with function sample(bit begins, bit is_error, bit interleaves, int cycles, bit is_second);
    beat: coverpoint begins {bins later = {0}; bins first = {1};}
    error: coverpoint is_error {bins none = {0}; bins error = {1};}
    neighbour: coverpoint interleaves iff (!begins) {bins follows = {0}; bins interleaves = {1};}
    delay: coverpoint cycles iff (begins) {bins next = {1}; bins soon = {[2:31]}; bins late = {[32:$]};}
    order: coverpoint is_second iff (begins) {bins in_order = {0}; bins overtakes = {1};}
    beat_error: cross beat, error;
  endgroup

  channels_cg channels = new;
  rays_cg     rays = new;
  hits_cg     hits = new;
  beats_cg    beats = new;
`endif

  function automatic void see(bin_e first, int value);
    count[bin_e'(int'(first) + value)]++;
  endfunction

  function automatic void see_channel(int channel, bit is_taken);
    see(RayWaits, 2 * channel + is_taken);
    `RAYPATH_SAMPLE(channels.sample(channel, is_taken))
  endfunction

  always @(posedge bus.clk_i or negedge bus.rst_ni) begin
    if (!bus.rst_ni) begin
      ids.delete();
      tags.delete();
    end else begin
      now++;
      if (bus.ray_valid_i) see_channel(0, bus.ray_ready_o);
      if (bus.hit_valid_o) see_channel(1, bus.hit_ready_i);
      if (bus.mem_req_valid_o) see_channel(2, bus.mem_req_ready_i);
      if (bus.hit_valid_o && bus.hit_ready_i) begin
        is_late = ids.size() != 0 && ids[0] != bus.hit_id_o;
        for (int i = ids.size() - 1; i >= 0; i--) if (ids[i] == bus.hit_id_o) ids.delete(i);
        see(Miss, bus.hit_status_o);
        see(Nodes0, (bus.hit_nodes_o > 0 ? 1 : 0) + (bus.hit_nodes_o > 7 ? 1 : 0) + (bus.hit_nodes_o > 31 ? 1 : 0));
        if (bus.hit_status_o == 1) see(FrontFace, bus.hit_back_face_o);
        see(HitInOrder, is_late);
        `RAYPATH_SAMPLE(hits.sample(bus.hit_status_o, bus.hit_nodes_o, bus.hit_back_face_o, is_late))
      end
      if (bus.ray_valid_i && bus.ray_ready_o) begin
        ids.push_back(bus.ray_id_i);
        for (int i = 0; i < 10; i++) if (bus.ray_flags_i[i]) see(Opaque, i);
        if (bus.ray_flags_i == 0) see(NoFlag, 0);
        see(Inside1, (ids.size() > 1 ? 1 : 0) + (ids.size() > 15 ? 1 : 0));
        `RAYPATH_SAMPLE(rays.sample(bus.ray_flags_i, ids.size()))
      end
      if (bus.flush_i) begin
        see(FlushEmpty, ids.size() != 0 ? 1 : 0);
        ids.delete();
      end
      if (bus.mem_rsp_valid_i) begin
        tag        = bus.mem_rsp_tag_i;
        is_first   = !begun[tag];
        begun[tag] = 1'b1;
        latency    = now - requested[tag];
        is_late    = tags.size() != 0 && tags[0] != tag;
        see(LaterBeat, 2 * is_first + bus.mem_rsp_error_i);
        if (is_first) begin
          for (int i = tags.size() - 1; i >= 0; i--) if (tags[i] == tag) tags.delete(i);
          see(Latency1, (latency > 1 ? 1 : 0) + (latency > 31 ? 1 : 0));
          see(BlockInOrder, is_late);
        end else see(Follows, last_tag != tag);
        `RAYPATH_SAMPLE(beats.sample(is_first, bus.mem_rsp_error_i, last_tag != tag, latency, is_late))
        last_tag = tag;
      end
      if (bus.mem_req_valid_o && bus.mem_req_ready_i) begin
        tags.push_back(bus.mem_req_tag_o);
        requested[bus.mem_req_tag_o] = now;
        begun[bus.mem_req_tag_o]     = 1'b0;
      end
    end
  end

  function automatic void report();
    int    seen = 0;
    string missed = "";
    for (bin_e bin = RayWaits; ; bin = bin.next()) begin
      if (count[bin] != 0) seen++;
      else missed = {missed, " ", bin.name()};
      if ($test$plusargs("bins")) $display("%s %0d", bin.name(), count[bin]);
      if (bin == BlockOvertakes) break;
    end
    $display("coverage: %0d of %0d bins; not seen:%s", seen, BlockOvertakes + 1, missed);
`ifdef RAYPATH_COVERGROUPS
    $display("covergroups: channels %0.0f %%, rays %0.0f %%, hits %0.0f %%, beats %0.0f %%",
             channels.get_inst_coverage(), rays.get_inst_coverage(), hits.get_inst_coverage(),
             beats.get_inst_coverage());
`endif
  endfunction

endmodule : raypath_agent_coverage
