  // The constants of each ray are there once, LATENCY cycles after it entered, with its own context; a ray enters every
  // five cycles.
  wire p_enters = valid_i && ready_o;
  logic [LATENCY-1:0] p_inside_q;
  logic [LATENCY*W-1:0] p_contexts_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_inside_q <= 0;
    else p_inside_q <= {p_inside_q[LATENCY-2:0], p_enters};
  always_ff @(posedge clk_i) p_contexts_q <= {p_contexts_q[(LATENCY-1)*W-1:0], context_i};
  always_comb once: assert (valid_o == p_inside_q[LATENCY-1]);
  always_comb own_context: assert (!valid_o || context_o == p_contexts_q[LATENCY*W-1 -: W]);
  always_comb every_five: assert (ready_o == (p_inside_q[3:0] == 0));
