/* The cycle-exact model against the rules of the handshake: latency, capacity, order, stalls, accumulators. */

#include <raypath.h>

#include "check.h"

#include <math.h>

static raypath_pipeline *new_pipeline(const char *toml, raypath_datapath **datapath) {
  raypath_pipeline *pipeline = NULL;
  CHECK(raypath_open(toml, datapath) == RAYPATH_OK);
  CHECK(raypath_pipeline_new(*datapath, &pipeline) == RAYPATH_OK);
  return pipeline;
}

static raypath_job timing(uint64_t opcode) {
  raypath_job job;
  memset(&job, 0, sizeof job);
  job.kind = RAYPATH_JOB_TIMING;
  job.input.words.opcode = opcode;
  return job;
}

/* A job of each kind, in an empty pipeline: its outcome is at the output after the latency, with its value. */
static void one_of_each(void) {
  raypath_datapath *datapath;
  raypath_pipeline *pipeline = new_pipeline(NULL, &datapath);
  const uint32_t latency = raypath_latency(datapath);
  const float origin[3] = {0, 0, -5}, direction[3] = {0, 0, 1};
  float a[16], b[16];
  for (int i = 0; i < 16; i++) a[i] = (float)i, b[i] = (float)(i - 2);
  raypath_job job;
  memset(&job, 0, sizeof job);
  for (int kind = RAYPATH_JOB_TRIANGLE; kind <= RAYPATH_JOB_ANGULAR; kind++) {
    job.kind = kind;
    if (kind == RAYPATH_JOB_TRIANGLE) {
      CHECK(raypath_ray_init(&job.input.triangle.ray, origin, direction, INFINITY) == RAYPATH_OK);
      job.input.triangle.triangle = (raypath_vertices){{-1, -1, 1}, {0, 1, 1}, {1, -1, 1}};
    } else if (kind == RAYPATH_JOB_QUADBOX) {
      CHECK(raypath_ray_init(&job.input.quadbox.ray, origin, direction, INFINITY) == RAYPATH_OK);
      for (int k = 0; k < 4; k++) {
        const float at = (float)(k == 2 ? 1 : 4 + k);
        job.input.quadbox.boxes[k] = (raypath_box){{-1, -1, at}, {1, 1, at + 1}};
      }
    } else {
      job.input.beat = (raypath_beat_input){a, b, 0x7, 1};
    }
    CHECK(raypath_pipeline_input_ready(pipeline, (uint64_t)kind));
    CHECK(raypath_pipeline_offer(pipeline, &job, 1000u + (uint64_t)kind) == RAYPATH_OK);
    CHECK(raypath_pipeline_offer(pipeline, &job, 0) == RAYPATH_BUSY); /* one job in a cycle */
    CHECK(raypath_pipeline_occupancy(pipeline) == 1);
    raypath_result result;
    for (uint32_t cycle = 0; cycle < latency; cycle++) {
      CHECK(!raypath_pipeline_output_valid(pipeline));
      CHECK(raypath_pipeline_peek(pipeline, &result) == RAYPATH_NO_RESULT);
      CHECK(raypath_pipeline_step(pipeline, true, &result) == RAYPATH_NO_RESULT);
      uint32_t stage = 0;
      CHECK(raypath_pipeline_stages(pipeline, &stage, 1) == 1 && stage == cycle + 1);
    }
    CHECK(raypath_pipeline_output_valid(pipeline));
    CHECK(raypath_pipeline_step(pipeline, false, &result) == RAYPATH_NO_RESULT); /* the sink is not ready */
    raypath_result peeked;
    memset(&peeked, 0, sizeof peeked);
    memset(&result, 0, sizeof result);
    CHECK(raypath_pipeline_peek(pipeline, &peeked) == RAYPATH_OK);
    CHECK(raypath_pipeline_step(pipeline, true, &result) == RAYPATH_OK);
    CHECK(peeked.kind == result.kind && peeked.tag == result.tag);
    CHECK(memcmp(&peeked.output.euclidean, &result.output.euclidean, sizeof result.output.euclidean) == 0);
    CHECK(result.kind == kind && result.tag == 1000u + (uint64_t)kind);
    if (kind == RAYPATH_JOB_TRIANGLE) {
      CHECK(result.output.triangle.triangle_hit == 1);
      CHECK(result.output.triangle.t_num / result.output.triangle.t_denom == 6.0f);
    } else if (kind == RAYPATH_JOB_QUADBOX) {
      CHECK(result.output.quadbox.box_index[0] == 2 && result.output.quadbox.tmin[0] == 6.0f);
    } else if (kind == RAYPATH_JOB_EUCLIDEAN) {
      CHECK(result.output.euclidean.accumulator == 12.0f && result.output.euclidean.reset_accum == 1);
    } else {
      CHECK(result.output.angular.dot_product == -1.0f && result.output.angular.norm == 5.0f);
    }
  }
  CHECK(raypath_pipeline_occupancy(pipeline) == 0);
  raypath_pipeline_free(pipeline);
  raypath_close(datapath);
}

