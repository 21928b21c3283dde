// The arbiter for inputs that may withdraw what is not taken.
module raypath_arbiter_properties #(
  parameter int N = 4
) (
  input logic clk_i, rst_ni, ready_i,
  input logic [N-1:0] valid_i
);
  wire [N-1:0] grant;
  raypath_arbiter #(.Inputs (N)) u_arbiter (.clk_i, .rst_ni, .valid_i, .ready_i, .grant_o (grant));

  always_comb one_hot: assert ((grant & (grant - N'(1))) == 0);
  always_comb valid: assert ((grant & ~valid_i) == 0);
  always_comb always_one: assert ((grant != 0) == (valid_i != 0));

  // A grant that was not taken.
  logic [N-1:0] p_shown_q;
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_shown_q <= 0;
    else p_shown_q <= ready_i ? 0 : grant;
  always_comb stays: assert ((p_shown_q & valid_i) == 0 || grant == p_shown_q);

  // Some input is followed: the others that are taken while it waits.
  (* anyconst *) logic [$clog2(N)-1:0] p_input;
  always_comb assume (p_input < N);
  logic [2:0] p_others_q;
  wire p_waits = valid_i[p_input] && !grant[p_input];
  always_ff @(posedge clk_i or negedge rst_ni)
    if (!rst_ni) p_others_q <= 0;
    else p_others_q <= p_waits ? p_others_q + {2'd0, ready_i && grant != 0} : 0;
  always_comb fair: assert (!p_waits || p_others_q < N - 1);
endmodule
