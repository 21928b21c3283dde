// SPDX-License-Identifier: MIT OR Apache-2.0
// raypath_device_registers (0) beside PeakRDL's block of the same RDL (1), each with a bus of its own.

module registers #(
  parameter  logic [31:0] Units    = 3,
  localparam logic [31:0] Counters = 13
) (
  input  logic         clk_i,
  input  logic         rst_ni,
  input  logic [1:0]   awvalid_i,
  output logic [1:0]   awready_o,
  input  logic [11:0]  awaddr_i [2],
  input  logic [1:0]   wvalid_i,
  output logic [1:0]   wready_o,
  input  logic [31:0]  wdata_i [2],
  input  logic [3:0]   wstrb_i [2],
  output logic [1:0]   bvalid_o,
  input  logic [1:0]   bready_i,
  output logic [1:0]   bresp_o [2],
  input  logic [1:0]   arvalid_i,
  output logic [1:0]   arready_o,
  input  logic [11:0]  araddr_i [2],
  output logic [1:0]   rvalid_o,
  input  logic [1:0]   rready_i,
  output logic [31:0]  rdata_o [2],
  output logic [1:0]   rresp_o [2],
  // What registers show, levels of interrupts, and events, for both.
  input  logic [164:0] status_i,
  input  logic [2:0]   levels_i,
  input  logic [Counters*Units-1:0] events_i,
  // Settings with the interrupt, and pulses.
  output logic [512:0] settings_o [2],
  output logic [2:0]   pulses_o [2]
);

  import raypath_device_registers_peakrdl_pkg::*;

  logic [7:0]  config_units_i;
  logic [8:0]  config_contexts_i;
  logic [1:0]  config_node_i;
  logic        config_flags_i;
  logic        config_candidates_i;
  logic        config_instances_i;
  logic        config_nested_instances_i;
  logic [5:0]  config_address_bits_i;
  logic [31:0] memory_bytes_i;
  logic [31:0] cache_bytes_i;
  logic        status_idle_i;
  logic        status_busy_i;
  logic        status_memory_timed_out_i;
  logic        status_ring_timed_out_i;
  logic [3:0]  status_error_i;
  logic [31:0] ray_head_i;
  logic [31:0] hit_tail_i;

  assign {config_units_i, config_contexts_i, config_node_i, config_flags_i, config_candidates_i, config_instances_i,
          config_nested_instances_i, config_address_bits_i, memory_bytes_i, cache_bytes_i, status_idle_i, status_busy_i,
          status_memory_timed_out_i, status_ring_timed_out_i, status_error_i, ray_head_i, hit_tail_i} = status_i;

  // ---- Ours -----------------------------------------------------------------------
  logic        irq_o;
  logic        control_enable_o;
  logic [31:0] node_limit_o;
  logic [31:0] timeout_o;
  logic [63:0] scene_base_o;
  logic [63:0] scene_end_o;
  logic [63:0] ray_base_o;
  logic [31:0] ray_size_o;
  logic [31:0] ray_tail_o;
  logic [63:0] hit_base_o;
  logic [31:0] hit_size_o;
  logic [31:0] hit_head_o;
  logic [31:0] interrupt_hits_o;
  logic        control_flush_o;
  logic        control_invalidate_o;
  logic        control_clear_error_o;

  // The counter of cycles has one event, all others have one for each unit.
  raypath_device_registers #(.Units (Units)) u_ours (
    .s_axi_awvalid (awvalid_i[0]), .s_axi_awready (awready_o[0]), .s_axi_awaddr (awaddr_i[0]), .s_axi_awprot ('0),
    .s_axi_wvalid (wvalid_i[0]), .s_axi_wready (wready_o[0]), .s_axi_wdata (wdata_i[0]), .s_axi_wstrb (wstrb_i[0]),
    .s_axi_bvalid (bvalid_o[0]), .s_axi_bready (bready_i[0]), .s_axi_bresp (bresp_o[0]),
    .s_axi_arvalid (arvalid_i[0]), .s_axi_arready (arready_o[0]), .s_axi_araddr (araddr_i[0]), .s_axi_arprot ('0),
    .s_axi_rvalid (rvalid_o[0]), .s_axi_rready (rready_i[0]), .s_axi_rdata (rdata_o[0]), .s_axi_rresp (rresp_o[0]),
    .interrupt_status_hits_i (levels_i[0]), .interrupt_status_error_i (levels_i[1]),
    .interrupt_status_drained_i (levels_i[2]), .count_cycles_i (events_i[0]),
    .count_boxes_i (events_i[1*Units+:Units]), .count_triangles_i (events_i[2*Units+:Units]),
    .count_transforms_i (events_i[3*Units+:Units]), .count_steps_i (events_i[4*Units+:Units]),
    .count_fetches_i (events_i[5*Units+:Units]), .count_rays_i (events_i[6*Units+:Units]),
    .count_restarts_i (events_i[7*Units+:Units]), .count_job_stalls_i (events_i[8*Units+:Units]),
    .count_candidates_i (events_i[9*Units+:Units]), .count_cache_hits_i (events_i[10*Units+:Units]),
    .count_cache_merges_i (events_i[11*Units+:Units]), .count_cache_misses_i (events_i[12*Units+:Units]), .*
  );

  assign settings_o[0] = {irq_o, control_enable_o, node_limit_o, timeout_o, scene_base_o[63:6], scene_end_o[63:6],
                          ray_base_o[63:6], ray_size_o, ray_tail_o, hit_base_o[63:6], hit_size_o, hit_head_o,
                          interrupt_hits_o, 55'd0};
  assign pulses_o[0] = {control_flush_o, control_invalidate_o, control_clear_error_o};

  // ---- PeakRDL's ------------------------------------------------------------------
  raypath_device_registers_peakrdl__in_t  hwif_in;
  raypath_device_registers_peakrdl__out_t hwif_out;

  raypath_device_registers_peakrdl u_peakrdl (
    .clk (clk_i), .arst_n (rst_ni),
    .s_axil_awvalid (awvalid_i[1]), .s_axil_awready (awready_o[1]), .s_axil_awaddr (awaddr_i[1]), .s_axil_awprot ('0),
    .s_axil_wvalid (wvalid_i[1]), .s_axil_wready (wready_o[1]), .s_axil_wdata (wdata_i[1]), .s_axil_wstrb (wstrb_i[1]),
    .s_axil_bvalid (bvalid_o[1]), .s_axil_bready (bready_i[1]), .s_axil_bresp (bresp_o[1]),
    .s_axil_arvalid (arvalid_i[1]), .s_axil_arready (arready_o[1]), .s_axil_araddr (araddr_i[1]), .s_axil_arprot ('0),
    .s_axil_rvalid (rvalid_o[1]), .s_axil_rready (rready_i[1]), .s_axil_rdata (rdata_o[1]), .s_axil_rresp (rresp_o[1]),
    .hwif_in, .hwif_out
  );

  logic [63:0] counts_q [Counters];

  for (genvar k = 0; k < Counters; k++) begin : g_counts
    always_ff @(posedge clk_i) begin
      if (!rst_ni || hwif_out.control.clear_counts.value) counts_q[k] <= '0;
      else counts_q[k] <= counts_q[k] + 64'($countones(k == 0 ? Units'(events_i[0]) : events_i[k*Units+:Units]));
    end
  end

`define COUNT(NAME, K) \
  assign hwif_in.NAME.low.value.next = counts_q[K][31:0]; \
  assign hwif_in.NAME.high.value.next = counts_q[K][63:32];
  `COUNT(cycles, 0)
  `COUNT(boxes, 1)
  `COUNT(triangles, 2)
  `COUNT(transforms, 3)
  `COUNT(steps, 4)
  `COUNT(fetches, 5)
  `COUNT(rays, 6)
  `COUNT(restarts, 7)
  `COUNT(job_stalls, 8)
  `COUNT(candidates, 9)
  `COUNT(cache_hits, 10)
  `COUNT(cache_merges, 11)
  `COUNT(cache_misses, 12)

  assign hwif_in.config_.units.next            = config_units_i;
  assign hwif_in.config_.contexts.next         = config_contexts_i;
  assign hwif_in.config_.node.next             = config_node_i;
  assign hwif_in.config_.flags.next            = config_flags_i;
  assign hwif_in.config_.candidates.next       = config_candidates_i;
  assign hwif_in.config_.instances.next        = config_instances_i;
  assign hwif_in.config_.nested_instances.next = config_nested_instances_i;
  assign hwif_in.config_.address_bits.next     = config_address_bits_i;
  assign hwif_in.memory_bytes.value.next       = memory_bytes_i;
  assign hwif_in.cache_bytes.value.next        = cache_bytes_i;
  assign hwif_in.status.idle.next              = status_idle_i;
  assign hwif_in.status.busy.next              = status_busy_i;
  assign hwif_in.status.memory_timed_out.next  = status_memory_timed_out_i;
  assign hwif_in.status.ring_timed_out.next    = status_ring_timed_out_i;
  assign hwif_in.status.error.next             = status_error_i;
  assign hwif_in.ray_head.value.next           = ray_head_i;
  assign hwif_in.hit_tail.value.next           = hit_tail_i;
  assign hwif_in.interrupt_status.hits.next    = levels_i[0];
  assign hwif_in.interrupt_status.error.next   = levels_i[1];
  assign hwif_in.interrupt_status.drained.next = levels_i[2];

  assign settings_o[1] = {
    hwif_out.interrupt_status.intr, hwif_out.control.enable.value, hwif_out.node_limit.value.value,
    hwif_out.timeout.value.value, hwif_out.scene_base.high.value.value, hwif_out.scene_base.low.value.value,
    hwif_out.scene_end.high.value.value, hwif_out.scene_end.low.value.value, hwif_out.ray_base.high.value.value,
    hwif_out.ray_base.low.value.value, hwif_out.ray_size.value.value, hwif_out.ray_tail.value.value,
    hwif_out.hit_base.high.value.value, hwif_out.hit_base.low.value.value, hwif_out.hit_size.value.value,
    hwif_out.hit_head.value.value, hwif_out.interrupt_hits.value.value, 55'd0
  };
  assign pulses_o[1] = {hwif_out.control.flush.value, hwif_out.control.invalidate.value,
                        hwif_out.control.clear_error.value};

endmodule : registers
