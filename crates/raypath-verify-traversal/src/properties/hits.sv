  // Each ray that ends leaves once, in the order of the ends, with its own values, and its context is released once.
  // Environment: at most N rays have ended and wait; a context does not end again before it is released.
  logic [8:0] p_inside_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_inside_q <= 0;
    else p_inside_q <= p_inside_q + {8'd0, ends_i} - {8'd0, release_o};
  always_comb assume (!(ends_i && p_inside_q - {8'd0, release_o} == N));
  always_comb assume (!ends_i || context_i < N);

  // Some end is followed: until its release, and then until its hit is taken.
  wire p_follow;
  logic p_follows_q, p_shows_q;
  logic [8:0] p_ahead_q;
  logic [W-1:0] p_context_q;
  logic [V-1:0] p_values_q;
  wire p_starts = ends_i && p_follow && p_tail == p_slot && context_i == p_hits_slot && !p_follows_q && !p_shows_q;
  wire p_turn = p_follows_q && p_ahead_q == 0 && release_o;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_follows_q, p_shows_q} <= 0;
    else begin
      p_follows_q <= p_starts || (p_follows_q && !p_turn);
      p_shows_q <= p_turn || (p_shows_q && !ready_i);
    end
  always_ff @(posedge clk_i)
    if (p_starts) begin
      p_ahead_q <= p_inside_q - {8'd0, release_o};
      p_context_q <= context_i;
      p_values_q <= p_values_in;
    end else if (release_o) p_ahead_q <= p_ahead_q - 9'd1;
  always_comb assume (!(p_follows_q && ends_i && context_i == p_context_q));
  always_comb order: assert (!p_turn || context_o == p_context_q);
  always_comb own_values: assert (!p_shows_q || (valid_o && p_values_out == p_values_q));

  // A hit is shown from the release on until it is taken, and no other.
  logic p_hit_q, p_waited_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_hit_q, p_waited_q} <= 0;
    else {p_hit_q, p_waited_q} <= {release_o || (p_hit_q && !ready_i), p_inside_q != 0 && !release_o};
  always_comb one_hit: assert (valid_o == p_hit_q && !(release_o && p_hit_q && !ready_i));
  always_comb real_end: assert (!release_o || p_inside_q != 0);
  always_comb progress: assert (!(p_waited_q && (!p_hit_q || ready_i)) || release_o);

  // Lemmas.
  wire p_holds;
  p_queue #(.N (N), .W (W)) p_lemmas (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .slot (p_slot), .stored (p_stored),
    .front (p_front),
    .inside (p_inside_q), .followed (p_follows_q), .index (p_ahead_q), .word (p_context_q), .holds (p_holds)
  );
  always_comb lemmas: assert (p_holds && (!p_waited_q || p_valid) && p_hit_q == valid_q
    && (!p_follows_q || p_context_q == p_hits_slot && p_hits_stored == p_values_q) && !(p_follows_q && p_shows_q));
