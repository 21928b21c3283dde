/* SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * libraypath: a ray-tracer datapath for C. Generated from crates/raypath-capi; do not edit.
 *
 * A function that fails returns a status below 0, and raypath_last_error has the message. "Safety" names what a caller
 * must guarantee, because a function cannot check it.
 */

#ifndef RAYPATH_H
#define RAYPATH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * A port of `raypath_port` is a floating-point number.
 */
#define RAYPATH_PORT_NUMBER 0

/**
 * One truth value, or several, one per bit.
 */
#define RAYPATH_PORT_FLAGS 1

/**
 * An unsigned word.
 */
#define RAYPATH_PORT_WORD 2

/**
 * A job of `raypath_job`: a ray against a triangle.
 */
#define RAYPATH_JOB_TRIANGLE 0

/**
 * A ray against four boxes.
 */
#define RAYPATH_JOB_QUADBOX 1

/**
 * A beat of a Euclidean distance.
 */
#define RAYPATH_JOB_EUCLIDEAN 2

/**
 * A beat of an angular distance.
 */
#define RAYPATH_JOB_ANGULAR 3

/**
 * A job of any operation, by its opcode, as the words at its ports.
 */
#define RAYPATH_JOB_WORDS 4

/**
 * The time of a job without its values, by its opcode. Accumulators do not change.
 */
#define RAYPATH_JOB_TIMING 5

/**
 * `raypath_search_reply`: the neighbours are complete.
 */
#define RAYPATH_SEARCH_DONE 0

/**
 * A word of the job is outside its range; there are no neighbours.
 */
#define RAYPATH_SEARCH_REFUSED 1

/**
 * The memory reported an error, or there is nothing at an address; there are no neighbours.
 */
#define RAYPATH_SEARCH_MEMORY 2

/**
 * The version of the binary interface. It changes when a program that was compiled against an older header would not
 * work.
 */
#define RAYPATH_ABI_VERSION 1

/**
 * `raypath_unit_hit`: no triangle is hit.
 */
#define RAYPATH_UNIT_MISS 0

/**
 * A triangle is hit.
 */
#define RAYPATH_UNIT_HIT 1

/**
 * A procedural box is hit, as the caller decided.
 */
#define RAYPATH_UNIT_PROCEDURAL 2

/**
 * The ray is refused: a direction that cannot be inverted, a value that is not finite, a negative `t_min`, flags that
 * have no meaning together.
 */
#define RAYPATH_UNIT_REFUSED 3

/**
 * The memory reported an error, or there is nothing at an address.
 */
#define RAYPATH_UNIT_MEMORY 4

/**
 * The scene is not valid.
 */
#define RAYPATH_UNIT_SCENE 5

/**
 * The ray has read as many nodes or triangles as it may.
 */
#define RAYPATH_UNIT_LIMIT 6

/**
 * The `instance` of a `raypath_unit_hit` whose triangle is in none.
 */
#define RAYPATH_UNIT_NO_INSTANCE 4294967295

/**
 * A bit of `flags` of `raypath_unit_ray`: every triangle counts as opaque.
 */
#define RAYPATH_RAY_OPAQUE 1

/**
 * Every triangle counts as non-opaque.
 */
#define RAYPATH_RAY_NO_OPAQUE 2

/**
 * The ray ends with the first block of triangles with a hit.
 */
#define RAYPATH_RAY_TERMINATE_ON_FIRST_HIT 4

/**
 * Without an effect on traversal.
 */
#define RAYPATH_RAY_SKIP_CLOSEST_HIT_SHADER 8

/**
 * Back faces are not hit.
 */
#define RAYPATH_RAY_CULL_BACK_FACING_TRIANGLES 16

/**
 * Front faces are not hit.
 */
#define RAYPATH_RAY_CULL_FRONT_FACING_TRIANGLES 32

/**
 * Triangles that count as opaque are not hit.
 */
#define RAYPATH_RAY_CULL_OPAQUE 64

/**
 * Triangles that count as non-opaque are not hit.
 */
#define RAYPATH_RAY_CULL_NO_OPAQUE 128

/**
 * Triangles are not hit.
 */
#define RAYPATH_RAY_SKIP_TRIANGLES 256

/**
 * Procedural boxes are not hit.
 */
#define RAYPATH_RAY_SKIP_AABBS 512

/**
 * A bit of `flags` of `raypath_unit_instance`: faces are not culled.
 */
#define RAYPATH_INSTANCE_FACING_CULL_DISABLE 1

/**
 * Front and back faces are exchanged.
 */
#define RAYPATH_INSTANCE_FLIP_FACING 2

/**
 * Its geometries count as opaque.
 */
#define RAYPATH_INSTANCE_FORCE_OPAQUE 4

/**
 * Its geometries count as non-opaque.
 */
#define RAYPATH_INSTANCE_FORCE_NO_OPAQUE 8

/**
 * The phase of a ray whose constants are computed.
 */
#define RAYPATH_PHASE_SET_UP 0

/**
 * The phase of a ray that waits for a block of the memory.
 */
#define RAYPATH_PHASE_MEMORY 1

/**
 * The phase of a ray that waits for the jobs of a block, or for its next step.
 */
#define RAYPATH_PHASE_JOBS 2

/**
 * The phase of a ray that has ended and waits for the channel of hits.
 */
#define RAYPATH_PHASE_ENDED 3

/**
 * The phase of a ray that waits for a verdict on a candidate.
 */
#define RAYPATH_PHASE_VERDICT 4

/**
 * A datapath: a configuration with its operations, models and hardware. It does not change, so any number of threads
 * may use it at once, until `raypath_close`.
 */
typedef struct raypath_datapath raypath_datapath;

/**
 * The cycle-exact model of a datapath. One thread at a time may use it; another thread may use it later.
 *
 * A cycle consists of at most one accepted `raypath_pipeline_offer`, then `raypath_pipeline_step`.
 */
typedef struct raypath_pipeline raypath_pipeline;

/**
 * A ray that waits for its caller at each candidate, as `rayQueryEXT` does. One thread at a time may use it.
 */
typedef struct raypath_query raypath_query;

/**
 * A scene in memory, as a traversal unit reads it. It does not change, so any number of threads may use it at once,
 * until `raypath_scene_free`.
 */
typedef struct raypath_scene raypath_scene;

/**
 * A traversal unit: a ray goes in, its closest or any hit comes out. It does not change, so any number of threads may
 * use it at once, until `raypath_unit_close`.
 */
typedef struct raypath_unit raypath_unit;

/**
 * The cycle-exact model of a traversal unit. One thread at a time may use it; another thread may use it later.
 *
 * A cycle consists of `raypath_unit_model_outputs`, which depend on earlier cycles alone, then
 * `raypath_unit_model_step`. The caller is the memory.
 */
typedef struct raypath_unit_model raypath_unit_model;

/**
 * The result of a call: 0 success, above 0 success of another kind, below 0 an error.
 */
typedef int32_t raypath_status;

/**
 * A ray with the values that the hardware expects, 64 bytes. They are derived from origin, direction and extent by
 * `raypath_ray_init` (in Rust `Ray::new`).
 */
typedef struct {
  /**
   * The point at which the ray begins.
   */
  float origin[3];
  /**
   * The direction, of any length except 0.
   */
  float direction[3];
  /**
   * 1 / direction, element by element; infinite where the direction is 0.
   */
  float inverse[3];
  /**
   * The length of the ray, in units of the direction's length. Boxes beyond it are missed.
   */
  float extent;
  /**
   * The direction along `kx` and along `ky`, and 1, each divided by the direction along `kz`.
   */
  float shear[3];
  /**
   * The axis that becomes x when the axes are permuted so that the ray runs along z: 0, 1 or 2.
   */
  uint32_t kx;
  /**
   * The axis that becomes y: 0, 1 or 2.
   */
  uint32_t ky;
  /**
   * The axis that becomes z: that of the direction's component of greatest magnitude.
   */
  uint32_t kz;
} raypath_ray;

/**
 * An axis-aligned box, 24 bytes.
 */
