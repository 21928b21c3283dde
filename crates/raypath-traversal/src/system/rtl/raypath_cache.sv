module raypath_cache #(
  // Sets and ways; the least recently used line of a set is replaced.
  parameter  logic [31:0] Sets         = 64,
  parameter  logic [31:0] Ways         = 4,
  // Lines that are fetched at a time.
  parameter  logic [31:0] Misses       = 8,
  parameter  logic [31:0] LineBytes    = 128,
  parameter  logic [31:0] BlockBytes   = 128,
  parameter  logic [31:0] DataWidth    = 512,
  parameter  logic [31:0] AddressWidth = 32,
  parameter  logic [31:0] Requesters   = 64,
  localparam logic [31:0] TagWidth     = $clog2(Requesters),
  localparam logic [31:0] MissWidth    = $clog2(Misses)
) (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  // All lines become invalid before a later request is answered.
  input  logic                    invalidate_i,
  // No request is in the cache.
  output logic                    idle_o,
  // A request is answered from a line, waits for a line under way, or fetches a line.
  output logic                    hits_o,
  output logic                    merges_o,
  output logic                    misses_o,
  // The request of a block; a tag has one request at a time.
  input  logic                    req_valid_i,
  input  logic [AddressWidth-1:0] req_addr_i,
  input  logic [TagWidth-1:0]     req_tag_i,
  output logic                    req_ready_o,
  // The beats of a block, without a pause between them.
  output logic                    rsp_valid_o,
  output logic [TagWidth-1:0]     rsp_tag_o,
  output logic                    rsp_error_o,
  output logic [DataWidth-1:0]    rsp_data_o,
  // The request of a line.
  input  logic                    mem_req_ready_i,
  output logic                    mem_req_valid_o,
  output logic [AddressWidth-1:0] mem_req_addr_o,
  output logic [MissWidth-1:0]    mem_req_tag_o,
  // A beat of a line, those of a tag in order of addresses; it is always taken.
  input  logic                    mem_rsp_valid_i,
  input  logic [MissWidth-1:0]    mem_rsp_tag_i,
  input  logic                    mem_rsp_error_i,
  input  logic [DataWidth-1:0]    mem_rsp_data_i
);

  localparam logic [31:0] OffsetBits  = $clog2(LineBytes);
  localparam logic [31:0] LineWidth   = AddressWidth - OffsetBits;
  localparam logic [31:0] SetWidth    = $clog2(Sets);
  localparam logic [31:0] LabelWidth  = LineWidth - SetWidth;
  localparam logic [31:0] WayWidth    = (Ways == 1) ? 1 : $clog2(Ways);
  localparam logic [31:0] Places      = Sets << WayWidth;
  localparam logic [31:0] PlaceWidth  = SetWidth + WayWidth;
  localparam logic [31:0] Beats       = BlockBytes * 8 / DataWidth;
  localparam logic [31:0] LineBeats   = LineBytes * 8 / DataWidth;
  localparam logic [31:0] BeatWidth   = (LineBeats == 1) ? 1 : $clog2(LineBeats);
  localparam logic [31:0] StoredBeats = Places << ((LineBeats == 1) ? 0 : BeatWidth);
  localparam logic [31:0] StoreWidth  = $clog2(StoredBeats);
  localparam logic [31:0] EntryWidth  = 1 + LabelWidth + WayWidth;
  localparam logic [31:0] WordWidth   = Ways * EntryWidth;
  localparam logic [31:0] Hits        = 4;

  localparam logic [BeatWidth-1:0] OneBeat = 1;
  localparam logic [SetWidth-1:0]  OneSet  = 1;

  if (Sets < 2 || Sets != (32'd1 << SetWidth)) begin : g_sets
    $error("Sets is %0d, expected a power of two from 2 on", Sets);
  end
  if (Ways != 1 && Ways != (32'd1 << WayWidth)) begin : g_ways
    $error("Ways is %0d, expected a power of two", Ways);
  end
  if (Misses < 2 || Misses != (32'd1 << MissWidth)) begin : g_misses
    $error("Misses is %0d, expected a power of two from 2 on", Misses);
  end
  if (LineBytes != (32'd1 << OffsetBits) || LineBytes < BlockBytes) begin : g_line
    $error("LineBytes is %0d, expected a power of two from %0d on", LineBytes, BlockBytes);
  end
  if (Requesters < 2) begin : g_requesters
    $error("Requesters is %0d, expected 2 or more", Requesters);
  end

  // ---- The lookup -------------------------------------------------------------
  // A request is accepted, and its set is read. A cycle later it leaves, or waits until it can.
  logic                  accepts;
  logic                  leaves;
  logic                  look_valid_q;
  logic [TagWidth-1:0]   look_tag_q;
  logic [LineWidth-1:0]  look_line_q;
  logic [BeatWidth-1:0]  look_beat_q;
  logic [SetWidth-1:0]   look_set;
  logic [LabelWidth-1:0] look_label;
  logic                  clears_q;
  logic                  sweeps;
  logic [SetWidth-1:0]   sweep_q;

  logic unused_address;
  assign unused_address = ^req_addr_i[OffsetBits-1:0];

  assign req_ready_o = ~clears_q & (~look_valid_q | leaves);
  assign accepts     = req_valid_i & req_ready_o;
  assign look_set    = look_line_q[SetWidth-1:0];
  assign look_label  = look_line_q[LineWidth-1:SetWidth];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) look_valid_q <= 1'b0;
    else look_valid_q <= accepts | (look_valid_q & ~leaves);
  end

  always_ff @(posedge clk_i) begin
    if (accepts) begin
      look_tag_q  <= req_tag_i;
      look_line_q <= req_addr_i[AddressWidth-1:OffsetBits];
    end
  end

  if (LineBeats == 1) begin : g_one_beat
    assign look_beat_q = '0;
  end else begin : g_beats
    localparam logic [31:0] BeatBits = OffsetBits - BeatWidth;
    always_ff @(posedge clk_i) begin
      if (accepts) look_beat_q <= req_addr_i[OffsetBits-1:BeatBits];
    end
  end

  // The word of a set has its lines in the order of their last use, each with the way in which it
  // is stored. So a line that is used moves to the front, and the last one is replaced.
  logic [WordWidth-1:0]  stored_word;
  logic [WordWidth-1:0]  initial_word;
  logic [WordWidth-1:0]  word;
  logic [WordWidth-1:0]  next_word;
  logic [WordWidth-1:0]  passed_word_q;
  logic                  is_passed_q;
  logic                  is_swept_q;
  logic                  updates;
  logic [Ways-1:0]       is_found;
  logic                  has_line;
  logic [WayWidth-1:0]   way;
  logic [PlaceWidth-1:0] place;

  for (genvar k = 0; k < Ways; k++) begin : g_ways_of_set
    localparam logic [31:0] Low = $unsigned(k) * EntryWidth;
    assign is_found[k] = (word[Low+WayWidth+:LabelWidth+1] == {1'b1, look_label});
    assign initial_word[Low+:EntryWidth] = EntryWidth'($unsigned(k));
    if (k == 0) begin : g_first
      assign next_word[Low+:EntryWidth] = {1'b1, look_label, way};
    end else begin : g_other
      // The lines that were used after the one that is found move back by a place.
      assign next_word[Low+:EntryWidth] = (is_found[k-1:0] == '0) ? word[Low-EntryWidth+:EntryWidth]
                                        : word[Low+:EntryWidth];
    end
  end

  always_comb begin
    way = word[(Ways-1)*EntryWidth+:WayWidth];
    for (int unsigned k = 0; k < Ways; k++) begin
      if (is_found[k]) way = word[k*EntryWidth+:WayWidth];
    end
  end

  assign word     = is_swept_q ? initial_word : is_passed_q ? passed_word_q : stored_word;
  assign has_line = |is_found;
  assign place    = {look_set, way};

  raypath_ram_1r1w #(.Depth (Sets), .Width (WordWidth)) u_sets (
    .clk_i, .write_enable_i (updates | sweeps), .write_address_i (sweeps ? sweep_q : look_set),
    .write_data_i (sweeps ? initial_word : next_word), .read_enable_i (accepts),
    .read_address_i (req_addr_i[OffsetBits+:SetWidth]), .read_data_o (stored_word)
  );

  // A request that enters while the word of its set is written takes the new one.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      is_passed_q <= 1'b0;
      is_swept_q  <= 1'b0;
    end else begin
      if (accepts) is_passed_q <= updates & (req_addr_i[OffsetBits+:SetWidth] == look_set);
      is_swept_q <= (sweeps & look_valid_q) | (is_swept_q & ~leaves);
    end
  end

  always_ff @(posedge clk_i) begin
    if (updates) passed_word_q <= next_word;
  end

  // ---- Lines under way --------------------------------------------------------
  // Requests of a line under way form a list, from the head to the tail; `u_followers` has the one
  // after each. A line stays under way until all of its list is answered: others of it join.
  logic [Misses-1:0]            is_busy;
  logic [Misses-1:0]            is_same;
  logic [Misses-1:0]            is_victim;
  logic [Misses*TagWidth-1:0]   heads;
  logic [Misses*TagWidth-1:0]   tails;
  logic [Misses*PlaceWidth-1:0] places;
  logic [Misses*BeatWidth-1:0]  arrived;
  logic [Misses-1:0]            has_error;
  logic [MissWidth-1:0]         free;
  logic [MissWidth-1:0]         same;
  logic                         merges;
  logic                         allocates;
  logic                         finishes;
  logic                         line_ends;
  logic [MissWidth-1:0]         walk_miss_q;

  for (genvar k = 0; k < Misses; k++) begin : g_misses_under_way
    localparam logic [MissWidth-1:0] Number = MissWidth'($unsigned(k));
    logic                  busy_q;
    logic                  error_q;
    logic [LineWidth-1:0]  line_q;
    logic [PlaceWidth-1:0] place_q;
    logic [TagWidth-1:0]   head_q;
    logic [TagWidth-1:0]   tail_q;
    logic [BeatWidth-1:0]  beat_q;
    logic                  begins;
    logic                  joins;
    logic                  receives;

    assign begins   = allocates & (free == Number);
    assign joins    = merges & is_same[k];
    assign receives = mem_rsp_valid_i & (mem_rsp_tag_i == Number);

    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) busy_q <= 1'b0;
      else busy_q <= begins | (busy_q & ~(finishes & (walk_miss_q == Number)));
    end

    always_ff @(posedge clk_i) begin
      if (begins) begin
        line_q  <= look_line_q;
        place_q <= place;
        head_q  <= look_tag_q;
      end
      if (begins | joins) tail_q <= look_tag_q;
      error_q <= ~begins & (error_q | (receives & mem_rsp_error_i));
      if (begins) beat_q <= '0;
      else if (receives) beat_q <= beat_q + OneBeat;
    end

    assign is_busy[k]   = busy_q;
    assign is_same[k]   = busy_q & (line_q == look_line_q);
    assign is_victim[k] = busy_q & (place_q == place);
    assign has_error[k] = error_q;
    assign heads[k*TagWidth+:TagWidth]      = head_q;
    assign tails[k*TagWidth+:TagWidth]      = tail_q;
    assign places[k*PlaceWidth+:PlaceWidth] = place_q;
    assign arrived[k*BeatWidth+:BeatWidth]  = beat_q;
  end

  always_comb begin
    free = '0;
    same = '0;
    for (int unsigned k = Misses; k > 0; k--) begin
      if (!is_busy[k-1]) free = MissWidth'(k - 1);
      if (is_same[k-1]) same = MissWidth'(k - 1);
    end
  end

  // The request of a line waits until the blocks of the line that it replaces are read.
  logic                 request_valid_q;
  logic [LineWidth-1:0] request_line_q;
  logic [MissWidth-1:0] request_miss_q;
  logic [2:0]           reads_before_q;
  logic [2:0]           reads_left_q;
  logic                 hit_is_read;
  logic                 can_hit;
  logic                 hits;
  logic                 is_read;

  assign merges    = look_valid_q & (|is_same);
  assign hits      = look_valid_q & ~(|is_same) & ~clears_q & has_line & can_hit;
  assign allocates = look_valid_q & ~(|is_same) & ~clears_q & ~has_line & ~request_valid_q
                   & ~(&is_busy) & ~(|is_victim) & ~is_read;
  assign leaves    = merges | hits | allocates;
  assign updates   = hits | allocates;

  assign mem_req_valid_o = request_valid_q & (reads_before_q == 3'd0);
  assign mem_req_addr_o  = {request_line_q, OffsetBits'(0)};
  assign mem_req_tag_o   = request_miss_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      request_valid_q <= 1'b0;
      reads_left_q    <= '0;
    end else begin
      request_valid_q <= allocates | (request_valid_q & ~(mem_req_valid_o & mem_req_ready_i));
      reads_left_q    <= reads_left_q + 3'(hits) - 3'(hit_is_read);
    end
  end

  always_ff @(posedge clk_i) begin
    if (allocates) begin
      request_line_q <= look_line_q;
      request_miss_q <= free;
    end
    if (allocates) reads_before_q <= reads_left_q - 3'(hit_is_read);
    else if (reads_before_q != 3'd0) reads_before_q <= reads_before_q - 3'(hit_is_read);
  end

  // ---- Invalidation -----------------------------------------------------------
  // After a reset, a request of it, or a line with an error, all sets are written, once no line is
  // under way. A request in the lookup then takes the initial word.
  logic fails;

  assign fails  = mem_rsp_valid_i & mem_rsp_error_i;
  assign sweeps = clears_q & ~(|is_busy);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      clears_q <= 1'b1;
      sweep_q  <= '0;
    end else begin
      clears_q <= invalidate_i | fails | (clears_q & ~(sweeps & (&sweep_q)));
      if (sweeps) sweep_q <= sweep_q + OneSet;
    end
  end

  // ---- The lists of lines that have arrived are answered ------------------------
  typedef enum logic [1:0] {WalkIdle, WalkServe, WalkNext, WalkLoad} walk_state_t;

  walk_state_t           walk_q;
  logic [TagWidth-1:0]   walk_tag_q;
  logic [TagWidth-1:0]   walk_head;
  logic [TagWidth-1:0]   walk_tail;
  logic [PlaceWidth-1:0] walk_place;
  logic [TagWidth-1:0]   follower;
  logic [BeatWidth-1:0]  walk_beat;
  logic                  filled_valid;
  logic [MissWidth-1:0]  filled_miss;
  logic                  begins_walk;
  logic                  has_follower;
  logic                  takes_walk;
  logic [BeatWidth-1:0]  fill_beat;
  logic [PlaceWidth-1:0] fill_place;

  assign fill_beat    = arrived[32'(mem_rsp_tag_i)*BeatWidth+:BeatWidth];
  assign fill_place   = places[32'(mem_rsp_tag_i)*PlaceWidth+:PlaceWidth];
  assign line_ends    = mem_rsp_valid_i & (fill_beat == BeatWidth'(LineBeats - 1));
  assign begins_walk  = (walk_q == WalkIdle) & filled_valid;
  assign walk_head    = heads[32'(filled_miss)*TagWidth+:TagWidth];
  assign walk_tail    = tails[32'(walk_miss_q)*TagWidth+:TagWidth];
  assign walk_place   = places[32'(walk_miss_q)*PlaceWidth+:PlaceWidth];
  assign has_follower = (walk_q == WalkNext) & (walk_tag_q != walk_tail);
  assign finishes     = (walk_q == WalkNext) & ~has_follower & ~(merges & is_same[walk_miss_q]);

  raypath_queue #(.Depth (Misses), .Width (MissWidth)) u_filled (
    .clk_i, .rst_ni, .push_i (line_ends), .data_i (mem_rsp_tag_i), .pop_i (walk_q == WalkIdle),
    .valid_o (filled_valid), .data_o (filled_miss)
  );

  raypath_ram_1r1w #(.Depth (Requesters), .Width (TagWidth)) u_followers (
    .clk_i, .write_enable_i (merges), .write_address_i (tails[32'(same)*TagWidth+:TagWidth]),
    .write_data_i (look_tag_q), .read_enable_i (has_follower), .read_address_i (walk_tag_q),
    .read_data_o (follower)
  );

  if (LineBytes == BlockBytes) begin : g_one_block
    assign walk_beat = '0;
  end else begin : g_blocks
    raypath_ram_1r1w #(.Depth (Requesters), .Width (BeatWidth)) u_beats (
      .clk_i, .write_enable_i (merges | allocates), .write_address_i (look_tag_q),
      .write_data_i (look_beat_q), .read_enable_i (begins_walk | (walk_q == WalkLoad)),
      .read_address_i (begins_walk ? walk_head : follower), .read_data_o (walk_beat)
    );
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      walk_q <= WalkIdle;
    end else begin
      unique case (walk_q)
        WalkIdle:  if (filled_valid) walk_q <= WalkServe;
        WalkServe: if (takes_walk) walk_q <= WalkNext;
        WalkNext:  if (has_follower) walk_q <= WalkLoad;
                   else if (finishes) walk_q <= WalkIdle;
        WalkLoad:  walk_q <= WalkServe;
      endcase
    end
  end

  always_ff @(posedge clk_i) begin
    if (begins_walk) walk_miss_q <= filled_miss;
    if (begins_walk) walk_tag_q <= walk_head;
    else if (walk_q == WalkLoad) walk_tag_q <= follower;
  end

  // ---- Hits wait for the store, and blocks are read from it ---------------------
  logic [Hits*PlaceWidth-1:0] hit_places_q;
  logic [Hits*BeatWidth-1:0]  hit_beats_q;
  logic [Hits*TagWidth-1:0]   hit_tags_q;
  logic [2:0]                 hit_count_q;
  logic [1:0]                 hit_head_q;
  logic [1:0]                 hit_tail_q;
  logic                       takes_hit;
  logic                       prefers_hit_q;
  logic                       read_valid_q;
  logic                       read_is_hit_q;
  logic [PlaceWidth-1:0]      read_place_q;
  logic [BeatWidth-1:0]       read_beat_q;
  logic [BeatWidth-1:0]       read_left_q;
  logic [TagWidth-1:0]        read_tag_q;
  logic                       read_error_q;
  logic                       read_ends;

  assign can_hit     = ~hit_count_q[2];
  assign read_ends   = read_valid_q & (read_left_q == '0);
  assign takes_walk  = (walk_q == WalkServe) & (~read_valid_q | read_ends)
                     & ~((hit_count_q != 3'd0) & prefers_hit_q);
  assign takes_hit   = (hit_count_q != 3'd0) & (~read_valid_q | read_ends) & ~takes_walk;
  assign hit_is_read = read_ends & read_is_hit_q;
  assign is_read     = read_valid_q & (read_place_q == place);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      hit_count_q   <= '0;
      hit_head_q    <= '0;
      hit_tail_q    <= '0;
      prefers_hit_q <= 1'b0;
      read_valid_q  <= 1'b0;
    end else begin
      hit_count_q  <= hit_count_q + 3'(hits) - 3'(takes_hit);
      hit_head_q   <= hit_head_q + 2'(takes_hit);
      hit_tail_q   <= hit_tail_q + 2'(hits);
      // Both sources have their turn.
      if (takes_walk | takes_hit) prefers_hit_q <= takes_walk;
      read_valid_q <= takes_walk | takes_hit | (read_valid_q & ~read_ends);
    end
  end

  always_ff @(posedge clk_i) begin
    if (hits) begin
      hit_places_q[32'(hit_tail_q)*PlaceWidth+:PlaceWidth] <= place;
      hit_beats_q[32'(hit_tail_q)*BeatWidth+:BeatWidth]    <= look_beat_q;
      hit_tags_q[32'(hit_tail_q)*TagWidth+:TagWidth]       <= look_tag_q;
    end
    if (takes_walk | takes_hit) begin
      read_is_hit_q <= takes_hit;
      read_left_q   <= BeatWidth'(Beats - 1);
      read_error_q  <= takes_walk & has_error[walk_miss_q];
      read_place_q  <= takes_hit ? hit_places_q[32'(hit_head_q)*PlaceWidth+:PlaceWidth]
                     : walk_place;
      read_beat_q   <= takes_hit ? hit_beats_q[32'(hit_head_q)*BeatWidth+:BeatWidth] : walk_beat;
      read_tag_q    <= takes_hit ? hit_tags_q[32'(hit_head_q)*TagWidth+:TagWidth] : walk_tag_q;
    end else begin
      read_left_q <= read_left_q - OneBeat;
      read_beat_q <= read_beat_q + OneBeat;
    end
  end

  logic [StoreWidth-1:0] fill_address;
  logic [StoreWidth-1:0] read_address;

  if (LineBeats == 1) begin : g_places
    assign fill_address = fill_place;
    assign read_address = read_place_q;
  end else begin : g_places_and_beats
    assign fill_address = {fill_place, fill_beat};
    assign read_address = {read_place_q, read_beat_q};
  end

  raypath_ram_1r1w #(.Depth (StoredBeats), .Width (DataWidth)) u_store (
    .clk_i, .write_enable_i (mem_rsp_valid_i), .write_address_i (fill_address),
    .write_data_i (mem_rsp_data_i), .read_enable_i (read_valid_q), .read_address_i (read_address),
    .read_data_o (rsp_data_o)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) rsp_valid_o <= 1'b0;
    else rsp_valid_o <= read_valid_q;
  end

  always_ff @(posedge clk_i) begin
    rsp_tag_o   <= read_tag_q;
    rsp_error_o <= read_error_q;
  end

  assign idle_o   = ~look_valid_q & ~(|is_busy) & (hit_count_q == 3'd0) & ~read_valid_q
                  & ~rsp_valid_o;
  assign hits_o   = hits;
  assign merges_o = merges;
  assign misses_o = allocates;

endmodule : raypath_cache