/* A job in every cycle: one leaves in every cycle. Then the sink stalls: as many jobs fit as the handshake promises. */
static void rate_and_capacity(const char *toml, size_t capacity) {
  raypath_datapath *datapath;
  raypath_pipeline *pipeline = new_pipeline(toml, &datapath);
  const uint64_t latency = raypath_latency(datapath);
  CHECK(raypath_capacity(datapath) == capacity);
  uint64_t offered = 0, received = 0;
  for (uint64_t cycle = 0; cycle < 100; cycle++) {
    const raypath_job job = timing(cycle % 2); /* boxes and triangles in turn */
    raypath_result result;
    CHECK(raypath_pipeline_offer(pipeline, &job, offered++) == RAYPATH_OK);
    if (raypath_pipeline_step(pipeline, true, &result) == RAYPATH_OK) {
      CHECK(result.tag == received && result.kind == RAYPATH_JOB_TIMING);
      CHECK(result.output.words.opcode == received % 2 && result.output.words.count == 0);
      received++;
    }
    CHECK(received == (cycle < latency ? 0 : cycle - latency + 1));
  }
  for (int cycle = 0; cycle < 100; cycle++) {
    const raypath_job job = timing(0);
    offered += raypath_pipeline_offer(pipeline, &job, offered) == RAYPATH_OK;
    CHECK(raypath_pipeline_step(pipeline, false, NULL) == RAYPATH_NO_RESULT);
  }
  CHECK(raypath_pipeline_occupancy(pipeline) == capacity && offered - received == capacity);
  CHECK(raypath_pipeline_skip(pipeline, 50) == 0); /* an outcome is at the output already */
  for (; raypath_pipeline_occupancy(pipeline) > 0; received++) {
    raypath_result result;
    CHECK(raypath_pipeline_step(pipeline, true, &result) == RAYPATH_OK && result.tag == received);
  }
  CHECK(offered == received);
  raypath_pipeline_free(pipeline);
  raypath_close(datapath);
}

/* Under random handshakes, `skip` is as many steps, nothing is lost or reordered, and sums are those of the beats. */
static void random_handshakes(const char *toml) {
  raypath_datapath *datapath;
  raypath_pipeline *skipping = new_pipeline(toml, &datapath), *stepping = NULL;
  CHECK(raypath_pipeline_new(datapath, &stepping) == RAYPATH_OK);
  const size_t lanes = raypath_lanes(datapath);
  uint32_t random = 7;
  uint64_t offered = 0, received = 0;
  double sums[4000];
  double sum = 0.0;
  float a[64], b[64];
  for (int round = 0; round < 4000; round++) {
    raypath_job job;
    memset(&job, 0, sizeof job);
    job.kind = RAYPATH_JOB_EUCLIDEAN;
    /* Whole numbers, so that every sum is exact. */
    for (size_t i = 0; i < lanes; i++) {
      a[i] = floorf(8.0f * next_random(&random));
      b[i] = floorf(8.0f * next_random(&random));
    }
    const uint32_t is_last = next_random(&random) < -0.5f;
    job.input.beat = (raypath_beat_input){a, b, UINT64_MAX, is_last};
    if (next_random(&random) < 0.2f) {
      const raypath_status status = raypath_pipeline_offer(skipping, &job, offered);
      CHECK(status == raypath_pipeline_offer(stepping, &job, offered));
      if (status == RAYPATH_OK) {
        for (size_t i = 0; i < lanes; i++) sum += ((double)a[i] - b[i]) * ((double)a[i] - b[i]);
        sums[offered++] = sum;
        if (is_last) sum = 0.0;
      }
    }
    if (next_random(&random) < -0.6f) {
      const uint64_t limit = (uint64_t)(10.0f + 9.0f * next_random(&random));
      uint64_t steps = 0;
      for (; steps < limit && !raypath_pipeline_output_valid(stepping); steps++)
        CHECK(raypath_pipeline_step(stepping, false, NULL) == RAYPATH_NO_RESULT);
      CHECK(raypath_pipeline_skip(skipping, limit) == steps);
    }
    const bool ready = next_random(&random) < 0.3f;
    raypath_result one, other;
    const raypath_status status = raypath_pipeline_step(skipping, ready, &one);
    CHECK(status == raypath_pipeline_step(stepping, ready, &other));
    if (status == RAYPATH_OK) {
      CHECK(one.tag == received && other.tag == received);
      CHECK(one.output.euclidean.accumulator == (float)sums[received]);
      received++;
    }
    CHECK(raypath_pipeline_occupancy(skipping) == offered - received);
  }
  CHECK(received > 500);
  CHECK(raypath_pipeline_reset(skipping) == RAYPATH_OK);
  CHECK(raypath_pipeline_occupancy(skipping) == 0 && !raypath_pipeline_output_valid(skipping));
  raypath_pipeline_free(skipping);
  raypath_close(datapath); /* a pipeline remains usable without its datapath */
  CHECK(raypath_pipeline_occupancy(stepping) == offered - received);
  raypath_pipeline_free(stepping);
}

