// The cache, whose memory gives the beats of each line in order, and errors; a tag has one request at a time.
module raypath_cache_properties #(
  parameter int WAYS = 1,
  parameter int BEATS = 2,
  parameter int LINE = 1,
  parameter int R = 2
) (
  input logic clk_i, rst_ni, invalidate_i, req_valid_i, mem_req_ready_i, mem_rsp_valid_i, mem_rsp_error_i,
  input logic [2:0] addr_i,
  input logic [1:0] req_tag_i,
  input logic mem_rsp_tag_i,
  input logic data_i
);
  // A line has LINE blocks, a block BEATS beats of two bytes.
  localparam int S = $clog2(LINE * BEATS), L = LINE * BEATS;
  localparam int A = 3 + S, O = 1 + $clog2(BEATS);
  wire idle, req_ready, rsp_valid, rsp_error, mem_req_valid, mem_req_tag;
  wire [1:0] rsp_tag;
  wire [15:0] rsp_data;
  wire [A-1:0] mem_req_addr;
  wire [A-1:0] req_addr = {addr_i[A-O-1:0], {O{1'b0}}};
  raypath_cache #(
    .Sets (2), .Ways (WAYS), .Misses (2), .LineBytes (2 * L), .BlockBytes (2 * BEATS), .DataWidth (16),
    .AddressWidth (A), .Requesters (R)
  ) u_cache (
    .clk_i, .rst_ni, .invalidate_i, .idle_o (idle), .req_valid_i, .req_addr_i (req_addr), .req_tag_i,
    .req_ready_o (req_ready), .rsp_valid_o (rsp_valid), .rsp_tag_o (rsp_tag), .rsp_error_o (rsp_error),
    .rsp_data_o (rsp_data), .mem_req_ready_i, .mem_req_valid_o (mem_req_valid), .mem_req_addr_o (mem_req_addr),
    .mem_req_tag_o (mem_req_tag), .mem_rsp_valid_i, .mem_rsp_tag_i, .mem_rsp_error_i,
    .mem_rsp_data_i ({15'd0, data_i})
  );

  // The memory has some bit in some beat, from some invalidation on; what it had before may be anything.
  (* anyconst *) logic [A-1:0] p_addr;
  (* anyconst *) logic p_bit;
  (* anyseq *) logic p_changes;
  logic p_new_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_new_q <= 0;
    else p_new_q <= p_new_q || (invalidate_i && p_changes);

  // Lines that the memory owes: what is left of each, its address, and whether it was read after the change.
  logic [3:0] p_left_q [2];
  logic [A-1:0] p_line_q [2];
  logic [1:0] p_is_new_q, p_owes;
  logic p_failed_q;
  for (genvar k = 0; k < 2; k++) begin : g_misses
    wire p_reads = mem_req_valid && mem_req_ready_i && mem_req_tag == k;
    wire p_here = mem_rsp_valid_i && mem_rsp_tag_i == k;
    always_ff @(posedge clk_i or negedge rst_ni)
      if (!rst_ni) p_left_q[k] <= 0;
      else p_left_q[k] <= p_reads ? L : p_left_q[k] - {3'd0, p_here};
    always_ff @(posedge clk_i)
      if (p_reads) {p_line_q[k], p_is_new_q[k]} <= {mem_req_addr, p_new_q};
      else if (p_here) p_line_q[k] <= p_line_q[k] + 2;
    assign p_owes[k] = p_left_q[k] != 0;
  end
  always_comb assume (!mem_rsp_valid_i || p_owes[mem_rsp_tag_i]);
  always_comb assume (!mem_rsp_valid_i || mem_rsp_error_i || !p_is_new_q[mem_rsp_tag_i]
    || p_line_q[mem_rsp_tag_i][A-1:1] != p_addr[A-1:1] || data_i == p_bit);
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_failed_q <= 0;
    else p_failed_q <= p_failed_q || (mem_rsp_valid_i && mem_rsp_error_i);
  always_comb once: assert (!(mem_req_valid && p_owes[mem_req_tag]));
  always_comb whole: assert (!mem_req_valid || (mem_req_addr & (2 * L - 1)) == 0);

  // Requests that wait, and the followed one of them.
  (* anyconst *) logic [1:0] p_tag;
  logic [R-1:0] p_open_q;
  logic p_fresh_q;
  logic [A-1:0] p_next_q;
  wire p_accepts = req_valid_i && req_ready;
  wire p_here = rsp_valid && rsp_tag == p_tag;
  always_comb assume (req_tag_i < R && p_tag < R);
  always_comb assume (!req_valid_i || !p_open_q[req_tag_i]);
  logic [2:0] p_rest_q [R];
  for (genvar k = 0; k < R; k++) begin : g_tags
    wire p_begins = p_accepts && req_tag_i == k;
    always_ff @(posedge clk_i or negedge rst_ni)
      if (!rst_ni) p_rest_q[k] <= 0;
      else p_rest_q[k] <= p_begins ? BEATS : p_rest_q[k] - {2'd0, rsp_valid && rsp_tag == k};
    assign p_open_q[k] = p_rest_q[k] != 0;
  end
  always_ff @(posedge clk_i)
    if (p_accepts && req_tag_i == p_tag) {p_fresh_q, p_next_q} <= {p_new_q, req_addr};
    else if (p_here) p_next_q <= p_next_q + 2;
  logic p_before_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_before_q <= 0;
    else p_before_q <= p_here && p_rest_q[p_tag] != 1;
  always_comb real_request: assert (!rsp_valid || (rsp_tag < R && p_open_q[rsp_tag]));
  always_comb without_pause: assert (!p_before_q || p_here);
  always_comb own_data: assert (!(p_here && p_fresh_q && p_next_q[A-1:1] == p_addr[A-1:1]) || rsp_error
    || rsp_data[0] == p_bit);
  always_comb real_error: assert (!(rsp_valid && rsp_error) || p_failed_q);
  always_comb none_lost: assert (idle == (p_open_q == 0));

  // With a memory that is always ready and gives a beat in each cycle in which it owes one, each request has its
  // answer in time.
  (* anyconst *) logic p_eager;
  logic [5:0] p_age_q;
  always_comb assume (!p_eager || (!invalidate_i && mem_req_ready_i && (p_owes == 0 || (mem_rsp_valid_i && !mem_rsp_error_i))));
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_age_q <= 0;
    else p_age_q <= p_open_q[p_tag] && !p_here && p_eager ? p_age_q + 1 : 0;
  always_comb in_time: assert (p_age_q < 24);
endmodule