typedef struct {
  /**
   * The lesser bound along x, y and z.
   */
  float min[3];
  /**
   * The greater bound along x, y and z.
   */
  float max[3];
} raypath_box;

/**
 * The four boxes of a job sorted by distance: hits before misses, nearer before farther. 24 bytes.
 */
typedef struct {
  /**
   * The distance at which the ray enters the box at each position of the order, in units of the direction's length;
   * infinity for a miss.
   */
  float tmin[4];
  /**
   * Whether the box at each position is hit: 0 or 1.
   */
  uint8_t is_intersect[4];
  /**
   * The index of the box in the job: 0 to 3.
   */
  uint8_t box_index[4];
} raypath_quadbox_result;

/**
 * The vertices of a triangle, counter-clockwise as seen from its front, 36 bytes.
 */
typedef struct {
  /**
   * The first vertex.
   */
  float a[3];
  /**
   * The second vertex.
   */
  float b[3];
  /**
   * The third vertex.
   */
  float c[3];
} raypath_vertices;

/**
 * The distance to a triangle as a fraction; the datapath does not divide. 12 bytes.
 */
typedef struct {
  /**
   * Numerator of the distance, in units of the direction's length times `t_denom`.
   */
  float t_num;
  /**
   * Denominator of the distance.
   */
  float t_denom;
  /**
   * Whether the ray hits the triangle: 0 or 1.
   */
  uint32_t triangle_hit;
} raypath_triangle_result;

/**
 * An operation of a datapath.
 */
typedef struct {
  /**
   * The name. It is valid while the datapath is open.
   */
  const char *name;
  /**
   * The value of the ports `opcode_i` and `opcode_o`.
   */
  uint64_t opcode;
  /**
   * The number of input ports, without those of the handshake and the opcode.
   */
  size_t inputs;
  /**
   * The number of output ports.
   */
  size_t outputs;
  /**
   * Cycles between two jobs of this operation if nothing stalls.
   */
  uint32_t initiation_interval;
} raypath_operation_info;

/**
 * A port of an operation.
 */
typedef struct {
  /**
   * The name without direction suffix, for example `ray_origin_x`. It is valid while the datapath is open.
   */
  const char *name;
  /**
   * One of `RAYPATH_PORT_…`.
   */
  int32_t kind;
  /**
   * The width of the port's word in bits; of a number, that of the IEEE 754 layout.
   */
  uint32_t width;
} raypath_port;

/**
 * Counts of units and registers.
 */
typedef struct {
  /**
   * Encoders to the recoded format.
   */
  uint32_t encoders;
  /**
   * Adders.
   */
  uint32_t adders;
  /**
   * Multipliers.
   */
  uint32_t multipliers;
  /**
   * Comparators.
   */
  uint32_t comparators;
  /**
   * Decoders from the recoded format.
   */
  uint32_t decoders;
  /**
   * Flip-flops.
   */
  uint64_t flip_flops;
} raypath_cost_counts;

/**
 * A ray and four boxes.
 */
typedef struct {
  /**
   * The ray.
   */
  raypath_ray ray;
  /**
   * The boxes.
   */
  raypath_box boxes[4];
} raypath_quadbox_input;

/**
 * A ray and a triangle.
 */
typedef struct {
  /**
   * The ray.
   */
  raypath_ray ray;
  /**
   * The triangle.
   */
  raypath_vertices triangle;
} raypath_triangle_input;

/**
 * A beat of a distance. `a` and `b` have `raypath_lanes` elements for a Euclidean beat, and half as many for an
 * angular one; they are read while the job is offered.
 */
typedef struct {
  /**
   * The query's coordinates.
   */
  const float *a;
  /**
   * The candidate's coordinates.
   */
  const float *b;
  /**
   * Bit i says whether lane i counts.
   */
  uint64_t mask;
  /**
   * Not 0: the sums restart at zero after this beat.
   */
  uint32_t reset_accum;
} raypath_beat_input;

/**
 * The words at the input ports of an operation, in the order of `raypath_input`; they are read while the job is
 * offered.
 */
typedef struct {
  /**
   * The operation's opcode.
   */
  uint64_t opcode;
  /**
   * The words.
   */
  const uint64_t *inputs;
  /**
   * The number of words.
   */
  size_t count;
} raypath_words_input;

/**
 * The input of a job.
 */
typedef union {
  /**
   * Of `RAYPATH_JOB_QUADBOX`.
   */
  raypath_quadbox_input quadbox;
  /**
   * Of `RAYPATH_JOB_TRIANGLE`.
   */
  raypath_triangle_input triangle;
  /**
   * Of `RAYPATH_JOB_EUCLIDEAN` and `RAYPATH_JOB_ANGULAR`.
   */
  raypath_beat_input beat;
  /**
   * Of `RAYPATH_JOB_WORDS` and `RAYPATH_JOB_TIMING`, which reads the opcode alone.
   */
  raypath_words_input words;
} raypath_job_input;

/**
 * A job. `kind` is one of `RAYPATH_JOB_…` and selects the member of `input`.
 */
typedef struct {
  /**
   * One of `RAYPATH_JOB_…`.
   */
  int32_t kind;
  /**
   * The member that `kind` selects.
   */
  raypath_job_input input;
} raypath_job;

/**
 * The outcome of a beat of a Euclidean distance, 8 bytes.
 */
typedef struct {
  /**
   * Sum of squared differences over all beats since the last reset, including this one.
   */
  float accumulator;
  /**
   * The beat's reset: 0 or 1.
   */
  uint32_t reset_accum;
} raypath_euclidean_result;

/**
 * The outcome of a beat of an angular distance, 12 bytes.
 */
typedef struct {
  /**
   * Sum of a·b over all beats since the last reset, including this one.
   */
  float dot_product;
  /**
   * Sum of b·b over the same beats.
   */
  float norm;
  /**
   * The beat's reset: 0 or 1.
   */
  uint32_t reset_accum;
} raypath_angular_result;

/**
 * The words at the output ports of an operation, in the order of `raypath_output`.
 */
typedef struct {
  /**
   * The operation's opcode.
   */
  uint64_t opcode;
  /**
   * The words. They are valid until the next `raypath_pipeline_step`, `_skip`, `_reset` or `_free` of the pipeline.
   */
  const uint64_t *outputs;
  /**
   * The number of words.
   */
  size_t count;
} raypath_words_output;

/**
 * The outcome of a job.
 */
typedef union {
  /**
   * Of `RAYPATH_JOB_QUADBOX`.
   */
  raypath_quadbox_result quadbox;
  /**
   * Of `RAYPATH_JOB_TRIANGLE`.
   */
  raypath_triangle_result triangle;
  /**
   * Of `RAYPATH_JOB_EUCLIDEAN`.
   */
  raypath_euclidean_result euclidean;
  /**
   * Of `RAYPATH_JOB_ANGULAR`.
   */
  raypath_angular_result angular;
  /**
   * Of `RAYPATH_JOB_WORDS` and `RAYPATH_JOB_TIMING`, which has no words.
   */
  raypath_words_output words;
} raypath_job_output;

/**
 * The outcome of a job with the tag of its offer.
 */
typedef struct {
  /**
   * The tag that was given with the job.
   */
  uint64_t tag;
  /**
   * The kind of the job.
   */
  int32_t kind;
  /**
   * The member that `kind` selects.
   */
  raypath_job_output output;
} raypath_result;

/**
 * A ray as the traversal unit takes it, 48 bytes. The members are the ports of the ray's channel.
 */
typedef struct {
  /**
   * The point at which the ray begins.
   */
  float origin[3];
  /**
   * The direction, of any length except 0.
   */
  float direction[3];
  /**
   * Hits count beyond this distance, in units of the direction's length.
   */
  float t_min;
  /**
   * Hits count below this distance; infinity reaches everything.
   */
  float t_max;
  /**
   * The bits `RAYPATH_RAY_…` that are set, which are those of SPIR-V's `RayFlags`.
   */
  uint32_t flags;
  /**
   * With `instances` and `queries`: instances count whose mask has a bit of it, 0 to 255. 255 is usual, and 0 hits no
   * instance.
   */
  uint32_t cull_mask;
  /**
   * The child word of the scene's root.
   */
  uint32_t root;
  /**
   * With `address-width` above 32: the bits of every address above its lower 32. A scene lies within the 4 GiB that
   * it selects. 0 in other units.
   */
  uint32_t base;
} raypath_unit_ray;

