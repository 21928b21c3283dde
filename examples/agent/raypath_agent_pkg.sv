// SPDX-License-Identifier: MIT OR Apache-2.0
// Types of the agent, and the functions of raypath_agent.c, which calls the models of libraypath.

package raypath_agent_pkg;

  // The structures raypath_unit_ray and raypath_unit_hit of raypath.h: their first word is in bits 31 to 0.
  typedef struct packed {
    bit [31:0] base, root, cull_mask, flags, tmax, tmin, dir_z, dir_y, dir_x, origin_z, origin_y, origin_x;
  } ray_t;

  typedef bit [13:0][31:0] hit_t;

  localparam string HitPorts[14] = '{
    "hit_status_o", "hit_primitive_o", "hit_instance_o", "hit_t_o", "hit_t_num_o", "hit_t_denom_o", "hit_u_o",
    "hit_v_o", "hit_back_face_o", "hit_nodes_o", "hit_triangles_o", "hit_geometry_o",
    "hit_custom_index_o", "hit_shader_offset_o"
  };

  // Opens the unit of a configuration, and a scene without its last bytes. Returns the bytes of a block, or 0.
  import "DPI-C" function int raypath_agent_open(input string configuration, input string scene, input int missing);
  // Reads the next ray of a file: origin, direction, and the distance up to which hits count. 0 at its end.
  import "DPI-C" function int raypath_agent_read(input string file, output ray_t ray);
  // The hit of a ray, by the functional model.
  import "DPI-C" function void raypath_agent_trace(input ray_t ray, output hit_t hit);
  // A block of the scene. Returns 0 if there is none.
  import "DPI-C" function int raypath_agent_block(input longint address, output bit [1023:0] data);

  // 1 in a percentage of the calls.
  function automatic bit chance(int percent);
    return int'($urandom_range(99)) < percent;
  endfunction

endpackage : raypath_agent_pkg
