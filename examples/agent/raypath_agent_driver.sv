// SPDX-License-Identifier: MIT OR Apache-2.0
// Sends the rays of a queue with gaps between them, takes hits with stalls, and may drop the rays inside.

module raypath_agent_driver import raypath_agent_pkg::*; (raypath_unit_if bus);

  int   ray_gap = 20, hit_stall = 30;  // percent of the cycles
  int   flush = 0;                     // of 100,000 cycles
  ray_t rays[$];
  ray_t ray;
  int   sent = 0;

  initial begin
    void'($value$plusargs("ray_gap=%d", ray_gap));
    void'($value$plusargs("hit_stall=%d", hit_stall));
    void'($value$plusargs("flush=%d", flush));
  end

  always @(posedge bus.clk_i or negedge bus.rst_ni) begin
    if (!bus.rst_ni) begin
      bus.ray_valid_i <= 1'b0;
      bus.hit_ready_i <= 1'b0;
      bus.flush_i     <= 1'b0;
    end else begin
      bus.hit_ready_i <= !chance(hit_stall);
      bus.flush_i     <= int'($urandom_range(99_999)) < flush;
      if (!bus.ray_valid_i || bus.ray_ready_o) begin
        bus.ray_valid_i <= 1'b0;
        if (rays.size() != 0 && !chance(ray_gap)) begin
          ray = rays.pop_front();
          bus.ray_valid_i <= 1'b1;
          bus.ray_id_i    <= sent;
          sent++;
          {bus.ray_origin_x_i, bus.ray_origin_y_i, bus.ray_origin_z_i} <= {ray.origin_x, ray.origin_y, ray.origin_z};
          {bus.ray_dir_x_i, bus.ray_dir_y_i, bus.ray_dir_z_i} <= {ray.dir_x, ray.dir_y, ray.dir_z};
          {bus.ray_tmin_i, bus.ray_tmax_i, bus.ray_root_i} <= {ray.tmin, ray.tmax, ray.root};
          bus.ray_flags_i     <= ray.flags;
          bus.ray_cull_mask_i <= ray.cull_mask;
          bus.ray_base_i      <= ray.base;
        end
      end
    end
  end

endmodule : raypath_agent_driver