/**
 * Something that a ray may hit, about which its user decides, 80 bytes: a triangle that is not opaque, or a procedural
 * box. The members are the ports of the channel of candidates; for a box, all but its indices and the ray are 0.
 */
typedef struct {
  /**
   * 1 for a procedural box, 0 for a triangle.
   */
  uint32_t is_box;
  /**
   * 1 if it counts as opaque, as boxes may.
   */
  uint32_t is_opaque;
  /**
   * The index in its geometry.
   */
  uint32_t primitive;
  /**
   * The index of its geometry.
   */
  uint32_t geometry;
  /**
   * The index of its instance; `RAYPATH_UNIT_NO_INSTANCE` in none.
   */
  uint32_t instance;
  /**
   * The custom index of its instance.
   */
  uint32_t custom_index;
  /**
   * The offset of its instance into the shader table.
   */
  uint32_t shader_offset;
  /**
   * The distance, in units of the direction's length.
   */
  float t;
  /**
   * The numerator of the distance.
   */
  float t_num;
  /**
   * The denominator of the distance.
   */
  float t_denom;
  /**
   * With `barycentrics`, the weight of the triangle's second vertex.
   */
  float u;
  /**
   * With `barycentrics`, the weight of the third vertex.
   */
  float v;
  /**
   * 1 if the ray meets the back face.
   */
  uint32_t back_face;
  /**
   * The index of the ray among those that were given.
   */
  uint32_t ray;
  /**
   * The origin of the ray in the space of its instance; in none, that of the ray itself.
   */
  float origin[3];
  /**
   * The direction of the ray in that space, which is not normalised.
   */
  float direction[3];
} raypath_unit_candidate;

/**
 * What a user decides about a candidate, 12 bytes. All members 0 ignore it.
 */
typedef struct {
  /**
   * Not 0: it becomes the closest hit.
   */
  uint32_t accept;
  /**
   * Not 0: the ray ends, with its closest hit.
   */
  uint32_t end;
  /**
   * The distance of the hit of a box. It counts from `t_min` up to the closest hit or `t_max`; beyond, nothing is
   * accepted.
   */
  float t;
} raypath_unit_verdict;

/**
 * What the traversal unit returns for a ray, 56 bytes. The members are the ports of the hit's channel: without a hit,
 * all but `status`, `nodes` and `triangles` are 0.
 */
typedef struct {
  /**
   * One of `RAYPATH_UNIT_…`: 0 miss, 1 hit of a triangle, 2 of a box, 3 ray refused, 4 error of the memory, 5 error
   * of the scene, 6 limit of work.
   */
  uint32_t status;
  /**
   * The index of the triangle in its geometry.
   */
  uint32_t primitive;
  /**
   * The index of the triangle's instance, as the scene has it; `RAYPATH_UNIT_NO_INSTANCE` for a triangle in none, as
   * all are in a unit without `instances`.
   */
  uint32_t instance;
  /**
   * The distance, in units of the direction's length.
   */
  float t;
  /**
   * The numerator of the distance.
   */
  float t_num;
  /**
   * The denominator of the distance; negative if the vertices run clockwise as the ray's origin sees them.
   */
  float t_denom;
  /**
   * With `barycentrics`, the weight of the triangle's second vertex at the hit; 0 otherwise. The weights of the
   * three vertices add up to 1.
   */
  float u;
  /**
   * With `barycentrics`, the weight of the third vertex.
   */
  float v;
  /**
   * Whether the ray meets the back face: 0 or 1.
   */
  uint32_t back_face;
  /**
   * The nodes that the ray has read.
   */
  uint32_t nodes;
  /**
   * The triangles that the ray has read.
   */
  uint32_t triangles;
  /**
   * With `queries`, the index of the triangle's geometry; 0 otherwise.
   */
  uint32_t geometry;
  /**
   * With `instances` and `queries`, the custom index of the triangle's instance; 0 otherwise.
   */
  uint32_t custom_index;
  /**
   * With `instances` and `queries`, the offset of that instance into the shader table; 0 otherwise.
   */
  uint32_t shader_offset;
} raypath_unit_hit;

/**
 * Decides about a candidate: sets `*verdict`, which ignores it before. `user` is that of `raypath_unit_trace_with`.
 */
typedef void (*raypath_decide)(void *user, const raypath_unit_candidate *candidate, raypath_unit_verdict *verdict);

/**
 * Triangles or procedural boxes of a scene that are opaque or not.
 */
typedef struct {
  /**
   * The number of its triangles.
   */
  uint32_t triangles;
  /**
   * The number of its boxes; 0 if it has triangles.
   */
  uint32_t boxes;
  /**
   * 0 if they are opaque, 1 if not.
   */
  uint32_t non_opaque;
} raypath_unit_geometry;

/**
 * A place of the triangles in a scene, 112 bytes.
 */
typedef struct {
  /**
   * The affine matrix from the triangles to the scene, row by row; the last number of each row is the translation.
   */
  double matrix[3][4];
  /**
   * The custom index, below 2²⁴.
   */
  uint32_t custom_index;
  /**
   * Rays count it whose mask has a bit of this one, 0 to 255.
   */
  uint32_t mask;
  /**
   * The offset into the shader table, below 2²⁴.
   */
  uint32_t shader_offset;
  /**
   * The bits `RAYPATH_INSTANCE_…` that are set.
   */
  uint32_t flags;
} raypath_unit_instance;

/**
 * A neighbour of a query.
 */
typedef struct {
  /**
   * The index of the vector.
   */
  uint32_t index;
  /**
   * The Euclidean distance, the dot product, or the cosine of the angle.
   */
  float distance;
} raypath_neighbour;

/**
 * How a search ended, and what it did.
 */
typedef struct {
  /**
   * One of `RAYPATH_SEARCH_…`.
   */
  uint32_t status;
  /**
   * The number of neighbours.
   */
  uint32_t count;
  /**
   * Vectors that were compared with the query.
   */
  uint64_t distances;
  /**
   * Beats of the datapath.
   */
  uint64_t beats;
  /**
   * Blocks of 64 bytes that were read.
   */
  uint64_t blocks;
  /**
   * Candidates whose neighbours were read.
   */
  uint64_t expansions;
} raypath_search_reply;

/**
 * The inputs of a unit in a cycle. The members are its ports. What belongs to a channel that is not valid is not read.
 */
typedef struct {
  /**
   * The id of the ray that is offered, which comes out with its hit.
   */
  uint64_t ray_id;
  /**
   * The ray that is offered.
   */
  raypath_unit_ray ray;
  /**
   * Not 0: a ray is offered. It is accepted in this cycle if the output `ray_ready` is 1; hold it until then.
   */
  uint32_t ray_valid;
  /**
   * The bytes of the beat, an eighth of the memory's width, the lowest address first. They are read during the call.
   */
  const uint8_t *mem_rsp_data;
  /**
   * Not 0: a beat of a block arrives. The beats of a block arrive in order, in any cycle after that of the request.
   */
  uint32_t mem_rsp_valid;
  /**
   * The tag of the request.
   */
  uint32_t mem_rsp_tag;
  /**
   * Not 0: the memory has no valid data for the beat.
   */
  uint32_t mem_rsp_error;
  /**
   * Not 0: a verdict on a candidate is given. It may come from the cycle after the candidate was taken on.
   */
  uint32_t answer_valid;
  /**
   * The tag of the candidate.
   */
  uint32_t answer_tag;
  /**
   * The verdict.
   */
  raypath_unit_verdict answer;
  /**
   * Not 0: the candidate at the outputs is taken.
   */
  uint32_t cand_ready;
  /**
   * Not 0: the hit at the outputs is taken.
   */
  uint32_t hit_ready;
  /**
   * Not 0: the request at the outputs is taken.
   */
  uint32_t mem_req_ready;
  /**
   * Not 0: all rays are dropped, from the next cycle until the output `idle` is 1. Beats and verdicts that are owed
   * must still come.
   */
  uint32_t flush;
} raypath_unit_inputs;

