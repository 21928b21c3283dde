module raypath_cluster #(
  // Those of units.
  parameter  logic [31:0] Contexts       = @CONTEXTS@,
  @ID_KIND@ logic [31:0] IdWidth        = @ID@,
  @ADDRESS_KIND@ logic [31:0] AddressWidth   = @ADDRESS@,
  parameter  logic [31:0] Units          = 1,
  // The cache of each unit: its sets, a power of two, or 0 for none; its ways, the lines that it
  // fetches at a time, and the bytes of a line: a block, or 2 or 4.
  parameter  logic [31:0] CacheSets      = 0,
  parameter  logic [31:0] CacheWays      = 4,
  parameter  logic [31:0] CacheMisses    = 8,
  parameter  logic [31:0] CacheLineBytes = @BLOCK@,
  // A tag is the number of a unit above a context, or above the number of a line under way.
  localparam logic [31:0] DataWidth      = @WIDTH@,
  localparam logic [31:0] UnitWidth      = $clog2(Units),
  localparam logic [31:0] ContextWidth   = $clog2(Contexts),
  localparam logic [31:0] LowerWidth     = (CacheSets == 0) ? ContextWidth : $clog2(CacheMisses),
@c  localparam logic [31:0] CandTagWidth   = UnitWidth + ContextWidth,
  localparam logic [31:0] TagWidth       = UnitWidth + LowerWidth
) (
@PORTS@
);

  localparam logic [31:0] HitWidth     = @HIT_BITS@;
@c  localparam logic [31:0] CandWidth    = @CAND_BITS@;

  if (Units < 1 || Units > 64) begin : g_units_range
    $error("Units is %0d, expected 1 to 64", Units);
  end

  logic [Units-1:0]              is_idle;
  logic [Units-1:0]              has_place;
  logic [Units-1:0]              enters;
  logic [Units-1:0]              has_hit;
  logic [Units-1:0]              shows;
  logic [Units-1:0]              has_request;
  logic [Units-1:0]              requests;
  logic [Units*AddressWidth-1:0] addresses;
  logic [Units*LowerWidth-1:0]   tags;
  logic [Units*HitWidth-1:0]     hits;
  logic                          flushes_q;
  logic                          ray_valid;
@c  logic [Units-1:0]              has_candidate;
@c  logic [Units-1:0]              asks;
@c  logic [Units*CandWidth-1:0]    candidates;
@c  logic [Units-1:0]              unused_answer_ready;

  // ---- Rays and the flush -------------------------------------------------------
  // Units end a flush one by one. No ray enters until all have.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) flushes_q <= 1'b0;
    else flushes_q <= flush_i | (flushes_q & ~idle_o);
  end

  assign idle_o      = &is_idle;
  assign busy_o      = ~idle_o;
  assign ray_valid   = ray_valid_i & ~flushes_q;
  assign ray_ready_o = (enters != '0) & ~flushes_q;

  raypath_arbiter #(.Inputs (Units)) u_rays (
    .clk_i, .rst_ni, .valid_i (has_place), .ready_i (ray_valid), .grant_o (enters)
  );

  // ---- Units ----------------------------------------------------------------------
  for (genvar u = 0; u < Units; u++) begin : g_units
    logic                    unit_idle;
    logic                    unused_busy;
    logic                    unused_mem_rsp_ready;
    logic                    req_valid;
    logic                    req_ready;
    logic [AddressWidth-1:0] req_addr;
    logic [ContextWidth-1:0] req_tag;
    logic                    is_of_unit;
    logic                    rsp_valid;
    logic                    rsp_error;
    logic [ContextWidth-1:0] rsp_tag;
    logic [DataWidth-1:0]    rsp_data;
    @HIT_WIRES@
@c    logic [ContextWidth-1:0] cand_tag;
@c    @CAND_WIRES@

    raypath_unit #(@PASSED@) u_unit (
      .clk_i, .rst_ni, .flush_i, .node_limit_i, .idle_o (unit_idle), .busy_o (unused_busy),
      .ray_valid_i (ray_valid & enters[u]), .ray_ready_o (has_place[u]),
      @RAY@,
      .hit_valid_o (has_hit[u]), .hit_ready_i (hit_ready_i & shows[u]),
      @HIT@,
