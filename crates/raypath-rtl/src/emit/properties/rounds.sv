// In a folded pipeline, jobs keep their distance, and none is lost or repeated.
module raypath_rounds_properties #(
  parameter int unsigned Positions = 2,
  parameter int unsigned Interval  = 2   // the least number of positions between two jobs
) (
  input logic                 clk_i,
  input logic                 rst_ni,
  input logic                 enters_i,
  input logic                 leaves_i,
  input logic [Positions-1:0] at_i
);

  localparam int unsigned CountWidth = $clog2(Positions + 2);

  logic was_reset_q = 1'b0;  // before the first reset nothing holds

  logic [CountWidth-1:0] count_q;
  logic [CountWidth-1:0] count;
  logic [Positions-1:0]  too_near;

  always_comb begin
    count    = '0;
    too_near = '0;
    for (int unsigned i = 0; i < Positions; i++) begin
      count = count + {{CountWidth-1{1'b0}}, at_i[i]};
    end
    for (int unsigned i = 1; i < Interval; i++) begin
      too_near = too_near | (at_i & (at_i >> i));
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
    end else begin
      count_q <= count_q + {{CountWidth-1{1'b0}}, enters_i} - {{CountWidth-1{1'b0}}, leaves_i};
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      was_reset_q <= 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (was_reset_q) begin
      none_too_near:         assert (too_near == '0);
      none_lost_or_repeated: assert (count == count_q);
    end
  end

endmodule : raypath_rounds_properties