/**
 * The inputs of searches in a cycle. The members are ports of the unit. What belongs to a channel that is not valid is
 * not read.
 */
typedef struct {
  /**
   * The id of the job that is offered, which comes out with its results.
   */
  uint64_t search_id;
  /**
   * The address of the job, a multiple of 64.
   */
  uint32_t search_job;
  /**
   * The upper 32 bits of all addresses of the job.
   */
  uint32_t search_base;
  /**
   * Not 0: a job is offered. It is accepted in this cycle if the output `search_ready` is 1; hold it until then.
   */
  uint32_t search_valid;
  /**
   * Not 0: the result at the outputs is taken.
   */
  uint32_t result_ready;
  /**
   * Not 0: the request at the outputs is taken.
   */
  uint32_t vec_req_ready;
  /**
   * Not 0: a beat of a block arrives. The beats of a block arrive in order, in any cycle after that of the request.
   */
  uint32_t vec_rsp_valid;
  /**
   * The tag of the request.
   */
  uint32_t vec_rsp_tag;
  /**
   * Not 0: the memory has no valid data for the beat.
   */
  uint32_t vec_rsp_error;
  /**
   * The bytes of the beat, an eighth of the memory's width, the lowest address first. They are read during the call.
   */
  const uint8_t *vec_rsp_data;
} raypath_search_inputs;

/**
 * The outputs of searches in a cycle. The members are ports of the unit. Those of a channel that is not valid are 0.
 */
typedef struct {
  /**
   * The id of the job of the result.
   */
  uint64_t result_id;
  /**
   * The address of the block that is requested.
   */
  uint64_t vec_req_addr;
  /**
   * The tag of its response.
   */
  uint32_t vec_req_tag;
  /**
   * 1: a block of 64 bytes is requested. The request stays at the outputs until a step takes it.
   */
  uint32_t vec_req_valid;
  /**
   * 1: no job is in the unit.
   */
  uint32_t searches_idle;
  /**
   * 1: a job that is offered is accepted in this cycle.
   */
  uint32_t search_ready;
  /**
   * 1: a result, which stays at the outputs until a step takes it.
   */
  uint32_t result_valid;
  /**
   * The number of the job's results before it.
   */
  uint32_t result_rank;
  /**
   * 1: the result is a neighbour; 0: the job has none.
   */
  uint32_t result_found;
  /**
   * The neighbour.
   */
  raypath_neighbour result;
  /**
   * 1: the result is the job's last.
   */
  uint32_t result_last;
  /**
   * With the last result: how the job has ended, one of `RAYPATH_SEARCH_…`.
   */
  uint32_t result_status;
} raypath_search_outputs;

/**
 * The parameters of a traversal unit.
 */
typedef struct {
  /**
   * Rays in flight.
   */
  uint32_t contexts;
  /**
   * Entries of the stack of each ray.
   */
  uint32_t stack;
  /**
   * Bytes of a block of the scene: 128, and with `node = "quantised"` 64.
   */
  uint32_t block_bytes;
  /**
   * Bits of a beat of the memory; a block has 8 · `block_bytes` / `memory_width` beats.
   */
  uint32_t memory_width;
  /**
   * Bits of the id of a ray.
   */
  uint32_t id_width;
  /**
   * Bits of an address.
   */
  uint32_t address_width;
  /**
   * Cycles of a division.
   */
  uint32_t divider_latency;
  /**
   * Cycles of a read of the memories of a step: 1 or 2.
   */
  uint32_t ram_latency;
  /**
   * Whether scenes have instances: 0 or 1.
   */
  uint32_t instances;
  /**
   * What it has of ray queries: 0 for `queries = "none"`, 1 for "flags", 2 for "full".
   */
  uint32_t queries;
  /**
   * Whether front faces run clockwise: 0 or 1.
   */
  uint32_t clockwise_front;
  /**
   * Whether the memories of a step have parity: 0 or 1.
   */
  uint32_t parity;
} raypath_unit_parameter_values;

/**
 * The outputs of a unit in a cycle. The members are its ports. Those of a channel that is not valid are 0.
 */
typedef struct {
  /**
   * The id of the ray that has ended.
   */
  uint64_t hit_id;
  /**
   * Its hit.
   */
  raypath_unit_hit hit;
  /**
   * 1: a ray that is offered is accepted in this cycle.
   */
  uint32_t ray_ready;
  /**
   * 1: a ray has ended. Its hit stays at the outputs until a step takes it.
   */
  uint32_t hit_valid;
  /**
   * 1: a ray waits for a verdict on a candidate, which stays at the outputs until a step takes it.
   */
  uint32_t cand_valid;
  /**
   * The tag of its verdict.
   */
  uint32_t cand_tag;
  /**
   * The id of its ray.
   */
  uint64_t cand_id;
  /**
   * The candidate.
   */
  raypath_unit_candidate cand;
  /**
   * 1: a block is requested. The request stays at the outputs until a step takes it.
   */
  uint32_t mem_req_valid;
  /**
   * The address of the block.
   */
  uint64_t mem_req_addr;
  /**
   * The tag of its response.
   */
  uint32_t mem_req_tag;
  /**
   * 1: no ray is in the unit.
   */
  uint32_t idle;
} raypath_unit_outputs;

/**
 * What a unit did since its last reset.
 */
typedef struct {
  /**
   * Cycles.
   */
  uint64_t cycles;
  /**
   * Box jobs of the datapath.
   */
  uint64_t boxes;
  /**
   * Triangle jobs of the datapath.
   */
  uint64_t triangles;
  /**
   * Steps of rays.
   */
  uint64_t steps;
  /**
   * Blocks that were requested.
   */
  uint64_t fetches;
  /**
   * Rays that ended.
   */
  uint64_t rays;
} raypath_unit_counts;

/**
 * Where rays, hits, requests and jobs of a unit waited since its last reset.
 */
typedef struct {
  /**
   * The rays inside, accepted and not taken as hits.
   */
  uint64_t rays_inside;
  /**
   * The sum of the rays inside over all cycles: divided by the cycles, the contexts in use.
   */
  uint64_t ray_cycles;
  /**
   * Cycles in which a ray was offered and not accepted.
   */
  uint64_t ray_stalls;
  /**
   * Cycles in which a hit was not taken.
   */
  uint64_t hit_stalls;
  /**
   * Cycles in which a request was not taken.
   */
  uint64_t request_stalls;
  /**
   * Cycles in which a job waited for the datapath.
   */
  uint64_t job_stalls;
  /**
   * Descents that began again at the root, because the stack of a ray had lost a level.
   */
  uint64_t restarts;
} raypath_unit_stalls;

/**
 * A ray in a context of a unit.
 */
typedef struct {
  /**
   * The id of the ray.
   */
  uint64_t id;
  /**
   * The number of the context, which is the tag of its requests.
   */
  uint32_t context;
  /**
   * One of `RAYPATH_PHASE_…`.
   */
  uint32_t phase;
  /**
   * The address of the block that it asked for last; before, the first of its window.
   */
  uint64_t address;
} raypath_ray_inside;

/**
 * `raypath_query_proceed`: the ray waits for a verdict on a candidate.
 */
#define RAYPATH_CANDIDATE 1

/**
 * Success; `raypath_pipeline_offer`: the job is accepted; `raypath_pipeline_step`: a result left.
 */
#define RAYPATH_OK 0

/**
 * `raypath_pipeline_offer`: the job is not accepted in this cycle.
 */
#define RAYPATH_BUSY 1

/**
 * `raypath_pipeline_step`: no result left in this cycle.
 */
#define RAYPATH_NO_RESULT 2

