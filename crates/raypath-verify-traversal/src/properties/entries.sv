  // The constants of each ray, new or in an instance, are there once, LATENCY cycles after it entered, with its own
  // context. A ray enters every five cycles. Environment: a new ray has a free context.
  always_comb assume (!valid_i || free_i);
  wire p_new = valid_i && ready_o;
  wire p_last = transformed_valid_i && transformed_is_last_i;
  wire p_instance = p_last && transformed_ready_o;
  logic [LATENCY-1:0] p_inside_q;
  logic [LATENCY*(W+1)-1:0] p_contexts_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_inside_q <= 0;
    else p_inside_q <= {p_inside_q[LATENCY-2:0], p_new || p_instance};
  always_ff @(posedge clk_i)
    p_contexts_q <= {p_contexts_q[(LATENCY-1)*(W+1)-1:0], p_instance, p_instance ? transformed_context_i : context_i};
  always_comb once: assert (valid_o == p_inside_q[LATENCY-1]);
  always_comb own_context: assert (!valid_o || {is_instance_o, context_o} == p_contexts_q[LATENCY*(W+1)-1 -: W+1]);
  always_comb every_five: assert (!(ready_o && p_instance) && (ready_o || p_instance) == (p_inside_q[3:0] == 0));

  // The first outcome of an instance is taken at once and kept for the second.
  logic p_has_q;
  logic [95:0] p_origin_q;
  wire p_first = transformed_valid_i && !transformed_is_last_i;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_has_q <= 0;
    else p_has_q <= p_has_q || p_first;
  always_ff @(posedge clk_i) if (p_first) p_origin_q <= {transformed_x_i, transformed_y_i, transformed_z_i};
  always_comb first_outcome: assert (!p_first || transformed_ready_o);
  always_comb enters: assert (enters_instance_o == p_instance && origin_context_o == transformed_context_i);
  always_comb own_origin: assert (!(p_instance && p_has_q) || {object_x_o, object_y_o, object_z_o} == p_origin_q);

  // Each waits for the ray in the set-up and for one of the other kind: at most nine cycles.
  logic [3:0] p_waits_q, p_new_waits_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_waits_q, p_new_waits_q} <= 0;
    else begin
      p_waits_q <= p_last && !transformed_ready_o ? p_waits_q + 4'd1 : 4'd0;
      p_new_waits_q <= valid_i && !ready_o ? p_new_waits_q + 4'd1 : 4'd0;
    end
  always_comb instance_waits: assert (!(p_last && !transformed_ready_o) || p_waits_q < 9);
  always_comb new_ray_waits: assert (!(valid_i && !ready_o) || p_new_waits_q < 9);
