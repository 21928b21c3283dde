// The ports of the traversal unit: a ray that enters ends once or is flushed, a request and a
// candidate have a tag that is not in use, an idle unit waits for nothing, and the memory and the
// user answer what they were asked. After a reset nothing is asked: an answer to a request from
// before it is one that was not requested.
module raypath_unit_ports_properties #(
  parameter int unsigned Contexts     = 8,
  parameter int unsigned ContextWidth = 3,
  parameter int unsigned Beats        = 1  // of a block
) (
  input logic                    clk_i,
  input logic                    rst_ni,
  input logic                    idle_i,
  input logic                    enters_i,
  input logic                    leaves_i,
  input logic                    requests_i,
  input logic [ContextWidth-1:0] request_tag_i,
  input logic                    arrives_i,
  input logic [ContextWidth-1:0] arrival_tag_i,
  input logic                    asks_i,
  input logic [ContextWidth-1:0] asked_tag_i,
  input logic                    answers_i,
  input logic [ContextWidth-1:0] answer_tag_i
);

  localparam int unsigned Tags       = 2 ** ContextWidth;
  localparam int unsigned CountWidth = $clog2(Beats + 1);

  logic was_reset_q = 1'b0;  // before the first reset nothing holds
  logic runs_q = 1'b0;       // a reset has ended

  logic [ContextWidth:0]      inside_q;
  logic [Tags*CountWidth-1:0] left_q;  // beats of each tag that have not arrived
  logic [Tags-1:0]            asked_q;  // candidates without a verdict
  logic [CountWidth-1:0]      left_of_request;
  logic [CountWidth-1:0]      left_of_arrival;

  assign left_of_request = left_q[request_tag_i*CountWidth +: CountWidth];
  assign left_of_arrival = left_q[arrival_tag_i*CountWidth +: CountWidth];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      was_reset_q <= 1'b1;
      runs_q      <= 1'b0;
      inside_q    <= '0;
      left_q      <= '0;
      asked_q     <= '0;
    end else begin
      runs_q   <= was_reset_q;
      inside_q <= (idle_i ? '0 : inside_q)
                + {{ContextWidth{1'b0}}, enters_i} - {{ContextWidth{1'b0}}, leaves_i};
      if (answers_i) begin
        asked_q[answer_tag_i] <= 1'b0;
      end
      if (asks_i) begin
        asked_q[asked_tag_i] <= 1'b1;
      end
      if (arrives_i) begin
        left_q[arrival_tag_i*CountWidth +: CountWidth] <= left_of_arrival - 1'b1;
      end
      if (requests_i) begin
        left_q[request_tag_i*CountWidth +: CountWidth] <= Beats[CountWidth-1:0];
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (runs_q) begin
      hits_have_rays:      assert (!leaves_i || inside_q != 0);
      // A context is free again while its hit waits at the port.
      contexts_suffice:    assert (inside_q <= Contexts[ContextWidth:0] + 1'b1);
      idle_is_empty:       assert (!idle_i || (left_q == '0 && asked_q == '0));
      tags_are_free:       assert (!requests_i || left_of_request == 0);
      asks_once:           assert (!asks_i || !asked_q[asked_tag_i]);
      // Of the memory and of the user, not of the unit.
      arrivals_were_asked: assert (!arrives_i || left_of_arrival != 0);
      answers_were_asked:  assert (!answers_i || asked_q[answer_tag_i]);
    end
  end

endmodule : raypath_unit_ports_properties