/**
 * A pointer is NULL.
 */
#define RAYPATH_ERROR_NULL -1

/**
 * An argument has a value that is not allowed.
 */
#define RAYPATH_ERROR_ARGUMENT -2

/**
 * A configuration is not valid, or cannot be elaborated.
 */
#define RAYPATH_ERROR_CONFIGURATION -3

/**
 * The datapath does not have the operation.
 */
#define RAYPATH_ERROR_OPERATION -4

/**
 * A pointer is not aligned to its type.
 */
#define RAYPATH_ERROR_ALIGNMENT -5

/**
 * An array of results overlaps another array of the call.
 */
#define RAYPATH_ERROR_OVERLAP -6

/**
 * A file cannot be written.
 */
#define RAYPATH_ERROR_IO -7

/**
 * A defect of raypath. The objects of the call must not be used again.
 */
#define RAYPATH_ERROR_INTERNAL -8

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Tests `count` rays against four boxes each: `boxes` has 4 * `count` elements. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_OPERATION`, `_NULL`, `_ALIGNMENT`, `_OVERLAP` of the results with another array.
 *
 * # Safety
 * `datapath` is NULL or an open datapath; the arrays are NULL or have that many elements.
 */
raypath_status raypath_quadbox(const raypath_datapath *datapath,
                               const raypath_ray *rays,
                               const raypath_box *boxes,
                               size_t count,
                               raypath_quadbox_result *quadbox_results);

/**
 * Tests `count` rays against a triangle each. With the feature `range`, rays begin at a distance of 0. Any thread may
 * call it.
 *
 * Errors: those of `raypath_quadbox`.
 *
 * # Safety
 * That of `raypath_quadbox`.
 */
raypath_status raypath_triangle(const raypath_datapath *datapath,
                                const raypath_ray *rays,
                                const raypath_vertices *triangles,
                                size_t count,
                                raypath_triangle_result *triangle_results);

/**
 * Computes the squared Euclidean distances of `count` pairs of vectors with `dimensions` numbers each, in `a` and `b`
 * one vector after another. The sums are those of the hardware's beats. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for 0 dimensions; those of `raypath_quadbox`.
 *
 * # Safety
 * `datapath` is NULL or an open datapath; `a` and `b` are NULL or have `count` * `dimensions` elements, `distances`
 * `count`.
 */
raypath_status raypath_euclidean(const raypath_datapath *datapath,
                                 const float *a,
                                 const float *b,
                                 size_t dimensions,
                                 size_t count,
                                 float *distances);

/**
 * Computes the dot products of `count` pairs of vectors, and the squared norms of the vectors of `b`. Shapes and
 * errors are those of `raypath_euclidean`. Any thread may call it.
 *
 * # Safety
 * That of `raypath_euclidean`; `dot_products` and `norms` are NULL or have `count` elements.
 */
raypath_status raypath_angular(const raypath_datapath *datapath,
                               const float *a,
                               const float *b,
                               size_t dimensions,
                               size_t count,
                               float *dot_products,
                               float *norms);

/**
 * Computes `count` jobs of any operation, in order, through the words at its ports: `inputs` has the words of one job
 * after another, in the order of `raypath_input`, and `outputs` receives those of the outcomes, in the order of
 * `raypath_output`. Numbers are in the IEEE 754 layout of the datapath's format. Accumulators are zero before the
 * first job. Any thread may call it.
 *
 * Errors: those of `raypath_quadbox`.
 *
 * # Safety
 * `datapath` is NULL or an open datapath; `operation` is NULL or a string; the arrays are NULL or have that many
 * elements.
 */
raypath_status raypath_run(const raypath_datapath *datapath,
                           const char *operation,
                           const uint64_t *inputs,
                           size_t count,
                           uint64_t *outputs);

/**
 * Opens a datapath and sets `*datapath`. `toml` has the keys of a configuration file, for example
 * `preset = "credit"`; NULL is the default configuration. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_CONFIGURATION` with the line of `toml`; `RAYPATH_ERROR_NULL`. Then `*datapath` is not
 * changed.
 *
 * # Safety
 * `toml` is NULL or a string; `datapath` is NULL or points to a pointer.
 */
raypath_status raypath_open(const char *toml, raypath_datapath **datapath);

/**
 * As `raypath_open`, with operations added to those of the paper: names as `raypath operations` lists them, separated
 * by commas; NULL for none.
 *
 * Errors: those of `raypath_open`; `RAYPATH_ERROR_ARGUMENT` for an unknown name.
 *
 * # Safety
 * That of `raypath_open`; `operations` is NULL or a string.
 */
raypath_status raypath_open_with(const char *toml, const char *operations, raypath_datapath **datapath);

/**
 * Closes a datapath. NULL is ignored. Pipelines of the datapath remain usable.
 *
 * # Safety
 * `datapath` is NULL or came from `raypath_open` and was not closed; no other call uses it.
 */
void raypath_close(raypath_datapath *datapath);

/**
 * Sets `*ray` to the ray from `origin` along `direction` (three numbers each) with the length `extent` times that of
 * `direction`; infinity reaches everything. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for a direction that is zero, not finite or too short to invert, an origin that is
 * not finite, an extent that is negative or NaN; `RAYPATH_ERROR_NULL`. Then `*ray` is not changed.
 *
 * # Safety
 * `origin` and `direction` are NULL or point to three numbers; `ray` is NULL or points to a ray.
 */
raypath_status raypath_ray_init(raypath_ray *ray, const float *origin, const float *direction, float extent);

/**
 * Writes the hardware into a folder, as `raypath generate` does: SystemVerilog, assertions, wrapper, manifests, a
 * picture. Creates the folder if it does not exist. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_IO` with the path; then no file has changed. `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `datapath` is NULL or an open datapath; `folder` is NULL or a string.
 */
raypath_status raypath_generate(const raypath_datapath *datapath, const char *folder);

/**
 * The configuration and the added operations in words. Valid while the datapath is open; NULL after an error.
 *
 * # Safety
 * `datapath` is NULL or an open datapath.
 */
const char *raypath_description(const raypath_datapath *datapath);

/**
 * A digest of the configuration and the added operations, 64 hexadecimal digits: equal for equal configurations of one
 * release. Valid while the datapath is open; NULL after an error.
 *
 * # Safety
 * `datapath` is NULL or an open datapath.
 */
const char *raypath_digest(const raypath_datapath *datapath);

/**
 * Cycles from the acceptance of a job to its outcome in an empty pipeline; 0 after an error.
 *
 * # Safety
 * `datapath` is NULL or an open datapath.
 */
uint32_t raypath_latency(const raypath_datapath *datapath);

/**
 * The number of jobs that fit while the sink is not ready; 0 after an error.
 *
 * # Safety
 * `datapath` is NULL or an open datapath.
 */
size_t raypath_capacity(const raypath_datapath *datapath);

/**
 * The coordinates of a Euclidean beat; an angular one has half as many. 0 without distance operations and after an
 * error.
 *
 * # Safety
 * `datapath` is NULL or an open datapath.
 */
size_t raypath_lanes(const raypath_datapath *datapath);

/**
 * The number of operations; 0 after an error.
 *
 * # Safety
 * `datapath` is NULL or an open datapath.
 */
size_t raypath_operation_count(const raypath_datapath *datapath);

/**
 * Sets `*operation` to the operation at `index`, in the order of opcodes.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for an index from `raypath_operation_count` on; `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `datapath` is NULL or an open datapath; `operation` is NULL or points to an operation.
 */
raypath_status raypath_operation(const raypath_datapath *datapath, size_t index, raypath_operation_info *operation);

/**
 * Sets `*port` to an input port of the operation at `operation`.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for an index that is too high; `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `datapath` is NULL or an open datapath; `port` is NULL or points to a port.
 */
raypath_status raypath_input(const raypath_datapath *datapath, size_t operation, size_t index, raypath_port *port);

/**
 * Sets `*port` to an output port of the operation at `operation`.
 *
 * Errors: those of `raypath_input`.
 *
 * # Safety
 * That of `raypath_input`.
 */
