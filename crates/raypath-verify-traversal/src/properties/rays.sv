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
  wire p_starts = p_known && p_follow && p_tail == p_slot && !p_follows_q;
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
  wire p_ids_right, p_ids_stays, p_begins_right, p_begins_stays,
    p_limits_right, p_limits_stays, p_origins_right, p_origins_stays, p_constants_right, p_constants_stays;
  (* hierconn *) logic [A-1:0] \u_ids.slot ;
  (* hierconn *) logic [$bits(id_o)-1:0] \u_ids.word_q ;
  always_comb assume (\u_ids.slot == p_context);
  p_kept #(.B ($bits(id_o))) p_keeps_ids (
    .clk_i, .rst_ni, .writes (p_enters && contexts_context == p_context),
    .reads (release_i && hit_context_i == p_context), .ignored (1'b0),
    .given (id_i), .stored (\u_ids.word_q ),
    .shown (id_o),
    .right (p_ids_right), .stays (p_ids_stays)
  );
  (* hierconn *) logic [A-1:0] \u_begins.slot ;
  (* hierconn *) logic [64:0] \u_begins.word_q ;
  always_comb assume (\u_begins.slot == p_context);
  p_kept #(.B (65), .LATENCY (LATENCY)) p_keeps_begins (
    .clk_i, .rst_ni, .writes (p_enters && contexts_context == p_context),
    .reads (step_read_i && step_context_i == p_context), .ignored (1'b0),
    .given ({root_i, entry_t_max_i, flags_i[2]}), .stored (\u_begins.word_q ),
    .shown ({begin_root_o, begin_t_max_o, begin_any_hit_o}),
    .right (p_begins_right), .stays (p_begins_stays)
  );
  (* hierconn *) logic [A-1:0] \u_limits.slot ;
  (* hierconn *) logic [33:0] \u_limits.word_q ;
  always_comb assume (\u_limits.slot == p_context);
  p_kept #(.B (34)) p_keeps_limits (
    .clk_i, .rst_ni, .writes (p_enters && contexts_context == p_context),
    .reads (limits_read_i && limits_context_i == p_context), .ignored (1'b0),
    .given ({entry_t_min_i, flags_i[4] | flags_i[6] | flags_i[8], flags_i[5] | flags_i[6] | flags_i[8]}),
    .stored (\u_limits.word_q ),
    .shown ({limits_t_min_o, limits_culls_clockwise_o, limits_culls_counter_clockwise_o}),
    .right (p_limits_right), .stays (p_limits_stays)
  );
  (* hierconn *) logic [A-1:0] \u_origins.slot ;
  (* hierconn *) logic [95:0] \u_origins.word_q ;
  always_comb assume (\u_origins.slot == p_context);
  p_kept #(.B (96)) p_keeps_origins (
    .clk_i, .rst_ni, .writes (p_enters && contexts_context == p_context),
    .reads (job_read_i && job_context_i == p_context), .ignored (p_is_inside),
    .given ({entry_origin_x_i, entry_origin_y_i, entry_origin_z_i}), .stored (\u_origins.word_q ),
    .shown ({job_origin_x_o, job_origin_y_o, job_origin_z_o}),
    .right (p_origins_right), .stays (p_origins_stays)
  );
  (* hierconn *) logic [A-1:0] \u_constants.slot ;
  (* hierconn *) logic [197:0] \u_constants.word_q ;
  always_comb assume (\u_constants.slot == p_context);
  p_kept #(.B (9)) p_keeps_constants (
    .clk_i, .rst_ni, .writes (p_known && !p_is_instance && p_known_context == p_context),
    .reads (job_read_i && job_context_i == p_context), .ignored (p_is_inside),
    .given (p_constants),
    .stored ({\u_constants.word_q [166], \u_constants.word_q [134], \u_constants.word_q [102], \u_constants.word_q [70],
      \u_constants.word_q [38], \u_constants.word_q [6], \u_constants.word_q [4],
      \u_constants.word_q [2], \u_constants.word_q [0]}),
    .shown ({job_inv_x_o[0], job_inv_y_o[0], job_inv_z_o[0], job_shear_x_o[0], job_shear_y_o[0],
      job_shear_z_o[0], job_kx_o[0], job_ky_o[0], job_kz_o[0]}),
    .right (p_constants_right), .stays (p_constants_stays)
  );
  always_comb kept: assert (p_ids_right && p_begins_right && p_limits_right && p_origins_right && p_constants_right);

  // Lemmas.
  wire p_holds;
  p_queue #(.N (N), .W (W)) p_lemmas (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .slot (p_slot), .stored (p_stored),
    .front (p_front),
    .inside (p_inside_q), .followed (p_follows_q), .index (p_ahead_q), .word (p_word_q), .holds (p_holds)
  );
  always_comb lemmas: assert (p_holds && (!p_waited_q || start_valid_o)
    && p_ids_stays && p_begins_stays && p_limits_stays && p_origins_stays && p_constants_stays && p_instances_stay);
