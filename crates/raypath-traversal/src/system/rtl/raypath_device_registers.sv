module raypath_device_registers #(
  parameter logic [31:0] Units = 1
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  output logic             irq_o,
  // AXI4-Lite, by the names of its specification.
  input  logic             s_axi_awvalid,
  output logic             s_axi_awready,
  input  logic [11:0]      s_axi_awaddr,
  input  logic [2:0]       s_axi_awprot,
  input  logic             s_axi_wvalid,
  output logic             s_axi_wready,
  input  logic [31:0]      s_axi_wdata,
  input  logic [3:0]       s_axi_wstrb,
  output logic             s_axi_bvalid,
  input  logic             s_axi_bready,
  output logic [1:0]       s_axi_bresp,
  input  logic             s_axi_arvalid,
  output logic             s_axi_arready,
  input  logic [11:0]      s_axi_araddr,
  input  logic [2:0]       s_axi_arprot,
  output logic             s_axi_rvalid,
  input  logic             s_axi_rready,
  output logic [31:0]      s_axi_rdata,
  output logic [1:0]       s_axi_rresp,
  // Settings, and pulses of a cycle.
  output logic             control_enable_o,
  output logic [31:0]      node_limit_o,
  output logic [31:0]      timeout_o,
  output logic [63:0]      scene_base_o,
  output logic [63:0]      scene_end_o,
  output logic [63:0]      ray_base_o,
  output logic [31:0]      ray_size_o,
  output logic [31:0]      ray_tail_o,
  output logic [63:0]      hit_base_o,
  output logic [31:0]      hit_size_o,
  output logic [31:0]      hit_head_o,
  output logic [31:0]      interrupt_hits_o,
  output logic             control_flush_o,
  output logic             control_invalidate_o,
  output logic             control_clear_error_o,
  // What registers show.
  input  logic [7:0]       config_units_i,
  input  logic [8:0]       config_contexts_i,
  input  logic [1:0]       config_node_i,
  input  logic             config_flags_i,
  input  logic             config_candidates_i,
  input  logic             config_instances_i,
  input  logic             config_nested_instances_i,
  input  logic [5:0]       config_address_bits_i,
  input  logic [31:0]      memory_bytes_i,
  input  logic [31:0]      cache_bytes_i,
  input  logic             status_idle_i,
  input  logic             status_busy_i,
  input  logic             status_memory_timed_out_i,
  input  logic             status_ring_timed_out_i,
  input  logic [3:0]       status_error_i,
  input  logic [31:0]      ray_head_i,
  input  logic [31:0]      hit_tail_i,
  // The rise of a level sets its bit of interrupt_status.
  input  logic             interrupt_status_hits_i,
  input  logic             interrupt_status_error_i,
  input  logic             interrupt_status_drained_i,
  // Events that are counted; those of units have a bit for each unit.
  input  logic             count_cycles_i,
  input  logic [Units-1:0] count_boxes_i,
  input  logic [Units-1:0] count_triangles_i,
  input  logic [Units-1:0] count_transforms_i,
  input  logic [Units-1:0] count_steps_i,
  input  logic [Units-1:0] count_fetches_i,
  input  logic [Units-1:0] count_rays_i,
  input  logic [Units-1:0] count_restarts_i,
  input  logic [Units-1:0] count_job_stalls_i,
  input  logic [Units-1:0] count_candidates_i,
  input  logic [Units-1:0] count_cache_hits_i,
  input  logic [Units-1:0] count_cache_merges_i,
  input  logic [Units-1:0] count_cache_misses_i
);

  // The number of each register: its offset without the low two bits.
  localparam logic [9:0] WordId              = 10'h000;
  localparam logic [9:0] WordVersion         = 10'h001;
  localparam logic [9:0] WordConfig          = 10'h002;
  localparam logic [9:0] WordMemoryBytes     = 10'h003;
  localparam logic [9:0] WordCacheBytes      = 10'h004;
  localparam logic [9:0] WordControl         = 10'h005;
  localparam logic [9:0] WordStatus          = 10'h006;
  localparam logic [9:0] WordNodeLimit       = 10'h007;
  localparam logic [9:0] WordTimeout         = 10'h008;
  localparam logic [9:0] WordSceneBaseLow    = 10'h00a;
  localparam logic [9:0] WordSceneBaseHigh   = 10'h00b;
  localparam logic [9:0] WordSceneEndLow     = 10'h00c;
  localparam logic [9:0] WordSceneEndHigh    = 10'h00d;
  localparam logic [9:0] WordRayBaseLow      = 10'h010;
  localparam logic [9:0] WordRayBaseHigh     = 10'h011;
  localparam logic [9:0] WordRaySize         = 10'h012;
  localparam logic [9:0] WordRayTail         = 10'h013;
  localparam logic [9:0] WordRayHead         = 10'h014;
  localparam logic [9:0] WordHitBaseLow      = 10'h018;
  localparam logic [9:0] WordHitBaseHigh     = 10'h019;
  localparam logic [9:0] WordHitSize         = 10'h01a;
  localparam logic [9:0] WordHitHead         = 10'h01b;
  localparam logic [9:0] WordHitTail         = 10'h01c;
  localparam logic [9:0] WordInterruptStatus = 10'h020;
  localparam logic [9:0] WordInterruptEnable = 10'h021;
  localparam logic [9:0] WordInterruptHits   = 10'h022;
  localparam logic [9:0] WordCyclesLow       = 10'h040;
  localparam logic [9:0] WordCyclesHigh      = 10'h041;
  localparam logic [9:0] WordBoxesLow        = 10'h042;
  localparam logic [9:0] WordBoxesHigh       = 10'h043;
  localparam logic [9:0] WordTrianglesLow    = 10'h044;
  localparam logic [9:0] WordTrianglesHigh   = 10'h045;
  localparam logic [9:0] WordTransformsLow   = 10'h046;
  localparam logic [9:0] WordTransformsHigh  = 10'h047;
  localparam logic [9:0] WordStepsLow        = 10'h048;
  localparam logic [9:0] WordStepsHigh       = 10'h049;
  localparam logic [9:0] WordFetchesLow      = 10'h04a;
  localparam logic [9:0] WordFetchesHigh     = 10'h04b;
  localparam logic [9:0] WordRaysLow         = 10'h04c;
  localparam logic [9:0] WordRaysHigh        = 10'h04d;
  localparam logic [9:0] WordRestartsLow     = 10'h04e;
  localparam logic [9:0] WordRestartsHigh    = 10'h04f;
  localparam logic [9:0] WordJobStallsLow    = 10'h050;
  localparam logic [9:0] WordJobStallsHigh   = 10'h051;
  localparam logic [9:0] WordCandidatesLow   = 10'h052;
  localparam logic [9:0] WordCandidatesHigh  = 10'h053;
  localparam logic [9:0] WordCacheHitsLow    = 10'h054;
  localparam logic [9:0] WordCacheHitsHigh   = 10'h055;
  localparam logic [9:0] WordCacheMergesLow  = 10'h056;
  localparam logic [9:0] WordCacheMergesHigh = 10'h057;
  localparam logic [9:0] WordCacheMissesLow  = 10'h058;
  localparam logic [9:0] WordCacheMissesHigh = 10'h059;

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
  logic        control_q;
  logic [31:0] node_limit_q;
  logic [31:0] timeout_q;
  logic [31:6] scene_base_low_q;
  logic [31:0] scene_base_high_q;
  logic [31:6] scene_end_low_q;
  logic [31:0] scene_end_high_q;
  logic [31:6] ray_base_low_q;
  logic [31:0] ray_base_high_q;
  logic [31:0] ray_size_q;
  logic [31:0] ray_tail_q;
  logic [31:6] hit_base_low_q;
  logic [31:0] hit_base_high_q;
  logic [31:0] hit_size_q;
  logic [31:0] hit_head_q;
  logic [2:0]  interrupt_enable_q;
  logic [31:0] interrupt_hits_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      control_q          <= 1'h0;
      node_limit_q       <= 32'h1000000;
      timeout_q          <= 32'h0;
      scene_base_low_q   <= 26'h0;
      scene_base_high_q  <= 32'h0;
      scene_end_low_q    <= 26'h0;
      scene_end_high_q   <= 32'h0;
      ray_base_low_q     <= 26'h0;
      ray_base_high_q    <= 32'h0;
      ray_size_q         <= 32'h0;
      ray_tail_q         <= 32'h0;
      hit_base_low_q     <= 26'h0;
      hit_base_high_q    <= 32'h0;
      hit_size_q         <= 32'h0;
      hit_head_q         <= 32'h0;
      interrupt_enable_q <= 3'h0;
      interrupt_hits_q   <= 32'h1;
    end else if (writes) begin
      case (aw_word_q)
        WordControl:         control_q <= (control_q & ~mask[0]) | data[0];
        WordNodeLimit:       node_limit_q <= (node_limit_q & ~mask) | data;
        WordTimeout:         timeout_q <= (timeout_q & ~mask) | data;
        WordSceneBaseLow:    scene_base_low_q <= (scene_base_low_q & ~mask[31:6]) | data[31:6];
        WordSceneBaseHigh:   scene_base_high_q <= (scene_base_high_q & ~mask) | data;
        WordSceneEndLow:     scene_end_low_q <= (scene_end_low_q & ~mask[31:6]) | data[31:6];
        WordSceneEndHigh:    scene_end_high_q <= (scene_end_high_q & ~mask) | data;
        WordRayBaseLow:      ray_base_low_q <= (ray_base_low_q & ~mask[31:6]) | data[31:6];
        WordRayBaseHigh:     ray_base_high_q <= (ray_base_high_q & ~mask) | data;
        WordRaySize:         ray_size_q <= (ray_size_q & ~mask) | data;
        WordRayTail:         ray_tail_q <= (ray_tail_q & ~mask) | data;
        WordHitBaseLow:      hit_base_low_q <= (hit_base_low_q & ~mask[31:6]) | data[31:6];
        WordHitBaseHigh:     hit_base_high_q <= (hit_base_high_q & ~mask) | data;
        WordHitSize:         hit_size_q <= (hit_size_q & ~mask) | data;
        WordHitHead:         hit_head_q <= (hit_head_q & ~mask) | data;
        WordInterruptEnable: interrupt_enable_q <= (interrupt_enable_q & ~mask[2:0]) | data[2:0];
        WordInterruptHits:   interrupt_hits_q <= (interrupt_hits_q & ~mask) | data;
        default: ;
      endcase
    end
  end

  logic control_flush_q;
  logic control_invalidate_q;
  logic control_clear_error_q;
  logic control_clear_counts_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      control_flush_q        <= 1'b0;
      control_invalidate_q   <= 1'b0;
      control_clear_error_q  <= 1'b0;
      control_clear_counts_q <= 1'b0;
    end else begin
      control_flush_q        <= writes & (aw_word_q == WordControl) & data[1];
      control_invalidate_q   <= writes & (aw_word_q == WordControl) & data[2];
      control_clear_error_q  <= writes & (aw_word_q == WordControl) & data[3];
      control_clear_counts_q <= writes & (aw_word_q == WordControl) & data[4];
    end
  end

  assign control_enable_o      = control_q;
  assign node_limit_o          = node_limit_q;
  assign timeout_o             = timeout_q;
  assign scene_base_o          = {scene_base_high_q, scene_base_low_q, 6'd0};
  assign scene_end_o           = {scene_end_high_q, scene_end_low_q, 6'd0};
  assign ray_base_o            = {ray_base_high_q, ray_base_low_q, 6'd0};
  assign ray_size_o            = ray_size_q;
  assign ray_tail_o            = ray_tail_q;
  assign hit_base_o            = {hit_base_high_q, hit_base_low_q, 6'd0};
  assign hit_size_o            = hit_size_q;
  assign hit_head_o            = hit_head_q;
  assign interrupt_hits_o      = interrupt_hits_q;
  assign control_flush_o       = control_flush_q;
  assign control_invalidate_o  = control_invalidate_q;
  assign control_clear_error_o = control_clear_error_q;

  // ---- Interrupts -----------------------------------------------------------------
  // An event is not lost if it comes while its bit is cleared.
  logic [2:0] levels;
  logic [2:0] levels_q;
  logic [2:0] cleared;
  logic [2:0] interrupt_status_q;

  assign levels  = {interrupt_status_drained_i, interrupt_status_error_i, interrupt_status_hits_i};
  assign cleared = (writes && aw_word_q == WordInterruptStatus) ? data[2:0] : '0;
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
  localparam logic [31:0] Counters = 12;

  logic [Counters*Units-1:0] events;
  logic [Counters*64-1:0]    counts;
  logic [63:0]               cycles;
  logic [63:0]               boxes;
  logic [63:0]               triangles;
  logic [63:0]               transforms;
  logic [63:0]               steps;
  logic [63:0]               fetches;
  logic [63:0]               rays;
  logic [63:0]               restarts;
  logic [63:0]               job_stalls;
  logic [63:0]               candidates;
  logic [63:0]               cache_hits;
  logic [63:0]               cache_merges;
  logic [63:0]               cache_misses;

  assign events = {
    count_cache_misses_i,
    count_cache_merges_i,
    count_cache_hits_i,
    count_candidates_i,
    count_job_stalls_i,
    count_restarts_i,
    count_rays_i,
    count_fetches_i,
    count_steps_i,
    count_transforms_i,
    count_triangles_i,
    count_boxes_i
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

  assign boxes        = counts[0*64+:64];
  assign triangles    = counts[1*64+:64];
  assign transforms   = counts[2*64+:64];
  assign steps        = counts[3*64+:64];
  assign fetches      = counts[4*64+:64];
  assign rays         = counts[5*64+:64];
  assign restarts     = counts[6*64+:64];
  assign job_stalls   = counts[7*64+:64];
  assign candidates   = counts[8*64+:64];
  assign cache_hits   = counts[9*64+:64];
  assign cache_merges = counts[10*64+:64];
  assign cache_misses = counts[11*64+:64];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) cycles <= '0;
    else cycles <= control_clear_counts_q ? '0 : cycles + 64'(count_cycles_i);
  end

  // ---- What is read ---------------------------------------------------------------
  always_comb begin
    case (ar_word_q)
      WordId:              read_data = 32'h52415950;
      WordVersion:         read_data = {16'h1, 16'h0};
      WordConfig:          read_data = {2'd0, config_address_bits_i, config_nested_instances_i,
                                        config_instances_i, config_candidates_i, config_flags_i,
                                        1'd0, config_node_i, config_contexts_i, config_units_i};
      WordMemoryBytes:     read_data = memory_bytes_i;
      WordCacheBytes:      read_data = cache_bytes_i;
      WordControl:         read_data = {31'd0, control_q};
      WordStatus:          read_data = {20'd0, status_error_i, 4'd0, status_ring_timed_out_i,
                                        status_memory_timed_out_i, status_busy_i, status_idle_i};
      WordNodeLimit:       read_data = node_limit_q;
      WordTimeout:         read_data = timeout_q;
      WordSceneBaseLow:    read_data = {scene_base_low_q, 6'd0};
      WordSceneBaseHigh:   read_data = scene_base_high_q;
      WordSceneEndLow:     read_data = {scene_end_low_q, 6'd0};
      WordSceneEndHigh:    read_data = scene_end_high_q;
      WordRayBaseLow:      read_data = {ray_base_low_q, 6'd0};
      WordRayBaseHigh:     read_data = ray_base_high_q;
      WordRaySize:         read_data = ray_size_q;
      WordRayTail:         read_data = ray_tail_q;
      WordRayHead:         read_data = ray_head_i;
      WordHitBaseLow:      read_data = {hit_base_low_q, 6'd0};
      WordHitBaseHigh:     read_data = hit_base_high_q;
      WordHitSize:         read_data = hit_size_q;
      WordHitHead:         read_data = hit_head_q;
      WordHitTail:         read_data = hit_tail_i;
      WordInterruptStatus: read_data = {29'd0, interrupt_status_q};
      WordInterruptEnable: read_data = {29'd0, interrupt_enable_q};
      WordInterruptHits:   read_data = interrupt_hits_q;
      WordCyclesLow:       read_data = cycles[31:0];
      WordCyclesHigh:      read_data = cycles[63:32];
      WordBoxesLow:        read_data = boxes[31:0];
      WordBoxesHigh:       read_data = boxes[63:32];
      WordTrianglesLow:    read_data = triangles[31:0];
      WordTrianglesHigh:   read_data = triangles[63:32];
      WordTransformsLow:   read_data = transforms[31:0];
      WordTransformsHigh:  read_data = transforms[63:32];
      WordStepsLow:        read_data = steps[31:0];
      WordStepsHigh:       read_data = steps[63:32];
      WordFetchesLow:      read_data = fetches[31:0];
      WordFetchesHigh:     read_data = fetches[63:32];
      WordRaysLow:         read_data = rays[31:0];
      WordRaysHigh:        read_data = rays[63:32];
      WordRestartsLow:     read_data = restarts[31:0];
      WordRestartsHigh:    read_data = restarts[63:32];
      WordJobStallsLow:    read_data = job_stalls[31:0];
      WordJobStallsHigh:   read_data = job_stalls[63:32];
      WordCandidatesLow:   read_data = candidates[31:0];
      WordCandidatesHigh:  read_data = candidates[63:32];
      WordCacheHitsLow:    read_data = cache_hits[31:0];
      WordCacheHitsHigh:   read_data = cache_hits[63:32];
      WordCacheMergesLow:  read_data = cache_merges[31:0];
      WordCacheMergesHigh: read_data = cache_merges[63:32];
      WordCacheMissesLow:  read_data = cache_misses[31:0];
      WordCacheMissesHigh: read_data = cache_misses[63:32];
      default:             read_data = '0;
    endcase
  end

endmodule : raypath_device_registers
