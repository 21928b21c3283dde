// For devices whose multipliers do not suffice: a product of 19 to 24 bits each in three multipliers of 18 by 18 bits
// instead of four. The product of the high bits, at most 6 by 6, is in lookup tables.
(* techmap_celltype = "$mul" *)
module raypath_product (A, B, Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  input [A_WIDTH-1:0] A;
  input [B_WIDTH-1:0] B;
  output [Y_WIDTH-1:0] Y;

  wire _TECHMAP_FAIL_ = A_SIGNED || B_SIGNED || A_WIDTH < 19 || A_WIDTH > 24 || B_WIDTH < 19 || B_WIDTH > 24;
  wire [1023:0] _TECHMAP_DO_ = "proc; opt_clean";

  // The widths of the high bits. Other widths fail above, but must be correct Verilog.
  localparam AH = A_WIDTH > 18 ? A_WIDTH - 18 : 1;
  localparam BH = B_WIDTH > 18 ? B_WIDTH - 18 : 1;

  wire [35:0] low = A[17:0] * B[17:0];
  wire [17+BH:0] middle_b = A[17:0] * B[17+BH:18];
  wire [17+AH:0] middle_a = B[17:0] * A[17+AH:18];
  wire [18+(AH>BH?AH:BH):0] middle = middle_a + middle_b;

  genvar i;
  wire [AH+BH-1:0] sum [BH:0];
  assign sum[0] = 0;
  generate
    for (i = 0; i < BH; i = i + 1) begin : row
      assign sum[i+1] = sum[i] + (({{BH{1'b0}}, A[17+AH:18]} & {(AH+BH){B[18+i]}}) << i);
    end
  endgenerate

  // The lowest and the highest product are side by side.
  wire [17+AH+BH:0] upper = {sum[BH], low[35:18]} + middle;
  assign Y = {upper, low[17:0]};
endmodule
