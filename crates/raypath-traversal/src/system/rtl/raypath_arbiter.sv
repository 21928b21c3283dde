module raypath_arbiter #(
  parameter logic [31:0] Inputs = 2
) (
  input  logic              clk_i,
  input  logic              rst_ni,
  input  logic [Inputs-1:0] valid_i,
  input  logic              ready_i,
  output logic [Inputs-1:0] grant_o
);

  localparam logic [Inputs-1:0] One = 1;

  // The inputs after the one that was taken last have their turn first. What waits must not change,
  // so that a grant stays until it is taken.
  logic [Inputs-1:0] after_q;
  logic [Inputs-1:0] held_q;
  logic [Inputs-1:0] held;
  logic [Inputs-1:0] later;
  logic [Inputs-1:0] from;

  assign held    = valid_i & held_q;
  assign later   = valid_i & after_q;
  assign from    = (later != '0) ? later : valid_i;
  assign grant_o = (held != '0) ? held : from & (~from + One);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      after_q <= '0;
      held_q  <= '0;
    end else begin
      if (ready_i && grant_o != '0) after_q <= ~(grant_o | (grant_o - One));
      held_q <= ready_i ? '0 : grant_o;
    end
  end

endmodule : raypath_arbiter
