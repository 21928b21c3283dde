  // No context is given out twice, and each that is released comes back. Environment: a context is taken where there
  // is one, and a context that is released is out. Some context is followed.
  (* anyconst *) logic [W-1:0] p_context;
  always_comb assume (p_context < N);
  logic [8:0] p_out_q;
  logic p_is_out_q;
  wire p_takes = take_i && context_o == p_context;
  wire p_releases = release_i && released_i == p_context;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_out_q, p_is_out_q} <= 0;
    else begin
      p_out_q <= p_out_q + {8'd0, take_i} - {8'd0, release_i};
      p_is_out_q <= p_takes || (p_is_out_q && !p_releases);
    end
  always_comb assume (!take_i || valid_o);
  always_comb assume (!p_releases || p_is_out_q);
  always_comb assume (!release_i || (p_out_q != 0 && released_i < N));
  always_comb once: assert (!(p_takes && p_is_out_q));
  always_comb in_range: assert (!valid_o || context_o < N);
  always_comb count: assert (p_out_q <= N && !(p_out_q == N && valid_o));

  // If a context is free for two cycles, one is offered.
  logic p_waited_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_waited_q <= 0;
    else p_waited_q <= p_out_q != N && !valid_o;
  always_comb progress: assert (!p_waited_q || valid_o);

  // A context that is released is given out after those that were free before it.
  logic p_returns_q;
  logic [8:0] p_ahead_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_returns_q <= 0;
    else p_returns_q <= p_releases || (p_returns_q && !p_takes);
  always_ff @(posedge clk_i)
    if (p_releases) p_ahead_q <= 9'(N) - p_out_q - {8'd0, take_i};
    else if (take_i) p_ahead_q <= p_ahead_q - 9'd1;
  always_comb returns: assert (!(p_returns_q && p_ahead_q == 0 && valid_o) || context_o == p_context);
  always_comb soon: assert (!p_returns_q || p_ahead_q < N);

  // Lemmas.
  wire [8:0] p_fresh = 9'(N) - p_fresh_q;
  wire p_holds, p_is_once;
  p_queue #(.N (N), .W (W)) p_lemmas (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .words (p_words), .front (p_front),
    .inside (9'(N) - p_out_q - p_fresh), .followed (p_returns_q), .index (p_ahead_q - p_fresh), .word (p_context),
    .holds (p_holds)
  );
  p_nowhere_else #(.N (N), .W (W)) p_where (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .words (p_words), .front (p_front),
    .followed (p_returns_q), .index (p_ahead_q - p_fresh), .word (p_context), .holds (p_is_once)
  );
  logic p_in_range;
  always_comb begin
    p_in_range = !p_valid || p_front < N;
    for (int k = 0; k < N; k++)
      if (p_head < p_tail ? 9'(k) >= p_head && 9'(k) < p_tail : p_count != 0 && (9'(k) >= p_head || 9'(k) < p_tail))
        p_in_range = p_in_range && p_words[k*W +: W] < N;
  end
  wire p_is_fresh = 9'(p_context) >= p_fresh_q;
  always_comb lemmas: assert (p_holds && p_is_once && p_in_range && (!has_fresh_q || p_fresh_q < N)
    && !(p_is_out_q && p_is_fresh) && p_returns_q == (!p_is_out_q && !p_is_fresh)
    && (!p_returns_q || p_ahead_q >= p_fresh) && (!p_waited_q || valid_o));