/* Words and typed jobs of a distance share one accumulator. */
static void words_and_beats(const char *toml) {
  raypath_datapath *datapath;
  raypath_pipeline *pipeline = new_pipeline(toml, &datapath);
  const uint64_t one = 0x3f800000;
  uint64_t inputs[64] = {0};
  raypath_operation_info operation;
  CHECK(raypath_operation(datapath, 2, &operation) == RAYPATH_OK && strcmp(operation.name, "euclidean") == 0);
  for (size_t i = 0; i < operation.inputs; i++) {
    raypath_port port;
    CHECK(raypath_input(datapath, 2, i, &port) == RAYPATH_OK);
    if (strcmp(port.name, "euclidean_a_0") == 0) inputs[i] = one;
    if (strcmp(port.name, "euclidean_mask") == 0) inputs[i] = UINT64_MAX;
  }
  float a[16] = {2}, b[16] = {0};
  raypath_job job;
  memset(&job, 0, sizeof job);
  for (int i = 0; i < 4; i++) {
    job.kind = i % 2 ? RAYPATH_JOB_EUCLIDEAN : RAYPATH_JOB_WORDS;
    if (i % 2) job.input.beat = (raypath_beat_input){a, b, 1, 0};
    else job.input.words = (raypath_words_input){operation.opcode, inputs, operation.inputs};
    CHECK(raypath_pipeline_offer(pipeline, &job, (uint64_t)i) == RAYPATH_OK);
    CHECK(raypath_pipeline_step(pipeline, true, NULL) == RAYPATH_NO_RESULT);
  }
  for (int i = 0; i < 4; i++) {
    static const float expected[4] = {1.0f, 5.0f, 6.0f, 10.0f};
    raypath_result result;
    raypath_pipeline_skip(pipeline, 20);
    raypath_result peeked;
    CHECK(raypath_pipeline_peek(pipeline, &peeked) == RAYPATH_OK && peeked.tag == (uint64_t)i);
    const uint64_t first = peeked.kind == RAYPATH_JOB_WORDS ? peeked.output.words.outputs[0] : 0;
    CHECK(raypath_pipeline_step(pipeline, true, &result) == RAYPATH_OK && result.tag == (uint64_t)i);
    float found = result.output.euclidean.accumulator;
    if (result.kind == RAYPATH_JOB_WORDS) {
      const uint32_t bits = (uint32_t)result.output.words.outputs[0];
      CHECK(result.output.words.count == operation.outputs && result.output.words.outputs[0] == first);
      memcpy(&found, &bits, sizeof found);
    }
    CHECK(found == expected[i]);
  }
  raypath_pipeline_free(pipeline);
  raypath_close(datapath);
}

int main(void) {
  one_of_each();
  rate_and_capacity(NULL, 24);
  rate_and_capacity("preset = \"credit\"", 13);
  rate_and_capacity("preset = \"fast\"", 47);
  random_handshakes(NULL);
  random_handshakes("preset = \"credit\"\nlanes = 4");
  random_handshakes("tag = 4");
  words_and_beats(NULL);
  words_and_beats("tag = 4");
  return 0;
}
