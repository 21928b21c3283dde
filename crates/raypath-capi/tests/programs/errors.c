/* Every wrong argument is a status with a message, and changes nothing. */

#include <raypath.h>

#include "check.h"

#include <math.h>
#include <sys/stat.h>

static void opening(void) {
  raypath_datapath *datapath = NULL;
  CHECK(strcmp(raypath_last_error(), "") == 0);
  CHECK_FAILS(raypath_open(NULL, NULL), RAYPATH_ERROR_NULL, "datapath is NULL");
  CHECK_FAILS(raypath_open("lanes = 16\ncontrol = \"fast\"\n", &datapath), RAYPATH_ERROR_CONFIGURATION,
              "configuration:2: control: 'fast'");
  CHECK_FAILS(raypath_open("preset = ", &datapath), RAYPATH_ERROR_CONFIGURATION, "configuration:1:");
  CHECK_FAILS(raypath_open("colour = 3", &datapath), RAYPATH_ERROR_CONFIGURATION, "'colour' is not a valid parameter");
  CHECK_FAILS(raypath_open("rules = \"chisel\"\nrounding = \"sum\"", &datapath), RAYPATH_ERROR_CONFIGURATION,
              "rounding");
  CHECK_FAILS(raypath_open("\xff", &datapath), RAYPATH_ERROR_ARGUMENT, "expected UTF-8");
  CHECK_FAILS(raypath_open_with(NULL, "sphere,cube", &datapath), RAYPATH_ERROR_ARGUMENT,
              "'cube' is not an added operation");
  CHECK(datapath == NULL);
  raypath_close(NULL);
}

static void rays(void) {
  const float origin[3] = {0, 0, 0}, forward[3] = {0, 0, 1}, zero[3] = {0, 0, 0}, nan[3] = {0, 0, NAN};
  raypath_ray ray, before;
  memset(&before, 0x5a, sizeof before);
  ray = before;
  CHECK_FAILS(raypath_ray_init(&ray, origin, zero, 1.0f), RAYPATH_ERROR_ARGUMENT, "direction (0, 0, 0) is zero");
  CHECK_FAILS(raypath_ray_init(&ray, origin, nan, 1.0f), RAYPATH_ERROR_ARGUMENT, "not finite");
  CHECK_FAILS(raypath_ray_init(&ray, nan, forward, 1.0f), RAYPATH_ERROR_ARGUMENT, "origin");
  CHECK_FAILS(raypath_ray_init(&ray, origin, forward, -1.0f), RAYPATH_ERROR_ARGUMENT, "extent -1");
  CHECK_FAILS(raypath_ray_init(&ray, NULL, forward, 1.0f), RAYPATH_ERROR_NULL, "origin is NULL");
  CHECK_FAILS(raypath_ray_init(&ray, origin, NULL, 1.0f), RAYPATH_ERROR_NULL, "direction is NULL");
  CHECK_FAILS(raypath_ray_init(NULL, origin, forward, 1.0f), RAYPATH_ERROR_NULL, "ray is NULL");
  CHECK(memcmp(&ray, &before, sizeof ray) == 0);
  /* A ray may be made from its own fields. */
  memcpy(ray.origin, origin, sizeof origin);
  memcpy(ray.direction, forward, sizeof forward);
  CHECK(raypath_ray_init(&ray, ray.origin, ray.direction, 2.0f) == RAYPATH_OK);
  CHECK(ray.kz == 2 && ray.inverse[2] == 1.0f && isinf(ray.inverse[0]) && ray.extent == 2.0f);
}

