  // The jobs of each block leave exactly once and in order, NODE_JOBS of a node; blocks follow each other as they arrived. Environment: at
  // most N blocks are inside; the number of triangles is that of the block that was taken, at most TRIANGLES, and stays.
  logic [8:0] p_inside_q, p_waiting_q;
  wire p_ends = (offer_o && ready_i && is_last_o) || (fault_valid_o && fault_taken_i);
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_inside_q, p_waiting_q} <= 0;
    else begin
      p_inside_q <= p_inside_q + {8'd0, arrived_i} - {8'd0, p_ends};
      p_waiting_q <= p_waiting_q + {8'd0, arrived_i} - {8'd0, take_o};
    end
  always_comb assume (!(arrived_i && p_inside_q - {8'd0, p_ends} == N));
  logic p_taken_q;
  logic [1:0] p_count_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_taken_q <= 0;
    else p_taken_q <= take_o;
  always_ff @(posedge clk_i) p_count_q <= count_i;
  always_comb assume (count_i <= TRIANGLES && (p_taken_q || count_i == p_count_q));

  // Some block is followed: until it is taken, and then until its last job leaves.
  wire p_follow;
  logic p_follows_q, p_serves_q;
  logic [8:0] p_ahead_q;
  logic [W-1:0] p_word_q;
  logic [1:0] p_jobs_q;
  wire p_starts = arrived_i && p_follow && p_tail == p_slot && !p_follows_q && !p_serves_q;
  wire p_turn = p_follows_q && p_ahead_q == 0 && take_o;
  wire [1:0] p_jobs = count_i == 0 ? NODE_JOBS : count_i;
  wire p_failed = p_word_q[0];
  wire p_is_last = p_jobs_q + 2'd1 == p_jobs;
  wire p_served = p_serves_q && (p_failed ? fault_taken_i : ready_i && p_is_last);
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_follows_q, p_serves_q} <= 0;
    else begin
      p_follows_q <= p_starts || (p_follows_q && !p_turn);
      p_serves_q <= p_turn || (p_serves_q && !p_served);
    end
  always_ff @(posedge clk_i) begin
    if (p_starts) begin
      p_ahead_q <= p_waiting_q - {8'd0, take_o};
      p_word_q <= {arrived_context_i, arrived_failed_i};
    end else if (take_o) p_ahead_q <= p_ahead_q - 9'd1;
    if (p_turn) p_jobs_q <= 0;
    else if (p_serves_q && ready_i) p_jobs_q <= p_jobs_q + 2'd1;
  end
  always_comb order: assert (!p_turn || take_context_o == p_word_q[W-1:1]);
  always_comb own_context: assert (!p_serves_q || context_o == p_word_q[W-1:1]);
  always_comb fault_only: assert (!(p_serves_q && p_failed) || (fault_valid_o && !offer_o));
  always_comb each_job: assert (!(p_serves_q && !p_failed) || (offer_o && !fault_valid_o && place_o == p_jobs_q));
  always_comb last_job: assert (!(p_serves_q && !p_failed) || (is_last_o == p_is_last && is_node_o == (count_i == 0)));
  always_comb words: assert (!(p_serves_q && !p_failed) || p_same_words);

  // Nothing is offered between blocks; a block is taken only when one waits and the one before ends, and then it is.
  logic p_busy_q, p_waited_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_busy_q, p_waited_q} <= 0;
    else {p_busy_q, p_waited_q} <= {take_o || (p_busy_q && !p_ends), p_waiting_q != 0 && !take_o};
  always_comb nothing_else: assert ((offer_o || fault_valid_o) == p_busy_q && !(offer_o && fault_valid_o));
  always_comb takes: assert (!take_o || (p_waiting_q != 0 && (!p_busy_q || p_ends)));
  always_comb progress: assert (!(p_waited_q && (!p_busy_q || p_ends)) || take_o);

  // Lemmas.
  wire p_holds;
  p_queue #(.N (N), .W (W)) p_lemmas (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .slot (p_slot), .stored (p_stored),
    .front (p_front),
    .inside (p_waiting_q), .followed (p_follows_q), .index (p_ahead_q), .word (p_word_q), .holds (p_holds)
  );
  always_comb lemmas: assert (p_holds && p_inside_q == p_waiting_q + {8'd0, p_busy_q} && p_busy_q == busy_q
    && (!p_waited_q || p_valid) && p_inside_q <= N && !(p_follows_q && p_serves_q)
    && (!p_serves_q || (p_busy_q && failed_q == p_failed && context_q == p_word_q[W-1:1]
      && (p_failed || (p_jobs_q < p_jobs && place_q == p_jobs_q)))));
