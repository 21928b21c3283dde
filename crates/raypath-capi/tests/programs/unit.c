/* The traversal unit: rays through a scene that this program lays out in memory, against every triangle in double
   precision. The cycle-exact model with a memory of this program, against the functional model. Instances of a scene
   against the same triangles in one tree. Wrong arguments. */

#include <raypath.h>

#include "check.h"

#include <math.h>
#include <sys/stat.h>

enum { BLOCK = 128, NODES = 5, LEAVES = 12, TRIANGLES = 46, RAYS = 600, BLOCKS = NODES + 3 * LEAVES };

static float triangles[TRIANGLES][3][3];
static uint8_t scene[BLOCKS * BLOCK];
static raypath_unit_ray rays[RAYS];
static raypath_unit_hit hits[RAYS + 1];

/* The layout of docs/reference/unit.md: box and child word of a node, triangle and index of a leaf's block. */
static void set_child(uint32_t node, int child, const float bounds[6], uint32_t word) {
  memcpy(scene + node + 24 * child, bounds, 24);
  memcpy(scene + node + 96 + 4 * child, &word, 4);
}

static void set_triangle(uint32_t block, int place, uint32_t index) {
  memcpy(scene + block + 36 * place, triangles[index], 36);
  memcpy(scene + block + 112 + 4 * place, &index, 4);
}

static void extend(float bounds[6], const float by[6]) {
  for (int axis = 0; axis < 3; axis++) {
    bounds[axis] = fminf(bounds[axis], by[axis]);
    bounds[3 + axis] = fmaxf(bounds[3 + axis], by[3 + axis]);
  }
}

enum { BACK = RAYPATH_RAY_CULL_BACK_FACING_TRIANGLES, FRONT = RAYPATH_RAY_CULL_FRONT_FACING_TRIANGLES };
static const uint32_t culls[3] = {0, BACK, FRONT};

/* A multiple of 2^-10, so that the transforms of instances are exact. */
static float on_grid(float x) { return roundf(1024.0f * x) / 1024.0f; }

