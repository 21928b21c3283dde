// An accumulator loads its next value, or zero if the beat resets it, when a beat of its operation
// leaves the step, and otherwise keeps its value: it changes once for each beat.
module raypath_state_properties #(
  parameter int unsigned OpcodeWidth = 2,
  parameter int unsigned Width       = 1,  // bits of the accumulator
  parameter int unsigned Opcode      = 0   // of the operation
) (
  input logic                   clk_i,
  input logic                   rst_ni,
  input logic                   valid_i,
  input logic                   ready_i,
  input logic [OpcodeWidth-1:0] opcode_i,
  input logic                   reset_i,
  input logic [Width-1:0]       sum_i,
  input logic [Width-1:0]       state_i
);

  logic was_reset_q = 1'b0;  // before the first reset nothing holds

  logic [Width-1:0] state_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= '0;
    end else if (valid_i && ready_i && opcode_i == Opcode[OpcodeWidth-1:0]) begin
      state_q <= reset_i ? '0 : sum_i;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      was_reset_q <= 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (was_reset_q) begin
      once_a_beat: assert (state_i == state_q);
    end
  end

endmodule : raypath_state_properties
