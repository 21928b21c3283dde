  // A block arrives with its last beat and once, whatever the order of the beats of different contexts, and has failed
  // if one of its beats has an error. Some context is followed, and its readers have the words of its beats.
  always_comb assume (p_context < N);
  wire p_here = valid_i && context_i == p_context;
  logic p_error_q;
  wire p_is_last = p_beats_q == BEATS - 1;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_beats_q, p_error_q} <= 0;
    else if (p_here) begin
      p_beats_q <= p_is_last ? 4'd0 : p_beats_q + 4'd1;
      p_error_q <= !p_is_last && (p_error_q || error_i);
    end
  always_comb last_beat: assert (!p_here || arrived_o == p_is_last);
  always_comb no_other: assert (valid_i || !arrived_o);
  always_comb error: assert (!(p_here && arrived_o) || failed_o == (p_error_q || error_i));
  always_comb kept: assert (p_right);
