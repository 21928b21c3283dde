// SPDX-License-Identifier: MIT OR Apache-2.0
// An agent for raypath_unit: driver, memory, scoreboard and coverage. Scoreboard and coverage work without the others.

module raypath_agent import raypath_agent_pkg::*; (raypath_unit_if bus);

  raypath_agent_driver     u_driver (.bus);
  raypath_agent_memory     u_memory (.bus);
  raypath_agent_scoreboard u_scoreboard (.bus);
  raypath_agent_coverage   u_coverage (.bus);

  function automatic void open(string configuration, string scene, int missing);
    u_memory.block_bytes = raypath_agent_open(configuration, scene, missing);
    if (u_memory.block_bytes == 0) $fatal(1, "no model of %s with %s", configuration, scene);
  endfunction

  function automatic void send(ray_t ray);
    u_driver.rays.push_back(ray);
  endfunction

  // Waits until all rays have ended, or none has for long, and prints the result.
  task automatic finish();
    forever begin
      @(negedge bus.clk_i);
      if (u_driver.rays.size() == 0 && !bus.ray_valid_i && u_scoreboard.pending.size() == 0) break;
      if (u_scoreboard.waits > 200_000) break;
    end
    $display("%0d cycles", u_memory.now);
    u_coverage.report();
    u_scoreboard.report();
  endtask

endmodule : raypath_agent