/* A root with four nodes, of which each has three leaves of 1 to 8 triangles. */
static void make_scene(void) {
  static const float none[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
  uint32_t random = 5, address = NODES * BLOCK, triangle = 0;
  for (int node = 0; node < 4; node++) {
    float all[6];
    memcpy(all, none, sizeof all);
    const uint32_t here = (uint32_t)(1 + node) * BLOCK;
    for (int child = 0; child < 3; child++) {
      const uint32_t count = (uint32_t)(3 * node + child) % 8 + 1;
      float bounds[6], centre[3];
      memcpy(bounds, none, sizeof bounds);
      for (int axis = 0; axis < 3; axis++) centre[axis] = next_random(&random);
      for (uint32_t i = 0; i < count; i++, triangle++) {
        for (int k = 0; k < 9; k++)
          triangles[triangle][k / 3][k % 3] = on_grid(centre[k % 3] + 0.5f * next_random(&random));
        for (int k = 0; k < 3; k++) {
          float padded[6];
          for (int axis = 0; axis < 3; axis++) {
            padded[axis] = triangles[triangle][k][axis] - 1e-4f;
            padded[3 + axis] = triangles[triangle][k][axis] + 1e-4f;
          }
          extend(bounds, padded);
        }
        set_triangle(address + i / 3 * BLOCK, (int)(i % 3), triangle);
      }
      set_child(here, child, bounds, address | count);
      extend(all, bounds);
      address += (count + 2) / 3 * BLOCK;
    }
    set_child(here, 3, none, 0);
    set_child(0, node, all, here | 32);
  }
  CHECK(triangle == TRIANGLES && address <= sizeof scene);
}

/* Möller and Trumbore's test in double precision: the distance, or infinity for a miss. `doubt` is the least distance
   from an edge. */
static double distance(const raypath_unit_ray *ray, uint32_t triangle, int *is_back, double *doubt) {
  double e1[3], e2[3], s[3], p[3], q[3], determinant = 0.0, u = 0.0, v = 0.0, t = 0.0;
  const float *d = ray->direction;
  for (int k = 0; k < 3; k++) {
    e1[k] = (double)triangles[triangle][1][k] - triangles[triangle][0][k];
    e2[k] = (double)triangles[triangle][2][k] - triangles[triangle][0][k];
    s[k] = (double)ray->origin[k] - triangles[triangle][0][k];
  }
  for (int k = 0; k < 3; k++) {
    const int x = (k + 1) % 3, y = (k + 2) % 3;
    p[k] = d[x] * e2[y] - d[y] * e2[x];
    q[k] = s[x] * e1[y] - s[y] * e1[x];
  }
  for (int k = 0; k < 3; k++) {
    determinant += e1[k] * p[k];
    u += s[k] * p[k];
    v += d[k] * q[k];
    t += e2[k] * q[k];
  }
  u /= determinant, v /= determinant, t /= determinant;
  const double inside = fmin(fmin(u, v), 1.0 - u - v);
  *doubt = fmin(fabs(inside), fmin(fabs(t - ray->t_min), fabs(t - ray->t_max)));
  *is_back = determinant < 0.0;
  const uint32_t culled = *is_back ? BACK : FRONT;
  if (fabs(determinant) < 1e-3) *doubt = 0.0;
  return inside < 0.0 || t <= ray->t_min || t >= ray->t_max || (ray->flags & culled) != 0 ? INFINITY : t;
}

/* Rays towards the triangles; each tenth points away from one. */
static void make_rays(void) {
  uint32_t random = 11;
  for (uint32_t i = 0; i < RAYS; i++) {
    raypath_unit_ray *ray = &rays[i];
    for (int axis = 0; axis < 3; axis++) {
      ray->origin[axis] = 2.5f * next_random(&random);
      const float target = triangles[i % TRIANGLES][0][axis] + 0.4f * next_random(&random);
      ray->direction[axis] = i % 10 == 9 ? ray->origin[axis] - target : target - ray->origin[axis];
    }
    ray->t_min = i % 5 == 0 ? 0.9f : 0.0f;
    ray->t_max = i % 7 == 0 ? 1.0f : INFINITY;
    ray->flags = (i % 4 == 3 ? RAYPATH_RAY_TERMINATE_ON_FIRST_HIT : 0) | culls[i / 4 % 3];
    ray->root = 32; /* the node at address 0 */
  }
}

static void functional_model(const raypath_unit *unit) {
  memset(hits, 0xee, sizeof hits);
  CHECK(raypath_unit_trace(unit, scene, sizeof scene, rays, RAYS, hits) == RAYPATH_OK);
  CHECK(hits[RAYS].status == 0xeeeeeeeeu); /* nothing beyond the array is written */
  int found[2] = {0, 0};
  for (uint32_t i = 0; i < RAYS; i++) {
    const raypath_unit_hit *hit = &hits[i];
    double nearest = INFINITY, second = INFINITY, least = INFINITY;
    int is_back = 0;
    uint32_t index = 0;
    for (uint32_t triangle = 0; triangle < TRIANGLES; triangle++) {
      int back;
      double doubt;
      const double t = distance(&rays[i], triangle, &back, &doubt);
      least = fmin(least, doubt);
      if (t < nearest) second = nearest, nearest = t, index = triangle, is_back = back;
      else second = fmin(second, t);
    }
    if (least < 1e-4 || second - nearest < 1e-4) continue;
    CHECK(hit->status == (nearest < INFINITY ? RAYPATH_UNIT_HIT : RAYPATH_UNIT_MISS));
    found[hit->status]++;
    if (hit->status == RAYPATH_UNIT_MISS) {
      CHECK(hit->primitive == 0 && hit->t == 0.0f && hit->t_denom == 0.0f);
      continue;
    }
    CHECK(hit->t == hit->t_num / hit->t_denom);
    if (rays[i].flags & RAYPATH_RAY_TERMINATE_ON_FIRST_HIT) {
      int back;
      double doubt;
      index = hit->primitive;
      CHECK(index < TRIANGLES && hit->t > nearest - 1e-3);
      nearest = distance(&rays[i], index, &back, &doubt);
      is_back = back;
    }
    CHECK(hit->primitive == index && fabs(hit->t - nearest) < 1e-3 * nearest);
    CHECK(hit->back_face == (uint32_t)is_back);
    for (int axis = 0; axis < 3; axis++) { /* the weights of the vertices give the point of the hit */
      const double a = triangles[index][0][axis], b = triangles[index][1][axis], c = triangles[index][2][axis];
      const double point = rays[i].origin[axis] + nearest * rays[i].direction[axis];
      CHECK(fabs(hit->u * b + hit->v * c + (1.0 - hit->u - hit->v) * a - point) < 1e-3);
    }
  }
  CHECK(found[0] > 100 && found[1] > 100);
}

/* A memory answers each request after `latency` cycles, in order, with the bytes below `size`. Rays come as fast as the
   unit takes them, and hits are taken at once. Sets the hit of each ray and the cycle in which it left. */
typedef struct {
  uint64_t due;
  uint64_t address;
  uint32_t tag;
} request;

static void run(raypath_unit_model *model, uint64_t latency, size_t size, bool skips, raypath_unit_hit *found,
                uint64_t *left) {
  static request queue[1 << 16];
  static const uint8_t nothing[BLOCK];
  const size_t width = 32; /* bytes of a beat of 256 bits */
  size_t first = 0, last = 0, done = 0, beat = 0, beats = 0;
  uint64_t offered = 0, cycle = 0, inside = 0, waited = 0, phases[4] = {0};
  memset(found, 0xee, RAYS * sizeof *found);
  while (done < RAYS) {
    raypath_unit_outputs outputs;
    raypath_unit_inputs inputs;
    memset(&inputs, 0, sizeof inputs);
    CHECK(raypath_unit_model_outputs(model, &outputs) == RAYPATH_OK);
    if (offered < RAYS) inputs.ray = rays[offered], inputs.ray_id = offered, inputs.ray_valid = 1;
    inputs.hit_ready = inputs.mem_req_ready = 1;
    if (first < last && queue[first].due <= cycle) {
      const bool exists = (size_t)queue[first].address + BLOCK <= size;
      inputs.mem_rsp_data = (exists ? scene + queue[first].address : nothing) + beat * width;
      inputs.mem_rsp_valid = 1;
      inputs.mem_rsp_tag = queue[first].tag;
      inputs.mem_rsp_error = !exists;
      beat = (beat + 1) % (BLOCK / width);
      first += beat == 0;
      beats++;
    } else if (skips && offered == RAYS && !outputs.hit_valid && !outputs.mem_req_valid) {
      const uint64_t most = first < last ? queue[first].due - cycle : 1000;
      const uint64_t skipped = raypath_unit_model_skip(model, most);
      CHECK(skipped >= 1 && skipped <= most);
      cycle += skipped;
      inside += (offered - done) * skipped;
      continue;
    }
    /* The rays inside are in contexts or at the outputs. One whose block was requested waits for the memory. */
    raypath_ray_inside in_contexts[256];
    const size_t count = raypath_unit_model_rays(model, in_contexts, 256);
    CHECK(count + outputs.hit_valid == offered - done);
    for (size_t i = 0; i < count; i++) {
      CHECK(in_contexts[i].id < offered && found[in_contexts[i].id].status == 0xeeeeeeeeu);
      phases[in_contexts[i].phase]++;
    }
    for (size_t k = first; k < last; k++) {
      size_t i = 0;
      while (i < count && in_contexts[i].context != queue[k].tag) i++;
      CHECK(i < count && in_contexts[i].phase == RAYPATH_PHASE_MEMORY && in_contexts[i].address == queue[k].address);
    }
    CHECK(raypath_unit_model_step(model, &inputs) == RAYPATH_OK);
    inside += offered - done;
    waited += inputs.ray_valid && !outputs.ray_ready;
    if (inputs.ray_valid && outputs.ray_ready) offered++;
    if (outputs.mem_req_valid) {
      CHECK(outputs.mem_req_addr % BLOCK == 0 && last < sizeof queue / sizeof *queue);
      queue[last++] = (request){cycle + latency, outputs.mem_req_addr, outputs.mem_req_tag};
    }
    if (outputs.hit_valid) {
      CHECK(outputs.hit_id < offered && found[outputs.hit_id].status == 0xeeeeeeeeu); /* once for each ray */
      found[outputs.hit_id] = outputs.hit;
      left[outputs.hit_id] = cycle;
      done++;
    }
    cycle++;
  }
  raypath_unit_counts counts;
  uint64_t nodes = 0, tested = 0;
  for (int i = 0; i < RAYS; i++) nodes += found[i].nodes, tested += found[i].triangles;
  CHECK(raypath_unit_model_counts(model, &counts) == RAYPATH_OK);
  CHECK(counts.rays == RAYS && counts.cycles == cycle && counts.fetches == last && 4 * last == beats);
  if (size >= sizeof scene) CHECK(counts.boxes == nodes && counts.triangles == tested);
  raypath_unit_stalls stalls;
  CHECK(raypath_unit_model_stalls(model, &stalls) == RAYPATH_OK);
  CHECK(stalls.rays_inside == 0 && stalls.ray_cycles == inside && stalls.hit_stalls == 0 && stalls.request_stalls == 0);
  CHECK(stalls.ray_stalls == waited);
  for (int phase = 0; phase < 4; phase++) CHECK(phases[phase] > 0);
}

static void cycle_exact_model(const raypath_unit *unit) {
  static raypath_unit_hit found[RAYS], other[RAYS];
  static uint64_t left[RAYS], left_other[RAYS];
  raypath_unit_model *model = NULL;
  CHECK(raypath_unit_model_new(unit, &model) == RAYPATH_OK);
  run(model, 100, sizeof scene, true, found, left);
  CHECK(memcmp(found, hits, sizeof found) == 0);
  CHECK(raypath_unit_model_reset(model) == RAYPATH_OK);
  run(model, 100, sizeof scene, false, other, left_other); /* `skip` is as many steps */
  CHECK(memcmp(other, hits, sizeof other) == 0 && memcmp(left, left_other, sizeof left) == 0);

  /* Of a scene without its last two nodes and without leaves, errors of the memory end rays, as in the functional
     model. */
  CHECK(raypath_unit_model_reset(model) == RAYPATH_OK);
  run(model, 1, 3 * BLOCK, true, found, left);
  CHECK(raypath_unit_trace(unit, scene, 3 * BLOCK, rays, RAYS, other) == RAYPATH_OK);
  int errors = 0;
  for (int i = 0; i < RAYS; i++) errors += other[i].status == RAYPATH_UNIT_MEMORY;
  CHECK(memcmp(found, other, sizeof found) == 0 && errors > 100 && errors < RAYS);
  raypath_unit_model_free(model);
}

/* What the unit refuses, and what the interface does. */
static void wrong_rays(const raypath_unit *unit) {
  raypath_unit_ray ray = rays[0];
  raypath_unit_hit hit;
  memset(ray.direction, 0, sizeof ray.direction);
  CHECK(raypath_unit_trace(unit, scene, sizeof scene, &ray, 1, &hit) == RAYPATH_OK);
  CHECK(hit.status == RAYPATH_UNIT_REFUSED && hit.nodes == 0);
  ray = rays[0];
  CHECK(raypath_unit_trace(unit, NULL, 0, &ray, 1, &hit) == RAYPATH_OK && hit.status == RAYPATH_UNIT_MEMORY);
  CHECK(raypath_unit_trace(unit, NULL, 0, NULL, 0, NULL) == RAYPATH_OK);
  raypath_unit_ray two[2] = {rays[0], rays[0]};
  raypath_unit_hit results[2];
  memset(results, 0x5a, sizeof results);
  two[1].flags = 1024;
  CHECK_FAILS(raypath_unit_trace(unit, scene, sizeof scene, two, 2, results), RAYPATH_ERROR_ARGUMENT,
              "ray 1: flags is 1024, expected 0 to 1023");
  two[1].flags = 0, two[1].base = 1;
  CHECK_FAILS(raypath_unit_trace(unit, scene, sizeof scene, two, 2, results), RAYPATH_ERROR_ARGUMENT,
              "ray 1: base is 1, expected 0 to 0 with addresses of 32 bits");
  CHECK(results[0].status == 0x5a5a5a5au);
  CHECK_FAILS(raypath_unit_trace(NULL, scene, sizeof scene, two, 1, results), RAYPATH_ERROR_NULL, "unit is NULL");
  CHECK_FAILS(raypath_unit_trace(unit, NULL, 128, two, 1, results), RAYPATH_ERROR_NULL, "scene is NULL");
  CHECK_FAILS(raypath_unit_trace(unit, scene, 128, NULL, 1, results), RAYPATH_ERROR_NULL, "rays is NULL");
  CHECK_FAILS(raypath_unit_trace(unit, scene, 128, two, 1, NULL), RAYPATH_ERROR_NULL, "hits is NULL");
  raypath_unit_hit *odd = (raypath_unit_hit *)(uintptr_t)((uintptr_t)results + 1);
  CHECK_FAILS(raypath_unit_trace(unit, scene, 128, two, 1, odd), RAYPATH_ERROR_ALIGNMENT, "multiple of 4");
  raypath_unit_hit *over = (raypath_unit_hit *)(void *)two;
  CHECK_FAILS(raypath_unit_trace(unit, scene, 128, two, 1, over), RAYPATH_ERROR_OVERLAP, "rays and hits overlap");
  const uint8_t *same = (const uint8_t *)results;
  CHECK_FAILS(raypath_unit_trace(unit, same, 8, two, 1, results), RAYPATH_ERROR_OVERLAP, "scene and hits overlap");
}

/* With addresses of 40 bits, a ray brings the upper 8, and the memory is asked for them, too. */
static void bases(void) {
  raypath_unit *unit = NULL;
  raypath_unit_model *model = NULL;
  CHECK(raypath_unit_open("preset = \"compact\"\naddress-width = 40", &unit) == RAYPATH_OK);
  raypath_unit_parameter_values values;
  CHECK(raypath_unit_parameters(unit, &values) == RAYPATH_OK && values.address_width == 40);
  raypath_unit_inputs inputs;
  memset(&inputs, 0, sizeof inputs);
  inputs.ray = rays[0], inputs.ray_valid = 1, inputs.ray.base = 256;
  raypath_unit_hit hit;
  CHECK_FAILS(raypath_unit_trace(unit, scene, sizeof scene, &inputs.ray, 1, &hit), RAYPATH_ERROR_ARGUMENT,
              "ray 0: base is 256, expected 0 to 255 with addresses of 40 bits");
  CHECK(raypath_unit_model_new(unit, &model) == RAYPATH_OK);
  CHECK_FAILS(raypath_unit_model_step(model, &inputs), RAYPATH_ERROR_ARGUMENT, "base is 256, expected 0 to 255");
  inputs.ray.base = 255;
  CHECK(raypath_unit_model_step(model, &inputs) == RAYPATH_OK);
  raypath_unit_outputs outputs;
  CHECK(raypath_unit_model_skip(model, 1000) > 0 && raypath_unit_model_outputs(model, &outputs) == RAYPATH_OK);
  inputs.ray_valid = 0;
  while (!outputs.mem_req_valid) {
    CHECK(raypath_unit_model_step(model, &inputs) == RAYPATH_OK);
    CHECK(raypath_unit_model_outputs(model, &outputs) == RAYPATH_OK);
  }
  raypath_ray_inside inside;
  CHECK(outputs.mem_req_addr == UINT64_C(0xff00000000) && raypath_unit_model_rays(model, &inside, 1) == 1);
  CHECK(inside.address == outputs.mem_req_addr);
  /* A scene in memory has base 0. */
  CHECK(raypath_unit_trace(unit, scene, sizeof scene, &inputs.ray, 1, &hit) == RAYPATH_OK);
  CHECK(hit.status == RAYPATH_UNIT_MEMORY);
  inputs.ray.base = 0;
  CHECK(raypath_unit_trace(unit, scene, sizeof scene, &inputs.ray, 1, &hit) == RAYPATH_OK);
  CHECK(hit.status == hits[0].status && hit.t == hits[0].t);
  raypath_unit_model_free(model);
  raypath_unit_close(unit);
}

static void wrong_inputs(const raypath_unit *unit) {
  raypath_unit_model *model = NULL;
  raypath_unit_outputs outputs;
  raypath_unit_counts counts;
  raypath_unit_inputs inputs;
  memset(&inputs, 0, sizeof inputs);
  CHECK_FAILS(raypath_unit_model_new(NULL, &model), RAYPATH_ERROR_NULL, "unit is NULL");
  CHECK_FAILS(raypath_unit_model_new(unit, NULL), RAYPATH_ERROR_NULL, "model is NULL");
  CHECK(raypath_unit_model_new(unit, &model) == RAYPATH_OK);
  CHECK_FAILS(raypath_unit_model_step(NULL, &inputs), RAYPATH_ERROR_NULL, "model is NULL");
  CHECK_FAILS(raypath_unit_model_step(model, NULL), RAYPATH_ERROR_NULL, "inputs is NULL");
  CHECK_FAILS(raypath_unit_model_outputs(model, NULL), RAYPATH_ERROR_NULL, "outputs is NULL");
  CHECK_FAILS(raypath_unit_model_counts(NULL, &counts), RAYPATH_ERROR_NULL, "model is NULL");
  CHECK_FAILS(raypath_unit_model_reset(NULL), RAYPATH_ERROR_NULL, "model is NULL");
  CHECK(raypath_unit_model_skip(NULL, 5) == 0);
  inputs.ray = rays[0], inputs.ray_valid = 1, inputs.ray_id = 1024;
  CHECK_FAILS(raypath_unit_model_step(model, &inputs), RAYPATH_ERROR_ARGUMENT, "id 1024, expected at most 10 bits");
  inputs.ray_id = 1023, inputs.ray.cull_mask = 256;
  CHECK_FAILS(raypath_unit_model_step(model, &inputs), RAYPATH_ERROR_ARGUMENT, "cull_mask is 256");
  inputs.ray.cull_mask = 0, inputs.mem_rsp_valid = 1;
  CHECK_FAILS(raypath_unit_model_step(model, &inputs), RAYPATH_ERROR_NULL, "mem_rsp_data is NULL");
  inputs.mem_rsp_data = scene;
  CHECK_FAILS(raypath_unit_model_step(model, &inputs), RAYPATH_ERROR_ARGUMENT, "a beat with the tag 0");
  inputs.mem_rsp_tag = 8;
  CHECK_FAILS(raypath_unit_model_step(model, &inputs), RAYPATH_ERROR_ARGUMENT, "a beat with the tag 8");
  CHECK(raypath_unit_model_counts(model, &counts) == RAYPATH_OK && counts.cycles == 0); /* no cycle has passed */

  /* A request that was not taken has no response yet, and after a reset none any more. */
  inputs.mem_rsp_valid = 0;
  CHECK(raypath_unit_model_step(model, &inputs) == RAYPATH_OK);
  inputs.ray_valid = 0;
  do {
    CHECK(raypath_unit_model_skip(model, 1000) > 0);
    CHECK(raypath_unit_model_outputs(model, &outputs) == RAYPATH_OK);
  } while (!outputs.mem_req_valid);
  CHECK(raypath_unit_model_skip(model, 1000) == 0); /* a request is at the outputs already */
  inputs.mem_rsp_valid = 1, inputs.mem_rsp_tag = outputs.mem_req_tag;
  CHECK_FAILS(raypath_unit_model_step(model, &inputs), RAYPATH_ERROR_ARGUMENT, "expected that of a request");
  inputs.mem_rsp_valid = 0, inputs.mem_req_ready = 1;
  CHECK(raypath_unit_model_step(model, &inputs) == RAYPATH_OK);
  inputs.mem_rsp_valid = 1, inputs.mem_req_ready = 0;
  CHECK(raypath_unit_model_step(model, &inputs) == RAYPATH_OK);
  CHECK(raypath_unit_model_reset(model) == RAYPATH_OK);
  CHECK_FAILS(raypath_unit_model_step(model, &inputs), RAYPATH_ERROR_ARGUMENT, "expected that of a request");
  raypath_unit_model_free(NULL);
  raypath_unit_model_free(model);
}

static void opening(const raypath_unit *unit, const char *folder) {
  raypath_unit *other = NULL;
  CHECK_FAILS(raypath_unit_open(NULL, NULL), RAYPATH_ERROR_NULL, "unit is NULL");
  CHECK_FAILS(raypath_unit_open("preset = \"compact\"\ncontexts = 7", &other), RAYPATH_ERROR_CONFIGURATION,
              "configuration:2: contexts: '7', expected 8 to 256");
  CHECK_FAILS(raypath_unit_open("stack = \"deep\"", &other), RAYPATH_ERROR_CONFIGURATION, "stack: 'deep'");
  CHECK_FAILS(raypath_unit_open("depth = 3", &other), RAYPATH_ERROR_CONFIGURATION, "divider-latency");
  CHECK_FAILS(raypath_unit_open("preset = \"half\"", &other), RAYPATH_ERROR_CONFIGURATION, "expected format fp32");
  raypath_datapath *datapath = NULL;
  CHECK_FAILS(raypath_open("contexts = 8", &datapath), RAYPATH_ERROR_CONFIGURATION, "'contexts' is not a valid");
  CHECK(other == NULL && datapath == NULL);
  raypath_unit_close(NULL);
  raypath_unit_parameter_values values;
  CHECK_FAILS(raypath_unit_parameters(unit, NULL), RAYPATH_ERROR_NULL, "values is NULL");
  CHECK(raypath_unit_parameters(unit, &values) == RAYPATH_OK && values.contexts == 8 && values.stack == 2);
  CHECK(values.memory_width == 256 && values.id_width == 10 && values.divider_latency == 11);
  CHECK(values.ram_latency == 1 && values.parity == 0);
  CHECK(values.block_bytes == BLOCK && values.instances == 0 && values.address_width == 32);
  CHECK(strstr(raypath_unit_description(unit), "8 contexts") != NULL && raypath_unit_description(NULL) == NULL);

  char path[4096];
  struct stat found;
  CHECK_FAILS(raypath_unit_generate(unit, NULL), RAYPATH_ERROR_NULL, "folder is NULL");
  CHECK_FAILS(raypath_unit_generate(unit, "/dev/null/x"), RAYPATH_ERROR_IO, "/dev/null/x");
  CHECK(raypath_unit_generate(unit, folder) == RAYPATH_OK);
  snprintf(path, sizeof path, "%s/raypath_unit.sv", folder);
  CHECK(stat(path, &found) == 0 && found.st_size > 100000);
  snprintf(path, sizeof path, "%s/rtl/raypath_unit_axi.sv", folder);
  CHECK(stat(path, &found) == 0);
}

enum { PLACES = 3, LEVELS = BLOCKS + PLACES + 1 };

/* Matrices from the object to the scene under which transforms have no rounding: the object itself, moved, and with
   its axes exchanged, so that a point (x, y, z) is at (z, x, y) + (0, -16, 0). */
static const float to_scene[PLACES][3][4] = {
    {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
    {{1, 0, 0, 8}, {0, 1, 0, 0}, {0, 0, 1, 16}},
    {{0, 0, 1, 0}, {1, 0, 0, -16}, {0, 1, 0, 0}},
};

static void place(const float matrix[3][4], const float from[3], float to[3]) {
  for (int axis = 0; axis < 3; axis++) {
    to[axis] = matrix[axis][3];
    for (int k = 0; k < 3; k++) to[axis] += matrix[axis][k] * from[k];
  }
}

/* A scene of two levels: the tree of `scene`, three instances of it, and a node over them as the root. */
static void instantiate(uint8_t *two_levels) {
  memcpy(two_levels, scene, sizeof scene);
  uint8_t *root = two_levels + (BLOCKS + PLACES) * BLOCK;
  for (int number = 0; number < PLACES; number++) {
    const uint32_t address = (uint32_t)(BLOCKS + number) * BLOCK, object = 32, index = (uint32_t)number;
    const uint32_t word = address | 33;
    float matrix[3][4], bounds[6];
    const float corners[2][3] = {{-2, -2, -2}, {2, 2, 2}};
    for (int row = 0; row < 3; row++) { /* the inverse of a matrix that turns and moves */
      matrix[row][3] = 0;
      for (int k = 0; k < 3; k++) {
        matrix[row][k] = to_scene[number][k][row];
        matrix[row][3] -= to_scene[number][k][row] * to_scene[number][k][3];
      }
    }
    memcpy(two_levels + address, matrix, sizeof matrix);
    memcpy(two_levels + address + 96, &object, 4);
    memcpy(two_levels + address + 100, &index, 4);
    for (int k = 0; k < 2; k++) place(to_scene[number], corners[k], bounds + 3 * k);
    memcpy(root + 24 * number, bounds, 24);
    memcpy(root + 96 + 4 * number, &word, 4);
  }
  const float none[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
  memcpy(root + 24 * PLACES, none, 24);
}

/* The same triangles in one list of leaves below a node: index `TRIANGLES * instance + triangle`. */
static uint32_t flatten(uint8_t *flat) {
  enum { LEAF = 8, PARTS = (PLACES * TRIANGLES + LEAF - 1) / LEAF };
  uint32_t words[64], address = 0, count = PARTS;
  for (uint32_t part = 0; part < PARTS; part++) {
    const uint32_t first = part * LEAF, left = PLACES * TRIANGLES - first, in_leaf = left < LEAF ? left : LEAF;
    words[part] = address | in_leaf;
    for (uint32_t i = 0; i < in_leaf; i++) {
      const uint32_t index = first + i;
      uint8_t *block = flat + address + i / 3 * BLOCK;
      for (int k = 0; k < 3; k++) {
        float corner[3];
        place(to_scene[index / TRIANGLES], triangles[index % TRIANGLES][k], corner);
        memcpy(block + 36 * (i % 3) + 12 * k, corner, 12);
      }
      memcpy(block + 112 + 4 * (i % 3), &index, 4);
    }
    address += (in_leaf + 2) / 3 * BLOCK;
  }
  static const float all[6] = {-100, -100, -100, 100, 100, 100};
  static const float none[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
  while (count > 1) {
    uint32_t nodes = 0;
    for (uint32_t first = 0; first < count; first += 4, nodes++, address += BLOCK) {
      for (uint32_t child = 0; child < 4; child++) {
        const uint32_t word = first + child < count ? words[first + child] : 0;
        memcpy(flat + address + 24 * child, word ? all : none, 24);
        memcpy(flat + address + 96 + 4 * child, &word, 4);
      }
      words[nodes] = address | 32;
    }
    count = nodes;
  }
  return words[0];
}

/* Hits of instances have the bits of those in one tree, because no transform rounds. */
static void instances(void) {
  static uint8_t two_levels[LEVELS * BLOCK], flat[128 * BLOCK];
  static raypath_unit_ray sent[RAYS];
  static raypath_unit_hit found[RAYS], expected[RAYS];
  raypath_unit *unit = NULL;
  raypath_unit_parameter_values values;
  CHECK_FAILS(raypath_unit_open("nested-instances = true", &unit), RAYPATH_ERROR_CONFIGURATION,
              "expected true, which nested instances need");
  CHECK(raypath_unit_open("barycentrics = true\ninstances = true", &unit) == RAYPATH_OK);
  CHECK(raypath_unit_parameters(unit, &values) == RAYPATH_OK && values.instances == 1 && values.block_bytes == 128);

  instantiate(two_levels);
  const uint32_t root = (uint32_t)(BLOCKS + PLACES) * BLOCK | 32, flat_root = flatten(flat);
  uint32_t random = 23;
  for (uint32_t i = 0; i < RAYS; i++) {
    float target[3];
    memset(&sent[i], 0, sizeof sent[i]);
    place(to_scene[i % PLACES], triangles[i % TRIANGLES][0], target);
    for (int axis = 0; axis < 3; axis++) {
      sent[i].origin[axis] = on_grid(4.0f * next_random(&random));
      sent[i].direction[axis] = target[axis] + on_grid(0.4f * next_random(&random)) - sent[i].origin[axis];
    }
    sent[i].t_max = INFINITY;
    sent[i].flags = culls[i / 4 % 3];
    sent[i].root = root;
  }
  CHECK(raypath_unit_trace(unit, two_levels, sizeof two_levels, sent, RAYS, found) == RAYPATH_OK);
  for (int i = 0; i < RAYS; i++) sent[i].root = flat_root;
  CHECK(raypath_unit_trace(unit, flat, sizeof flat, sent, RAYS, expected) == RAYPATH_OK);
  int in_place[PLACES] = {0}, missed = 0;
  for (int i = 0; i < RAYS; i++) {
    CHECK(found[i].status == expected[i].status && found[i].status <= RAYPATH_UNIT_HIT);
    if (found[i].status == RAYPATH_UNIT_MISS) {
      CHECK(found[i].instance == 0);
      missed++;
      continue;
    }
    CHECK(found[i].instance < PLACES && expected[i].instance == RAYPATH_UNIT_NO_INSTANCE);
    CHECK(found[i].instance * TRIANGLES + found[i].primitive == expected[i].primitive);
    CHECK(memcmp(&found[i].t, &expected[i].t, 6 * sizeof(float)) == 0); /* t to back_face */
    in_place[found[i].instance]++;
  }
  CHECK(missed > 20 && in_place[0] > 20 && in_place[1] > 20 && in_place[2] > 20);
  raypath_unit_close(unit);
}

int main(int count, char **arguments) {
  CHECK(count == 2);
  make_scene();
  make_rays();
  raypath_unit *unit = NULL;
  const char *toml =
      "preset = \"compact\"\nbarycentrics = true\ncontexts = 8\nstack = 2\nmemory-width = 256\nid-width = 10";
  CHECK(raypath_unit_open(toml, &unit) == RAYPATH_OK);
  opening(unit, arguments[1]);
  functional_model(unit);
  wrong_rays(unit);
  bases();
  wrong_inputs(unit);
  cycle_exact_model(unit);
  raypath_unit_close(unit);
  instances();
  return 0;
}
