  // An index that a search has not asked for is not skipped. Environment: what comes is for searches inside, and a search
  // that is over has neither a turn nor a burst. Some index of some search is followed.
  (* anyconst *) logic [W-1:0] p_context;
  (* anyconst *) logic [31:0] p_index;
  always_comb assume (p_context < N && enter_block_i != '1);
  wire p_enters = enters && entered == p_context;
  wire p_runs = runs_q && context_q == p_context;
  wire p_own = burst_is_compared_q && burst_context_q == p_context;
  wire p_asks = pushes && p_own && burst_index_q == p_index;
  logic p_inside_q, p_asked_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_inside_q, p_asked_q} <= 0;
    else begin
      p_inside_q <= p_enters || (p_inside_q && !(release_i && release_context_i == p_context));
      p_asked_q <= !p_enters && (p_asks || p_asked_q);
    end
  wire p_touches = (load_i || list_valid_i) && block_context_i == p_context ||
    expands_i && expands_context_i == p_context || visited_i && visited_context_i == p_context;
  always_comb assume (!p_touches || p_inside_q);
  always_comb assume (!(release_i && release_context_i == p_context) ||
    (p_inside_q && !p_touches && !p_runs && !waits_q[p_context] && !(has_burst_q && burst_context_q == p_context) &&
      !(sweeps_q && swept_q == p_context)));
  wire p_follows;  // from the lemmas
  always_comb nothing_lost: assert (!(p_follows && has_burst_q && skips && p_own && burst_index_q == p_index) ||
    burst_is_outside_q || p_asked_q);

  // Lemmas.
  wire [S-1:0] p_set = p_index[S-1:0] ^ p_index[2*S-1:S];
  always_comb assume (p_slot == {p_context, p_set});
  wire p_sweeps = sweeps_q && swept_q == p_context;
  wire p_swept = !(p_sweeps && sweep_set_q <= p_set);
  wire p_is_free = p_index != '1;
  wire [7:0] p_stored_is, p_shown_is;
  for (genvar k = 0; k < 8; k++) begin : p_ways
    assign p_stored_is[k] = p_stored[32*k +: 32] == p_index;
    assign p_shown_is[k] = p_shown[32*k +: 32] == p_index;
  end
  always_comb inside: assert (p_inside_q == in_use_q[p_context]);
  always_comb outside: assert (p_inside_q || !(p_runs || waits_q[p_context] || is_new_q[p_context] || p_sweeps ||
    has_burst_q && burst_context_q == p_context));
  always_comb sweeping: assert (!p_sweeps || !(p_runs && !was_new_q) && !(has_burst_q && p_own));
  always_comb clean: assert (remembered_q[p_context] || !p_swept || !p_is_free || p_stored_is == 0);
  always_comb stored: assert (!(p_inside_q && !p_asked_q && p_swept && p_is_free) || p_stored_is == 0);
  wire p_pending = !(has_burst_q && p_own && burst_set_q == p_set && !p_asked_q && p_is_free) || p_shown_is == 0;
  wire p_own_set = !(has_burst_q && burst_is_compared_q) ||
    burst_set_q == (burst_index_q[S-1:0] ^ burst_index_q[2*S-1:S]);
  wire p_none = !(has_burst_q && p_own && burst_index_q == '1) || burst_is_outside_q;
  assign p_follows = p_pending && p_own_set && p_none;
  always_comb pending: assert (p_pending);
  always_comb own_set: assert (p_own_set);
  always_comb none: assert (p_none);
  always_comb first_set: assert (sweeps_q || sweep_set_q == 0);
  always_comb fresh: assert (!is_new_q[p_context] || waits_q[p_context]);
