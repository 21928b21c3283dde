module raypath_ram_1r1w #(
  parameter  logic [31:0] Depth        = 2,
  parameter  logic [31:0] Width        = 1,
  parameter  logic [31:0] ReadLatency  = 1,
  parameter               Style        = "auto",
  localparam logic [31:0] AddressWidth = $clog2(Depth)
) (
  input  logic                    clk_i,
  input  logic                    write_enable_i,
  input  logic [AddressWidth-1:0] write_address_i,
  input  logic [Width-1:0]        write_data_i,
  input  logic                    read_enable_i,
  input  logic [AddressWidth-1:0] read_address_i,
  output logic [Width-1:0]        read_data_o
);

  // The attribute of Vivado and Yosys, and that of Quartus.
  (* ram_style = Style, ramstyle = Style *)
  logic [Width-1:0] words [Depth];
  logic [Width-1:0] word_q;

  if (Style == "") begin : g_no_style
    initial $error("Style is empty, expected auto or a value of the synthesiser");
  end

  always_ff @(posedge clk_i) begin
    if (write_enable_i) words[write_address_i] <= write_data_i;
  end

  always_ff @(posedge clk_i) begin
    if (read_enable_i) word_q <= words[read_address_i];
  end

  if (ReadLatency == 2) begin : g_output
    // The output register of a block RAM. It needs no enable: `word_q` stays until the next read.
    logic [Width-1:0] output_q;

    always_ff @(posedge clk_i) output_q <= word_q;

    assign read_data_o = output_q;
  end else begin : g_no_output
    assign read_data_o = word_q;
  end

endmodule : raypath_ram_1r1w
