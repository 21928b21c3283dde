module raypath_unit_axi #(
  // Those of units.
  parameter  logic [31:0]            Contexts       = @CONTEXTS@,
  @ID_KIND@ logic [31:0]            IdWidth        = @ID@,
  @ADDRESS_KIND@ logic [31:0]            AddressWidth   = @ADDRESS@,
  // Units, each with a cache of its own: its sets, a power of two, or 0 for none; its ways, the
  // lines that it fetches at a time, and the bytes of a line: a block, or 2 or 4.
  parameter  logic [31:0]            Units          = 1,
  parameter  logic [31:0]            CacheSets      = 0,
  parameter  logic [31:0]            CacheWays      = 4,
  parameter  logic [31:0]            CacheMisses    = 8,
  parameter  logic [31:0]            CacheLineBytes = @BLOCK@,
  // The cycles without a beat that the memory may owe one; 0 for any number.
  parameter  logic [31:0]            Timeout        = 0,
  // Attributes of reads: normal memory, bufferable, not secure.
  parameter  logic [3:0]             ArCache        = 4'b0011,
  parameter  logic [2:0]             ArProt         = 3'b010,
  parameter  logic [3:0]             ArQos          = 4'b0000,
  parameter  logic [31:0]            ArUserWidth    = 1,
  parameter  logic [ArUserWidth-1:0] ArUser         = '0,
  localparam logic [31:0]            DataWidth      = @WIDTH@,
  localparam logic [31:0]            UnitWidth      = $clog2(Units),
  localparam logic [31:0]            ContextWidth   = $clog2(Contexts),
  localparam logic [31:0]            LowerWidth     = (CacheSets == 0) ? ContextWidth
                                                    : $clog2(CacheMisses),
@c  localparam logic [31:0]            CandTagWidth   = UnitWidth + ContextWidth,
  localparam logic [31:0]            TagWidth       = UnitWidth + LowerWidth
) (
@PORTS@
);

  localparam logic [31:0] BeatBytes  = DataWidth / 8;
  localparam logic [31:0] BeatBits   = $clog2(BeatBytes);
  localparam logic [31:0] BurstBytes = (CacheSets == 0) ? @BLOCK@ : CacheLineBytes;

  logic                    mem_req_valid;
  logic                    mem_req_ready;
  logic [AddressWidth-1:0] mem_req_addr;
  logic [TagWidth-1:0]     mem_req_tag;
  logic                    mem_rsp_valid;
  logic                    unused_mem_rsp_ready;
  logic [TagWidth-1:0]     mem_rsp_tag;
  logic                    mem_rsp_error;
  logic [DataWidth-1:0]    mem_rsp_data;
  logic                    req_valid;
  logic                    req_ready;
  logic [AddressWidth-1:0] req_addr;
  logic [TagWidth-1:0]     req_tag;
  logic                    rsp_valid;
  logic                    rsp_ready;
  logic [TagWidth-1:0]     rsp_tag;
  logic                    rsp_error;
  logic [DataWidth-1:0]    rsp_data;

  raypath_cluster #(
    @PASSED@,
    .Units (Units), .CacheSets (CacheSets), .CacheWays (CacheWays), .CacheMisses (CacheMisses),
    .CacheLineBytes (CacheLineBytes)
  ) u_cluster (
    @CONNECTIONS@,
    .mem_req_valid_o (mem_req_valid), .mem_req_ready_i (mem_req_ready),
    .mem_req_addr_o (mem_req_addr), .mem_req_tag_o (mem_req_tag), .mem_rsp_valid_i (mem_rsp_valid),
    .mem_rsp_ready_o (unused_mem_rsp_ready), .mem_rsp_tag_i (mem_rsp_tag),
    .mem_rsp_error_i (mem_rsp_error), .mem_rsp_data_i (mem_rsp_data)
  );

  if (Timeout == 0) begin : g_patient
    assign req_valid     = mem_req_valid;
    assign req_addr      = mem_req_addr;
    assign req_tag       = mem_req_tag;
    assign mem_req_ready = req_ready;
    assign mem_rsp_valid = rsp_valid;
    assign mem_rsp_tag   = rsp_tag;
    assign mem_rsp_error = rsp_error;
    assign mem_rsp_data  = rsp_data;
    assign rsp_ready     = 1'b1;
    assign timed_out_o   = 1'b0;
  end else begin : g_guard
    logic unused_idle;

    raypath_guard #(
      .AddressWidth (AddressWidth), .DataWidth (DataWidth), .BurstBytes (BurstBytes),
      .TagWidth (TagWidth)
    ) u_guard (
      .clk_i, .rst_ni, .first_i ('0), .end_i ({1'b1, AddressWidth'(0)}), .timeout_i (Timeout),
      .clear_i (1'b1), .timed_out_o, .idle_o (unused_idle), .req_valid_i (mem_req_valid),
      .req_addr_i (mem_req_addr), .req_tag_i (mem_req_tag), .req_ready_o (mem_req_ready),
      .rsp_valid_o (mem_rsp_valid), .rsp_tag_o (mem_rsp_tag), .rsp_error_o (mem_rsp_error),
      .rsp_data_o (mem_rsp_data), .mem_req_valid_o (req_valid), .mem_req_addr_o (req_addr),
      .mem_req_tag_o (req_tag), .mem_req_ready_i (req_ready), .mem_rsp_valid_i (rsp_valid),
      .mem_rsp_tag_i (rsp_tag), .mem_rsp_error_i (rsp_error), .mem_rsp_data_i (rsp_data),
      .mem_rsp_ready_o (rsp_ready)
    );
  end

  // Bursts increment. They are aligned to their length, so that none crosses 4 KiB.
  assign m_axi_arvalid = req_valid;
  assign m_axi_arid    = req_tag;
  assign m_axi_araddr  = req_addr;
  assign m_axi_arlen   = 8'(BurstBytes / BeatBytes - 1);
  assign m_axi_arsize  = 3'(BeatBits);
  assign m_axi_arburst = 2'b01;
  assign m_axi_arlock  = 1'b0;
  assign m_axi_arcache = ArCache;
  assign m_axi_arprot  = ArProt;
  assign m_axi_arqos   = ArQos;
  assign m_axi_aruser  = ArUser;
  assign req_ready     = m_axi_arready;

  assign rsp_valid    = m_axi_rvalid;
  assign rsp_tag      = m_axi_rid;
  assign rsp_error    = (m_axi_rresp != 2'b00);
  assign rsp_data     = m_axi_rdata;
  assign m_axi_rready = rsp_ready;

  // Readers count the beats of each burst.
  logic unused_rlast;
  assign unused_rlast = m_axi_rlast;

endmodule : raypath_unit_axi