static void arrays(const raypath_datapath *datapath) {
  static _Alignas(64) unsigned char memory[4096];
  raypath_ray *rays = (raypath_ray *)(void *)memory;
  raypath_box *boxes = (raypath_box *)(void *)(memory + 1024);
  raypath_quadbox_result *results = (raypath_quadbox_result *)(void *)(memory + 2048);
  raypath_vertices triangle = {{0}, {0}, {0}};
  raypath_triangle_result hit;
  CHECK(raypath_quadbox(datapath, rays, boxes, 2, results) == RAYPATH_OK);
  CHECK(raypath_quadbox(datapath, NULL, NULL, 0, NULL) == RAYPATH_OK); /* empty arrays */
  CHECK_FAILS(raypath_quadbox(NULL, rays, boxes, 2, results), RAYPATH_ERROR_NULL, "datapath is NULL");
  CHECK_FAILS(raypath_quadbox(datapath, NULL, boxes, 2, results), RAYPATH_ERROR_NULL, "rays is NULL");
  CHECK_FAILS(raypath_quadbox(datapath, rays, NULL, 2, results), RAYPATH_ERROR_NULL, "boxes is NULL");
  CHECK_FAILS(raypath_quadbox(datapath, rays, boxes, 2, NULL), RAYPATH_ERROR_NULL, "results is NULL");
  CHECK_FAILS(raypath_triangle(datapath, rays, &triangle, 1, NULL), RAYPATH_ERROR_NULL, "results is NULL");
  CHECK_FAILS(raypath_triangle(datapath, rays, NULL, 1, &hit), RAYPATH_ERROR_NULL, "triangles is NULL");

  raypath_ray *odd_rays = (raypath_ray *)(uintptr_t)((uintptr_t)rays + 1);
  raypath_quadbox_result *odd_results = (raypath_quadbox_result *)(uintptr_t)((uintptr_t)results + 2);
  CHECK_FAILS(raypath_quadbox(datapath, odd_rays, boxes, 1, results), RAYPATH_ERROR_ALIGNMENT, "multiple of 4");
  CHECK_FAILS(raypath_quadbox(datapath, rays, boxes, 1, odd_results), RAYPATH_ERROR_ALIGNMENT, "results is at");

  raypath_quadbox_result *inside = (raypath_quadbox_result *)(void *)(memory + 1024 + 4 * 24 - 4);
  CHECK_FAILS(raypath_quadbox(datapath, rays, boxes, 1, inside), RAYPATH_ERROR_OVERLAP, "boxes and results overlap");
  inside = (raypath_quadbox_result *)(void *)memory;
  CHECK_FAILS(raypath_quadbox(datapath, rays, boxes, 1, inside), RAYPATH_ERROR_OVERLAP, "rays and results overlap");
  CHECK_FAILS(raypath_quadbox(datapath, rays, boxes, SIZE_MAX / 8, results), RAYPATH_ERROR_ARGUMENT,
              "do not fit into memory");

  float a[32] = {0}, b[32] = {0}, sums[2];
  CHECK_FAILS(raypath_euclidean(datapath, a, b, 0, 1, sums), RAYPATH_ERROR_ARGUMENT, "0 dimensions");
  CHECK_FAILS(raypath_euclidean(datapath, a, b, SIZE_MAX, 2, sums), RAYPATH_ERROR_ARGUMENT, "memory");
  CHECK_FAILS(raypath_euclidean(datapath, a, b, 16, 2, a + 31), RAYPATH_ERROR_OVERLAP, "a and distances");
  CHECK_FAILS(raypath_angular(datapath, a, b, 16, 2, sums, sums + 1), RAYPATH_ERROR_OVERLAP, "dot_products and norms");
  CHECK(raypath_euclidean(datapath, a, a, 16, 2, sums) == RAYPATH_OK); /* inputs may overlap */

  uint64_t words[64] = {0};
  CHECK_FAILS(raypath_run(datapath, "cube", words, 1, words), RAYPATH_ERROR_OPERATION, "'cube'");
  CHECK_FAILS(raypath_run(datapath, NULL, words, 1, words), RAYPATH_ERROR_NULL, "operation is NULL");
  CHECK_FAILS(raypath_run(datapath, "triangle", words, 1, words), RAYPATH_ERROR_OVERLAP, "inputs and outputs");
}

