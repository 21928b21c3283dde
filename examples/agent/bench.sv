// SPDX-License-Identifier: MIT OR Apache-2.0
// A bench of the traversal unit: the rays of a file, many of them changed, through the unit with the agent around it.

module bench import raypath_agent_pkg::*; #(
  parameter int IdWidth = 16, TagWidth = 6, AddressWidth = 32, MemoryWidth = 512
);
  logic clk = 1'b0, rst_n = 1'b0;
  always #5 clk = !clk;

  raypath_unit_if #(
    .IdWidth(IdWidth), .TagWidth(TagWidth), .AddressWidth(AddressWidth), .MemoryWidth(MemoryWidth)
  ) bus (.clk_i(clk), .rst_ni(rst_n));

  raypath_unit u_unit (
    `include "raypath_unit_ports.svh"  // .port(bus.port) for each port; run.sh writes it
  );

  raypath_agent u_agent (.bus);

  string folder = ".";
  int    missing = 0;     // bytes at the end of the scene that the memory does not have
  int    root = 32'h20;   // where `raypath scene` puts the root of a scene without instances
  ray_t  ray;
  initial begin
    void'($value$plusargs("folder=%s", folder));
    void'($value$plusargs("missing=%d", missing));
    void'($value$plusargs("root=%h", root));
    void'($value$plusargs("node_limit=%d", bus.node_limit_i));
    u_agent.open({folder, "/unit.toml"}, {folder, "/scene.bin"}, missing);
    while (raypath_agent_read({folder, "/rays.txt"}, ray) != 0) begin
      ray.root = root;
      if (chance(30)) ray.flags = 1 << $urandom_range(9) | 1 << $urandom_range(9);
      if (chance(5)) {ray.tmin, ray.tmax} = {9'h7e, 23'($urandom), 9'h7f, 23'($urandom)};  // 0.5 to 1, 1 to 2
      if (chance(3)) ray.dir_x = $urandom;
      if (chance(2)) ray.root = chance(50) ? 32'hffff_ff20 : 32'h3f;  // behind the scene; a kind that is not valid
      u_agent.send(ray);
    end
    repeat (4) @(negedge clk);
    rst_n = 1'b1;
    u_agent.finish();
    $finish;
  end

endmodule : bench
