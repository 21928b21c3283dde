module raypath_registers #(
  parameter  logic [31:0] Depth        = 2,
  parameter  logic [31:0] Width        = 1,
  localparam logic [31:0] AddressWidth = $clog2(Depth)
) (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  input  logic                    write_enable_i,
  input  logic [AddressWidth-1:0] address_i,
  input  logic [Width-1:0]        data_i,
  output logic [Width-1:0]        data_o
);

  localparam logic [31:0] Bits = Depth * Width;
  localparam logic [31:0] IndexWidth = $clog2(Bits);

  logic [Bits-1:0] words_q;

  for (genvar k = 0; k < Depth; k++) begin : g_words
    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) begin
        words_q[k*Width+:Width] <= '0;
      end else if (write_enable_i && address_i == AddressWidth'($unsigned(k))) begin
        words_q[k*Width+:Width] <= data_i;
      end
    end
  end

  assign data_o = words_q[IndexWidth'(address_i)*IndexWidth'(Width)+:Width];

endmodule : raypath_registers
