/* Searches: vectors that this program lays out in memory, whose neighbours are found by comparing all of them with exact
   numbers. The functional model, and the cycle-exact model with a memory of this program, saved and restored on the way.
   Wrong arguments. */

#include <raypath.h>

#include "check.h"

#include <math.h>

enum { VECTORS = 90, DIMENSIONS = 20, STRIDE = 128, QUERY = VECTORS * STRIDE, JOBS = QUERY + STRIDE, LIST = JOBS + 3 * 64,
       LISTED = 21, SIZE = LIST + 128, K = 7, BEAT = 32 };

static uint8_t memory[SIZE];
static float vectors[VECTORS + 1][DIMENSIONS];

static void set_word(uint32_t address, uint32_t word) { memcpy(memory + address, &word, 4); }

/* The layout of docs/reference/searching.md: small integers as binary32, and a job of each metric; the last gathers. */
static void make_memory(void) {
  uint32_t random = 9;
  for (int i = 0; i <= VECTORS; i++) {
    for (int j = 0; j < DIMENSIONS; j++) vectors[i][j] = roundf(5.0f * next_random(&random));
    memcpy(memory + i * STRIDE, vectors[i], sizeof vectors[i]);
  }
  for (uint32_t metric = 0; metric < 3; metric++) {
    const uint32_t job = JOBS + 64 * metric;
    const bool gathers = metric == 2;
    const float bound = INFINITY, scale = 1.0f;
    set_word(job, (uint32_t)K << 16 | metric % 2 << 4 | gathers);
    set_word(job + 4, DIMENSIONS);
    set_word(job + 8, QUERY);
    set_word(job + 16, STRIDE);
    set_word(job + 20, VECTORS);
    if (gathers) set_word(job + 24, LIST), set_word(job + 28, LISTED);
    memcpy(memory + job + 44, &bound, 4);
    memcpy(memory + job + 48, &scale, 4);
  }
  for (uint32_t i = 0; i < LISTED; i++) set_word(LIST + 4 * i, 4 * i);
}

/* The neighbours, by comparison of all. */
static void exactly(int job, raypath_neighbour found[K]) {
  double ranks[VECTORS];
  for (int i = 0; i < VECTORS; i++) {
    double squares = 0, product = 0;
    for (int j = 0; j < DIMENSIONS; j++) {
      const double a = vectors[VECTORS][j], b = vectors[i][j];
      squares += (a - b) * (a - b), product += a * b;
    }
    ranks[i] = job == 2 && (i % 4 != 0 || i >= 4 * LISTED) ? INFINITY : job == 1 ? -product : squares;
  }
  for (int n = 0; n < K; n++) {
    int best = 0;
    for (int i = 1; i < VECTORS; i++)
      if (ranks[i] < ranks[best]) best = i;
    found[n].index = (uint32_t)best;
    found[n].distance = job == 1 ? (float)-ranks[best] : (float)sqrt(ranks[best]);
    ranks[best] = INFINITY;
  }
}

static void equal(const raypath_neighbour *found, int job) {
  raypath_neighbour expected[K];
  exactly(job, expected);
  for (int n = 0; n < K; n++)
    CHECK(found[n].index == expected[n].index && found[n].distance == expected[n].distance);
}

static void functional_model(const raypath_unit *unit) {
  for (int job = 0; job < 3; job++) {
    raypath_neighbour found[K + 1];
    raypath_search_reply reply;
    CHECK(raypath_unit_search(unit, memory, SIZE, 0, JOBS + 64 * (uint32_t)job, found, K + 1, &reply) == RAYPATH_OK);
    CHECK(reply.status == RAYPATH_SEARCH_DONE && reply.count == K && reply.expansions == 0);
    CHECK(reply.distances == (job == 2 ? LISTED : VECTORS) && reply.beats == reply.distances * (job == 1 ? 3 : 2));
    equal(found, job);
  }
}

/* A request of a block, and the beats that are sent. */
typedef struct {
  uint32_t address, tag, beats;
} request;

