// The first of four boxes on a ray: an example that instantiates the wrapper of the datapath.

module nearest_box (
  input  logic                           clk_i,
  input  logic                           rst_ni,
  input  logic                           ray_valid_i,
  output logic                           ray_ready_o,
  input  raypath_wrapper_pkg::job_ray_t  ray_i,
  input  raypath_wrapper_pkg::job_aabb_t box_0_i,
  input  raypath_wrapper_pkg::job_aabb_t box_1_i,
  input  raypath_wrapper_pkg::job_aabb_t box_2_i,
  input  raypath_wrapper_pkg::job_aabb_t box_3_i,
  output logic                           hit_valid_o,
  input  logic                           hit_ready_i,
  output logic                           is_hit_o,
  output logic [1:0]                     box_o,
  output logic [31:0]                    distance_o
);

  // ANCHOR: body
  raypath_wrapper_pkg::job_t     job;
  raypath_wrapper_pkg::outcome_t outcome;

  always_comb begin
    job        = '0;
    job.opcode = raypath_pkg::OpQuadbox;
    job.ray    = ray_i;
    job.aabb_0 = box_0_i;
    job.aabb_1 = box_1_i;
    job.aabb_2 = box_2_i;
    job.aabb_3 = box_3_i;
  end

  raypath_wrapper u_raypath (
    .clk_i          (clk_i),
    .rst_ni         (rst_ni),
    .input_valid_i  (ray_valid_i),
    .input_ready_o  (ray_ready_o),
    .job_i          (job),
    .output_valid_o (hit_valid_o),
    .output_ready_i (hit_ready_i),
    .outcome_o      (outcome)
  );

  // Hits come first, the nearest before the others.
  assign is_hit_o   = outcome.is_intersect[0];
  assign box_o      = outcome.box.index_0;
  assign distance_o = outcome.tmin_0;
  // ANCHOR_END: body

  logic unused_outcome;
  assign unused_outcome = ^outcome;

endmodule : nearest_box
