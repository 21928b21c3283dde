  // An answer is taken wherever there is one, and only one. Two reads of memories later its step ends, with one write of its own
  // context's state, and the ray fetches, ends, continues or asks about a candidate.
  wire [4:0] p_taken = {p_verdict_taken, start_taken_o, fault_taken_o, block_taken_o, boxes_taken};
  wire [4:0] p_offered = {p_verdict_valid, start_valid_i, fault_valid_i, block_valid_i, tested_valid};
  wire p_continues = read_o && p_taken == 0;
  always_comb taken: assert ((p_taken & ~p_offered) == 0 && (p_taken & (p_taken - 5'd1)) == 0);
  always_comb always_one: assert ((p_offered == 0 || read_o) && (p_taken == 0 || read_o));
  always_comb own_context: assert (
    (!start_taken_o || read_context_o == start_context_i) && (!fault_taken_o || read_context_o == fault_context_i)
    && (!p_verdict_taken || read_context_o == p_verdict_context)
    && (!block_taken_o || read_context_o == block_context_i) && (!boxes_taken || read_context_o == tested_context));
  logic [2*L-1:0] p_steps_q;
  logic [2*L-1:0][W-1:0] p_contexts_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_steps_q <= 0;
    else p_steps_q <= {p_steps_q[2*L-2:0], read_o};
  always_ff @(posedge clk_i) p_contexts_q <= {p_contexts_q[2*L-2:0], read_context_o};
  wire p_ends = p_steps_q[2*L-1];
  always_comb two_reads: assert (finishes_q == p_ends && (!p_ends || context_o == p_contexts_q[2*L-1]));
  wire [2:0] p_asks = {2'd0, fetches_o} + {2'd0, ends_o} + {2'd0, again_asked} + {2'd0, p_candidate};
  always_comb one_request: assert (p_asks == {2'd0, p_ends});
  always_comb flushed: assert (!flush_i || ends_o == p_ends);

  // Rays that continue come back, in order. Environment: at most N rays continue.
  logic [8:0] p_inside_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_inside_q <= 0;
    else p_inside_q <= p_inside_q + {8'd0, again_asked} - {8'd0, p_continues};
  always_comb assume (!(again_asked && p_inside_q - {8'd0, p_continues} == N));
  wire p_follow;
  logic p_follows_q;
  logic [8:0] p_ahead_q;
  logic [W-1:0] p_word_q;
  wire p_starts = again_asked && p_follow && p_tail == p_slot && !p_follows_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_follows_q <= 0;
    else if (p_starts) p_follows_q <= 1;
    else if (p_continues && p_ahead_q == 0) p_follows_q <= 0;
  always_ff @(posedge clk_i)
    if (p_starts) begin
      p_ahead_q <= p_inside_q - {8'd0, p_continues};
      p_word_q <= context_o;
    end else if (p_continues) p_ahead_q <= p_ahead_q - 9'd1;
  always_comb order: assert (!(p_follows_q && p_ahead_q == 0 && p_continues) || read_context_o == p_word_q);
  always_comb real_ray: assert (!p_continues || p_inside_q != 0);

  // Each answer waits for at most S - 1 others, a ray that continues for one cycle more.
  logic [3*S-1:0] p_waits_q;
  wire [4:0] p_left = p_offered & ~p_taken;
  wire [5:0] p_waiting = {p_left[4], p_inside_q != 0 && !p_continues, p_left[3:0]};
  logic [S-1:0] p_unfair;
  for (genvar k = 0; k < S; k++) begin : g_fair
    always_ff @(posedge clk_i or negedge rst_ni)
      if (!rst_ni) p_waits_q[3*k +: 3] <= 0;
      else p_waits_q[3*k +: 3] <= p_waiting[k] ? p_waits_q[3*k +: 3] + 3'd1 : 3'd0;
    assign p_unfair[k] = p_waiting[k] && p_waits_q[3*k +: 3] >= (k == 4 ? S : S - 1);
  end
  always_comb fair: assert (p_unfair == 0);

  // Lemmas.
  wire p_holds;
  p_queue #(.N (N), .W (W)) p_lemmas (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .slot (p_slot), .stored (p_stored),
    .front (p_front),
    .inside (p_inside_q), .followed (p_follows_q), .index (p_ahead_q), .word (p_word_q), .holds (p_holds)
  );
  // The scheduler has granted sources nearer and nearer to one that waits.
  (* hierconn *) logic [S-2:0] \u_scheduler.after_q ;
  wire [S-1:0] p_after = {\u_scheduler.after_q , 1'b0};
  logic [3:0] p_later;
  logic p_nearer;
  always_comb begin
    p_later = 0;
    for (int k = 0; k < S; k++) p_later = p_later + {3'd0, p_after[k]};
    p_nearer = 1;
    for (int k = 0; k < S - 1; k++) p_nearer = p_nearer && (!p_after[k] || p_after[k + 1]);
    for (int k = 0; k < S; k++)
      p_nearer = p_nearer && {1'b0, p_waits_q[3*k +: 3]} + (p_after[k] ? 4'(k) + p_later - 4'(S) : p_later + 4'(k))
        <= (k == 4 ? S : S - 1);
  end
  always_comb lemmas: assert (p_holds && p_nearer && (p_valid || p_waits_q[14:12] == 0) && p_early
    && prepares_q == p_steps_q[L-1] && (!p_steps_q[L-1] || prepared_context_q == p_contexts_q[L-1]));
