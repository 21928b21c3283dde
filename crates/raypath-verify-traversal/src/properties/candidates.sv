  // Each ray that asks is shown once, in the order in which rays ask, with its own values: those of its state, and of
  // the closest hit that was tested last for its context. Environment: at most N rays wait; a context asks about what
  // was tested for it, and nothing is tested for it and it does not ask again before its candidate is taken.
  logic [8:0] p_inside_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_inside_q <= 0;
    else p_inside_q <= p_inside_q + {8'd0, asks_i} - {8'd0, read_o};
  always_comb assume (!(asks_i && p_inside_q - {8'd0, read_o} == N));
  always_comb assume (!asks_i || context_i < N);

  // Some context is followed: what was tested for it, and then its candidate until it is taken.
  wire [T-1:0] p_tested_in = {tested_t_i, tested_primitive_i, tested_geometry_i, tested_t_num_i, tested_t_denom_i,
    tested_u_num_i, tested_v_num_i, tested_is_clockwise_i};
  wire [V-1:0] p_state_in = {next_leaf_is_box_i, next_leaf_is_opaque_i, next_instance_index_i,
    next_instance_custom_index_i, next_instance_shader_offset_i, next_instance_flags_flipped_i};
  wire p_follow;
  logic p_has_q, p_follows_q, p_shows_q;
  logic [8:0] p_ahead_q;
  logic [W-1:0] p_context_q;
  logic [T-1:0] p_tested_q;
  logic [V-1:0] p_state_q;
  wire p_is_tested = is_tested_i && tested_context_i == p_states_slot;
  wire p_starts = asks_i && p_follow && p_tail == p_slot && context_i == p_states_slot && !p_follows_q && !p_shows_q;
  wire p_turn = p_follows_q && p_ahead_q == 0 && read_o;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_has_q, p_follows_q, p_shows_q} <= 0;
    else begin
      p_has_q <= p_has_q || p_is_tested;
      p_follows_q <= p_starts || (p_follows_q && !p_turn);
      p_shows_q <= p_turn || (p_shows_q && !ready_i);
    end
  always_ff @(posedge clk_i) begin
    if (p_is_tested) p_tested_q <= p_tested_in;
    if (p_starts) begin
      p_ahead_q <= p_inside_q - {8'd0, read_o};
      p_context_q <= context_i;
      p_state_q <= p_state_in;
    end else if (read_o) p_ahead_q <= p_ahead_q - 9'd1;
  end
  always_comb assume (p_states_slot == p_tested_slot);
  always_comb assume (!p_starts || (p_has_q && !p_is_tested));
  always_comb assume (!((p_follows_q || p_shows_q) && (p_is_tested || (asks_i && context_i == p_context_q))));
  always_comb order: assert (!p_turn || context_o == p_context_q);
  wire p_is_box = p_state_q[V-1];
  wire [31:0] p_of_triangle = {32{~p_is_box}};
  always_comb own_values: assert (!p_shows_q || (valid_o && tag_o == p_context_q
    && {cand_is_box_o, cand_is_opaque_o, cand_instance_o, cand_custom_index_o, cand_shader_offset_o} == p_state_q[V-1:1]
    && {cand_primitive_o, cand_geometry_o} == p_tested_q[T-33 -: 64]
    && cand_t_o == (p_tested_q[T-1 -: 32] & p_of_triangle)
    && cand_t_num_o == (p_tested_q[128 -: 32] & p_of_triangle) && cand_t_denom_o == (p_tested_q[96 -: 32] & p_of_triangle)
    && cand_u_num_o == (p_tested_q[64 -: 32] & p_of_triangle) && cand_v_num_o == (p_tested_q[32 -: 32] & p_of_triangle)
    && cand_back_face_o == ((p_tested_q[0] ^ p_state_q[0]) && !p_is_box)));

  // A candidate is shown until it is taken, and no other.
  logic p_shown_q, p_waited_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_shown_q, p_waited_q} <= 0;
    else {p_shown_q, p_waited_q} <= {read_o || (p_shown_q && !ready_i), p_inside_q != 0 && !read_o};
  always_comb one_candidate: assert (valid_o == p_shown_q && !(read_o && p_shown_q && !ready_i));
  always_comb real_candidate: assert (!read_o || p_inside_q != 0);
  always_comb progress: assert (!(p_waited_q && (!p_shown_q || ready_i)) || read_o);

  // Lemmas.
  wire p_holds;
  p_queue #(.N (N), .W (W)) p_lemmas (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .slot (p_slot), .stored (p_stored),
    .front (p_front),
    .inside (p_inside_q), .followed (p_follows_q), .index (p_ahead_q), .word (p_context_q), .holds (p_holds)
  );
  always_comb lemmas: assert (p_holds && (!p_waited_q || p_valid) && p_shown_q == valid_q
    && (!p_has_q || p_tested_stored == p_tested_q) && !(p_follows_q && p_shows_q)
    && (!p_follows_q || (p_context_q == p_states_slot && p_states_stored == p_state_q && p_has_q)));
