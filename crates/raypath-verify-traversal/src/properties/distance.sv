  // Each triangle is read once, in order, with its own context and fraction, and each block gives one closest hit, in
  // the order of their last triangles. Environment: a context has one block at a time, so that a place of a context is
  // not used again before it is read.
  always_comb assume (!valid_i || context_i < N);
  wire p_enters = valid_i && ready_o;
  wire p_ends = p_enters && is_last_i;
  wire p_leaves = valid_o && taken_i;
  logic [8:0] p_inside_q, p_blocks_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_inside_q, p_blocks_q} <= 0;
    else begin
      p_inside_q <= p_inside_q + {8'd0, p_enters} - {8'd0, read_o};
      p_blocks_q <= p_blocks_q + {8'd0, p_ends} - {8'd0, p_leaves};
    end

  // Some triangle is followed until it is read.
  wire p_follow;
  logic p_follows_q, p_read_q;
  logic [8:0] p_ahead_q;
  logic [W+1:0] p_place_q;
  logic [F-1:0] p_fraction_q;
  wire p_starts = p_enters && p_follow && {context_i, 2'(place_i)} == p_slot && !p_follows_q && !p_read_q;
  wire p_turn = p_follows_q && p_ahead_q == 0 && read_o;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_follows_q, p_read_q} <= 0;
    else begin
      p_follows_q <= p_starts || (p_follows_q && !p_turn);
      p_read_q <= p_turn;
    end
  always_ff @(posedge clk_i)
    if (p_starts) begin
      p_ahead_q <= p_inside_q - {8'd0, read_o};
      p_place_q <= {context_i, 2'(place_i)};
      p_fraction_q <= p_fraction_in;
    end else if (read_o) p_ahead_q <= p_ahead_q - 9'd1;
  always_comb assume (!(p_follows_q && p_enters && {context_i, 2'(place_i)} == p_place_q));
  always_comb reads: assert (!p_turn || read_context_o == p_place_q[W+1:2]);
  always_comb fraction: assert (!p_read_q || p_fraction_out == p_fraction_q);
  always_comb real_triangle: assert (!read_o || p_inside_q != 0);

  // Some block is followed from its last triangle on.
  wire p_choose;
  logic p_chosen_q;
  logic [8:0] p_before_q;
  logic [W-1:0] p_context_q;
  wire p_begins = p_ends && p_choose && !p_chosen_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_chosen_q <= 0;
    else p_chosen_q <= p_begins || (p_chosen_q && !(p_leaves && p_before_q == 0));
  always_ff @(posedge clk_i)
    if (p_begins) begin
      p_before_q <= p_blocks_q - {8'd0, p_leaves};
      p_context_q <= context_i;
    end else if (p_leaves) p_before_q <= p_before_q - 9'd1;
  always_comb order: assert (!(p_chosen_q && p_before_q == 0 && valid_o) || context_o == p_context_q);
  always_comb real_block: assert (!valid_o || p_blocks_q != 0);

  // A closest hit stays until it is taken. If none waits, triangles enter and a block is ready after LATENCY + 3 cycles.
  logic p_stalled_q;
  logic [5:0] p_waits_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_stalled_q, p_waits_q} <= 0;
    else {p_stalled_q, p_waits_q} <= {valid_o && !taken_i, valid_o || p_blocks_q == 0 ? 6'd0 : p_waits_q + 6'd1};
  always_comb stays: assert (!p_stalled_q || valid_o);
  always_comb accepts: assert (valid_o || ready_o);
  always_comb progress: assert (valid_o || p_waits_q < LATENCY + 3);

  // Lemmas. The stages from the last to the first: the closest hit, the hit that is read, the divider's,
  // the operands.
  logic p_holds;
  logic [8:0] p_triangles, p_lasts;
  always_comb begin
    p_holds = !(p_chosen_q && valid_o && p_before_q == 0) || context_q == p_context_q;
    p_triangles = 0;
    p_lasts = {8'd0, valid_o};
    if (has_hit_q && p_is_last(tag_q)) begin
      p_holds = p_holds && (!(p_chosen_q && p_lasts == p_before_q) || p_context(tag_q) == p_context_q)
        && (p_lasts != 0 || p_waits_q <= LATENCY + 1);
      p_lasts = p_lasts + 9'd1;
    end
    for (int k = LATENCY - 1; k >= 0; k--)
      if (p_stages[k]) begin
        p_holds = p_holds && (!(p_follows_q && p_triangles == p_ahead_q) || p_place(p_tags[k*T +: T]) == p_place_q);
        p_triangles = p_triangles + 9'd1;
        if (p_is_last(p_tags[k*T +: T])) begin
          p_holds = p_holds && (!(p_chosen_q && p_lasts == p_before_q) || p_context(p_tags[k*T +: T]) == p_context_q)
            && (p_lasts != 0 || p_waits_q <= k + 1);
          p_lasts = p_lasts + 9'd1;
        end
      end
    if (has_operands_q) begin
      p_holds = p_holds && (!(p_follows_q && p_triangles == p_ahead_q) || p_place(operands_tag_q) == p_place_q);
      p_triangles = p_triangles + 9'd1;
      if (p_is_last(operands_tag_q)) begin
        p_holds = p_holds && (!(p_chosen_q && p_lasts == p_before_q) || p_context(operands_tag_q) == p_context_q)
          && (p_lasts != 0 || p_waits_q == 0);
        p_lasts = p_lasts + 9'd1;
      end
    end
  end
  always_comb lemmas: assert (p_holds && p_triangles == p_inside_q && p_lasts == p_blocks_q
    && (!p_follows_q || (p_ahead_q < p_inside_q && p_place_q == p_slot && p_fractions_stored == p_fraction_q))
    && !(p_follows_q && p_read_q)
    && (!p_chosen_q || p_before_q < p_blocks_q) && (p_blocks_q != 0 || p_waits_q == 0));
