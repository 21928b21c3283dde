// An output that is not accepted stays valid and unchanged.
module raypath_stall_properties #(
  parameter int unsigned Width = 1  // bits of the output
) (
  input logic             clk_i,
  input logic             rst_ni,
  input logic             valid_i,
  input logic             ready_i,
  input logic [Width-1:0] data_i
);

  logic was_reset_q = 1'b0;  // before the first reset nothing holds

  logic             stalled_q;
  logic [Width-1:0] data_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      stalled_q <= 1'b0;
      data_q    <= '0;
    end else begin
      stalled_q <= valid_i & ~ready_i;
      data_q    <= data_i;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      was_reset_q <= 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (was_reset_q) begin
      valid_stays: assert (!stalled_q || valid_i);
      data_stay:   assert (!stalled_q || data_i == data_q);
    end
  end

endmodule : raypath_stall_properties
