// The pipeline accepts no more jobs than the exit has places for.
module raypath_credit_properties #(
  parameter int unsigned Capacity = 1  // places at the exit
) (
  input logic clk_i,
  input logic rst_ni,
  input logic enters_i,
  input logic returned_i
);

  localparam int unsigned CountWidth = $clog2(Capacity + 2);

  logic was_reset_q = 1'b0;  // before the first reset nothing holds

  logic [CountWidth-1:0] count_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
    end else begin
      count_q <= count_q + {{CountWidth-1{1'b0}}, enters_i} - {{CountWidth-1{1'b0}}, returned_i};
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      was_reset_q <= 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (was_reset_q) begin
      none_without_a_place: assert (!enters_i || count_q < Capacity[CountWidth-1:0]);
    end
  end

endmodule : raypath_credit_properties
