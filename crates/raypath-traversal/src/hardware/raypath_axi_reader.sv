module raypath_axi_reader #(
  parameter  logic [31:0] AddressWidth   = 32,
  parameter  logic [31:0] DataWidth      = 512,
  parameter  logic [31:0] BlockBytes     = 128,
  parameter  logic [31:0] Requesters     = 64,
  parameter  logic [31:0] CacheSets      = 0,
  parameter  logic [31:0] CacheWays      = 4,
  parameter  logic [31:0] CacheMisses    = 8,
  parameter  logic [31:0] CacheLineBytes = BlockBytes,
  parameter  logic [3:0]  ArCache        = 4'b0011,
  parameter  logic [2:0]  ArProt         = 3'b010,
  parameter  logic [3:0]  ArQos          = 4'b0000,
  localparam logic [31:0] TagWidth       = $clog2(Requesters)
) (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  input  logic                    invalidate_i,
  // The request of a block.
  input  logic                    req_valid_i,
  input  logic [AddressWidth-1:0] req_addr_i,
  input  logic [TagWidth-1:0]     req_tag_i,
  output logic                    req_ready_o,
  // A beat of a block.
  output logic                    rsp_valid_o,
  output logic [TagWidth-1:0]     rsp_tag_o,
  output logic                    rsp_error_o,
  output logic [DataWidth-1:0]    rsp_data_o,
  // AXI4, by the names of its specification.
  input  logic                    m_axi_arready,
  output logic                    m_axi_arvalid,
  output logic [TagWidth-1:0]     m_axi_arid,
  output logic [AddressWidth-1:0] m_axi_araddr,
  output logic [7:0]              m_axi_arlen,
  output logic [2:0]              m_axi_arsize,
  output logic [1:0]              m_axi_arburst,
  output logic                    m_axi_arlock,
  output logic [3:0]              m_axi_arcache,
  output logic [2:0]              m_axi_arprot,
  output logic [3:0]              m_axi_arqos,
  input  logic                    m_axi_rvalid,
  input  logic [TagWidth-1:0]     m_axi_rid,
  input  logic [DataWidth-1:0]    m_axi_rdata,
  input  logic [1:0]              m_axi_rresp,
  input  logic                    m_axi_rlast,
  output logic                    m_axi_rready
);

  localparam logic [31:0] BurstBytes = (CacheSets == 0) ? BlockBytes : CacheLineBytes;
  localparam logic [31:0] Beats      = BurstBytes * 8 / DataWidth;
  localparam logic [31:0] BeatBytes  = DataWidth / 8;

  // Bursts increment. They are aligned to their length, so that none crosses 4 KiB.
  assign m_axi_arlen   = 8'(Beats - 1);
  assign m_axi_arsize  = 3'($clog2(BeatBytes));
  assign m_axi_arburst = 2'b01;
  assign m_axi_arlock  = 1'b0;
  assign m_axi_arcache = ArCache;
  assign m_axi_arprot  = ArProt;
  assign m_axi_arqos   = ArQos;
  assign m_axi_rready  = 1'b1;

  // Readers count the beats of each burst.
  logic unused_rlast;
  assign unused_rlast = m_axi_rlast;

  if (CacheSets == 0) begin : g_direct
    // An id is the tag of a request.
    logic unused_inputs;
    assign unused_inputs = ^{clk_i, rst_ni, invalidate_i};

    assign req_ready_o   = m_axi_arready;
    assign m_axi_arvalid = req_valid_i;
    assign m_axi_arid    = req_tag_i;
    assign m_axi_araddr  = req_addr_i;
    assign rsp_valid_o   = m_axi_rvalid;
    assign rsp_tag_o     = m_axi_rid;
    assign rsp_error_o   = (m_axi_rresp != 2'b00);
    assign rsp_data_o    = m_axi_rdata;
  end else begin : g_cache
    // An id is the number of a line under way.
    localparam logic [31:0] MissWidth = $clog2(CacheMisses);
    logic [MissWidth-1:0] miss;
    logic                 unused_outputs;
    logic                 idle;
    logic                 hits;
    logic                 merges;
    logic                 misses;

    assign unused_outputs = ^{idle, hits, merges, misses};

    if (MissWidth > TagWidth) begin : g_too_many_misses
      $error("CacheMisses is %0d, expected at most %0d", CacheMisses, 32'd1 << TagWidth);
    end else if (MissWidth == TagWidth) begin : g_id
      assign m_axi_arid = miss;
    end else begin : g_extended_id
      logic unused_id;
      assign unused_id  = ^m_axi_rid[TagWidth-1:MissWidth];
      assign m_axi_arid = {{(TagWidth - MissWidth){1'b0}}, miss};
    end

    raypath_cache #(
      .Sets (CacheSets), .Ways (CacheWays), .Misses (CacheMisses), .LineBytes (CacheLineBytes),
      .BlockBytes (BlockBytes), .DataWidth (DataWidth), .AddressWidth (AddressWidth),
      .Requesters (Requesters)
    ) u_cache (
      .clk_i, .rst_ni, .invalidate_i, .idle_o (idle), .hits_o (hits), .merges_o (merges),
      .misses_o (misses), .req_valid_i, .req_addr_i, .req_tag_i, .req_ready_o, .rsp_valid_o,
      .rsp_tag_o, .rsp_error_o, .rsp_data_o, .mem_req_ready_i (m_axi_arready),
      .mem_req_valid_o (m_axi_arvalid), .mem_req_addr_o (m_axi_araddr), .mem_req_tag_o (miss),
      .mem_rsp_valid_i (m_axi_rvalid), .mem_rsp_tag_i (m_axi_rid[MissWidth-1:0]),
      .mem_rsp_error_i (m_axi_rresp != 2'b00), .mem_rsp_data_i (m_axi_rdata)
    );
  end

endmodule : raypath_axi_reader
