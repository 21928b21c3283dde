  // Each ray that is taken leaves once, in order, with its own context, and with two quotients of its own. Environment:
  // whether it has a hit is known in the cycle after it is taken, and stays until the next is taken.
  wire p_leaves = valid_o && ready_i;
  wire p_divided = divider_valid && moves;
  logic [8:0] p_inside_q;
  logic p_taken_q, p_is_hit_q, p_second_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_inside_q, p_taken_q, p_second_q} <= 0;
    else begin
      p_inside_q <= p_inside_q + {8'd0, take_o} - {8'd0, p_leaves};
      p_taken_q <= take_o;
      p_second_q <= p_second_q ^ p_divided;
    end
  always_ff @(posedge clk_i) p_is_hit_q <= is_hit_i;
  always_comb assume (p_taken_q || is_hit_i == p_is_hit_q);

  // Some ray is followed.
  wire p_follow;
  logic p_follows_q, p_begins_q, p_has_hit_q;
  logic [8:0] p_ahead_q;
  logic [W-1:0] p_context_q;
  logic [31:0] p_u_q;
  wire p_starts = take_o && p_follow && !p_follows_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_follows_q, p_begins_q} <= 0;
    else {p_follows_q, p_begins_q} <= {p_starts || (p_follows_q && !(p_leaves && p_ahead_q == 0)), p_starts};
  always_ff @(posedge clk_i) begin
    if (p_starts) begin
      p_ahead_q <= p_inside_q - {8'd0, p_leaves};
      p_context_q <= context_i;
    end else if (p_leaves) p_ahead_q <= p_ahead_q - 9'd1;
    if (p_begins_q) p_has_hit_q <= is_hit_i;
    if (p_divided && !p_second_q) p_u_q <= v_o;
  end
  wire p_turn = p_follows_q && p_ahead_q == 0 && valid_o;
  always_comb order: assert (!p_turn || context_o == p_context_q);
  always_comb no_hit: assert (!p_turn || p_has_hit_q || (u_o == 0 && v_o == 0));
  always_comb real_ray: assert ((!valid_o || p_inside_q != 0) && (!take_o || valid_i));
  always_comb both: assert (!divider_valid || (valid_o == p_second_q && (!valid_o || u_o == p_u_q)));

  // If no weights wait, a ray is taken every second cycle, and its weights are there after LATENCY + 3 cycles.
  logic p_refused_q;
  logic [5:0] p_waits_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_refused_q, p_waits_q} <= 0;
    else begin
      p_refused_q <= valid_i && !take_o && !valid_o;
      p_waits_q <= valid_o || p_inside_q == 0 ? 6'd0 : p_waits_q + 6'd1;
    end
  always_comb accepts: assert (!(p_refused_q && valid_i && !take_o && !valid_o));
  always_comb progress: assert (valid_o || p_waits_q < LATENCY + 2);

  // Lemmas. The quotients from the first on, which has left if p_second_q is 1: two of each ray.
  logic p_holds, p_has_second;
  logic [8:0] p_quotients;
  always_comb begin
    p_holds = 1;
    p_has_second = 0;
    p_quotients = {8'd0, p_second_q};
    for (int k = LATENCY - 1; k >= 0; k--)
      if (p_stages[k]) begin
        p_holds = p_holds && p_tags[k*T] == p_quotients[0]
          && (!(p_follows_q && p_quotients[8:1] == p_ahead_q)
            || (p_tags[k*T+2 +: W] == p_context_q && !p_begins_q && p_tags[k*T+1] == p_has_hit_q))
          && (!p_tags[k*T] || p_has_second || p_waits_q <= k + 3);
        p_has_second = p_has_second || p_tags[k*T];
        p_quotients = p_quotients + 9'd1;
      end
    if (has_operands_q) begin
      p_holds = p_holds && operands_tag_q[0] == p_quotients[0]
        && (!(p_follows_q && p_quotients[8:1] == p_ahead_q)
          || (operands_tag_q[2 +: W] == p_context_q && !p_begins_q && operands_tag_q[1] == p_has_hit_q))
        && (!operands_tag_q[0] || p_has_second || p_waits_q <= 2);
      p_has_second = p_has_second || operands_tag_q[0];
      p_quotients = p_quotients + 9'd1;
    end
    if (busy_q) p_holds = p_holds && (p_has_second || p_waits_q <= {5'd0, is_second_q})
      && (!(p_follows_q && p_quotients[8:1] == p_ahead_q)
        || (context_q == p_context_q && (p_begins_q || p_is_hit_q == p_has_hit_q)));
  end
  always_comb lemmas: assert (p_holds && is_second_q == p_quotients[0] && (!is_second_q || busy_q)
    && p_inside_q == {1'b0, p_quotients[8:1]} + {8'd0, busy_q} && (!p_follows_q || p_ahead_q < p_inside_q)
    && (!p_begins_q || (p_taken_q && p_follows_q && p_ahead_q == {1'b0, p_quotients[8:1]}))
    && (!p_taken_q || (busy_q && !is_second_q))
    && (!p_second_q || u_q == p_u_q) && (!(p_second_q && p_follows_q && p_ahead_q == 0) || p_has_hit_q || u_q == 0)
    && (!p_refused_q || is_second_q) && (p_inside_q != 0 || p_waits_q == 0));
