  // A list is sorted, and loses only what is behind it. Environment: each word that is read is sorted, as is each that
  // is written, and a search begins with words that are cleared; no vector has the key of nothing.
  wire [14:0] p_old_sorted, p_new_sorted;
  for (genvar k = 0; k < 15; k++) begin : p_neighbours
    assign p_old_sorted[k] = p_old[k] < p_old[k + 1] || (&p_old[k][63:32] && &p_old[k + 1][63:32]);
    assign p_new_sorted[k] = p_new[k] < p_new[k + 1] || (&p_new[k][63:32] && &p_new[k + 1][63:32]);
  end
  always_comb assume (&p_old_sorted);
  always_comb assume (!(valid_i && kind_i == 3'd4) || key_i != '1);
  always_comb assume (clear_context_i < N && context_i < N);
  always_comb sorted: assert (!writes || &p_new_sorted);

  // Some candidate is followed: it is in the word that is written, or goes on to the next, if and only if it was in the
  // word that was read, or came from the word before. What goes on is behind the word.
  (* anyconst *) logic [63:0] p_some;
  always_comb assume (p_some[63:32] != '1);
  wire [15:0] p_is_old, p_is_new, p_is_none;
  for (genvar k = 0; k < 16; k++) begin : p_each
    assign p_is_old[k] = p_old[k] == p_some;
    assign p_is_new[k] = p_new[k] == p_some;
    assign p_is_none[k] = &p_old[k][63:32];
  end
  wire [63:0] p_behind = carried < p_old[15] ? p_old[15] : carried;
  wire p_was = |p_is_old || carried == p_some, p_is = |p_is_new || p_behind == p_some;
  always_comb kept: assert (!places || p_was == p_is);
  always_comb behind: assert (!places || p_behind > p_new[15] || &p_behind[63:32]);
  always_comb lost: assert (!places || inserts_on || is_last_word || &p_behind[63:32]);
  always_comb once: assert (!(inserts_q && is_there) || (!writes && p_old != '1));
  always_comb limit: assert (!(limits_o && !clear) ||
    (inserts_q && is_last_word && limit_o == p_new[15] && limit_context_o == context_q));

  // What goes on comes to the next word of the same search.
  logic p_goes_q;
  logic [63:0] p_behind_q;
  logic [W+B-1:0] p_next_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_goes_q <= 0;
    else p_goes_q <= inserts_on;
  always_ff @(posedge clk_i) begin
    p_behind_q <= p_behind;
    p_next_q <= {context_q, word_q} + 1'b1;
  end
  always_comb next: assert (!p_goes_q || (inserts_q && carried == p_behind_q && {context_q, word_q} == p_next_q));

  // A word is written to where it was read, and not read at the same time.
  logic [W+B-1:0] p_read_q;
  always_ff @(posedge clk_i) if (p_reads) p_read_q <= p_read;
  always_comb place: assert (!(writes && !clears_q) || p_written == p_read_q);
  always_comb not_stale: assert (!(writes && p_reads) || p_written != p_read);

  // The best candidate is named whose neighbours were not asked for, and nothing else changes.
  wire [15:0] p_open = ~p_old_expanded & ~p_is_none;
  always_comb best: assert (!expands_o || (chosen != 0 && (chosen & ~p_open) == 0 && ((chosen - 16'd1) & p_open) == 0));
  always_comb marked: assert (!expands_o || (p_new == p_old && p_new_expanded == (p_old_expanded | chosen)));

  // Neighbours leave in the order of the list.
  logic p_left_q;
  logic [B+3:0] p_place_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_left_q <= 0;
    else p_left_q <= found_valid_o && found_ready_i && !found_is_end_o;
  always_ff @(posedge clk_i) p_place_q <= {word_q, place_q} + 1'b1;
  always_comb in_order: assert (!p_left_q || (found_valid_o && {word_q, place_q} == p_place_q));
  always_comb shown: assert (!found_valid_o || {found_key_o, found_index_o} == p_old[place_q]);

  // Lemmas.
  wire [3:0] p_state = {clears_q, inserts_q, seeks_q, drains_q};
  always_comb one_state: assert ((p_state & (p_state - 4'd1)) == 0);
  always_comb starts: assert (!(inserts_q && is_own_q) || word_q == 0);
  always_comb own: assert (!(inserts_q && is_own_q) || own_key_q != '1);
  always_comb carried_on: assert (!(inserts_q && !is_own_q) || carried[63:32] != '1);
  always_comb within: assert (!(inserts_q || seeks_q) || word_q <= settings_candidate[B+3:4]);
