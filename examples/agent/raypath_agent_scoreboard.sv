// SPDX-License-Identifier: MIT OR Apache-2.0
// Watches rays and hits, and compares every word of a hit with the functional model. It drives nothing.

module raypath_agent_scoreboard import raypath_agent_pkg::*; (raypath_unit_if bus);

  typedef struct packed {
    bit [63:0] id;
    bit [31:0] number;  // of the ray, from 0 on
    hit_t      hit;
  } expected_t;

  int        corrupt_ray = -1, corrupt_word = 3;  // a bit of a hit to turn over, to see that it is found
  int        rays = 0, hits = 0, dropped = 0, mismatches = 0, faults = 0, waits = 0, place;
  expected_t pending[$];  // the rays inside
  expected_t expected;
  hit_t      found;

  initial begin
    void'($value$plusargs("corrupt_ray=%d", corrupt_ray));
    void'($value$plusargs("corrupt_word=%d", corrupt_word));
  end

  function automatic void fault(string text);
    faults++;
    if (faults <= 20) $display("ERROR: %s", text);
  endfunction

  function automatic void compare();
    place = -1;
    for (int i = 0; i < pending.size(); i++) begin
      // Of several rays with this id, one with this hit.
      if (pending[i].id == bus.hit_id_o && (place < 0 || pending[i].hit == found)) place = i;
    end
    if (place < 0) begin
      fault($sformatf("a hit has the id %0h, which no ray inside has", bus.hit_id_o));
      return;
    end
    expected = pending[place];
    pending.delete(place);
    if (expected.number == corrupt_ray) found[corrupt_word] = found[corrupt_word] ^ 1;
    if (found != expected.hit) mismatches++;
    for (int word = 0; word < 14; word++) begin
      if (found[word] != expected.hit[word])
        fault($sformatf("ray %0d (id %0h): %s is %h, expected %h", expected.number, bus.hit_id_o, HitPorts[word],
                        found[word], expected.hit[word]));
    end
  endfunction

  always @(posedge bus.clk_i or negedge bus.rst_ni) begin
    if (!bus.rst_ni) begin
      pending.delete();
    end else begin
      waits = pending.size() == 0 ? 0 : waits + 1;
      if (bus.hit_valid_o && bus.hit_ready_i) begin
        waits = 0;
        hits++;
        found = {
          32'(bus.hit_shader_offset_o), 32'(bus.hit_custom_index_o), bus.hit_geometry_o, bus.hit_triangles_o,
          bus.hit_nodes_o, 32'(bus.hit_back_face_o), bus.hit_v_o, bus.hit_u_o, bus.hit_t_denom_o, bus.hit_t_num_o,
          bus.hit_t_o, bus.hit_instance_o, bus.hit_primitive_o, 32'(bus.hit_status_o)
        };
        compare();
      end
      if (bus.ray_valid_i && bus.ray_ready_o) begin
        expected.id     = bus.ray_id_i;
        expected.number = rays;
        rays++;
        raypath_agent_trace('{
          base: bus.ray_base_i, root: bus.ray_root_i, cull_mask: bus.ray_cull_mask_i, flags: bus.ray_flags_i,
          tmax: bus.ray_tmax_i, tmin: bus.ray_tmin_i,
          dir_z: bus.ray_dir_z_i, dir_y: bus.ray_dir_y_i, dir_x: bus.ray_dir_x_i,
          origin_z: bus.ray_origin_z_i, origin_y: bus.ray_origin_y_i, origin_x: bus.ray_origin_x_i
        }, expected.hit);
        pending.push_back(expected);
      end
      if (bus.flush_i) begin
        dropped += pending.size();
        pending.delete();
      end
    end
  end

  // Ends the simulation with an error if there was one.
  function automatic void report();
    if (pending.size() != 0) fault($sformatf("%0d rays did not end, one is %0d", pending.size(), pending[0].number));
    $display("scoreboard: %0d rays, %0d hits, %0d dropped, %0d mismatches", rays, hits, dropped, mismatches);
    if (faults != 0 || hits == 0) $fatal(1, "%0d faults in %0d hits", faults, hits);
  endfunction

endmodule : raypath_agent_scoreboard