static void cycle_exact_model(const raypath_unit *unit) {
  raypath_unit_model *model = NULL, *restored = NULL;
  CHECK(raypath_unit_model_new(unit, &model) == RAYPATH_OK && raypath_unit_model_new(unit, &restored) == RAYPATH_OK);
  static uint8_t state[1 << 20];
  raypath_neighbour found[3][K];
  request queue[64];
  uint32_t waiting = 0, offered = 0, ended = 0;
  const raypath_unit_inputs nothing = {0};
  for (uint32_t cycle = 0; ended < 3; cycle++) {
    CHECK(cycle < 20000);
    if (cycle % 100 == 50) {
      const size_t size = raypath_unit_model_save(model, state, sizeof state);
      CHECK(size > 0 && size <= sizeof state && raypath_unit_model_restore(restored, state, size) == RAYPATH_OK);
      raypath_unit_model *const other = model;
      model = restored, restored = other;
    }
    raypath_search_outputs now;
    CHECK(raypath_unit_model_search_outputs(model, &now) == RAYPATH_OK);
    raypath_search_inputs inputs = {0};
    inputs.search_valid = offered < 3;
    inputs.search_id = 5 + offered;
    inputs.search_job = JOBS + 64 * offered;
    inputs.result_ready = cycle % 3 != 0;
    inputs.vec_req_ready = waiting < 64 && cycle % 5 != 0;
    if (waiting > 0) {
      inputs.vec_rsp_valid = 1;
      inputs.vec_rsp_tag = queue[0].tag;
      inputs.vec_rsp_data = memory + queue[0].address + queue[0].beats * BEAT;
    }
    CHECK(raypath_unit_model_step_with(model, &nothing, &inputs) == RAYPATH_OK);
    if (inputs.vec_rsp_valid && ++queue[0].beats == 64 / BEAT) memmove(queue, queue + 1, --waiting * sizeof *queue);
    offered += inputs.search_valid && now.search_ready;
    if (now.vec_req_valid && inputs.vec_req_ready) {
      CHECK(now.vec_req_addr % 64 == 0 && now.vec_req_addr < SIZE);
      queue[waiting++] = (request){(uint32_t)now.vec_req_addr, now.vec_req_tag, 0};
    }
    if (now.result_valid && inputs.result_ready) {
      CHECK(now.result_id >= 5 && now.result_id < 8);
      if (now.result_found) found[now.result_id - 5][now.result_rank] = now.result;
      if (now.result_last) {
        CHECK(now.result_status == RAYPATH_SEARCH_DONE && now.result_rank + now.result_found == K);
        ended++;
      }
    }
  }
  raypath_search_outputs now;
  CHECK(raypath_unit_model_search_outputs(model, &now) == RAYPATH_OK && now.searches_idle && now.search_ready);
  for (int job = 0; job < 3; job++) equal(found[job], job);
  raypath_unit_model_free(model);
  raypath_unit_model_free(restored);
}

static void wrong_arguments(const raypath_unit *unit) {
  raypath_neighbour found[K];
  raypath_search_reply reply = {.count = 77};
  CHECK(raypath_unit_search(unit, memory, SIZE, 0, JOBS, found, K - 1, &reply) == RAYPATH_ERROR_ARGUMENT);
  CHECK(strstr(raypath_last_error(), "capacity 6, expected at least 7") != NULL);
  CHECK(raypath_unit_search(unit, memory, SIZE, 0, JOBS + 4, found, K, &reply) == RAYPATH_ERROR_ARGUMENT);
  CHECK(strstr(raypath_last_error(), "expected a multiple of 64") != NULL && reply.count == 77);
  CHECK(raypath_unit_search(unit, memory, SIZE, 0, SIZE, found, K, &reply) == RAYPATH_OK);
  CHECK(reply.status == RAYPATH_SEARCH_MEMORY && reply.count == 0);
  CHECK(raypath_unit_search(unit, memory, SIZE, 0, 0, found, K, &reply) == RAYPATH_OK);
  CHECK(reply.status == RAYPATH_SEARCH_REFUSED && reply.count == 0);
  CHECK(raypath_unit_search(unit, memory, SIZE, 0, JOBS, NULL, K, &reply) == RAYPATH_ERROR_NULL);

  raypath_unit *plain = NULL;
  raypath_unit_model *model = NULL;
  CHECK(raypath_unit_open(NULL, &plain) == RAYPATH_OK && raypath_unit_model_new(plain, &model) == RAYPATH_OK);
  CHECK(raypath_unit_search(plain, memory, SIZE, 0, JOBS, found, K, &reply) == RAYPATH_ERROR_ARGUMENT);
  CHECK(strstr(raypath_last_error(), "a unit without searches") != NULL);
  const raypath_unit_inputs nothing = {0};
  raypath_search_inputs inputs = {.search_valid = 1};
  CHECK(raypath_unit_model_step_with(model, &nothing, &inputs) == RAYPATH_ERROR_ARGUMENT);
  CHECK(strstr(raypath_last_error(), "a unit without searches") != NULL);
  raypath_unit_model_free(model);
  raypath_unit_close(plain);

  CHECK(raypath_unit_model_new(unit, &model) == RAYPATH_OK);
  inputs.search_job = 8;
  CHECK(raypath_unit_model_step_with(model, &nothing, &inputs) == RAYPATH_ERROR_ARGUMENT);
  CHECK(strstr(raypath_last_error(), "expected a multiple of 64") != NULL);
  inputs = (raypath_search_inputs){.vec_rsp_valid = 1, .vec_rsp_data = memory};
  CHECK(raypath_unit_model_step_with(model, &nothing, &inputs) == RAYPATH_ERROR_ARGUMENT);
  CHECK(strstr(raypath_last_error(), "that of a request") != NULL);
  CHECK(raypath_unit_model_step_with(model, &nothing, NULL) == RAYPATH_ERROR_NULL);
  raypath_unit_model_free(model);
}

int main(void) {
  make_memory();
  raypath_unit *unit = NULL;
  const char *toml = "search = \"k=8,m=16,contexts=2,dimensions=32\"\ncontexts = 8\nmemory-width = 256\nid-width = 10";
  CHECK(raypath_unit_open(toml, &unit) == RAYPATH_OK);
  functional_model(unit);
  cycle_exact_model(unit);
  wrong_arguments(unit);
  raypath_unit_close(unit);
  return 0;
}
