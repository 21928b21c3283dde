// The word at one address of a memory, which one is free. What is read at another address is free, too.
module raypath_ram_1r1w #(
  parameter int Depth = 2,
  parameter int Width = 1,
  parameter int ReadLatency = 1,
  localparam int AddressWidth = $clog2(Depth)
) (
  input  logic clk_i, write_enable_i, read_enable_i,
  input  logic [AddressWidth-1:0] write_address_i, read_address_i,
  input  logic [Width-1:0] write_data_i,
  output logic [Width-1:0] read_data_o
);
  (* anyconst *) logic [AddressWidth-1:0] slot;
  always_comb assume (slot < Depth);
  (* anyseq *) logic [Width-1:0] other;
  logic [Width-1:0] word_q, read_q, output_q;
  always_ff @(posedge clk_i) begin
    if (write_enable_i && write_address_i == slot) word_q <= write_data_i;
    if (read_enable_i) read_q <= read_address_i == slot ? word_q : other;
    output_q <= read_q;
  end
  assign read_data_o = ReadLatency == 2 ? output_q : read_q;
endmodule