raypath_status raypath_output(const raypath_datapath *datapath, size_t operation, size_t index, raypath_port *port);

/**
 * The number of steps of the pipeline: with units of one step, the stages of the paper's Table VII. 0 after an error.
 *
 * # Safety
 * `datapath` is NULL or an open datapath.
 */
size_t raypath_step_count(const raypath_datapath *datapath);

/**
 * Sets `*cost` to the units of a step and the registers after it, counted in the netlist.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for a step from `raypath_step_count` on; `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `datapath` is NULL or an open datapath; `cost` is NULL or points to a cost.
 */
raypath_status raypath_step_cost(const raypath_datapath *datapath, size_t step, raypath_cost_counts *cost);

/**
 * Sets `*cost` to the units and flip-flops of the whole datapath, counted in the netlist.
 *
 * Errors: `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * That of `raypath_step_cost`.
 */
raypath_status raypath_cost(const raypath_datapath *datapath, raypath_cost_counts *cost);

/**
 * Sets `*value` to a number of a card, the JSON that `raypath card` writes. `pointer` is a JSON pointer, for example
 * `/operations/quadbox/pj_per_job`. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for another text, another version of it, or no number there, with the reason that the
 * card states; `RAYPATH_ERROR_NULL`. Then `*value` is not changed.
 *
 * # Safety
 * `json` and `pointer` are NULL or strings; `value` is NULL or points to a number.
 */
raypath_status raypath_card_number(const char *json,
                                   const char *pointer,
                                   double *value);

/**
 * Makes an empty pipeline with accumulators of zero, and sets `*pipeline`. The datapath may be closed before the
 * pipeline. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `datapath` is NULL or an open datapath; `pipeline` is NULL or points to a pointer.
 */
raypath_status raypath_pipeline_new(const raypath_datapath *datapath, raypath_pipeline **pipeline);

/**
 * Frees a pipeline. NULL is ignored.
 *
 * # Safety
 * `pipeline` is NULL or came from `raypath_pipeline_new` and was not freed; no other call uses it.
 */
void raypath_pipeline_free(raypath_pipeline *pipeline);

/**
 * Offers a job with a tag, any number, in this cycle: `RAYPATH_OK` if it is accepted, `RAYPATH_BUSY` if not. At most
 * one job is accepted in a cycle. The job is read before the call returns.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for a kind that is not one of `RAYPATH_JOB_…` or another number of words than the
 * operation has; `RAYPATH_ERROR_OPERATION`; `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread uses; `job` is NULL or points to a job whose pointers are NULL
 * or have as many elements as [`JobInput`] says.
 */
raypath_status raypath_pipeline_offer(raypath_pipeline *pipeline, const raypath_job *job, uint64_t tag);

/**
 * One clock cycle. The job that was accepted in this cycle enters. If `output_ready` and there is an outcome at the
 * output, it leaves: `RAYPATH_OK`, and `*result` is set. Otherwise `RAYPATH_NO_RESULT`. If `result` is NULL, the
 * outcome is discarded.
 *
 * Errors: `RAYPATH_ERROR_NULL` for the pipeline; `RAYPATH_ERROR_ALIGNMENT`. Then no cycle passes.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread uses; `result` is NULL or points to a result.
 */
raypath_status raypath_pipeline_step(raypath_pipeline *pipeline, bool output_ready, raypath_result *result);

/**
 * Sets `*result` to the outcome at the output in this cycle, which stays until a step takes it: `RAYPATH_OK`.
 * `RAYPATH_NO_RESULT` if there is none. No cycle passes.
 *
 * Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread changes; `result` is NULL or points to a result.
 */
raypath_status raypath_pipeline_peek(const raypath_pipeline *pipeline, raypath_result *result);

/**
 * Advances up to `cycles` cycles in which no further job is offered and the sink is not ready, and stops in the first
 * with an outcome at the output. Returns the number of cycles that passed: 0 if there is an outcome already, and after
 * an error. A job that was accepted in this cycle enters in the first. Equivalent to that many calls of
 * `raypath_pipeline_step`, but faster.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread uses.
 */
uint64_t raypath_pipeline_skip(raypath_pipeline *pipeline, uint64_t cycles);

/**
 * The number of jobs inside, with the one that was accepted in this cycle; 0 after an error.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread changes.
 */
size_t raypath_pipeline_occupancy(const raypath_pipeline *pipeline);

/**
 * Sets the first `capacity` elements of `stages` to the stages of the jobs inside, oldest first, without a job that
 * was accepted in this cycle: 1 after the input's registers, the latency at the output. Returns the number of jobs;
 * 0 after an error.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread changes; `stages` is NULL or has `capacity` elements.
 */
size_t raypath_pipeline_stages(const raypath_pipeline *pipeline, uint32_t *stages, size_t capacity);

/**
 * Whether a job with this opcode would be accepted in this cycle; false after an error.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread changes.
 */
bool raypath_pipeline_input_ready(const raypath_pipeline *pipeline, uint64_t opcode);

/**
 * Whether there is an outcome at the output in this cycle; false after an error.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread changes.
 */
bool raypath_pipeline_output_valid(const raypath_pipeline *pipeline);

/**
 * A cycle in which `rst_ni` is 0: all jobs are lost, and the accumulators are zero.
 *
 * Errors: `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread uses.
 */
raypath_status raypath_pipeline_reset(raypath_pipeline *pipeline);

/**
 * Copies the whole state as bytes into `bytes`, if they fit into `capacity`, and returns their number; 0 after an
 * error. With a capacity of 0 it says how many are needed. `raypath_pipeline_restore` takes them over, also in another
 * process.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread changes; `bytes` is NULL or has `capacity` elements.
 */
size_t raypath_pipeline_save(const raypath_pipeline *pipeline, uint8_t *bytes, size_t capacity);

/**
 * Takes over a state that `raypath_pipeline_save` copied, of an equal datapath in the same release of raypath.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for other bytes; `RAYPATH_ERROR_NULL`. Then nothing changes.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread uses; `bytes` is NULL or has `size` elements.
 */
raypath_status raypath_pipeline_restore(raypath_pipeline *pipeline, const uint8_t *bytes, size_t size);

/**
 * Makes a copy with the same state, and sets `*copy`, which is freed like the original.
 *
 * Errors: `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `pipeline` is NULL or a pipeline that no other thread changes; `copy` is NULL or points to a pointer.
 */
raypath_status raypath_pipeline_clone(const raypath_pipeline *pipeline, raypath_pipeline **copy);

/**
 * Begins a query with a ray, and sets `*query`. The unit may be closed before the query. Only a unit with
 * `queries = "full"` has candidates.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for flags, a mask or a base out of range; `RAYPATH_ERROR_NULL`, `_ALIGNMENT`.
 *
 * # Safety
 * `unit` is NULL or an open unit; `ray` is NULL or points to a structure; `query` is NULL or points to a pointer.
 */
raypath_status raypath_query_new(const raypath_unit *unit, const raypath_unit_ray *ray, raypath_query **query);

/**
 * Goes on through a scene of `size` bytes. Returns `RAYPATH_CANDIDATE` with `*candidate` if the ray waits for a verdict,
 * or `RAYPATH_OK` if it has ended. A candidate without `raypath_query_answer` is ignored.
 *
 * Errors: `RAYPATH_ERROR_NULL`, `_ALIGNMENT`.
 *
 * # Safety
 * `query` is NULL or a query that no other thread uses; `scene` is NULL or has `size` elements; `candidate` is NULL or
 * points to a structure.
 */
raypath_status raypath_query_proceed(raypath_query *query,
                                     const uint8_t *scene,
                                     size_t size,
                                     raypath_unit_candidate *candidate);

/**
 * Decides about the candidate for which the ray waits.
 *
 * Errors: `RAYPATH_ERROR_NULL`, `_ALIGNMENT`.
 *
 * # Safety
 * `query` is NULL or a query that no other thread uses; `verdict` is NULL or points to a structure.
 */
raypath_status raypath_query_answer(raypath_query *query, const raypath_unit_verdict *verdict);

