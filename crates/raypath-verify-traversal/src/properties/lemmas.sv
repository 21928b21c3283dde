
// What holds in a queue of N words of W bits, of which one may be followed, `index` words behind the first.
module p_queue #(parameter int N = 8, parameter int W = 3) (
  input logic [8:0] count, head, tail, inside, index,
  input logic valid, followed,
  input logic [N*W-1:0] words,
  input logic [W-1:0] front, word,
  output logic holds
);
  wire [8:0] last = head + count;
  wire [8:0] place = head + index - {8'd0, valid};
  wire [8:0] wrapped = place >= N ? place - 9'(N) : place;
  logic [W-1:0] found;
  always_comb begin
    found = 0;
    for (int k = 0; k < N; k++) if (wrapped == k) found = words[k*W +: W];
  end
  wire is_found = valid && index == 0 ? front == word : found == word;
  assign holds = inside == count + {8'd0, valid} && count <= N && inside <= N && head < N && tail < N
    && tail == (last >= N ? last - 9'(N) : last) && (!followed || (index < inside && is_found));
endmodule

// Whether a word is in a queue only where it is followed.
module p_nowhere_else #(parameter int N = 8, parameter int W = 3) (
  input logic [8:0] count, head, tail, index,
  input logic valid, followed,
  input logic [N*W-1:0] words,
  input logic [W-1:0] front, word,
  output logic holds
);
  wire [8:0] place = head + index - {8'd0, valid};
  wire [8:0] wrapped = place >= N ? place - 9'(N) : place;
  logic [N-1:0] holds_word;
  always_comb
    for (int k = 0; k < N; k++)
      holds_word[k] = words[k*W +: W] == word
        && (head < tail ? 9'(k) >= head && 9'(k) < tail : count != 0 && (9'(k) >= head || 9'(k) < tail));
  always_comb begin
    holds = !(valid && front == word) || (followed && index == 0);
    for (int k = 0; k < N; k++)
      holds = holds && (!holds_word[k] || (followed && !(valid && index == 0) && wrapped == 9'(k)));
  end
endmodule

// What is kept in a memory for the context that is followed: a reader has in the next cycle what was written last.
module p_kept #(parameter int B = 1) (
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
  assign right = !read_q || ignored || shown == expected_q;
  assign stays = !has_q || stored == kept_q;
endmodule
