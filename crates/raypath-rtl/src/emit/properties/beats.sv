// An accumulator that one step reads and a later step writes: at most one beat is between the two, so
// each beat reads the value that the beat before it wrote.
module raypath_beats_properties #(
  parameter int unsigned OpcodeWidth = 2,
  parameter int unsigned Opcode      = 0  // of the operation
) (
  input logic                   clk_i,
  input logic                   rst_ni,
  input logic                   read_valid_i,
  input logic                   read_ready_i,
  input logic [OpcodeWidth-1:0] read_opcode_i,
  input logic                   write_valid_i,
  input logic                   write_ready_i,
  input logic [OpcodeWidth-1:0] write_opcode_i
);

  logic was_reset_q = 1'b0;  // before the first reset nothing holds

  logic between_q;
  logic reads;
  logic writes;

  assign reads  = read_valid_i && read_ready_i && read_opcode_i == Opcode[OpcodeWidth-1:0];
  assign writes = write_valid_i && write_ready_i && write_opcode_i == Opcode[OpcodeWidth-1:0];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      between_q <= 1'b0;
    end else begin
      between_q <= reads || (between_q && !writes);
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      was_reset_q <= 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (was_reset_q) begin
      reads_what_is_written: assert (!reads || !between_q);
      writes_what_it_read:   assert (!writes || between_q);
    end
  end

endmodule : raypath_beats_properties
