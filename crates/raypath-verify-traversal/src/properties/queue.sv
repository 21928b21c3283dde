  // The queue is first in, first out: nothing is lost, repeated or reordered. Environment: at most N words are inside.
  logic [8:0] p_inside_q;
  wire p_leaves = valid_o && pop_i;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_inside_q <= 0;
    else p_inside_q <= p_inside_q + {8'd0, push_i} - {8'd0, p_leaves};
  always_comb assume (!(push_i && p_inside_q - {8'd0, p_leaves} == N));

  // Some word is followed, which one is free: it leaves after the words that were inside before it.
  wire p_follow;
  logic p_follows_q;
  logic [8:0] p_ahead_q;
  logic [W-1:0] p_word_q;
  wire p_starts = push_i && p_follow && p_tail == p_slot && !p_follows_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_follows_q <= 0;
    else if (p_starts) p_follows_q <= 1;
    else if (p_leaves && p_ahead_q == 0) p_follows_q <= 0;
  always_ff @(posedge clk_i)
    if (p_starts) begin
      p_ahead_q <= p_inside_q - {8'd0, p_leaves};
      p_word_q <= p_word_in;
    end else if (p_leaves) p_ahead_q <= p_ahead_q - 9'd1;
  always_comb order: assert (!(p_follows_q && p_ahead_q == 0 && valid_o) || p_word_out == p_word_q);
  always_comb real_word: assert (!valid_o || p_inside_q != 0);

  // The first word is at the output at the latest two cycles after it entered, and stays until it is taken.
  logic p_waited_q, p_stalled_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_waited_q, p_stalled_q} <= 0;
    else {p_waited_q, p_stalled_q} <= {p_inside_q != 0 && !valid_o, valid_o && !pop_i};
  always_comb progress: assert (!(p_waited_q || p_stalled_q) || valid_o);

  // Lemmas.
  wire p_holds;
  p_queue #(.N (N), .W (W)) p_lemmas (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .slot (p_slot), .stored (p_stored),
    .front (p_front),
    .inside (p_inside_q), .followed (p_follows_q), .index (p_ahead_q), .word (p_word_q), .holds (p_holds)
  );
  always_comb lemmas: assert (p_holds && (!p_waited_q || valid_o));
