
  localparam logic [31:0] Parts     = @PARTS@;
  localparam logic [31:0] RestWidth = @REST@;
  // The digits that are known after each part but the last, 8 bits each, the first part lowest.
  localparam logic [8*Parts-9:0] Known = {@KNOWN@};

  logic                   advance;
  logic [Parts-1:0]       valid_q;
  logic [Parts*Width-1:0] tags_q;
  logic [@LAST_RESULT@:0]            result;
  logic [@LAST_RESULT@:0]            result_q;

  // A result that waits stops all parts.
  assign advance  = ~valid_q[Parts-1] | ready_i;
  assign ready_o  = advance;
  assign valid_o  = valid_q[Parts-1];
  assign result_o = result_q;
  assign tag_o    = tags_q[Parts*Width-1-:Width];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) valid_q <= '0;
    else if (advance) valid_q <= {valid_q[Parts-2:0], valid_i};
  end

  always_ff @(posedge clk_i) begin
    if (advance) begin
      tags_q   <= {tags_q[(Parts-1)*Width-1:0], tag_i};
      result_q <= result;
    end
  end

  // The first part has the class and the exponent. Each has some digits: what remains of the
  // dividend, less the divisor, is negative or not.
  for (genvar k = 0; k < Parts - 1; k++) begin : g_parts
    localparam logic [31:0] Count = 32'(Known[8*k+:8]);
    logic [Count-1:0]     digits;
    logic [RestWidth-1:0] remainder;
    logic [@LAST_EXPONENT@:0]           exponent;
    logic                 settled;
    logic                 sign;
    logic [@LAST_DIVISOR@:0]          divisor;
    logic [Count-1:0]     digits_q;
    logic [RestWidth-1:0] remainder_q;
    logic [@LAST_EXPONENT@:0]           exponent_q;
    logic                 settled_q;
    logic                 sign_q;

    if (k == 0) begin : g_first
      @FIRST@ u_first (
        .a_i, .b_i, .digits_o (digits), .remainder_o (remainder), .exponent_o (exponent),
        .settled_o (settled), .sign_o (sign), .divisor_o (divisor)
      );
    end else begin : g_digits
      localparam logic [31:0] Before = 32'(Known[8*(k-1)+:8]);
      localparam logic [31:0] More   = Count - Before;
      logic [RestWidth-1:0] difference;

      assign exponent = g_parts[k-1].exponent_q;
      assign settled  = g_parts[k-1].settled_q;
      assign sign     = g_parts[k-1].sign_q;
      assign divisor  = g_parts[k-1].g_divisor.divisor_q;

      always_comb begin
        digits     = {g_parts[k-1].digits_q, More'(0)};
        remainder  = g_parts[k-1].remainder_q;
        difference = '0;
        for (int unsigned d = 0; d < More; d++) begin
          difference       = remainder - {2'd1, divisor};
          digits[More-1-d] = ~difference[RestWidth-1];
          remainder        = {difference[RestWidth-1] ? remainder[RestWidth-2:0]
                           : difference[RestWidth-2:0], 1'b0};
        end
      end
    end

    always_ff @(posedge clk_i) begin
      if (advance) begin
        digits_q    <= digits;
        remainder_q <= remainder;
        exponent_q  <= exponent;
        settled_q   <= settled;
        sign_q      <= sign;
      end
    end

    if (k < Parts - 2) begin : g_divisor
      logic [@LAST_DIVISOR@:0] divisor_q;
      always_ff @(posedge clk_i) begin
        if (advance) divisor_q <= divisor;
      end
    end else begin : g_last
      logic unused_divisor;
      assign unused_divisor = ^divisor;
    end
  end

  @LAST@ u_last (
    .digits_i (g_parts[Parts-2].digits_q), .remainder_i (g_parts[Parts-2].remainder_q),
    .exponent_i (g_parts[Parts-2].exponent_q), .settled_i (g_parts[Parts-2].settled_q),
    .sign_i (g_parts[Parts-2].sign_q), .result_o (result)
  );