@c      .cand_valid_o (has_candidate[u]), .cand_ready_i (cand_ready_i & asks[u]),
@c      @CAND@,
@c      .answer_valid_i (answer_valid_i & (32'(answer_tag_i) >> ContextWidth == $unsigned(u))),
@c      .answer_ready_o (unused_answer_ready[u]), .answer_tag_i (answer_tag_i[ContextWidth-1:0]),
@c      @ANSWER@,
      @COUNTS@,
      .mem_req_valid_o (req_valid), .mem_req_ready_i (req_ready), .mem_req_addr_o (req_addr),
      .mem_req_tag_o (req_tag), .mem_rsp_valid_i (rsp_valid),
      .mem_rsp_ready_o (unused_mem_rsp_ready), .mem_rsp_tag_i (rsp_tag),
      .mem_rsp_error_i (rsp_error), .mem_rsp_data_i (rsp_data)
    );

    assign is_of_unit = mem_rsp_valid_i & (32'(mem_rsp_tag_i) >> LowerWidth == $unsigned(u));
    assign hits[$unsigned(u)*HitWidth+:HitWidth] = {
      @HIT_FIELDS@
    };
@c    assign candidates[$unsigned(u)*CandWidth+:CandWidth] = {
@c      @CAND_FIELDS@
@c    };

    if (CacheSets == 0) begin : g_direct
      assign is_idle[u]     = unit_idle;
      assign has_request[u] = req_valid;
      assign req_ready      = mem_req_ready_i & requests[u];
      assign rsp_valid      = is_of_unit;
      assign rsp_tag        = mem_rsp_tag_i[LowerWidth-1:0];
      assign rsp_error      = mem_rsp_error_i;
      assign rsp_data       = mem_rsp_data_i;

      assign addresses[$unsigned(u)*AddressWidth+:AddressWidth] = req_addr;
      assign tags[$unsigned(u)*LowerWidth+:LowerWidth]          = req_tag;

      assign count_cache_hits_o[u]   = 1'b0;
      assign count_cache_merges_o[u] = 1'b0;
      assign count_cache_misses_o[u] = 1'b0;
    end else begin : g_cache
      logic cache_idle;

      assign is_idle[u] = unit_idle & cache_idle;

      raypath_cache #(
        .Sets (CacheSets), .Ways (CacheWays), .Misses (CacheMisses), .LineBytes (CacheLineBytes),
        .BlockBytes (@BLOCK@), .DataWidth (DataWidth), .AddressWidth (AddressWidth),
        .Requesters (Contexts)
      ) u_cache (
        .clk_i, .rst_ni, .invalidate_i, .idle_o (cache_idle), .hits_o (count_cache_hits_o[u]),
        .merges_o (count_cache_merges_o[u]), .misses_o (count_cache_misses_o[u]),
        .req_valid_i (req_valid), .req_addr_i (req_addr), .req_tag_i (req_tag),
        .req_ready_o (req_ready), .rsp_valid_o (rsp_valid), .rsp_tag_o (rsp_tag),
        .rsp_error_o (rsp_error), .rsp_data_o (rsp_data),
        .mem_req_ready_i (mem_req_ready_i & requests[u]), .mem_req_valid_o (has_request[u]),
        .mem_req_addr_o (addresses[$unsigned(u)*AddressWidth+:AddressWidth]),
        .mem_req_tag_o (tags[$unsigned(u)*LowerWidth+:LowerWidth]), .mem_rsp_valid_i (is_of_unit),
        .mem_rsp_tag_i (mem_rsp_tag_i[LowerWidth-1:0]), .mem_rsp_error_i,
        .mem_rsp_data_i
      );
    end
  end

  // ---- Requests of the memory ---------------------------------------------------------
  raypath_arbiter #(.Inputs (Units)) u_requests (
    .clk_i, .rst_ni, .valid_i (has_request), .ready_i (mem_req_ready_i), .grant_o (requests)
  );

  assign mem_req_valid_o = (requests != '0);
  assign mem_rsp_ready_o = 1'b1;

  always_comb begin
    mem_req_addr_o = '0;
    mem_req_tag_o  = '0;
    for (int unsigned u = 0; u < Units; u++) begin
      if (requests[u]) begin
        mem_req_addr_o = addresses[u*AddressWidth+:AddressWidth];
        mem_req_tag_o  = TagWidth'((u << LowerWidth) | 32'(tags[u*LowerWidth+:LowerWidth]));
      end
    end
  end

  if (CacheSets == 0) begin : g_no_cache
    logic unused_invalidate;
    assign unused_invalidate = invalidate_i;
  end

  // ---- Hits ------------------------------------------------------------------------------
  raypath_arbiter #(.Inputs (Units)) u_hits (
    .clk_i, .rst_ni, .valid_i (has_hit), .ready_i (hit_ready_i), .grant_o (shows)
  );

  logic [HitWidth-1:0]     hit;

  always_comb begin
    hit = '0;
    for (int unsigned u = 0; u < Units; u++) begin
      if (shows[u]) hit = hits[u*HitWidth+:HitWidth];
    end
  end

  assign hit_valid_o = (shows != '0);
  assign {
    @HIT_PORTS@
  } = hit;
@c
@c  // ---- Candidates and verdicts -----------------------------------------------------------
@c  raypath_arbiter #(.Inputs (Units)) u_candidates (
@c    .clk_i, .rst_ni, .valid_i (has_candidate), .ready_i (cand_ready_i), .grant_o (asks)
@c  );
@c
@c  logic [CandWidth-1:0]    candidate;
@c  logic [ContextWidth-1:0] candidate_context;
@c
@c  always_comb begin
@c    candidate = '0;
@c    for (int unsigned u = 0; u < Units; u++) begin
@c      if (asks[u]) candidate = candidates[u*CandWidth+:CandWidth];
@c    end
@c  end
@c
@c  always_comb begin
@c    cand_tag_o = '0;
@c    for (int unsigned u = 0; u < Units; u++) begin
@c      if (asks[u]) cand_tag_o = CandTagWidth'((u << ContextWidth) | 32'(candidate_context));
@c    end
@c  end
@c
@c  assign cand_valid_o   = (asks != '0);
@c  assign answer_ready_o = 1'b1;
@c  assign {
@c    @CAND_PORTS@
@c  } = candidate;

endmodule : raypath_cluster
