// The rings with any settings in each cycle, a memory that keeps to the rules of AXI4, and a cluster that returns as many
// hits as it has rays, or drops them in a flush.
module raypath_rings_properties #(
  parameter int D = 512,
  parameter int A = 32
) (
  input logic clk_i, rst_ni, enable_i, flush_i, clear_error_i, ray_ready_i, hit_valid_i, read_ready_i, data_valid_i,
  input logic data_error_i, m_axi_awready, m_axi_wready, m_axi_bvalid, drop_i,
  input logic [1:0] m_axi_bresp, limit_i,
  input logic [63:0] ray_base_i, hit_base_i,
  input logic [31:0] ray_size_i, ray_tail_i, hit_size_i, hit_head_i,
  input logic [511:0] hit_record_i,
  input logic [D-1:0] data_i
);
  localparam int BEATS = D > 512 ? 1 : 512 / D;
  wire [31:0] ray_head, hit_tail;
  wire idle, timed_out, drained, ray_valid, hit_ready, read_valid, awvalid, wvalid, wlast;
  wire [3:0] error;
  wire [511:0] ray_record;
  wire [A-1:0] read_addr, awaddr;
  wire [7:0] awlen;
  wire [2:0] awsize;
  wire [D-1:0] wdata;
  wire [D/8-1:0] wstrb;
  wire p_cluster_idle;
  raypath_rings #(.AddressWidth (A), .DataWidth (D)) u_rings (
    .clk_i, .rst_ni, .enable_i, .flush_i, .clear_error_i, .timeout_i ({30'd0, limit_i}), .timed_out_o (timed_out),
    .ray_base_i, .ray_size_i, .ray_tail_i, .hit_base_i, .hit_size_i, .hit_head_i, .ray_head_o (ray_head),
    .hit_tail_o (hit_tail), .idle_o (idle), .error_o (error),
    .drained_o (drained), .cluster_idle_i (p_cluster_idle), .ray_valid_o (ray_valid), .ray_ready_i,
    .ray_record_o (ray_record), .hit_valid_i, .hit_ready_o (hit_ready), .hit_record_i, .read_valid_o (read_valid),
    .read_ready_i, .read_addr_o (read_addr), .data_valid_i, .data_error_i, .data_i, .m_axi_awvalid (awvalid),
    .m_axi_awready, .m_axi_awaddr (awaddr), .m_axi_awlen (awlen), .m_axi_awsize (awsize), .m_axi_wvalid (wvalid),
    .m_axi_wready, .m_axi_wdata (wdata), .m_axi_wstrb (wstrb), .m_axi_wlast (wlast), .m_axi_bvalid, .m_axi_bid (1'b0),
    .m_axi_bresp
  );

  // Beats of reads that the memory owes, writes whose address and whose data it has, and hits that the cluster owes.
  logic [4:0] p_beats_q;
  logic [2:0] p_addresses_q, p_records_q;
  logic [3:0] p_beat_q;
  logic [2:0] p_inside_q;
  logic p_flushes_q;
  wire p_reads = read_valid && read_ready_i;
  wire p_sends = ray_valid && ray_ready_i;
  wire p_takes = hit_valid_i && hit_ready;
  assign p_cluster_idle = p_inside_q == 0;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_beats_q, p_addresses_q, p_records_q, p_beat_q, p_inside_q, p_flushes_q} <= 0;
    else begin
      p_beats_q <= p_beats_q + (p_reads ? BEATS : 0) - {4'd0, data_valid_i};
      p_addresses_q <= p_addresses_q + {2'd0, awvalid && m_axi_awready} - {2'd0, m_axi_bvalid};
      p_records_q <= p_records_q + {2'd0, wvalid && m_axi_wready && wlast} - {2'd0, m_axi_bvalid};
      if (wvalid && m_axi_wready) p_beat_q <= wlast ? 0 : p_beat_q + 1;
      p_flushes_q <= flush_i || (p_flushes_q && !p_cluster_idle);
      p_inside_q <= flush_i && drop_i ? 0 : p_inside_q + {2'd0, p_sends} - {2'd0, p_takes};
    end
  always_comb assume (!data_valid_i || p_beats_q != 0);
  always_comb assume (!m_axi_bvalid || (p_addresses_q != 0 && p_records_q != 0));
  always_comb assume (!hit_valid_i || p_inside_q != 0);
  always_comb assume (p_inside_q != 7 || !ray_ready_i);
  always_comb four: assert (p_beats_q <= 4 * BEATS && p_addresses_q <= 4 && p_records_q <= 4);
  always_comb burst: assert (!wvalid || wlast == (p_beat_q == BEATS - 1));

  // What is shown for the first time, and the records that are under way before the next cycle.
  logic p_read_stalls_q, p_write_stalls_q;
  logic [3:0] p_part_q;
  logic [31:0] p_reading_q, p_writing_q;
  wire p_is_read = read_valid && !p_read_stalls_q, p_is_write = awvalid && !p_write_stalls_q;
  wire p_record_ends = data_valid_i && p_part_q == BEATS - 1;
  wire [31:0] p_reading = p_reading_q + (p_is_read ? 1 : 0), p_writing = p_writing_q + (p_is_write ? 1 : 0);
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_read_stalls_q, p_write_stalls_q, p_part_q, p_reading_q, p_writing_q} <= 0;
    else begin
      {p_read_stalls_q, p_write_stalls_q} <= {read_valid && !read_ready_i, awvalid && !m_axi_awready};
      if (data_valid_i) p_part_q <= p_record_ends ? 0 : p_part_q + 1;
      p_reading_q <= p_reading - (p_record_ends ? 1 : 0);
      p_writing_q <= p_writing - (m_axi_bvalid ? 1 : 0);
    end

  // The cycle before, whose settings allow each read and write: of the next record, of those between head and tail or of
  // those with room, at its place in the ring, which is inside of the memory.
  logic p_enable_q, p_has_ray_q, p_has_room_q, p_runs_q;
  logic [64:0] p_ray_q, p_hit_q;
  logic [2*A-1:0] p_addr_q;
  wire [31:0] p_ray = ray_head + p_reading, p_hit = hit_tail + p_writing;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_runs_q <= 0;
    else p_runs_q <= 1;
  always_ff @(posedge clk_i) begin
    p_enable_q <= enable_i;
    p_has_ray_q <= ray_size_i <= 20 && ray_tail_i - ray_head <= 1 << ray_size_i && ray_tail_i - ray_head > p_reading;
    p_has_room_q <= hit_size_i <= 20 && hit_tail - hit_head_i <= 1 << hit_size_i
      && {1'b0, hit_tail - hit_head_i} + p_writing < 1 << hit_size_i;
    p_ray_q <= {1'b0, ray_base_i & ~64'd63} + {27'd0, p_ray & ((1 << ray_size_i[4:0]) - 1), 6'd0};
    p_hit_q <= {1'b0, hit_base_i & ~64'd63} + {27'd0, p_hit & ((1 << hit_size_i[4:0]) - 1), 6'd0};
    p_addr_q <= {read_addr, awaddr};
  end
  always_comb read_allowed: assert (!p_is_read || (p_enable_q && p_has_ray_q));
  always_comb write_allowed: assert (!p_is_write || p_has_room_q);
  always_comb read_inside: assert (!p_is_read || p_ray_q == read_addr);
  always_comb write_inside: assert (!p_is_write || p_hit_q == awaddr);
  always_comb read_stays: assert (!p_read_stalls_q || (read_valid && read_addr == p_addr_q[2*A-1:A]));
  always_comb write_stays: assert (!p_write_stalls_q || (awvalid && awaddr == p_addr_q[A-1:0]));

  // A record is written once and whole.
  logic [511:0] p_record_q;
  logic p_half_q, p_w_stalls_q;
  always_ff @(posedge clk_i) begin
    if (p_takes && (!wvalid || (m_axi_wready && wlast))) p_record_q <= hit_record_i;
    if (p_is_write) p_half_q <= awaddr[6];
  end
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_w_stalls_q <= 0;
    else p_w_stalls_q <= wvalid && !(m_axi_wready && wlast);
  wire p_half = p_is_write ? awaddr[6] : p_half_q;
  wire [1023:0] p_data = D > 512 ? {p_record_q, p_record_q} : p_record_q >> p_beat_q * D;
  always_comb own_data: assert (!wvalid || wdata == p_data[D-1:0]);
  always_comb own_half: assert (!wvalid || wstrb == (D > 512 ? {{64{p_half}}, {64{!p_half}}} : {(D / 8){1'b1}}));
  always_comb each_once: assert (wvalid == (p_is_write || p_w_stalls_q));

  // The cycles without an answer to a read, and to a write, that is owed.
  logic [31:0] p_silent_q [2];
  logic [1:0] p_expires;
  logic p_late_q;
  for (genvar k = 0; k < 2; k++) begin : g_silence
    wire p_is_silent = !timed_out && (k ? p_writing != 0 && !m_axi_bvalid : p_reading != 0 && !data_valid_i);
    always_ff @(posedge clk_i or negedge rst_ni)
      if (!rst_ni) p_silent_q[k] <= 0;
      else p_silent_q[k] <= p_is_silent ? p_silent_q[k] + 1 : 0;
    assign p_expires[k] = p_is_silent && limit_i != 0 && p_silent_q[k] >= limit_i;
  end
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_late_q <= 0;
    else p_late_q <= !(!enable_i && idle) && (timed_out || p_expires != 0);
  always_comb in_time: assert (timed_out == p_late_q && (!timed_out || error != 0));

  // Rays are records that arrived in time and without an error.
  logic [2:0] p_due_q;
  logic p_bad_q;
  wire p_is_bad = data_error_i || p_bad_q;
  wire p_is_due = p_record_ends && !p_is_bad && !timed_out;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_due_q, p_bad_q} <= 0;
    else begin
      p_due_q <= p_due_q + {2'd0, p_is_due && (p_due_q != 7 || p_sends)} - {2'd0, p_sends};
      if (data_valid_i) p_bad_q <= p_is_bad && !p_record_ends;
    end
  always_comb own_ray: assert (!ray_valid || p_due_q != 0);

  // Indices move by a record that was read, and by one that is in memory and none before it failed.
  logic [31:0] p_head_q, p_tail_q;
  logic p_starts_q, p_fails_q, p_wrong_q;
  logic [3:0] p_first_q;
  logic [15:0] p_causes_q;
  wire p_is_wrong_of_rays = ray_size_i > 20 || ray_tail_i - ray_head > 1 << ray_size_i;
  wire p_is_wrong_of_hits = hit_size_i > 20 || hit_tail - hit_head_i > 1 << hit_size_i;
  wire p_is_wrong = p_is_wrong_of_hits || p_hit_end > 1 << A;
  wire [65:0] p_ray_end = {2'd0, ray_base_i & ~64'd63} + (64 << ray_size_i[4:0]);
  wire [65:0] p_hit_end = {2'd0, hit_base_i & ~64'd63} + (64 << hit_size_i[4:0]);
  wire p_fails = m_axi_bvalid && m_axi_bresp != 0;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_head_q, p_tail_q, p_starts_q, p_fails_q, p_wrong_q, p_first_q, p_causes_q} <= 0;
    else begin
      p_head_q <= p_record_ends ? ray_head + 1 : ray_head;
      p_tail_q <= m_axi_bvalid && !p_fails && !p_fails_q ? hit_tail + 1 : hit_tail;
      p_starts_q <= !enable_i && idle;
      p_fails_q <= !(!enable_i && idle) && (p_fails_q || p_fails || p_expires[1]);
      p_wrong_q <= !(!enable_i && idle) && (p_wrong_q || p_is_wrong);
      p_first_q <= clear_error_i && !enable_i && !timed_out && p_expires == 0 ? 0 : error;
      p_causes_q <= error != 0 ? 0 : {8'd0, p_expires != 0, 1'b0, p_fails, p_record_ends && p_is_bad,
        enable_i && p_ray_end > 1 << A || (enable_i || !idle) && p_hit_end > 1 << A,
        (enable_i || !idle) && p_is_wrong_of_hits, enable_i && p_is_wrong_of_rays, 1'b0};
    end
  always_comb head: assert (ray_head == (p_starts_q ? 0 : p_head_q));
  always_comb tail: assert (hit_tail == (p_starts_q ? 0 : p_tail_q) || (p_wrong_q && hit_tail + 1 == p_tail_q));
  always_comb first_error: assert (p_first_q == 0 || error == p_first_q);
  always_comb cause: assert (p_first_q != 0 || (p_causes_q == 0 ? error == 0 : p_causes_q[error]));
  always_comb idle_alone: assert (!idle || (!read_valid && p_beats_q == 0 && !awvalid && !wvalid && p_addresses_q == 0
    && p_records_q == 0 && p_inside_q == 0 && !ray_valid));

  // With software that moves the head of hits up to their tail only, the tail never passes a full ring.
  (* anyconst *) logic p_is_good;
  (* anyconst *) logic [31:0] p_size;
  logic [31:0] p_old_head_q, p_old_tail_q;
  wire [31:0] p_used = hit_tail - hit_head_i;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_old_head_q, p_old_tail_q} <= 0;
    else {p_old_head_q, p_old_tail_q} <= {hit_head_i, hit_tail};
  always_comb assume (!p_is_good || (p_size <= 20 && hit_size_i == p_size && hit_base_i == 0
    && (p_starts_q ? hit_head_i == 0 : hit_head_i - p_old_head_q <= p_old_tail_q - p_old_head_q)));
  always_comb never_full: assert (!p_is_good || ({1'b0, p_used} + p_writing <= 1 << p_size && error != 2));

  // Lemmas.
  (* hierconn *) wire [2:0] \u_rings.reading_q ;
  (* hierconn *) wire [2:0] \u_rings.held_q ;
  (* hierconn *) wire [2:0] \u_rings.writing_q ;
  (* hierconn *) wire [19:0] \u_rings.inside_q ;
  (* hierconn *) wire [31:0] \u_rings.g_times[0].waited_q , \u_rings.g_times[1].waited_q ;
  (* hierconn *) wire \u_rings.flushes_q ;
  (* hierconn *) wire \u_rings.drops_q ;
  (* hierconn *) wire [511:0] \u_rings.w_record_q ;
  (* hierconn *) wire \u_rings.u_records.valid_q ;
  (* hierconn *) wire [1:0] \u_rings.u_records.head_q ;
  (* hierconn *) wire [1:0] \u_rings.u_records.tail_q ;
  wire [1:0] p_stored = \u_rings.u_records.tail_q - \u_rings.u_records.head_q ;
  wire [2:0] p_queued = {1'b0, p_stored} + \u_rings.u_records.valid_q ;
  always_comb lemmas: assert (\u_rings.reading_q == p_reading && \u_rings.reading_q <= 4
    && \u_rings.writing_q == p_writing && \u_rings.writing_q <= 4
    && \u_rings.held_q <= 4 && \u_rings.reading_q <= \u_rings.held_q && \u_rings.held_q == \u_rings.reading_q + p_queued
    && p_beats_q == (\u_rings.reading_q - {2'd0, read_valid}) * BEATS - p_part_q && p_part_q < BEATS
    && p_addresses_q + {3'd0, awvalid} == \u_rings.writing_q && p_records_q + {3'd0, wvalid} == \u_rings.writing_q
    && p_beat_q < BEATS && (wvalid || p_beat_q == 0)
    && (\u_rings.flushes_q ? \u_rings.inside_q >= p_inside_q : \u_rings.inside_q == p_inside_q)
    && (!p_fails_q || \u_rings.drops_q ) && (!\u_rings.drops_q || p_fails_q || p_wrong_q)
    && (!wvalid || \u_rings.w_record_q == p_record_q >> p_beat_q * D)
    && (!p_w_stalls_q || wvalid)
    && p_queued <= p_due_q && (!p_bad_q || p_part_q != 0)
    && p_silent_q[0] == \u_rings.g_times[0].waited_q && p_silent_q[1] == \u_rings.g_times[1].waited_q );
endmodule
