module raypath_rings #(
  parameter  logic [31:0] AddressWidth = 32,
  parameter  logic [31:0] DataWidth    = 512,
  // The index of the first record after the engine was disabled.
  parameter  logic [31:0] FirstIndex   = 0,
  localparam logic [31:0] Bytes        = DataWidth / 8
) (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  // Settings of the registers. They may change at any time.
  input  logic                    enable_i,
  input  logic                    flush_i,
  input  logic                    clear_error_i,
  // The cycles in which the memory may answer no read, or no write, while it owes one; 0 for any
  // number.
  input  logic [31:0]             timeout_i,
  input  logic [63:0]             ray_base_i,
  input  logic [31:0]             ray_size_i,
  input  logic [31:0]             ray_tail_i,
  input  logic [63:0]             hit_base_i,
  input  logic [31:0]             hit_size_i,
  input  logic [31:0]             hit_head_i,
  // Status for the registers.
  output logic [31:0]             ray_head_o,
  output logic [31:0]             hit_tail_o,
  output logic                    idle_o,
  output logic [3:0]              error_o,
  output logic                    timed_out_o,
  output logic                    drained_o,
  // Rays to the cluster, and its hits in any order. It is idle until the edge at which it takes a
  // ray, and again when its last hit is taken or dropped. A flush withdraws a ray that it has not
  // taken.
  input  logic                    cluster_idle_i,
  output logic                    ray_valid_o,
  input  logic                    ray_ready_i,
  output logic [511:0]            ray_record_o,
  input  logic                    hit_valid_i,
  output logic                    hit_ready_o,
  input  logic [511:0]            hit_record_i,
  // Reads of records, and their beats in the same order; a beat is always taken.
  output logic                    read_valid_o,
  input  logic                    read_ready_i,
  output logic [AddressWidth-1:0] read_addr_o,
  input  logic                    data_valid_i,
  input  logic                    data_error_i,
  input  logic [DataWidth-1:0]    data_i,
  // Writes of records.
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
  input  logic [1:0]              m_axi_bresp
);

  localparam logic [31:0] Beats     = (DataWidth > 512) ? 1 : 512 / DataWidth;
  localparam logic [31:0] BeatWidth = (Beats == 1) ? 1 : $clog2(Beats);
  // Bits of the number of a record's place.
  localparam logic [31:0] PlaceWidth = AddressWidth - 6;
  localparam logic [58:0] Places     = 59'd1 << PlaceWidth;
  // Records that are read or wait for the cluster, and records whose write is not answered.
  localparam logic [2:0]  Reads      = 4;
  localparam logic [2:0]  Writes     = 4;
  localparam logic [31:0] MaxSize    = 20;
  // Rays in the cluster are fewer than 2^CountWidth.
  localparam logic [31:0] CountWidth = 20;

  localparam logic [BeatWidth-1:0] OneBeat = 1;

  if (AddressWidth < 32 || AddressWidth > 64) begin : g_address
    $error("AddressWidth is %0d, expected 32 to 64", AddressWidth);
  end
  if (DataWidth != 128 && DataWidth != 256 && DataWidth != 512 && DataWidth != 1024) begin : g_data
    $error("DataWidth is %0d, expected 128, 256, 512 or 1024", DataWidth);
  end

  typedef enum logic [3:0] {
    ErrorNone, ErrorRays, ErrorHits, ErrorRegion, ErrorRead, ErrorWrite,
    ErrorTimeout = 4'd7
  } error_t;

  // ---- The rings ----------------------------------------------------------------
  // Record k is at place k modulo the size of its ring. Indices run freely, so their difference is
  // the number of records in between, and a full ring is not an empty one.
  //
  //   rays:  ray_head ... records that are read ... ray_tail
  //   hits:  hit_head ... records in memory ... hit_tail ... records that are written
  logic [31:0] ray_head_q;
  logic [31:0] hit_tail_q;
  logic [2:0]  reading_q;
  logic [2:0]  writing_q;
  logic [20:0] ray_places;
  logic [20:0] hit_places;
  logic [31:0] rays_used;
  logic [31:0] hits_used;
  logic [58:0] ray_end;
  logic [58:0] hit_end;
  logic [19:0] ray_index;
  logic [19:0] hit_index;
  logic        rays_fit;
  logic        hits_fit;
  logic        rays_are_wrong;
  logic        hits_are_wrong;
  logic        has_ray;
  logic        has_room;

  logic unused_settings;
  assign unused_settings = ^{ray_base_i[5:0], hit_base_i[5:0], m_axi_bid};

  assign ray_places     = 21'd1 << ray_size_i[4:0];
  assign hit_places     = 21'd1 << hit_size_i[4:0];
  assign rays_used      = ray_tail_i - ray_head_q;
  assign hits_used      = hit_tail_q - hit_head_i;
  assign ray_end        = {1'b0, ray_base_i[63:6]} + 59'(ray_places);
  assign hit_end        = {1'b0, hit_base_i[63:6]} + 59'(hit_places);
  assign rays_fit       = (ray_end <= Places);
  assign hits_fit       = (hit_end <= Places);
  assign rays_are_wrong = (ray_size_i > MaxSize) | (rays_used > 32'(ray_places));
  assign hits_are_wrong = (hit_size_i > MaxSize) | (hits_used > 32'(hit_places));
  assign ray_index      = (ray_head_q[19:0] + 20'(reading_q)) & 20'(ray_places - 21'd1);
  assign hit_index      = (hit_tail_q[19:0] + 20'(writing_q)) & 20'(hit_places - 21'd1);
  // Software may move its indices back, so that more is under way than they allow.
  assign has_ray        = ~rays_are_wrong & rays_fit & (rays_used > 32'(reading_q));
  assign has_room       = ~hits_are_wrong & hits_fit
                        & (33'(hits_used) + 33'(writing_q) < 33'(hit_places));

  // ---- The time of the memory -----------------------------------------------------
  // After a timeout, late records are dropped, until the engine is disabled and idle.
  logic [1:0] waits;
  logic [1:0] times_out;
  logic       is_late;
  logic       late_q;
  logic       starts;

  assign is_late = late_q | (|times_out);
  assign waits   = {(writing_q != 3'd0) & ~m_axi_bvalid, (reading_q != 3'd0) & ~data_valid_i};

  for (genvar k = 0; k < 2; k++) begin : g_times
    logic [31:0] waited_q;
    assign times_out[k] = waits[k] & ~late_q & (timeout_i != 32'd0) & (waited_q >= timeout_i);
    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) waited_q <= '0;
      else waited_q <= (waits[k] & ~late_q) ? waited_q + 32'd1 : '0;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) late_q <= 1'b0;
    else late_q <= ~starts & is_late;
  end

  // ---- Errors -------------------------------------------------------------------
  // The first error stays. Hits are dropped after an error of their ring, until the engine is
  // disabled and idle: the places of later ones are not known.
  error_t error_q;
  logic   drops_q;
  logic   flushes_q;
  logic   read_fails;
  logic   write_fails;
  logic   hits_fail;

  assign starts    = ~enable_i & idle_o;
  assign hits_fail = (enable_i | ~idle_o) & (hits_are_wrong | ~hits_fit);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      error_q <= ErrorNone;
      drops_q <= 1'b0;
    end else begin
      drops_q <= ~starts & (drops_q | hits_fail | write_fails | times_out[1]);
      if (error_q != ErrorNone) begin
        if (clear_error_i && !enable_i && !is_late) error_q <= ErrorNone;
      end else if (|times_out) begin
        error_q <= ErrorTimeout;
      end else if (write_fails) begin
        error_q <= ErrorWrite;
      end else if (read_fails) begin
        error_q <= ErrorRead;
      end else if (enable_i && rays_are_wrong) begin
        error_q <= ErrorRays;
      end else if (hits_fail && hits_are_wrong) begin
        error_q <= ErrorHits;
      end else if (hits_fail || (enable_i && !rays_fit)) begin
        error_q <= ErrorRegion;
      end
    end
  end

  // ---- Records of rays are read ---------------------------------------------------
  logic                  fetches;
  logic                  request_valid_q;
  logic [PlaceWidth-1:0] request_place_q;
  logic [2:0]            held_q;
  logic                  record_ends;
  logic                  record_fails;
  logic [511:0]          record;
  logic                  pushes;
  logic                  pops;
  logic                  queue_valid;

  assign fetches = enable_i & (error_q == ErrorNone) & ~flush_i & ~flushes_q & has_ray
                 & (held_q < Reads) & (~request_valid_q | read_ready_i);

  assign read_valid_o = request_valid_q;
  assign read_addr_o  = {request_place_q, 6'd0};
  assign read_fails   = record_ends & (record_fails | late_q);
  assign pushes       = record_ends & ~read_fails;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      request_valid_q <= 1'b0;
      ray_head_q      <= FirstIndex;
      reading_q       <= '0;
      held_q          <= '0;
    end else begin
      request_valid_q <= fetches | (request_valid_q & ~read_ready_i);
      ray_head_q      <= starts ? FirstIndex : ray_head_q + 32'(record_ends);
      reading_q       <= reading_q + 3'(fetches) - 3'(record_ends);
      held_q          <= held_q + 3'(fetches) - 3'(read_fails) - 3'(pops);
    end
  end

  always_ff @(posedge clk_i) begin
    if (fetches) request_place_q <= ray_base_i[AddressWidth-1:6] + PlaceWidth'(ray_index);
  end

  if (Beats == 1) begin : g_one_beat
    assign record_ends  = data_valid_i;
    assign record_fails = data_error_i;
  end else begin : g_beats
    logic [BeatWidth-1:0]   beat_q;
    logic                   error_before_q;
    logic [511-DataWidth:0] before_q;

    assign record_ends  = data_valid_i & (beat_q == BeatWidth'(Beats - 1));
    assign record_fails = data_error_i | error_before_q;
    assign record       = {data_i, before_q};

    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) begin
        beat_q         <= '0;
        error_before_q <= 1'b0;
      end else if (data_valid_i) begin
        beat_q         <= beat_q + OneBeat;
        error_before_q <= ~record_ends & record_fails;
      end
    end

    always_ff @(posedge clk_i) begin
      if (data_valid_i) before_q <= record[511:DataWidth];
    end
  end

  if (DataWidth == 512) begin : g_record
    assign record = data_i;
  end else if (DataWidth == 1024) begin : g_half
    // The halves in which the records under way are, the first one lowest.
    logic [3:0] is_high_q;
    logic [3:0] is_high;
    assign is_high = is_high_q >> record_ends;
    always_ff @(posedge clk_i) begin
      is_high_q <= is_high;
      if (fetches) is_high_q[2'(reading_q - 3'(record_ends))] <= ray_base_i[6] ^ ray_index[0];
    end
    assign record = is_high_q[0] ? data_i[DataWidth-1-:512] : data_i[511:0];
  end

  raypath_queue #(.Depth (32'(Reads)), .Width (512)) u_records (
    .clk_i, .rst_ni, .push_i (pushes), .data_i (record), .pop_i (pops), .valid_o (queue_valid),
    .data_o (ray_record_o)
  );

  // ---- Rays in the cluster --------------------------------------------------------
  // A flush lasts until no record is left and the cluster is idle; hits are dropped meanwhile.
  logic [CountWidth-1:0] inside_q;
  logic                  flush_ends;
  logic                  sends;
  logic                  takes_hit;

  assign ray_valid_o = queue_valid & ~flush_i & ~flushes_q;
  assign pops        = queue_valid & (ray_ready_i | flush_i | flushes_q);
  assign flush_ends  = flushes_q & (held_q == 3'd0) & cluster_idle_i;
  assign sends       = ray_valid_o & ray_ready_i;
  assign takes_hit   = hit_valid_i & hit_ready_o;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      inside_q  <= '0;
      flushes_q <= 1'b0;
    end else begin
      inside_q  <= flush_ends ? '0 : inside_q + CountWidth'(sends) - CountWidth'(takes_hit);
      flushes_q <= flush_i | (flushes_q & ~flush_ends);
    end
  end

  // ---- Records of hits are written ------------------------------------------------
  // A hit is taken when its place is free, so a record in these registers is always written. After
  // a failure, later records are not announced: the one before them is missing.
  logic                  stores;
  logic                  aw_valid_q;
  logic [PlaceWidth-1:0] aw_place_q;
  logic                  w_valid_q;
  logic [511:0]          w_record_q;
  logic                  w_is_last;
  logic                  w_ends;
  logic                  announces;

  assign w_ends      = w_valid_q & w_is_last & m_axi_wready;
  assign stores      = hit_valid_i & ~drops_q & ~flushes_q & has_room & (writing_q < Writes)
                     & (~aw_valid_q | m_axi_awready) & (~w_valid_q | w_ends);
  assign hit_ready_o = stores | drops_q | flushes_q;
  assign announces   = m_axi_bvalid & ~write_fails & ~drops_q;
  assign write_fails = m_axi_bvalid & (m_axi_bresp != 2'b00);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      aw_valid_q <= 1'b0;
      w_valid_q  <= 1'b0;
      hit_tail_q <= FirstIndex;
      writing_q  <= '0;
    end else begin
      aw_valid_q <= stores | (aw_valid_q & ~m_axi_awready);
      w_valid_q  <= stores | (w_valid_q & ~w_ends);
      hit_tail_q <= starts ? FirstIndex : hit_tail_q + 32'(announces);
      writing_q  <= writing_q + 3'(stores) - 3'(m_axi_bvalid);
    end
  end

  always_ff @(posedge clk_i) begin
    if (stores) aw_place_q <= hit_base_i[AddressWidth-1:6] + PlaceWidth'(hit_index);
  end

  if (Beats == 1) begin : g_one_write
    assign w_is_last = 1'b1;
    always_ff @(posedge clk_i) begin
      if (stores) w_record_q <= hit_record_i;
    end
  end else begin : g_writes
    logic [BeatWidth-1:0] w_beat_q;
    assign w_is_last = (w_beat_q == BeatWidth'(Beats - 1));
    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) w_beat_q <= '0;
      else if (w_valid_q && m_axi_wready) w_beat_q <= w_beat_q + OneBeat;
    end

    always_ff @(posedge clk_i) begin
      if (stores) w_record_q <= hit_record_i;
      else if (w_valid_q && m_axi_wready) w_record_q <= w_record_q >> DataWidth;
    end
  end

  if (DataWidth == 1024) begin : g_write_half
    logic w_is_high_q;
    assign m_axi_wdata = {w_record_q, w_record_q};
    assign m_axi_wstrb = {{64{w_is_high_q}}, {64{~w_is_high_q}}};
    always_ff @(posedge clk_i) begin
      if (stores) w_is_high_q <= hit_base_i[6] ^ hit_index[0];
    end
  end else begin : g_write
    assign m_axi_wdata = w_record_q[DataWidth-1:0];
    assign m_axi_wstrb = '1;
  end

  assign m_axi_awvalid = aw_valid_q;
  assign m_axi_awid    = 1'b0;
  assign m_axi_awaddr  = {aw_place_q, 6'd0};
  assign m_axi_awlen   = 8'(Beats - 1);
  assign m_axi_awsize  = (DataWidth > 512) ? 3'd6 : 3'($clog2(Bytes));
  assign m_axi_awburst = 2'b01;
  assign m_axi_wvalid  = w_valid_q;
  assign m_axi_wlast   = w_is_last;
  assign m_axi_bready  = 1'b1;

  assign ray_head_o  = ray_head_q;
  assign hit_tail_o  = hit_tail_q;
  assign error_o     = error_q;
  assign timed_out_o = late_q;
  assign idle_o      = (held_q == 3'd0) & (inside_q == '0) & (writing_q == 3'd0) & ~flushes_q;
  assign drained_o   = enable_i & idle_o & (rays_used == 32'd0);

endmodule : raypath_rings
