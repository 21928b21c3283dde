// SPDX-License-Identifier: MIT OR Apache-2.0
// The registers with the engine of the rings. The bench is the cluster and the memory.

module rings #(
  parameter  logic [31:0] AddressWidth = 32,
  parameter  logic [31:0] DataWidth    = 128,
  // Indices soon pass from 2^32 - 1 to 0.
  parameter  logic [31:0] FirstIndex   = 32'hffff_fff0,
  localparam logic [31:0] Bytes        = DataWidth / 8
) (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  output logic                    irq_o,
  input  logic                    s_axi_awvalid,
  output logic                    s_axi_awready,
  input  logic [11:0]             s_axi_awaddr,
  input  logic                    s_axi_wvalid,
  output logic                    s_axi_wready,
  input  logic [31:0]             s_axi_wdata,
  input  logic [3:0]              s_axi_wstrb,
  output logic                    s_axi_bvalid,
  input  logic                    s_axi_bready,
  output logic [1:0]              s_axi_bresp,
  input  logic                    s_axi_arvalid,
  output logic                    s_axi_arready,
  input  logic [11:0]             s_axi_araddr,
  output logic                    s_axi_rvalid,
  input  logic                    s_axi_rready,
  output logic [31:0]             s_axi_rdata,
  output logic [1:0]              s_axi_rresp,
  // The cluster.
  input  logic                    cluster_idle_i,
  output logic                    ray_valid_o,
  input  logic                    ray_ready_i,
  output logic [511:0]            ray_record_o,
  input  logic                    hit_valid_i,
  output logic                    hit_ready_o,
  input  logic [511:0]            hit_record_i,
  // The memory.
  output logic                    read_valid_o,
  input  logic                    read_ready_i,
  output logic [AddressWidth-1:0] read_addr_o,
  input  logic                    data_valid_i,
  input  logic                    data_error_i,
  input  logic [DataWidth-1:0]    data_i,
  output logic                    m_axi_awvalid,
  input  logic                    m_axi_awready,
  output logic                    m_axi_awid,
  output logic [AddressWidth-1:0] m_axi_awaddr,
  output logic [7:0]              m_axi_awlen,
  output logic [2:0]              m_axi_awsize,
  output logic [1:0]              m_axi_awburst,
  output logic                    m_axi_wvalid,
  input  logic                    m_axi_wready,
  output logic [DataWidth-1:0]    m_axi_wdata,
  output logic [Bytes-1:0]        m_axi_wstrb,
  output logic                    m_axi_wlast,
  input  logic                    m_axi_bvalid,
  output logic                    m_axi_bready,
  input  logic                    m_axi_bid,
  input  logic [1:0]              m_axi_bresp,
  // What the bench sees of the registers.
  output logic                    enable_o,
  output logic                    flush_o,
  output logic [31:0]             timeout_o,
  output logic [63:0]             ray_base_o,
  output logic [31:0]             ray_size_o,
  output logic [31:0]             ray_head_o,
  output logic [31:0]             ray_tail_o,
  output logic [63:0]             hit_base_o,
  output logic [31:0]             hit_size_o,
  output logic [31:0]             hit_head_o,
  output logic [31:0]             hit_tail_o,
  output logic                    idle_o,
  output logic [3:0]              error_o,
  output logic                    timed_out_o,
  output logic                    drained_o,
  output logic [2:0]              events_o
);

  logic        clear_error;
  logic [31:0] interrupt_hits;

  raypath_device_registers u_registers (
    .clk_i, .rst_ni, .irq_o, .s_axi_awvalid, .s_axi_awready, .s_axi_awaddr, .s_axi_awprot ('0), .s_axi_wvalid,
    .s_axi_wready, .s_axi_wdata, .s_axi_wstrb, .s_axi_bvalid, .s_axi_bready, .s_axi_bresp, .s_axi_arvalid,
    .s_axi_arready, .s_axi_araddr, .s_axi_arprot ('0), .s_axi_rvalid, .s_axi_rready, .s_axi_rdata, .s_axi_rresp,
    .control_enable_o (enable_o), .node_limit_o (), .timeout_o, .scene_base_o (), .scene_end_o (), .ray_base_o,
    .ray_size_o, .ray_tail_o, .hit_base_o, .hit_size_o, .hit_head_o, .interrupt_hits_o (interrupt_hits),
    .control_flush_o (flush_o), .control_invalidate_o (), .control_clear_error_o (clear_error), .config_units_i (8'd1),
    .config_contexts_i (9'd16), .config_node_i (2'd0), .config_flags_i (1'b0), .config_candidates_i (1'b0),
    .config_instances_i (1'b0), .config_nested_instances_i (1'b0), .config_address_bits_i (6'(AddressWidth - 32'd32)),
    .memory_bytes_i (Bytes), .cache_bytes_i ('0), .status_idle_i (idle_o), .status_busy_i (~idle_o),
    .status_memory_timed_out_i (1'b0), .status_ring_timed_out_i (timed_out_o), .status_error_i (error_o),
    .ray_head_i (ray_head_o), .hit_tail_i (hit_tail_o),
    .interrupt_status_hits_i (enable_o & (hit_tail_o - hit_head_o >= interrupt_hits)),
    .interrupt_status_error_i (error_o != 4'd0), .interrupt_status_drained_i (drained_o), .count_cycles_i (1'b1),
    .count_boxes_i ('0), .count_triangles_i ('0), .count_transforms_i ('0), .count_steps_i ('0), .count_fetches_i ('0),
    .count_rays_i (hit_valid_i & hit_ready_o), .count_restarts_i ('0), .count_job_stalls_i ('0),
    .count_candidates_i ('0), .count_cache_hits_i ('0), .count_cache_merges_i ('0), .count_cache_misses_i ('0)
  );

  assign events_o = u_registers.interrupt_status_q;

  raypath_rings #(.AddressWidth (AddressWidth), .DataWidth (DataWidth), .FirstIndex (FirstIndex)) u_rings (
    .enable_i (enable_o), .flush_i (flush_o), .clear_error_i (clear_error), .timeout_i (timeout_o),
    .ray_base_i (ray_base_o), .ray_size_i (ray_size_o), .ray_tail_i (ray_tail_o), .hit_base_i (hit_base_o),
    .hit_size_i (hit_size_o), .hit_head_i (hit_head_o), .*
  );

endmodule : rings
