module raypath_device #(
  // Those of units.
  parameter  logic [31:0] Contexts       = @CONTEXTS@,
  @ID_KIND@ logic [31:0] IdWidth        = @ID@,
  @ADDRESS_KIND@ logic [31:0] AddressWidth   = @ADDRESS@,
  // Units, each with a cache of its own: its sets, a power of two, or 0 for none; its ways, the
  // lines that it fetches at a time, and the bytes of a line: a block, or 2 or 4.
  parameter  logic [31:0] Units          = 1,
  parameter  logic [31:0] CacheSets      = 0,
  parameter  logic [31:0] CacheWays      = 4,
  parameter  logic [31:0] CacheMisses    = 8,
  parameter  logic [31:0] CacheLineBytes = @BLOCK@,
  // Attributes of reads and writes: normal memory, bufferable, not secure.
  parameter  logic [3:0]  AxCache        = 4'b0011,
  parameter  logic [2:0]  AxProt         = 3'b010,
  parameter  logic [3:0]  AxQos          = 4'b0000,
  localparam logic [31:0] DataWidth      = @WIDTH@,
  localparam logic [31:0] UnitWidth      = $clog2(Units),
  localparam logic [31:0] ContextWidth   = $clog2(Contexts),
@c  localparam logic [31:0] CandTagWidth   = UnitWidth + ContextWidth,
  localparam logic [31:0] LowerWidth     = (CacheSets == 0) ? ContextWidth : $clog2(CacheMisses),
  localparam logic [31:0] TagWidth       = UnitWidth + LowerWidth,
  // An id is a tag, below a bit that says whether the read is of a ring.
  localparam logic [31:0] AxiIdWidth     = TagWidth + 1
) (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  output logic                    irq_o,
  // The registers: an AXI4-Lite slave, by the names of its specification.
  input  logic                    s_axi_awvalid,
  output logic                    s_axi_awready,
  input  logic [11:0]             s_axi_awaddr,
  input  logic [2:0]              s_axi_awprot,
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
  input  logic [2:0]              s_axi_arprot,
  output logic                    s_axi_rvalid,
  input  logic                    s_axi_rready,
  output logic [31:0]             s_axi_rdata,
  output logic [1:0]              s_axi_rresp,
  // An AXI4 master: reads of the scene and of rays, writes of hits.
  output logic                    m_axi_arvalid,
  input  logic                    m_axi_arready,
  output logic [AxiIdWidth-1:0]      m_axi_arid,
  output logic [AddressWidth-1:0] m_axi_araddr,
  output logic [7:0]              m_axi_arlen,
  output logic [2:0]              m_axi_arsize,
  output logic [1:0]              m_axi_arburst,
  output logic                    m_axi_arlock,
  output logic [3:0]              m_axi_arcache,
  output logic [2:0]              m_axi_arprot,
  output logic [3:0]              m_axi_arqos,
  input  logic                    m_axi_rvalid,
  output logic                    m_axi_rready,
  input  logic [AxiIdWidth-1:0]      m_axi_rid,
  input  logic [DataWidth-1:0]    m_axi_rdata,
  input  logic [1:0]              m_axi_rresp,
  input  logic                    m_axi_rlast,
  output logic                    m_axi_awvalid,
  input  logic                    m_axi_awready,
  output logic                    m_axi_awid,
  output logic [AddressWidth-1:0] m_axi_awaddr,
  output logic [7:0]              m_axi_awlen,
  output logic [2:0]              m_axi_awsize,
  output logic [1:0]              m_axi_awburst,
  output logic                    m_axi_awlock,
  output logic [3:0]              m_axi_awcache,
  output logic [2:0]              m_axi_awprot,
  output logic [3:0]              m_axi_awqos,
  output logic                    m_axi_wvalid,
  input  logic                    m_axi_wready,
  output logic [DataWidth-1:0]    m_axi_wdata,
  output logic [DataWidth/8-1:0]  m_axi_wstrb,
  output logic                    m_axi_wlast,
  input  logic                    m_axi_bvalid,
  output logic                    m_axi_bready,
  input  logic                    m_axi_bid,
  input  logic [1:0]              m_axi_bresp
);

  localparam logic [31:0] BurstBytes  = (CacheSets == 0) ? @BLOCK@ : CacheLineBytes;
  localparam logic [31:0] BeatBytes   = DataWidth / 8;
  localparam logic [31:0] BeatBits    = $clog2(BeatBytes);
  localparam logic [31:0] RecordBeats = (BeatBytes > 64) ? 1 : 64 / BeatBytes;
  localparam logic [2:0]  RecordSize  = (BeatBytes > 64) ? 3'd6 : 3'(BeatBits);
  localparam logic [31:0] CacheBytes  = CacheSets * CacheWays * CacheLineBytes;

  // ---- Registers ------------------------------------------------------------------
  logic        enable;
  logic        flush;
  logic        invalidate;
  logic        clear_error;
  logic [31:0] node_limit;
  logic [31:0] timeout;
  logic [63:0] scene_base;
  logic [63:0] scene_end;
  logic [63:0] ray_base;
  logic [31:0] ray_size;
  logic [31:0] ray_tail;
  logic [31:0] ray_head;
  logic [63:0] hit_base;
  logic [31:0] hit_size;
  logic [31:0] hit_head;
  logic [31:0] hit_tail;
  logic [31:0] interrupt_hits;
  logic [31:0] unread;
  logic        cluster_idle;
  logic        guard_idle;
  logic        rings_idle;
  logic        is_idle;
  logic        drained;
  logic        timed_out;
  logic        ring_timed_out;
  logic [3:0]  rings_error;
  logic [3:0]  error;
  @COUNT_WIRES@

  assign is_idle = cluster_idle & guard_idle & rings_idle;
  assign error   = (rings_error != 4'd0) ? rings_error : timed_out ? 4'd6 : 4'd0;
  assign unread  = hit_tail - hit_head;

  raypath_device_registers #(.Units (Units)) u_registers (
    .clk_i, .rst_ni, .irq_o, .s_axi_awvalid, .s_axi_awready, .s_axi_awaddr, .s_axi_awprot,
    .s_axi_wvalid, .s_axi_wready, .s_axi_wdata, .s_axi_wstrb, .s_axi_bvalid, .s_axi_bready,
    .s_axi_bresp, .s_axi_arvalid, .s_axi_arready, .s_axi_araddr, .s_axi_arprot, .s_axi_rvalid,
    .s_axi_rready, .s_axi_rdata, .s_axi_rresp, .control_enable_o (enable),
    .control_flush_o (flush), .control_invalidate_o (invalidate),
    .control_clear_error_o (clear_error), .node_limit_o (node_limit), .timeout_o (timeout),
    .scene_base_o (scene_base), .scene_end_o (scene_end), .ray_base_o (ray_base),
    .ray_size_o (ray_size), .ray_tail_o (ray_tail), .hit_base_o (hit_base),
    .hit_size_o (hit_size), .hit_head_o (hit_head), .interrupt_hits_o (interrupt_hits),
    .config_units_i (8'(Units)), .config_contexts_i (9'(Contexts)), .config_node_i (2'd@NODE@),
    .config_flags_i (1'b@FLAGS@), .config_candidates_i (1'b@CANDIDATES@),
    .config_instances_i (1'b@INSTANCES@), .config_nested_instances_i (1'b@NESTED@),
    .config_address_bits_i (6'(AddressWidth - 32)), .memory_bytes_i (BeatBytes),
    .cache_bytes_i (CacheBytes),
    .status_idle_i (is_idle), .status_busy_i (~is_idle), .status_memory_timed_out_i (timed_out),
    .status_ring_timed_out_i (ring_timed_out), .status_error_i (error), .ray_head_i (ray_head),
    .hit_tail_i (hit_tail),
    .interrupt_status_hits_i (enable && unread != 32'd0 && unread >= interrupt_hits),
    .interrupt_status_error_i (error != 4'd0), .interrupt_status_drained_i (drained),
    .count_cycles_i (1'b1),
    @COUNT_INPUTS@
  );

  // ---- Rings ------------------------------------------------------------------------
  logic                    ray_valid;
  logic                    ray_ready;
  logic [511:0]            ray;
  logic                    hit_valid;
  logic                    hit_ready;
  logic [511:0]            hit;
  logic                    record_valid;
  logic                    record_ready;
  logic [AddressWidth-1:0] record_addr;
  logic                    data_valid;
  logic                    unused_ray;

  // Some of its bits belong to no field.
  assign unused_ray = ^ray;

  raypath_rings #(.AddressWidth (AddressWidth), .DataWidth (DataWidth)) u_rings (
    .clk_i, .rst_ni, .enable_i (enable), .flush_i (flush), .clear_error_i (clear_error),
    .timeout_i (timeout), .timed_out_o (ring_timed_out), .ray_base_i (ray_base),
    .ray_size_i (ray_size), .ray_tail_i (ray_tail), .hit_base_i (hit_base),
    .hit_size_i (hit_size), .hit_head_i (hit_head),
    .ray_head_o (ray_head), .hit_tail_o (hit_tail), .idle_o (rings_idle), .error_o (rings_error),
    .drained_o (drained), .cluster_idle_i (cluster_idle), .ray_valid_o (ray_valid),
    .ray_ready_i (ray_ready), .ray_record_o (ray), .hit_valid_i (hit_valid),
    .hit_ready_o (hit_ready), .hit_record_i (hit), .read_valid_o (record_valid),
    .read_ready_i (record_ready), .read_addr_o (record_addr), .data_valid_i (data_valid),
    .data_error_i (m_axi_rresp != 2'b00), .data_i (m_axi_rdata), .m_axi_awvalid, .m_axi_awready,
    .m_axi_awid, .m_axi_awaddr, .m_axi_awlen, .m_axi_awsize, .m_axi_awburst, .m_axi_wvalid,
    .m_axi_wready, .m_axi_wdata, .m_axi_wstrb, .m_axi_wlast, .m_axi_bvalid, .m_axi_bready,
    .m_axi_bid, .m_axi_bresp
  );

  assign m_axi_awlock  = 1'b0;
  assign m_axi_awcache = AxCache;
  assign m_axi_awprot  = AxProt;
  assign m_axi_awqos   = AxQos;

  // ---- Units --------------------------------------------------------------------------
  logic                    unused_busy;
  logic                    unused_mem_rsp_ready;
  logic                    mem_req_valid;
  logic                    mem_req_ready;
  logic [AddressWidth-1:0] mem_req_addr;
  logic [TagWidth-1:0]     mem_req_tag;
  logic                    mem_rsp_valid;
  logic [TagWidth-1:0]     mem_rsp_tag;
  logic                    mem_rsp_error;
  logic [DataWidth-1:0]    mem_rsp_data;
  @HIT_WIRES@
  logic [63:0] hit_number;
@c  logic                    cand_valid;
@c  logic [CandTagWidth-1:0] cand_tag;
@c  @CAND_WIRES@
@c  logic                    answer_valid_q;
@c  logic                    answer_accept_q;
@c  logic [CandTagWidth-1:0] answer_tag_q;
@c  logic                    unused_answer_ready;

  raypath_cluster #(
    @PASSED@,
    .Units (Units), .CacheSets (CacheSets), .CacheWays (CacheWays), .CacheMisses (CacheMisses),
    .CacheLineBytes (CacheLineBytes)
  ) u_cluster (
    .clk_i, .rst_ni, .flush_i (flush), .node_limit_i (node_limit), .invalidate_i (invalidate),
    .idle_o (cluster_idle), .busy_o (unused_busy), .ray_valid_i (ray_valid),
    .ray_ready_o (ray_ready),
    @RAY_WORDS@,
    .hit_valid_o (hit_valid), .hit_ready_i (hit_ready),
    @HIT@,
@c    .cand_valid_o (cand_valid), .cand_ready_i (1'b1),
@c    @CAND@,
@c    .answer_valid_i (answer_valid_q), .answer_ready_o (unused_answer_ready),
@c    .answer_tag_i (answer_tag_q), .answer_accept_i (answer_accept_q), .answer_end_i (1'b0),
@c    .answer_t_i (32'd0),
    @COUNT_OUTPUTS@,
    .mem_req_valid_o (mem_req_valid), .mem_req_ready_i (mem_req_ready),
    .mem_req_addr_o (mem_req_addr), .mem_req_tag_o (mem_req_tag), .mem_rsp_valid_i (mem_rsp_valid),
    .mem_rsp_ready_o (unused_mem_rsp_ready), .mem_rsp_tag_i (mem_rsp_tag),
    .mem_rsp_error_i (mem_rsp_error), .mem_rsp_data_i (mem_rsp_data)
  );

  always_comb begin
    hit_number = '0;
    hit_number[IdWidth-1:0] = hit_id;
  end

  assign hit = {
    @HIT_WORDS@
  };
@c
@c  // There is no shader: triangles are accepted, and boxes are not.
@c  logic unused_candidate;
@c  assign unused_candidate = ^{
@c    @CAND_UNUSED@
@c  };
@c
@c  always_ff @(posedge clk_i or negedge rst_ni) begin
@c    if (!rst_ni) answer_valid_q <= 1'b0;
@c    else answer_valid_q <= cand_valid;
@c  end
@c
@c  always_ff @(posedge clk_i) begin
@c    answer_tag_q    <= cand_tag;
@c    answer_accept_q <= ~cand_is_box;
@c  end

  // ---- The scene's region, and the time of the memory ------------------------------------
  localparam logic [64:0] Top = 65'd1 << AddressWidth;

  logic [64:0]             region_end;
  logic                    req_valid;
  logic                    req_ready;
  logic [AddressWidth-1:0] req_addr;
  logic [TagWidth-1:0]     req_tag;
  logic                    rsp_valid;
  logic                    rsp_ready;
@u  logic                    unused_region;

  assign region_end = ({1'b0, scene_base} >= Top) ? '0 : ({1'b0, scene_end} > Top) ? Top
                    : {1'b0, scene_end};
@u  assign unused_region = ^region_end[64:AddressWidth+1];

  raypath_guard #(
    .AddressWidth (AddressWidth), .DataWidth (DataWidth), .BurstBytes (BurstBytes),
    .TagWidth (TagWidth)
  ) u_guard (
    .clk_i, .rst_ni, .first_i (scene_base[AddressWidth-1:0]), .end_i (region_end[AddressWidth:0]),
    .timeout_i (timeout), .clear_i (clear_error), .timed_out_o (timed_out), .idle_o (guard_idle),
    .req_valid_i (mem_req_valid), .req_addr_i (mem_req_addr), .req_tag_i (mem_req_tag),
    .req_ready_o (mem_req_ready), .rsp_valid_o (mem_rsp_valid), .rsp_tag_o (mem_rsp_tag),
    .rsp_error_o (mem_rsp_error), .rsp_data_o (mem_rsp_data), .mem_req_valid_o (req_valid),
    .mem_req_addr_o (req_addr), .mem_req_tag_o (req_tag), .mem_req_ready_i (req_ready),
    .mem_rsp_valid_i (rsp_valid), .mem_rsp_tag_i (m_axi_rid[TagWidth-1:0]),
    .mem_rsp_error_i (m_axi_rresp != 2'b00), .mem_rsp_data_i (m_axi_rdata),
    .mem_rsp_ready_o (rsp_ready)
  );

  // ---- Reads: of the scene and of rays ------------------------------------------------------
  logic [1:0] reads;
  logic       is_of_record;
  logic       unused_rlast;

  raypath_arbiter #(.Inputs (2)) u_reads (
    .clk_i, .rst_ni, .valid_i ({record_valid, req_valid}), .ready_i (m_axi_arready),
    .grant_o (reads)
  );

  assign req_ready     = m_axi_arready & reads[0];
  assign record_ready  = m_axi_arready & reads[1];
  assign m_axi_arvalid = (reads != 2'b00);
  assign m_axi_arid    = reads[1] ? {1'b1, TagWidth'(0)} : {1'b0, req_tag};
  assign m_axi_araddr  = reads[1] ? record_addr : req_addr;
  assign m_axi_arlen   = reads[1] ? 8'(RecordBeats - 1) : 8'(BurstBytes / BeatBytes - 1);
  assign m_axi_arsize  = reads[1] ? RecordSize : 3'(BeatBits);
  assign m_axi_arburst = 2'b01;
  assign m_axi_arlock  = 1'b0;
  assign m_axi_arcache = AxCache;
  assign m_axi_arprot  = AxProt;
  assign m_axi_arqos   = AxQos;

  assign is_of_record = m_axi_rid[TagWidth];
  assign data_valid   = m_axi_rvalid & is_of_record;
  assign rsp_valid    = m_axi_rvalid & ~is_of_record;
  assign m_axi_rready = is_of_record | rsp_ready;
  assign unused_rlast = m_axi_rlast;

endmodule : raypath_device
