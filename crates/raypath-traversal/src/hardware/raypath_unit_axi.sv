module raypath_unit_axi #(
  // The sets of the cache of blocks, a power of two; 0 for none. Its ways, the lines that it
  // fetches at a time, and the bytes of a line: a block, or 2 or 4.
  parameter logic [31:0] CacheSets      = 0,
  parameter logic [31:0] CacheWays      = 4,
  parameter logic [31:0] CacheMisses    = 8,
  parameter logic [31:0] CacheLineBytes = @BLOCK@,
  // Attributes of reads: normal memory, bufferable, not secure.
  parameter logic [3:0]  ArCache        = 4'b0011,
  parameter logic [2:0]  ArProt         = 3'b010,
  parameter logic [3:0]  ArQos          = 4'b0000
) (
@PORTS@
);

  logic mem_req_valid;
  logic mem_req_ready;
  logic [@LAST_ADDRESS@:0] mem_req_addr;
  logic [@LAST_TAG@:0] mem_req_tag;
  logic mem_rsp_valid;
  logic unused_mem_rsp_ready;
  logic [@LAST_TAG@:0] mem_rsp_tag;
  logic mem_rsp_error;
  logic [@LAST_DATA@:0] mem_rsp_data;

  raypath_unit u_unit (
@CONNECTIONS@    .mem_req_valid_o (mem_req_valid), .mem_req_ready_i (mem_req_ready),
    .mem_req_addr_o (mem_req_addr), .mem_req_tag_o (mem_req_tag), .mem_rsp_valid_i (mem_rsp_valid),
    .mem_rsp_ready_o (unused_mem_rsp_ready), .mem_rsp_tag_i (mem_rsp_tag),
    .mem_rsp_error_i (mem_rsp_error), .mem_rsp_data_i (mem_rsp_data)
  );

  raypath_axi_reader #(
    .AddressWidth (@ADDRESS@), .DataWidth (@WIDTH@), .BlockBytes (@BLOCK@),
    .Requesters (@CONTEXTS@), .CacheSets (CacheSets), .CacheWays (CacheWays),
    .CacheMisses (CacheMisses), .CacheLineBytes (CacheLineBytes), .ArCache (ArCache),
    .ArProt (ArProt), .ArQos (ArQos)
  ) u_reader (
    .clk_i, .rst_ni, .invalidate_i, .req_valid_i (mem_req_valid), .req_addr_i (mem_req_addr),
    .req_tag_i (mem_req_tag), .req_ready_o (mem_req_ready), .rsp_valid_o (mem_rsp_valid),
    .rsp_tag_o (mem_rsp_tag), .rsp_error_o (mem_rsp_error), .rsp_data_o (mem_rsp_data),
    .m_axi_arready, .m_axi_arvalid, .m_axi_arid, .m_axi_araddr, .m_axi_arlen, .m_axi_arsize,
    .m_axi_arburst, .m_axi_arlock, .m_axi_arcache, .m_axi_arprot, .m_axi_arqos, .m_axi_rvalid,
    .m_axi_rid, .m_axi_rdata, .m_axi_rresp, .m_axi_rlast, .m_axi_rready
  );

endmodule : raypath_unit_axi
