// Jobs leave in the order in which they enter, each once, and none stays inside. The checker stores
// the opcodes of the jobs inside, the oldest in the lowest bits. A job may enter a full FIFO in the
// cycle in which another one leaves.
module raypath_order_properties #(
  parameter int unsigned OpcodeWidth = 2,
  parameter int unsigned Capacity    = 2,  // jobs that fit inside
  parameter int unsigned MaxWaits    = 1   // cycles that a ready sink waits for a job inside
) (
  input logic                   clk_i,
  input logic                   rst_ni,
  input logic                   enter_valid_i,
  input logic                   enter_ready_i,
  input logic [OpcodeWidth-1:0] enter_opcode_i,
  input logic                   leave_valid_i,
  input logic                   leave_ready_i,
  input logic [OpcodeWidth-1:0] leave_opcode_i
);

  localparam int unsigned CountWidth  = $clog2(Capacity + 2);
  localparam int unsigned WaitsWidth  = $clog2(MaxWaits + 2);
  localparam int unsigned InsideWidth = OpcodeWidth * (Capacity + 1);

  logic was_reset_q = 1'b0;  // before the first reset nothing holds

  logic [CountWidth-1:0]  count_q;
  logic [InsideWidth-1:0] inside_q;
  logic [WaitsWidth-1:0]  waits_q;
  logic                   enters;
  logic                   leaves;
  logic                   waiting;
  logic [CountWidth-1:0]  staying;
  logic [InsideWidth-1:0] left;
  logic [InsideWidth-1:0] entering;

  assign enters   = enter_valid_i & enter_ready_i;
  assign leaves   = leave_valid_i & leave_ready_i;
  assign waiting  = leave_ready_i && !leave_valid_i && count_q != '0;
  assign staying  = count_q - {{CountWidth-1{1'b0}}, leaves};
  assign left     = leaves ? inside_q >> OpcodeWidth : inside_q;
  assign entering = {{OpcodeWidth*Capacity{1'b0}}, enter_opcode_i} << (OpcodeWidth * staying);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q  <= '0;
      inside_q <= '0;
      waits_q  <= '0;
    end else begin
      count_q  <= staying + {{CountWidth-1{1'b0}}, enters};
      inside_q <= enters ? left | entering : left;
      waits_q  <= waiting ? waits_q + {{WaitsWidth-1{1'b0}}, 1'b1} : '0;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      was_reset_q <= 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (was_reset_q) begin
      no_more_than_fit: assert (!enters || staying < Capacity[CountWidth-1:0]);
      none_repeated:    assert (!leave_valid_i || count_q != '0);
      none_reordered:   assert (!leave_valid_i || leave_opcode_i == inside_q[OpcodeWidth-1:0]);
      none_lost:        assert (waits_q < MaxWaits[WaitsWidth-1:0]);
    end
  end

endmodule : raypath_order_properties
