// The guard for a memory that gives what it owes, or does not, and a requester with one request of a tag at a time.
module raypath_guard_properties #(
  parameter int T = 1,
  parameter int BEATS = 2
) (
  input logic clk_i, rst_ni, clear_i, req_valid_i, mem_req_ready_i, mem_rsp_valid_i, mem_rsp_error_i,
  input logic [2:0] first_i, req_addr_i,
  input logic [3:0] end_i,
  input logic [1:0] limit_i,
  input logic [T-1:0] req_tag_i, mem_rsp_tag_i,
  input logic mem_rsp_data_i
);
  localparam int N = 1 << T, W = BEATS == 1 ? 1 : $clog2(BEATS);
  wire timed_out, idle, req_ready, rsp_valid, rsp_error, rsp_data, mem_req_valid, mem_rsp_ready;
  wire [T-1:0] rsp_tag, mem_req_tag;
  wire [2:0] mem_req_addr;
  wire [31:0] timeout = {30'd0, limit_i};
  raypath_guard #(.AddressWidth (3), .DataWidth (8), .BurstBytes (BEATS), .TagWidth (T)) u_guard (
    .clk_i, .rst_ni, .first_i, .end_i, .timeout_i (timeout), .clear_i, .timed_out_o (timed_out), .idle_o (idle),
    .req_valid_i, .req_addr_i, .req_tag_i, .req_ready_o (req_ready), .rsp_valid_o (rsp_valid), .rsp_tag_o (rsp_tag),
    .rsp_error_o (rsp_error), .rsp_data_o (rsp_data), .mem_req_valid_o (mem_req_valid),
    .mem_req_addr_o (mem_req_addr), .mem_req_tag_o (mem_req_tag), .mem_req_ready_i, .mem_rsp_valid_i,
    .mem_rsp_tag_i, .mem_rsp_error_i, .mem_rsp_data_i, .mem_rsp_ready_o (mem_rsp_ready)
  );

  // Beats that each tag waits for, and that the memory owes it.
  wire p_accepts = req_valid_i && req_ready;
  wire p_sends = mem_req_valid && mem_req_ready_i;
  wire p_receives = mem_rsp_valid_i && mem_rsp_ready;
  logic [2:0] p_left_q [N], p_owed_q [N];
  logic [N-1:0] p_owes, p_open;
  for (genvar k = 0; k < N; k++) begin : g_tags
    always_ff @(posedge clk_i or negedge rst_ni)
      if (!rst_ni) {p_left_q[k], p_owed_q[k]} <= 0;
      else begin
        p_left_q[k] <= p_accepts && req_tag_i == k ? BEATS : p_left_q[k] - {2'd0, rsp_valid && rsp_tag == k};
        p_owed_q[k] <= p_owed_q[k] + (p_sends && mem_req_tag == k ? BEATS : 0)
          - {2'd0, p_receives && mem_rsp_tag_i == k};
      end
    assign {p_owes[k], p_open[k]} = {p_owed_q[k] != 0, p_left_q[k] != 0};
  end
  always_comb assume (!req_valid_i || !p_open[req_tag_i]);
  always_comb assume (!mem_rsp_valid_i || p_owes[mem_rsp_tag_i]);

  // A request whose bytes are all in the region is read, from its address, and no other one is.
  wire p_inside = req_addr_i >= first_i && {2'd0, req_addr_i} + BEATS - 1 < end_i;
  logic p_held_q, p_waits_q;
  logic [2:0] p_addr_q;
  logic [T-1:0] p_tag_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_held_q, p_waits_q} <= 0;
    else begin
      p_held_q <= (p_accepts && p_inside && !timed_out) || (mem_req_valid && !mem_req_ready_i);
      p_waits_q <= mem_req_valid && !mem_req_ready_i;
    end
  always_ff @(posedge clk_i)
    if (p_accepts) {p_addr_q, p_tag_q} <= {req_addr_i, req_tag_i};
  always_comb reads: assert (mem_req_valid == p_held_q);
  always_comb address: assert (!mem_req_valid || {mem_req_addr, mem_req_tag} == {p_addr_q, p_tag_q});

  // Some tag is followed: it has an answer only while it waits for one, so each request has at most its beats. An
  // error is the memory's, or that of a request outside of the region or with a timeout; other answers are its beats.
  (* anyconst *) logic [T-1:0] p_tag;
  wire p_begins = p_accepts && req_tag_i == p_tag;
  wire p_answers = rsp_valid && rsp_tag == p_tag;
  wire p_is_beat = mem_rsp_valid_i && mem_rsp_tag_i == p_tag && mem_rsp_ready && !timed_out;
  logic p_fails_q, p_dead_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_fails_q, p_dead_q} <= 0;
    else begin
      p_fails_q <= p_begins ? !p_inside || timed_out : p_fails_q;
      p_dead_q <= timed_out;
    end
  wire p_fails = p_fails_q || timed_out;
  always_comb beats: assert (!p_answers || p_open[p_tag]);
  always_comb own: assert (!p_answers || p_fails || 
    (p_is_beat && rsp_error == mem_rsp_error_i && rsp_data == mem_rsp_data_i));
  always_comb forwards: assert (!p_is_beat || p_answers);
  always_comb error: assert (!p_answers || p_is_beat || rsp_error);

  // After a timeout nothing is read but what was accepted before, and no late beat is an answer.
  always_comb nothing_new: assert (!(timed_out && p_dead_q && mem_req_valid) || p_waits_q);
  always_comb nothing_late: assert (!(timed_out && p_answers) || (rsp_error && p_open[p_tag]));
  always_comb no_underflow: assert (idle == (p_owes == 0 && p_open == 0 && !mem_req_valid));
  logic p_was_idle_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_was_idle_q <= 0;
    else p_was_idle_q <= idle && clear_i;
  always_comb falls: assert (!p_dead_q || timed_out == !p_was_idle_q);

  // The cycles without a beat that is owed, and those in which the tag waits for an error while no request enters.
  logic [31:0] p_silent_q;
  logic [4:0] p_waited_q;
  logic p_expires_q;
  wire p_is_silent = !mem_rsp_valid_i && (mem_req_valid || p_owes != 0) && !timed_out;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_silent_q, p_waited_q, p_expires_q} <= 0;
    else begin
      p_silent_q <= p_is_silent ? p_silent_q + 1 : 0;
      p_waited_q <= p_open[p_tag] && p_fails && !p_accepts && !p_answers ? p_waited_q + 1 : 0;
      p_expires_q <= limit_i != 0 && p_silent_q >= limit_i && !mem_rsp_valid_i && !timed_out;
    end
  always_comb in_time: assert (p_dead_q || timed_out == p_expires_q);
  always_comb answered: assert (p_waited_q <= BEATS * (N - 1));

  // Lemmas.
  (* hierconn *) wire [31:0] \u_guard.waited_q ;
  (* hierconn *) wire [T+$clog2(BEATS):0] \u_guard.owed_q ;
  (* hierconn *) wire [N-1:0] \u_guard.open_q ;
  (* hierconn *) wire [N-1:0] \u_guard.fails_q ;
  (* hierconn *) wire [W*N-1:0] \u_guard.beats_q ;
  wire [N-1:0] p_failing = \u_guard.fails_q ;
  wire [W*N-1:0] p_beats = \u_guard.beats_q ;
  logic [N-1:0] p_right;
  logic [4:0] p_all, p_below;
  always_comb begin
    {p_all, p_below} = 0;
    for (int k = 0; k < N; k++) begin
      p_all = p_all + p_owed_q[k];
      if (k < p_tag) p_below = p_below + p_left_q[k];
    end
  end
  for (genvar k = 0; k < N; k++) begin : g_lemmas
    wire [2:0] p_under_way = p_owed_q[k] + (mem_req_valid && mem_req_tag == k ? BEATS : 0);
    assign p_right[k] = (p_open[k] || !p_failing[k]) && p_left_q[k] <= BEATS && p_owed_q[k] <= BEATS
      && (timed_out ? p_failing[k] == p_open[k] && p_under_way <= BEATS
        : p_under_way == (p_failing[k] ? 0 : p_left_q[k]))
      && (!p_open[k] || p_beats[k*W +: W] == (BEATS - p_left_q[k]));
  end
  always_comb lemmas: assert (p_right == '1 && \u_guard.open_q == p_open && \u_guard.owed_q == p_all
    && \u_guard.waited_q == p_silent_q && p_waited_q + p_below <= BEATS * (N - 1)
    && (timed_out || !p_open[p_tag] || p_failing[p_tag] == p_fails_q));
endmodule