static void operations_that_are_missing(void) {
  raypath_datapath *graphics = NULL;
  float numbers[16] = {0}, sums[1];
  CHECK(raypath_open("preset = \"graphics\"", &graphics) == RAYPATH_OK);
  CHECK(raypath_lanes(graphics) == 0);
  CHECK_FAILS(raypath_euclidean(graphics, numbers, numbers, 16, 1, sums), RAYPATH_ERROR_OPERATION,
              "'euclidean' is not an operation of this datapath, expected");
  raypath_pipeline *pipeline = NULL;
  CHECK(raypath_pipeline_new(graphics, &pipeline) == RAYPATH_OK);
  raypath_job job;
  memset(&job, 0, sizeof job);
  job.kind = RAYPATH_JOB_EUCLIDEAN;
  CHECK_FAILS(raypath_pipeline_offer(pipeline, &job, 0), RAYPATH_ERROR_OPERATION, "'euclidean'");
  raypath_pipeline_free(pipeline);
  raypath_close(graphics);
}

static void pipelines(const raypath_datapath *datapath) {
  raypath_pipeline *pipeline = NULL;
  CHECK_FAILS(raypath_pipeline_new(NULL, &pipeline), RAYPATH_ERROR_NULL, "datapath is NULL");
  CHECK_FAILS(raypath_pipeline_new(datapath, NULL), RAYPATH_ERROR_NULL, "pipeline is NULL");
  CHECK(raypath_pipeline_new(datapath, &pipeline) == RAYPATH_OK);
  raypath_job job;
  memset(&job, 0, sizeof job);
  static const int32_t wrong[] = {-1, 6, INT32_MAX, INT32_MIN};
  for (size_t i = 0; i < 4; i++) {
    job.kind = wrong[i];
    CHECK_FAILS(raypath_pipeline_offer(pipeline, &job, 0), RAYPATH_ERROR_ARGUMENT, "is not a valid kind of job");
  }
  job.kind = RAYPATH_JOB_EUCLIDEAN;
  CHECK_FAILS(raypath_pipeline_offer(pipeline, &job, 0), RAYPATH_ERROR_NULL, "a is NULL");
  job.kind = RAYPATH_JOB_TIMING;
  job.input.words.opcode = 77;
  CHECK_FAILS(raypath_pipeline_offer(pipeline, &job, 0), RAYPATH_ERROR_OPERATION, "opcode 77");
  const uint64_t words[3] = {0};
  job.kind = RAYPATH_JOB_WORDS;
  job.input.words = (raypath_words_input){0, words, 3};
  CHECK_FAILS(raypath_pipeline_offer(pipeline, &job, 0), RAYPATH_ERROR_ARGUMENT, "3 words for a job of triangle");
  CHECK_FAILS(raypath_pipeline_offer(NULL, &job, 0), RAYPATH_ERROR_NULL, "pipeline is NULL");
  CHECK_FAILS(raypath_pipeline_offer(pipeline, NULL, 0), RAYPATH_ERROR_NULL, "job is NULL");
  CHECK(raypath_pipeline_occupancy(pipeline) == 0);
  CHECK_FAILS(raypath_pipeline_step(NULL, true, NULL), RAYPATH_ERROR_NULL, "pipeline is NULL");
  CHECK(raypath_pipeline_step(pipeline, true, NULL) == RAYPATH_NO_RESULT);
  CHECK(raypath_pipeline_skip(NULL, 5) == 0 && raypath_pipeline_occupancy(NULL) == 0);
  CHECK(!raypath_pipeline_input_ready(NULL, 0) && !raypath_pipeline_output_valid(NULL));
  raypath_result result;
  CHECK_FAILS(raypath_pipeline_peek(NULL, &result), RAYPATH_ERROR_NULL, "pipeline is NULL");
  CHECK_FAILS(raypath_pipeline_peek(pipeline, NULL), RAYPATH_ERROR_NULL, "result is NULL");
  CHECK(raypath_pipeline_peek(pipeline, &result) == RAYPATH_NO_RESULT);
  CHECK_FAILS(raypath_pipeline_reset(NULL), RAYPATH_ERROR_NULL, "pipeline is NULL");
  raypath_pipeline_free(NULL);
  raypath_pipeline_free(pipeline);
}

