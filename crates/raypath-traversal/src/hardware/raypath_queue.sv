module raypath_queue #(
  parameter  logic [31:0] Depth        = 2,
  parameter  logic [31:0] Width        = 1,
  localparam logic [31:0] AddressWidth = $clog2(Depth)
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             push_i,
  input  logic [Width-1:0] data_i,
  input  logic             pop_i,
  output logic             valid_o,
  output logic [Width-1:0] data_o
);

  localparam logic [AddressWidth-1:0] One  = 1;
  localparam logic [AddressWidth-1:0] Last = AddressWidth'(Depth - 1);

  logic [AddressWidth-1:0] head_q;
  logic [AddressWidth-1:0] tail_q;
  logic                    valid_q;
  logic                    read;

  // A word waits in the memory only while another is at the output, or for one cycle. So the memory
  // is never full, and it is empty where both ends are the same.
  assign read = (head_q != tail_q) & (~valid_q | pop_i);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      head_q  <= '0;
      tail_q  <= '0;
      valid_q <= 1'b0;
    end else begin
      if (read) head_q <= (head_q == Last) ? '0 : head_q + One;
      if (push_i) tail_q <= (tail_q == Last) ? '0 : tail_q + One;
      valid_q <= read | (valid_q & ~pop_i);
    end
  end

  raypath_ram_1r1w #(.Depth (Depth), .Width (Width)) u_words (
    .clk_i, .write_enable_i (push_i), .write_address_i (tail_q), .write_data_i (data_i),
    .read_enable_i (read), .read_address_i (head_q), .read_data_o (data_o)
  );

  assign valid_o = valid_q;

endmodule : raypath_queue
