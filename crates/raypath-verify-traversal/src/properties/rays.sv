  // A ray enters where a context is free and the set-up takes it. Each ray whose constants are known starts once, in
  // order. Environment: at most N of them wait, because a context has one ray.
  wire p_enters = valid_i && ready_o;
  wire p_leaves = start_valid_o && start_taken_i;
  always_comb accepts: assert (ready_o == (contexts_valid && p_set_up_ready));
  logic [8:0] p_inside_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_inside_q <= 0;
    else p_inside_q <= p_inside_q + {8'd0, p_known} - {8'd0, p_leaves};
  always_comb assume (!(p_known && p_inside_q - {8'd0, p_leaves} == N));
  wire p_follow;
  logic p_follows_q;
  logic [8:0] p_ahead_q;
  logic [W-1:0] p_word_q;
  wire p_starts = p_known && p_follow && !p_follows_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_follows_q <= 0;
    else p_follows_q <= p_starts || (p_follows_q && !(p_leaves && p_ahead_q == 0));
  always_ff @(posedge clk_i)
    if (p_starts) begin
      p_ahead_q <= p_inside_q - {8'd0, p_leaves};
      p_word_q <= p_known_word;
    end else if (p_leaves) p_ahead_q <= p_ahead_q - 9'd1;
  always_comb order: assert (!(p_follows_q && p_ahead_q == 0 && start_valid_o) || p_start_word == p_word_q);
  always_comb real_ray: assert (!start_valid_o || p_inside_q != 0);
  logic p_waited_q, p_stalled_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_waited_q, p_stalled_q} <= 0;
    else {p_waited_q, p_stalled_q} <= {p_inside_q != 0 && !start_valid_o, start_valid_o && !start_taken_i};
  always_comb progress: assert (!(p_waited_q || p_stalled_q) || start_valid_o);

  // A reader of the context that is followed has what was written last for it.
  always_comb kept: assert (&p_right);

  // Lemmas.
  wire p_holds;
  p_queue #(.N (N), .W (W)) p_lemmas (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .words (p_words), .front (p_front),
    .inside (p_inside_q), .followed (p_follows_q), .index (p_ahead_q), .word (p_word_q), .holds (p_holds)
  );
  always_comb lemmas: assert (p_holds && (!p_waited_q || start_valid_o) && &p_stays);