static void inspection(const raypath_datapath *datapath) {
  raypath_operation_info operation;
  raypath_port port;
  raypath_cost_counts cost;
  CHECK_FAILS(raypath_operation(datapath, 4, &operation), RAYPATH_ERROR_ARGUMENT, "operation 4, expected 0 to 3");
  CHECK_FAILS(raypath_input(datapath, 0, 999, &port), RAYPATH_ERROR_ARGUMENT, "port 999 of triangle");
  CHECK_FAILS(raypath_output(datapath, 9, 0, &port), RAYPATH_ERROR_ARGUMENT, "operation 9");
  CHECK_FAILS(raypath_step_cost(datapath, 99, &cost), RAYPATH_ERROR_ARGUMENT, "step 99");
  CHECK_FAILS(raypath_cost(NULL, &cost), RAYPATH_ERROR_NULL, "datapath is NULL");
  CHECK(raypath_latency(NULL) == 0 && raypath_description(NULL) == NULL);
  /* Table VIII of the paper, and README's flip-flops. */
  CHECK(raypath_cost(datapath, &cost) == RAYPATH_OK);
  CHECK(raypath_latency(datapath) == 12 && raypath_capacity(datapath) == 24 && raypath_lanes(datapath) == 16);
  CHECK(cost.flip_flops == 11023);
  uint64_t flip_flops = 0;
  for (size_t step = 0; step < raypath_step_count(datapath); step++) {
    CHECK(raypath_step_cost(datapath, step, &cost) == RAYPATH_OK);
    CHECK(step != 2 || cost.adders == 24);
    flip_flops += cost.flip_flops;
  }
  CHECK(flip_flops == 11023);
}

static void cards(void) {
  const char *card = "{\"card_version\": 1, \"idle_pj_per_cycle\": null, \"absent\": {\"idle_pj_per_cycle\": \"why\"},"
                     "\"operations\": {\"quadbox\": {\"pj_per_job\": 1.5}}}";
  double value = 0;
  CHECK(raypath_card_number(card, "/operations/quadbox/pj_per_job", &value) == RAYPATH_OK && value == 1.5);
  CHECK_FAILS(raypath_card_number(card, "/idle_pj_per_cycle", &value), RAYPATH_ERROR_ARGUMENT, "why");
  CHECK_FAILS(raypath_card_number(card, "/operations", &value), RAYPATH_ERROR_ARGUMENT, "expected a number");
  CHECK_FAILS(raypath_card_number("{\"card_version\": 2}", "/x", &value), RAYPATH_ERROR_ARGUMENT,
              "card_version is 2, expected 1");
  CHECK_FAILS(raypath_card_number("[]", "/x", &value), RAYPATH_ERROR_ARGUMENT, "card_version is null, expected 1");
  CHECK_FAILS(raypath_card_number("{", "/x", &value), RAYPATH_ERROR_ARGUMENT, "expected what `raypath card` writes");
  CHECK_FAILS(raypath_card_number(card, "/x", NULL), RAYPATH_ERROR_NULL, "value is NULL");
  CHECK_FAILS(raypath_card_number(NULL, "/x", &value), RAYPATH_ERROR_NULL, "json is NULL");
  CHECK(value == 1.5);
}

static void generation(const raypath_datapath *datapath, const char *folder) {
  char path[4096];
  struct stat found;
  CHECK_FAILS(raypath_generate(datapath, NULL), RAYPATH_ERROR_NULL, "folder is NULL");
  CHECK_FAILS(raypath_generate(datapath, "/dev/null/x"), RAYPATH_ERROR_IO, "/dev/null/x");
  CHECK(raypath_generate(datapath, folder) == RAYPATH_OK);
  snprintf(path, sizeof path, "%s/raypath.sv", folder);
  CHECK(stat(path, &found) == 0 && found.st_size > 100000);
}

int main(int count, char **arguments) {
  CHECK(count == 2);
  CHECK(raypath_abi_version() == RAYPATH_ABI_VERSION && strchr(raypath_version(), '.') != NULL);
  CHECK(strlen(raypath_commit()) == 40 || strlen(raypath_commit()) == 0);
  opening();
  rays();
  raypath_datapath *datapath = NULL;
  CHECK(raypath_open(NULL, &datapath) == RAYPATH_OK);
  arrays(datapath);
  operations_that_are_missing();
  pipelines(datapath);
  inspection(datapath);
  cards();
  generation(datapath, arguments[1]);
  raypath_close(datapath);
  return 0;
}