/**
 * Sets `*hit` to that of a ray that has ended.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` before; `RAYPATH_ERROR_NULL`, `_ALIGNMENT`.
 *
 * # Safety
 * `query` is NULL or a query; `hit` is NULL or points to a structure.
 */
raypath_status raypath_query_hit(const raypath_query *query, raypath_unit_hit *hit);

/**
 * Frees a query. NULL is ignored.
 *
 * # Safety
 * `query` is NULL or came from `raypath_query_new` and was not freed; no other call uses it.
 */
void raypath_query_free(raypath_query *query);

/**
 * As `raypath_unit_trace`, with a function that decides about the candidates of each ray, in the order in which the ray
 * meets them; NULL accepts triangles and ignores boxes. `user` is passed on to it.
 *
 * Errors: those of `raypath_unit_trace`.
 *
 * # Safety
 * That of `raypath_unit_trace`; `decide` uses none of the arrays but to read them, and does not unwind.
 */
raypath_status raypath_unit_trace_with(const raypath_unit *unit,
                                       const uint8_t *scene,
                                       size_t size,
                                       const raypath_unit_ray *rays,
                                       size_t count,
                                       raypath_unit_hit *hits,
                                       raypath_decide decide,
                                       void *user);

/**
 * Builds a scene in the layout that the unit reads, and sets `*scene`. Any thread may call it.
 *
 * `vertices` has three numbers for each of `vertex_count` vertices, `indices` three vertices for each of
 * `triangle_count` triangles, counter-clockwise as seen from the front. Arrays after these may be NULL. `boxes` are
 * procedural boxes, for a unit with `queries = "full"`; one with a minimum above its maximum is the point in its middle.
 * `geometries` are those to which triangles and boxes belong in order; without, the triangles are one opaque geometry.
 * In a unit with `queries`, a triangle or a box is inactive that has a vertex or a corner whose x is NaN: it is not hit,
 * and counts in indices. With `instances` the scene has two levels, with all of it at each of `instance_count` places.
 * `reach` is the greatest distance, along any axis, between the origin of a ray and a vertex in a scene with instances;
 * 0 for 16 times its longest side. Rays from further away may lose hits at the edges of instances.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for an index of no vertex, a coordinate beyond 2^40, a matrix without an inverse, a
 * negative reach, nothing active, more than fits into 4 GiB, geometries with another number of triangles or boxes, a
 * word of an instance out of range, or what needs `instances` or `queries` for a unit without them;
 * `RAYPATH_ERROR_NULL`, `_ALIGNMENT`. Then `*scene` is not changed.
 *
 * # Safety
 * `unit` is NULL or an open unit; the arrays are NULL or have that many elements; `scene` is NULL or points to a
 * pointer.
 */
raypath_status raypath_scene_build(const raypath_unit *unit,
                                   const float (*vertices)[3],
                                   size_t vertex_count,
                                   const uint32_t (*indices)[3],
                                   size_t triangle_count,
                                   const raypath_box *boxes,
                                   size_t box_count,
                                   const raypath_unit_geometry *geometries,
                                   size_t geometry_count,
                                   const raypath_unit_instance *instances,
                                   size_t instance_count,
                                   float reach,
                                   raypath_scene **scene);

/**
 * Builds a scene of scenes that `unit` reads, and sets `*scene`. Any thread may call it.
 *
 * Each of `instance_count` instances places the scene whose number in `scenes` is its element of `members`. In a unit with
 * `nested-instances` the scenes may have instances themselves. Hits report the number of the instance. The scenes were
 * built for units with the same nodes, and are not needed afterwards. `reach` is that of `raypath_scene_build`; a scene
 * with instances must have been built for the reach that it has at its places.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for a scene that does not exist or has other nodes, no instance, a matrix, a word or a
 * reach out of range, a smaller reach, more than fits into 4 GiB or 64 levels, or a unit without what the scene needs;
 * `RAYPATH_ERROR_NULL`, `_ALIGNMENT`. Then `*scene` is not changed.
 *
 * # Safety
 * `unit` is NULL or an open unit; the arrays are NULL or have that many elements; those of `scenes` are NULL or scenes;
 * `scene` is NULL or points to a pointer.
 */
raypath_status raypath_scene_group(const raypath_unit *unit,
                                   const raypath_scene *const *scenes,
                                   size_t scene_count,
                                   const uint32_t *members,
                                   const raypath_unit_instance *instances,
                                   size_t instance_count,
                                   float reach,
                                   raypath_scene **scene);

/**
 * Frees a scene. NULL is ignored.
 *
 * # Safety
 * `scene` is NULL or came from `raypath_scene_build` or `_group` and was not freed; no other call uses it.
 */
void raypath_scene_free(raypath_scene *scene);

/**
 * The bytes of a scene, the first of which has the address 0; NULL after an error. They are valid while the scene is.
 *
 * # Safety
 * `scene` is NULL or a scene.
 */
const uint8_t *raypath_scene_data(const raypath_scene *scene);

/**
 * The number of its bytes; 0 after an error.
 *
 * # Safety
 * `scene` is NULL or a scene.
 */
size_t raypath_scene_size(const raypath_scene *scene);

/**
 * The child word of its root, for `root` of a ray; 0 after an error.
 *
 * # Safety
 * `scene` is NULL or a scene.
 */
uint32_t raypath_scene_root(const raypath_scene *scene);

/**
 * The reach for which it was built; 0 after an error.
 *
 * # Safety
 * `scene` is NULL or a scene.
 */
float raypath_scene_reach(const raypath_scene *scene);

/**
 * Does the job at an address of a memory of `size` bytes by the functional model, and sets `neighbours`, the best
 * first, and `*reply`. The first byte of the memory has the address 0; an address outside of it is an error of the
 * memory. `base` has the upper 32 bits of all addresses. The layout of a job is that of `docs/reference/searching.md`.
 * Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for a unit without searches, an address that is not a multiple of 64, and a
 * capacity below the number of neighbours; `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`. Then nothing is set.
 *
 * # Safety
 * `unit` is NULL or an open unit; `reply` is NULL or points to a structure; the arrays are NULL or have that many
 * elements.
 */
raypath_status raypath_unit_search(const raypath_unit *unit,
                                   const uint8_t *memory,
                                   size_t size,
                                   uint32_t base,
                                   uint32_t job,
                                   raypath_neighbour *neighbours,
                                   size_t capacity,
                                   raypath_search_reply *reply);

/**
 * `raypath_unit_model_step` of a unit with searches, with their inputs.
 *
 * Errors: those of `raypath_unit_model_step`; `RAYPATH_ERROR_ARGUMENT` for a job of a unit without searches, one with
 * an id or a base of too many bits, or an address that is not a multiple of 64. Then no cycle passes.
 *
 * # Safety
 * That of `raypath_unit_model_step`, also for `search`.
 */
raypath_status raypath_unit_model_step_with(raypath_unit_model *model,
                                            const raypath_unit_inputs *inputs,
                                            const raypath_search_inputs *search);

/**
 * Sets `*outputs` to the outputs of searches in this cycle; all are 0 in a unit without searches. No cycle passes.
 *
 * Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
 *
 * # Safety
 * That of `raypath_unit_model_outputs`.
 */
raypath_status raypath_unit_model_search_outputs(const raypath_unit_model *model, raypath_search_outputs *outputs);

/**
 * The version of the binary interface of this library. A program compares it with `RAYPATH_ABI_VERSION`. Any thread
 * may call it.
 */
uint32_t raypath_abi_version(void);

/**
 * The commit of raypath from which the library was built, 40 hexadecimal digits; empty if it is not known. Any thread
 * may call it.
 */
const char *raypath_commit(void);

/**
 * The version of raypath, for example "0.1.0". Any thread may call it.
 */
const char *raypath_version(void);

/**
 * The message of the last call of this thread that failed: what was found, and what was expected. Empty if none
 * failed. It is valid until another call of this thread fails. Never NULL.
 */
const char *raypath_last_error(void);

