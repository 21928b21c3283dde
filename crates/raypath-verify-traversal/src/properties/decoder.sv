  // Each block leaves once, in order, with its own context and words, and is read in the cycle before it is at the
  // outputs. Some block is followed.
  wire p_enters = valid_i && ready_o;
  wire p_leaves = valid_o && ready_i;
  wire p_follow;
  logic [1:0] p_inside_q, p_ahead_q;
  logic p_follows_q;
  logic [W-1:0] p_context_q;
  logic [D-1:0] p_words_q;
  wire p_starts = p_enters && p_follow && !p_follows_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) {p_inside_q, p_follows_q} <= 0;
    else begin
      p_inside_q <= p_inside_q + {1'b0, p_enters} - {1'b0, p_leaves};
      p_follows_q <= p_starts || (p_follows_q && !(p_leaves && p_ahead_q == 0));
    end
  always_ff @(posedge clk_i)
    if (p_starts) begin
      p_ahead_q <= p_inside_q - {1'b0, p_leaves};
      p_context_q <= context_i;
      p_words_q <= p_words_in;
    end else if (p_leaves) p_ahead_q <= p_ahead_q - 2'd1;
  wire p_turn = p_follows_q && p_ahead_q == 0 && valid_o;
  always_comb order: assert (!p_turn || (context_o == p_context_q && p_words_out == p_words_q));
  always_comb real_block: assert (p_inside_q <= 2 && (!valid_o || p_inside_q != 0));

  // A block is at the outputs from the cycle after its read on until it leaves, and no other.
  logic p_shows_q;
  logic [W-1:0] p_read_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_shows_q <= 0;
    else p_shows_q <= read_o || (p_shows_q && !ready_i);
  always_ff @(posedge clk_i) if (read_o) p_read_q <= read_context_o;
  always_comb shows: assert (valid_o == p_shows_q && (!valid_o || context_o == p_read_q));
  always_comb one_read: assert (!(read_o && p_shows_q && !ready_i));

  // A block enters wherever none waits at the outputs, and is there in two cycles then.
  logic p_waited_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_waited_q <= 0;
    else p_waited_q <= p_inside_q != 0 && !valid_o;
  always_comb accepts: assert (ready_o == (!valid_o || ready_i));
  always_comb progress: assert (!p_waited_q || valid_o);
