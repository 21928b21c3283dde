// SPDX-License-Identifier: MIT OR Apache-2.0
// The ports of raypath_unit by their names. Those that not every unit has are of 2 states: 0 where they are missing.

interface raypath_unit_if #(
  parameter int IdWidth = 16, TagWidth = 6, AddressWidth = 32, MemoryWidth = 512,
  parameter int BaseWidth = AddressWidth > 32 ? AddressWidth - 32 : 1
) (
  input logic clk_i,
  input logic rst_ni
);
  logic [31:0]             node_limit_i = 32'd1 << 24;
  logic                    flush_i, idle_o, busy_o;

  logic                    ray_valid_i, ray_ready_o;
  logic [IdWidth-1:0]      ray_id_i;
  logic [9:0]              ray_flags_i;
  logic [7:0]              ray_cull_mask_i;
  logic [BaseWidth-1:0]    ray_base_i;
  logic [31:0]             ray_root_i, ray_tmin_i, ray_tmax_i, ray_origin_x_i, ray_origin_y_i, ray_origin_z_i;
  logic [31:0]             ray_dir_x_i, ray_dir_y_i, ray_dir_z_i;

  logic                    hit_valid_o, hit_ready_i, hit_back_face_o;
  logic [IdWidth-1:0]      hit_id_o;
  logic [2:0]              hit_status_o;
  logic [31:0]             hit_t_o, hit_t_num_o, hit_t_denom_o, hit_primitive_o, hit_nodes_o, hit_triangles_o;
  bit   [31:0]             hit_u_o, hit_v_o, hit_instance_o, hit_geometry_o;
  bit   [23:0]             hit_custom_index_o, hit_shader_offset_o;

  logic                    mem_req_valid_o, mem_req_ready_i, mem_rsp_valid_i, mem_rsp_ready_o, mem_rsp_error_i;
  logic [TagWidth-1:0]     mem_req_tag_o, mem_rsp_tag_i;
  logic [AddressWidth-1:0] mem_req_addr_o;
  logic [MemoryWidth-1:0]  mem_rsp_data_i;

  logic                    count_boxes_o, count_triangles_o, count_transforms_o, count_steps_o, count_fetches_o;
  logic                    count_rays_o, count_restarts_o, count_job_stalls_o, count_candidates_o;

endinterface : raypath_unit_if
