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
  always_comb idle: assert (is_idle_o == (p_out_q == 0));
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

  // Lemmas. A word that waits is the context that is followed exactly where that one is. By induction over time this
  // holds at all addresses of the memory: it is assumed of what is read, and proved of the slot, which is any address.
  wire [8:0] p_fresh = 9'(N) - p_fresh_q;
  wire [8:0] p_index = p_ahead_q - p_fresh;
  wire p_holds;
  p_queue #(.N (N), .W (W)) p_lemmas (
    .count (p_count), .head (p_head), .tail (p_tail), .valid (p_valid), .slot (p_slot), .stored (p_stored),
    .front (p_front), .inside (9'(N) - p_out_q - p_fresh), .followed (1'b0), .index (p_index), .word (p_context),
    .holds (p_holds)
  );
  wire p_at_front = p_returns_q && p_valid && p_index == 0;
  wire [8:0] p_place = p_head + p_index - {8'd0, p_valid};
  wire [8:0] p_wrapped = p_place >= N ? p_place - 9'(N) : p_place;
  wire p_waits = p_returns_q && !p_at_front;
  wire p_is_live = p_head < p_tail ? p_slot >= p_head && p_slot < p_tail
    : p_count != 0 && (p_slot >= p_head || p_slot < p_tail);
  always_comb assume (p_other < N && (p_other == p_context) == (p_waits && p_wrapped == p_head));
  wire p_is_once = (!p_is_live || (p_stored < N && (p_stored == p_context) == (p_waits && p_wrapped == p_slot)))
    && (!p_valid || (p_front < N && (p_front == p_context) == p_at_front));
  wire p_is_fresh = 9'(p_context) >= p_fresh_q;
  always_comb lemmas: assert (p_holds && p_is_once && 9'(taken_q) == p_out_q && (!has_fresh_q || p_fresh_q < N)
    && !(p_is_out_q && p_is_fresh) && p_returns_q == (!p_is_out_q && !p_is_fresh)
    && (!p_returns_q || (p_ahead_q >= p_fresh && p_index < 9'(N) - p_out_q - p_fresh)) && (!p_waited_q || valid_o));
