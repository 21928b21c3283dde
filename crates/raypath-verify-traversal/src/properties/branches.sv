  // The branch that is read is the last one of its search that was kept and has not left. Environment: what leaves is there,
  // and leaves before outcomes of its nodes come. Some place of some search is followed.
  (* anyconst *) logic [4:0] p_place;
  always_comb assume (p_context < N);
  wire p_comes = valid_i && nodes_context == p_context;
  wire p_enters = enter_i && enter_context_i == p_context;
  wire p_kept = p_comes && children != 0;
  wire p_leaves = pop_i && pop_context_i == p_context;
  logic [5:0] p_depth_q;
  logic p_is_own_q, p_overflowed_q;
  logic [36:0] p_word_q;
  always_comb assume (!p_leaves || (p_depth_q != 0 && !p_comes && !p_enters));
  wire p_is_full = p_depth_q == 32;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_depth_q, p_is_own_q, p_overflowed_q} <= 0;
    else begin
      p_depth_q <= p_enters ? 6'd0 : p_depth_q + 6'(p_kept && !p_is_full) - 6'(p_leaves);
      p_overflowed_q <= !p_enters && (p_overflowed_q || p_kept && p_is_full);
      if (read_i) p_is_own_q <= read_context_i == p_context && p_depth_q == 6'(p_place) + 6'd1;
    end
  always_ff @(posedge clk_i)
    if (p_kept && p_depth_q == 6'(p_place))
      p_word_q <= {nodes_first + (nodes_is_keys ? 32'(child_i) : 32'd0), children, nodes_is_leaf};
  logic [36:0] p_read_q;
  always_ff @(posedge clk_i) if (read_i) p_read_q <= p_word_q;
  always_comb last: assert (!p_is_own_q || (next_is_there_o && {next_first_o, next_children_o, next_is_leaf_o} == p_read_q));
  always_comb overflows: assert (overflowed_o[p_context] == p_overflowed_q);

  // Lemmas.
  always_comb assume (p_slot == {p_context, p_place});
  always_comb depth: assert (p_count == p_depth_q && p_depth_q <= 32);
  always_comb stored: assert (p_depth_q <= 6'(p_place) || p_stored == p_word_q);
