
// What holds in a queue of N words of W bits, of which one may be followed, `index` words behind the first. Of its
// memory the word at one address is known, `stored` at `slot`.
module p_queue #(parameter int N = 8, parameter int W = 3) (
  input logic [8:0] count, head, tail, slot, inside, index,
  input logic valid, followed,
  input logic [W-1:0] stored, front, word,
  output logic holds
);
  wire [8:0] last = head + count;
  wire [8:0] place = head + index - {8'd0, valid};
  wire is_found = valid && index == 0 ? front == word : slot == (place >= N ? place - 9'(N) : place) && stored == word;
  assign holds = inside == count + {8'd0, valid} && count <= N && inside <= N && head < N && tail < N
    && tail == (last >= N ? last - 9'(N) : last) && (!followed || (index < inside && is_found));
endmodule

// What is kept in a memory for the context that is followed: a reader has in the next cycle what was written last.
module p_kept #(parameter int B = 1, parameter int LATENCY = 1) (
  input logic clk_i, rst_ni, writes, reads, ignored,
  input logic [B-1:0] given, shown, stored,
  output logic right, stays
);
  logic has_q, read_q;
  logic [B-1:0] kept_q, expected_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {has_q, read_q} <= 0;
    else {has_q, read_q} <= {has_q || writes, reads && has_q};
  always_ff @(posedge clk_i) begin
    if (writes) kept_q <= given;
    if (reads) expected_q <= kept_q;
  end
  logic late_q;
  logic [B-1:0] late_expected_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) late_q <= 0;
    else late_q <= read_q;
  always_ff @(posedge clk_i) late_expected_q <= expected_q;
  assign right = LATENCY == 2 ? !late_q || ignored || shown == late_expected_q
    : !read_q || ignored || shown == expected_q;
  assign stays = !has_q || stored == kept_q;
endmodule
