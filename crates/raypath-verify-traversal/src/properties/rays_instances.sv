  // The same of what is kept for a ray in an instance.
  wire p_object_constants_right, p_object_constants_stays, p_object_origins_right, p_object_origins_stays;
  wire p_directions_right, p_directions_stays;
  (* hierconn *) logic [A-1:0] \u_object_constants.slot ;
  (* hierconn *) logic [197:0] \u_object_constants.word_q ;
  always_comb assume (\u_object_constants.slot == p_context);
  p_kept #(.B (9)) p_keeps_object_constants (
    .clk_i, .rst_ni, .writes (p_known && p_is_instance && p_known_context == p_context),
    .reads (job_read_i && job_context_i == p_context), .ignored (!p_is_inside),
    .given (p_constants),
    .stored ({\u_object_constants.word_q [166], \u_object_constants.word_q [134], \u_object_constants.word_q [102],
      \u_object_constants.word_q [70], \u_object_constants.word_q [38], \u_object_constants.word_q [6], \u_object_constants.word_q [4],
      \u_object_constants.word_q [2], \u_object_constants.word_q [0]}),
    .shown ({job_inv_x_o[0], job_inv_y_o[0], job_inv_z_o[0], job_shear_x_o[0], job_shear_y_o[0],
      job_shear_z_o[0], job_kx_o[0], job_ky_o[0], job_kz_o[0]}),
    .right (p_object_constants_right), .stays (p_object_constants_stays)
  );
  (* hierconn *) logic [A-1:0] \u_object_origins.slot ;
  (* hierconn *) logic [95:0] \u_object_origins.word_q ;
  always_comb assume (\u_object_origins.slot == p_context);
  p_kept #(.B (96)) p_keeps_object_origins (
    .clk_i, .rst_ni, .writes (entries_enters_instance && entries_origin_context == p_context),
    .reads (job_read_i && job_context_i == p_context), .ignored (!p_is_inside),
    .given ({entries_object_x, entries_object_y, entries_object_z}), .stored (\u_object_origins.word_q ),
    .shown ({job_origin_x_o, job_origin_y_o, job_origin_z_o}),
    .right (p_object_origins_right), .stays (p_object_origins_stays)
  );
  (* hierconn *) logic [A-1:0] \u_directions.slot ;
  (* hierconn *) logic [95:0] \u_directions.word_q ;
  always_comb assume (\u_directions.slot == p_context);
  p_kept #(.B (96)) p_keeps_directions (
    .clk_i, .rst_ni, .writes (p_enters && contexts_context == p_context),
    .reads (job_read_i && job_context_i == p_context), .ignored (1'b0),
    .given ({entry_dir_x_i, entry_dir_y_i, entry_dir_z_i}), .stored (\u_directions.word_q ),
    .shown ({job_dir_x_o, job_dir_y_o, job_dir_z_o}),
    .right (p_directions_right), .stays (p_directions_stays)
  );
  always_comb kept_in_instances: assert (p_object_constants_right && p_object_origins_right && p_directions_right);
  wire p_instances_stay = p_object_constants_stays && p_object_origins_stays && p_directions_stays;

