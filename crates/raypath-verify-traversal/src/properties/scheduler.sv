  // The grant is one of the requests wherever there is one, and a steady request waits for at most S - 1 others.
  always_comb one_hot: assert ((grant_o & (grant_o - S'(1))) == 0);
  always_comb requested: assert ((grant_o & ~request_i) == 0);
  always_comb always_one: assert ((grant_o != 0) == (request_i != 0));
  logic [3*S-1:0] p_waits_q;
  logic [S-1:0] p_unfair;
  for (genvar k = 0; k < S; k++) begin : g_fair
    wire p_waits = request_i[k] && !grant_o[k];
    always_ff @(posedge clk_i or negedge rst_ni)
      if (!rst_ni) p_waits_q[3*k +: 3] <= 0;
      else p_waits_q[3*k +: 3] <= p_waits ? p_waits_q[3*k +: 3] + 3'd1 : 3'd0;
    assign p_unfair[k] = p_waits && p_waits_q[3*k +: 3] >= S - 1;
  end
  always_comb fair: assert (p_unfair == 0);
