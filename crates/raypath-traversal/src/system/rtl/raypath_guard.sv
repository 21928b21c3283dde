module raypath_guard #(
  parameter logic [31:0] AddressWidth = 32,
  parameter logic [31:0] DataWidth    = 512,
  parameter logic [31:0] BurstBytes   = 128,
  parameter logic [31:0] TagWidth     = 6
) (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  // Bursts are read from `first_i` to the byte before `end_i`.
  input  logic [AddressWidth-1:0] first_i,
  input  logic [AddressWidth:0]   end_i,
  // The cycles without a beat that the memory may owe one; 0 for any number.
  input  logic [31:0]             timeout_i,
  // Ends the time after a timeout, once the memory has given what it owed.
  input  logic                    clear_i,
  output logic                    timed_out_o,
  output logic                    idle_o,
  // The request of a burst; a tag has one request at a time.
  input  logic                    req_valid_i,
  input  logic [AddressWidth-1:0] req_addr_i,
  input  logic [TagWidth-1:0]     req_tag_i,
  output logic                    req_ready_o,
  // A beat of a burst.
  output logic                    rsp_valid_o,
  output logic [TagWidth-1:0]     rsp_tag_o,
  output logic                    rsp_error_o,
  output logic [DataWidth-1:0]    rsp_data_o,
  // The memory.
  output logic                    mem_req_valid_o,
  output logic [AddressWidth-1:0] mem_req_addr_o,
  output logic [TagWidth-1:0]     mem_req_tag_o,
  input  logic                    mem_req_ready_i,
  input  logic                    mem_rsp_valid_i,
  input  logic [TagWidth-1:0]     mem_rsp_tag_i,
  input  logic                    mem_rsp_error_i,
  input  logic [DataWidth-1:0]    mem_rsp_data_i,
  output logic                    mem_rsp_ready_o
);

  localparam logic [31:0] Tags      = 32'd1 << TagWidth;
  localparam logic [31:0] Beats     = BurstBytes * 8 / DataWidth;
  localparam logic [31:0] BeatWidth = (Beats == 1) ? 1 : $clog2(Beats);
  localparam logic [31:0] BeatBits  = $clog2(Beats);
  localparam logic [31:0] OwedWidth = TagWidth + BeatBits + 1;

  localparam logic [BeatWidth-1:0] OneBeat  = 1;
  localparam logic [BeatWidth-1:0] LastBeat = BeatWidth'(Beats - 1);

  // ---- Requests -----------------------------------------------------------------
  // A request is in the register until the memory takes it, or fails at once.
  logic                    accepts;
  logic                    is_inside;
  logic                    fails;
  logic                    sends;
  logic                    held_q;
  logic [AddressWidth-1:0] held_addr_q;
  logic [TagWidth-1:0]     held_tag_q;
  logic                    dead_q;

  assign req_ready_o     = ~held_q | mem_req_ready_i;
  assign accepts         = req_valid_i & req_ready_o;
  assign is_inside       = (req_addr_i >= first_i)
                         & ({1'b0, req_addr_i} + (AddressWidth + 1)'(BurstBytes) <= end_i);
  assign fails           = accepts & (~is_inside | dead_q);
  assign sends           = held_q & mem_req_ready_i;
  assign mem_req_valid_o = held_q;
  assign mem_req_addr_o  = held_addr_q;
  assign mem_req_tag_o   = held_tag_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) held_q <= 1'b0;
    else held_q <= (accepts & ~fails) | (held_q & ~sends);
  end

  always_ff @(posedge clk_i) begin
    if (accepts) begin
      held_addr_q <= req_addr_i;
      held_tag_q  <= req_tag_i;
    end
  end

  // ---- The time of the memory -----------------------------------------------------
  // After a timeout, late beats are dropped: no request has their tags.
  logic [OwedWidth-1:0] owed_q;
  logic [31:0]          waited_q;
  logic                 receives;
  logic                 is_owed;
  logic                 times_out;
  logic                 has_failed;

  assign receives  = mem_rsp_valid_i & mem_rsp_ready_o;
  assign is_owed   = held_q | (owed_q != '0);
  assign times_out = (timeout_i != 32'd0) & (waited_q >= timeout_i) & ~mem_rsp_valid_i
                   & ~dead_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      owed_q   <= '0;
      waited_q <= '0;
      dead_q   <= 1'b0;
    end else begin
      owed_q   <= owed_q + (sends ? OwedWidth'(Beats) : '0) - OwedWidth'(receives);
      waited_q <= (is_owed & ~mem_rsp_valid_i & ~dead_q) ? waited_q + 32'd1 : '0;
      dead_q   <= times_out | (dead_q & ~(clear_i & idle_o));
    end
  end

  assign timed_out_o = dead_q;

  // ---- Answers ----------------------------------------------------------------------
  // Requests that failed are answered with errors, and the memory waits meanwhile.
  logic [Tags-1:0]           open_q;
  logic [Tags-1:0]           fails_q;
  logic [Tags*BeatWidth-1:0] beats_q;
  logic [TagWidth-1:0]       failed_tag;
  logic                      is_last;

  always_comb begin
    failed_tag = '0;
    for (int unsigned k = Tags; k > 0; k--) begin
      if (fails_q[k-1]) failed_tag = TagWidth'(k - 1);
    end
  end

  assign has_failed      = (fails_q != '0);
  assign mem_rsp_ready_o = dead_q | ~has_failed;
  assign rsp_valid_o     = has_failed | (mem_rsp_valid_i & ~dead_q);
  assign rsp_tag_o       = has_failed ? failed_tag : mem_rsp_tag_i;
  assign rsp_error_o     = has_failed | mem_rsp_error_i;
  assign rsp_data_o      = mem_rsp_data_i;
  assign is_last         = (beats_q[32'(rsp_tag_o)*BeatWidth+:BeatWidth] == LastBeat);
  assign idle_o          = ~is_owed & (open_q == '0);

  for (genvar k = 0; k < Tags; k++) begin : g_tags
    localparam logic [TagWidth-1:0] Tag = TagWidth'($unsigned(k));
    logic                 begins;
    logic                 answers;
    logic                 ends;
    logic [BeatWidth-1:0] beat;

    assign begins  = accepts & (req_tag_i == Tag);
    assign answers = rsp_valid_o & (rsp_tag_o == Tag);
    assign ends    = answers & is_last;
    assign beat    = beats_q[$unsigned(k)*BeatWidth+:BeatWidth];

    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) begin
        open_q[k]  <= 1'b0;
        fails_q[k] <= 1'b0;
      end else begin
        open_q[k]  <= begins | (open_q[k] & ~ends);
        fails_q[k] <= (begins & (fails | times_out)) | (open_q[k] & ~ends & times_out)
                    | (fails_q[k] & ~ends);
      end
    end

    always_ff @(posedge clk_i) begin
      if (begins) beats_q[$unsigned(k)*BeatWidth+:BeatWidth] <= '0;
      else if (answers) beats_q[$unsigned(k)*BeatWidth+:BeatWidth] <= beat + OneBeat;
    end
  end

endmodule : raypath_guard