/**
 * Opens a traversal unit and sets `*unit`. `toml` has the keys of a configuration file, and those of the unit:
 * `contexts`, `stack`, `node`, `memory-width`, `id-width`, `address-width`, `divider-latency`, `ram-latency`,
 * `instances`, `queries`, `parity`, `front`. For example `preset = "compact"`, `contexts = 16` and `instances = true` in a
 * line each; NULL is the default. Of the features, a unit has `barycentrics` alone. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_CONFIGURATION` with the line of `toml`, or for a datapath that the unit does not have;
 * `RAYPATH_ERROR_NULL`. Then `*unit` is not changed.
 *
 * # Safety
 * `toml` is NULL or a string; `unit` is NULL or points to a pointer.
 */
raypath_status raypath_unit_open(const char *toml,
                                 raypath_unit **unit);

/**
 * Closes a unit. NULL is ignored. Models of the unit remain usable.
 *
 * # Safety
 * `unit` is NULL or came from `raypath_unit_open` and was not closed; no other call uses it.
 */
void raypath_unit_close(raypath_unit *unit);

/**
 * The parameters of the unit and of its datapath in words. Valid while the unit is open; NULL after an error.
 *
 * # Safety
 * `unit` is NULL or an open unit.
 */
const char *raypath_unit_description(const raypath_unit *unit);

/**
 * A digest of the configuration of the unit and of its datapath, 64 hexadecimal digits: equal for equal configurations
 * of one release. Valid while the unit is open; NULL after an error.
 *
 * # Safety
 * `unit` is NULL or an open unit.
 */
const char *raypath_unit_digest(const raypath_unit *unit);

/**
 * Sets `*values` to the parameters of the unit.
 *
 * Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
 *
 * # Safety
 * `unit` is NULL or an open unit; `values` is NULL or points to a structure.
 */
raypath_status raypath_unit_parameters(const raypath_unit *unit, raypath_unit_parameter_values *values);

/**
 * Traces `count` rays through a scene of `size` bytes by the functional model, and sets a hit for each. The first byte
 * of the scene has the address 0; an address outside of it is an error of the memory, which ends a ray with
 * `RAYPATH_UNIT_MEMORY`. Of candidates, triangles are accepted and boxes ignored. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for flags, a mask or a base out of range, with the index of the ray;
 * `RAYPATH_ERROR_NULL`, `_ALIGNMENT`, `_OVERLAP` of the hits with another array. Then no hit is set.
 *
 * # Safety
 * `unit` is NULL or an open unit; the arrays are NULL or have that many elements.
 */
raypath_status raypath_unit_trace(const raypath_unit *unit,
                                  const uint8_t *scene,
                                  size_t size,
                                  const raypath_unit_ray *rays,
                                  size_t count,
                                  raypath_unit_hit *hits);

/**
 * Writes the hardware into a folder, as `raypath generate --unit` does: SystemVerilog, assertions, the AXI4 wrapper,
 * manifests. Creates the folder if it does not exist. Any thread may call it.
 *
 * Errors: `RAYPATH_ERROR_IO` with the path; then no file has changed. `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `unit` is NULL or an open unit; `folder` is NULL or a string.
 */
raypath_status raypath_unit_generate(const raypath_unit *unit, const char *folder);

/**
 * Makes a model of the unit after a reset, and sets `*model`. The unit may be closed before the model. Any thread may
 * call it.
 *
 * Errors: `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `unit` is NULL or an open unit; `model` is NULL or points to a pointer.
 */
raypath_status raypath_unit_model_new(const raypath_unit *unit, raypath_unit_model **model);

/**
 * Frees a model. NULL is ignored.
 *
 * # Safety
 * `model` is NULL or came from `raypath_unit_model_new` and was not freed; no other call uses it.
 */
void raypath_unit_model_free(raypath_unit_model *model);

/**
 * Sets `*outputs` to the outputs in this cycle. No cycle passes.
 *
 * Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
 *
 * # Safety
 * `model` is NULL or a model that no other thread changes; `outputs` is NULL or points to a structure.
 */
raypath_status raypath_unit_model_outputs(const raypath_unit_model *model, raypath_unit_outputs *outputs);

/**
 * The clock edge that ends this cycle.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for an id with more bits than the unit has for it, flags, a mask or a base out of
 * range, a beat whose tag is that of no request that waits for one, and a verdict whose tag is that of no candidate that
 * was taken; `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`. Then no cycle passes.
 *
 * # Safety
 * `model` is NULL or a model that no other thread uses; `inputs` is NULL or points to a structure, whose beat has an
 * eighth of the memory's width if it is valid.
 */
raypath_status raypath_unit_model_step(raypath_unit_model *model,
                                       const raypath_unit_inputs *inputs);

/**
 * Advances up to `cycles` cycles in which no ray is offered, no beat arrives and nothing is taken, and stops in the
 * first with a hit, a candidate or a request at the outputs, or in which `ray_ready` is 1 and was 0 before. Returns the
 * number of cycles that passed: 0 if there is one already, and after an error. Equivalent to that many calls of
 * `raypath_unit_model_step`, but cycles in which the unit waits for the memory take no time.
 *
 * # Safety
 * `model` is NULL or a model that no other thread uses.
 */
uint64_t raypath_unit_model_skip(raypath_unit_model *model, uint64_t cycles);

/**
 * Sets `*counts` to what the unit did since its last reset.
 *
 * Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
 *
 * # Safety
 * That of `raypath_unit_model_outputs`; `counts` is NULL or points to a structure.
 */
raypath_status raypath_unit_model_counts(const raypath_unit_model *model, raypath_unit_counts *counts);

/**
 * Sets `*stalls` to where rays, hits, requests and jobs waited since the last reset.
 *
 * Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
 *
 * # Safety
 * That of `raypath_unit_model_outputs`; `stalls` is NULL or points to a structure.
 */
raypath_status raypath_unit_model_stalls(const raypath_unit_model *model, raypath_unit_stalls *stalls);

/**
 * Sets the first `capacity` elements of `rays` to the rays in contexts, by context, and returns their number; 0 after
 * an error. From cycle to cycle they are the timeline of the unit. A ray whose hit is at the outputs has left its
 * context.
 *
 * # Safety
 * `model` is NULL or a model that no other thread changes; `rays` is NULL or has `capacity` elements.
 */
size_t raypath_unit_model_rays(const raypath_unit_model *model, raypath_ray_inside *rays, size_t capacity);

/**
 * Copies the whole state as bytes into `bytes`, if they fit into `capacity`, and returns their number; 0 after an
 * error. With a capacity of 0 it says how many are needed. `raypath_unit_model_restore` takes them over, also in
 * another process.
 *
 * # Safety
 * `model` is NULL or a model that no other thread changes; `bytes` is NULL or has `capacity` elements.
 */
size_t raypath_unit_model_save(const raypath_unit_model *model, uint8_t *bytes, size_t capacity);

/**
 * Takes over a state that `raypath_unit_model_save` copied, of an equal unit in the same release of raypath.
 *
 * Errors: `RAYPATH_ERROR_ARGUMENT` for other bytes; `RAYPATH_ERROR_NULL`. Then nothing changes.
 *
 * # Safety
 * `model` is NULL or a model that no other thread uses; `bytes` is NULL or has `size` elements.
 */
raypath_status raypath_unit_model_restore(raypath_unit_model *model, const uint8_t *bytes, size_t size);

/**
 * Makes a copy with the same state, and sets `*copy`, which is freed like the original.
 *
 * Errors: `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `model` is NULL or a model that no other thread changes; `copy` is NULL or points to a pointer.
 */
raypath_status raypath_unit_model_clone(const raypath_unit_model *model, raypath_unit_model **copy);

/**
 * A cycle in which `rst_ni` is 0: all rays are lost, and requests get no response.
 *
 * Errors: `RAYPATH_ERROR_NULL`.
 *
 * # Safety
 * `model` is NULL or a model that no other thread uses.
 */
raypath_status raypath_unit_model_reset(raypath_unit_model *model);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* RAYPATH_H */
