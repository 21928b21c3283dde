// The ports of the traversal unit: a ray that enters ends once, a request has a tag that is not in
// use, and the memory answers requests alone.
module raypath_unit_ports_properties #(
  parameter int unsigned Contexts     = 8,
  parameter int unsigned ContextWidth = 3,
  parameter int unsigned Beats        = 1  // of a block
) (
  input logic                    clk_i,
  input logic                    rst_ni,
  input logic                    enters_i,
  input logic                    leaves_i,
  input logic                    requests_i,
  input logic [ContextWidth-1:0] request_tag_i,
  input logic                    arrives_i,
  input logic [ContextWidth-1:0] arrival_tag_i
);

  logic                  runs_q;  // not in reset
  logic [ContextWidth:0] inside_q;
  logic [31:0]           left_q [0:2**ContextWidth-1];  // beats of each tag that have not arrived

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      runs_q   <= 1'b0;
      inside_q <= '0;
      for (int tag = 0; tag < 2**ContextWidth; tag++) begin
        left_q[tag] <= '0;
      end
    end else begin
      runs_q   <= 1'b1;
      inside_q <= inside_q + {{ContextWidth{1'b0}}, enters_i} - {{ContextWidth{1'b0}}, leaves_i};
      if (arrives_i) begin
        left_q[arrival_tag_i] <= left_q[arrival_tag_i] - 1;
      end
      if (requests_i) begin
        left_q[request_tag_i] <= Beats;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (runs_q) begin
      hits_have_rays:      assert (!leaves_i || inside_q != 0);
      // A context is free again while its hit waits at the port.
      contexts_suffice:    assert (inside_q <= Contexts[ContextWidth:0] + 1'b1);
      tags_are_free:       assert (!requests_i || left_q[request_tag_i] == 0);
      // Of the memory, not of the unit.
      arrivals_were_asked: assert (!arrives_i || left_q[arrival_tag_i] != 0);
    end
  end

endmodule : raypath_unit_ports_properties
