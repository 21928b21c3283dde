/* SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * A model of raypath_device for programs without hardware: its registers and rings in C around the cycle-exact unit of
 * libraypath. The driver runs on it as on the device; the test at the end compares its hits with those of the
 * functional model.
 */

#include <raypath.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raypath_driver.h"

#define LATENCY 60 /* cycles of the memory */
#define ACCESS 8   /* cycles of an access to a register */
#define SLOTS 65536

/* A block that the unit waits for. */
typedef struct {
  uint64_t due, address;
  uint32_t tag;
} request;

typedef struct {
  uint8_t *memory; /* The device's addresses from 0 on. */
  size_t size;
  raypath_unit_parameter_values values;
  raypath_unit_model *unit;
  uint32_t registers[1024]; /* By offset / 4. */
  uint32_t error, before;   /* The levels of the events in the cycle before. */
  int has_ray, is_flushing;
  raypath_device_ray ray;
  uint32_t ids[SLOTS][2]; /* Of the rays inside, by the id in the unit. */
  uint8_t is_used[SLOTS];
  uint32_t next, inside;
  request queue[SLOTS];
  uint32_t queue_head, queue_tail, beat;
  uint64_t cycle;
} model;

static uint32_t *at(model *device, uint32_t offset) { return &device->registers[offset / 4]; }

static uint64_t pair(model *device, uint32_t offset) {
  return (uint64_t)*at(device, offset + 4) << 32 | *at(device, offset);
}

/* The place of a record, or NULL beyond the memory. */
static void *place(model *device, uint32_t base, uint32_t size, uint32_t index) {
  const uint64_t bytes = UINT64_C(64) << *at(device, size), first = pair(device, base);
  if (first > device->size || bytes > device->size - first) return NULL;
  return device->memory + first + 64 * (index & ((1u << *at(device, size)) - 1));
}

static int is_wrong(model *device, uint32_t size, uint32_t used) {
  return *at(device, size) > 20 || used > 1u << *at(device, size);
}

static int is_idle(const model *device) { return !device->has_ray && device->inside == 0 && !device->is_flushing; }

/* The ray of a record, and the record of a hit. */
static raypath_unit_ray unit_ray(const raypath_device_ray *ray) {
  raypath_unit_ray unit = {.t_min = ray->t_min,
                           .t_max = ray->t_max,
                           .flags = ray->flags & 0x3ff,
                           .cull_mask = ray->cull_mask & 0xff,
                           .root = ray->root,
                           .base = ray->base};
  memcpy(unit.origin, ray->origin, sizeof unit.origin);
  memcpy(unit.direction, ray->direction, sizeof unit.direction);
  return unit;
}

static raypath_device_hit device_hit(const raypath_unit_hit *hit, const uint32_t id[2]) {
  return (raypath_device_hit){.id = {id[0], id[1]},
                              .status = hit->status | hit->back_face << 8,
                              .primitive = hit->primitive,
                              .t = hit->t,
                              .t_num = hit->t_num,
                              .t_denom = hit->t_denom,
                              .geometry = hit->geometry,
                              .nodes = hit->nodes,
                              .triangles = hit->triangles,
                              .instance = hit->instance,
                              .custom_index = hit->custom_index,
                              .shader_offset = hit->shader_offset};
}

static void step(model *device) {
  const int enable = *at(device, RAYPATH_DEVICE_CONTROL) & 1;
  uint32_t *head = at(device, RAYPATH_DEVICE_RAY_HEAD), *tail = at(device, RAYPATH_DEVICE_HIT_TAIL);
  const uint32_t rays = *at(device, RAYPATH_DEVICE_RAY_TAIL) - *head,
                 hits = *tail - *at(device, RAYPATH_DEVICE_HIT_HEAD);
  const int rays_are_wrong = is_wrong(device, RAYPATH_DEVICE_RAY_SIZE, rays);
  const int hits_are_wrong = is_wrong(device, RAYPATH_DEVICE_HIT_SIZE, hits);
  void *from = rays_are_wrong ? NULL : place(device, RAYPATH_DEVICE_RAY_BASE, RAYPATH_DEVICE_RAY_SIZE, *head);
  void *to = hits_are_wrong ? NULL : place(device, RAYPATH_DEVICE_HIT_BASE, RAYPATH_DEVICE_HIT_SIZE, *tail);
  raypath_unit_outputs outputs;
  raypath_unit_inputs inputs = {.mem_req_ready = 1, .flush = (uint32_t)device->is_flushing};

  raypath_unit_model_outputs(device->unit, &outputs);
  if (enable && device->error == 0) {
    device->error = rays_are_wrong               ? RAYPATH_DEVICE_STATUS_ERROR_RAYS
                    : hits_are_wrong             ? RAYPATH_DEVICE_STATUS_ERROR_HITS
                    : from == NULL || to == NULL ? RAYPATH_DEVICE_STATUS_ERROR_REGION
                                                 : RAYPATH_DEVICE_STATUS_ERROR_NONE;
  }
  if (enable && device->error == 0 && !device->has_ray && !device->is_flushing && rays != 0) {
    memcpy(&device->ray, from, 64);
    device->has_ray = 1;
    ++*head;
  }
  while (device->is_used[device->next]) device->next = (device->next + 1) % (1u << device->values.id_width);
  if (device->has_ray && !device->is_flushing) {
    inputs.ray = unit_ray(&device->ray), inputs.ray_id = device->next, inputs.ray_valid = 1;
    if (outputs.ray_ready) {
      memcpy(device->ids[device->next], device->ray.id, 8);
      device->is_used[device->next] = 1;
      device->has_ray = 0, device->inside++;
    }
  }
  /* A hit waits for room; after an error of its ring it is dropped. */
  if (outputs.hit_valid && (to == NULL || device->is_flushing || hits < 1u << *at(device, RAYPATH_DEVICE_HIT_SIZE))) {
    const raypath_device_hit hit = device_hit(&outputs.hit, device->ids[outputs.hit_id]);
    inputs.hit_ready = 1;
    device->is_used[outputs.hit_id] = 0, device->inside--;
    if (to != NULL && !device->is_flushing) memcpy(to, &hit, 64), ++*tail;
  }
  const request *first = &device->queue[device->queue_head % SLOTS];
  const uint32_t bytes = device->values.memory_width / 8;
  static const uint8_t nothing[128];
  if (device->queue_head != device->queue_tail && first->due <= device->cycle) {
    const int exists = first->address >= pair(device, RAYPATH_DEVICE_SCENE_BASE) &&
                       first->address + device->values.block_bytes <= pair(device, RAYPATH_DEVICE_SCENE_END);
    inputs.mem_rsp_valid = 1, inputs.mem_rsp_tag = first->tag, inputs.mem_rsp_error = !exists;
    inputs.mem_rsp_data = exists ? device->memory + first->address + device->beat * bytes : nothing;
    device->beat = (device->beat + 1) % (device->values.block_bytes / bytes);
    device->queue_head += device->beat == 0;
  }
  if (outputs.mem_req_valid)
    device->queue[device->queue_tail++ % SLOTS] =
        (request){device->cycle + LATENCY, outputs.mem_req_addr, outputs.mem_req_tag};
  if (raypath_unit_model_step(device->unit, &inputs) != RAYPATH_OK) {
    fprintf(stderr, "model: %s\n", raypath_last_error());
    exit(1);
  }
  device->cycle++;
  raypath_unit_model_outputs(device->unit, &outputs);
  if (device->is_flushing && outputs.idle) {
    memset(device->is_used, 0, sizeof device->is_used);
    device->is_flushing = device->has_ray = 0, device->inside = 0;
  }
  if (!enable && is_idle(device)) *head = *tail = 0;
  const uint32_t unread = *tail - *at(device, RAYPATH_DEVICE_HIT_HEAD);
  const uint32_t levels = (enable && unread >= *at(device, RAYPATH_DEVICE_INTERRUPT_HITS)) | (device->error != 0) << 1 |
                          (enable && is_idle(device) && *head == *at(device, RAYPATH_DEVICE_RAY_TAIL)) << 2;
  *at(device, RAYPATH_DEVICE_INTERRUPT_STATUS) |= levels & ~device->before;
  device->before = levels;
}

static uint32_t model_read(void *context, uint32_t offset) {
  model *device = context;
  raypath_unit_counts counts;
  for (int k = 0; k < ACCESS; k++) step(device);
  raypath_unit_model_counts(device->unit, &counts);
  const uint64_t *count = (offset & ~7u) == RAYPATH_DEVICE_COUNT_CYCLES      ? &counts.cycles
                          : (offset & ~7u) == RAYPATH_DEVICE_COUNT_BOXES     ? &counts.boxes
                          : (offset & ~7u) == RAYPATH_DEVICE_COUNT_TRIANGLES ? &counts.triangles
                          : (offset & ~7u) == RAYPATH_DEVICE_COUNT_STEPS     ? &counts.steps
                          : (offset & ~7u) == RAYPATH_DEVICE_COUNT_FETCHES   ? &counts.fetches
                          : (offset & ~7u) == RAYPATH_DEVICE_COUNT_RAYS      ? &counts.rays
                                                                             : NULL;
  if (count != NULL) return (uint32_t)(*count >> (offset & 4 ? 32 : 0));
  if (offset != RAYPATH_DEVICE_STATUS) return *at(device, offset);
  return (uint32_t)is_idle(device) | (uint32_t)!is_idle(device) << 1 |
         device->error << RAYPATH_DEVICE_STATUS_ERROR_SHIFT;
}

static void model_write(void *context, uint32_t offset, uint32_t value) {
  model *device = context;
  for (int k = 0; k < ACCESS; k++) step(device);
  switch (offset) {
  case RAYPATH_DEVICE_CONTROL:
    *at(device, offset) = value & 1;
    if (value & RAYPATH_DEVICE_CONTROL_FLUSH_MASK) device->is_flushing = 1;
    if ((value & RAYPATH_DEVICE_CONTROL_CLEAR_ERROR_MASK) && !(value & 1)) device->error = 0;
    break;
  case RAYPATH_DEVICE_INTERRUPT_STATUS: *at(device, offset) &= ~value; break;
  case RAYPATH_DEVICE_ID:
  case RAYPATH_DEVICE_VERSION:
  case RAYPATH_DEVICE_CONFIG:
  case RAYPATH_DEVICE_MEMORY_BYTES:
  case RAYPATH_DEVICE_CACHE_BYTES:
  case RAYPATH_DEVICE_STATUS:
  case RAYPATH_DEVICE_RAY_HEAD:
  case RAYPATH_DEVICE_HIT_TAIL: break;
  default: *at(device, offset) = value;
  }
}

static void model_open(model *device, const raypath_unit *unit, uint8_t *memory, size_t size) {
  memset(device, 0, sizeof *device);
  device->memory = memory, device->size = size;
  if (raypath_unit_parameters(unit, &device->values) != RAYPATH_OK ||
      raypath_unit_model_new(unit, &device->unit) != RAYPATH_OK) {
    fprintf(stderr, "model: %s\n", raypath_last_error());
    exit(1);
  }
  *at(device, RAYPATH_DEVICE_ID) = RAYPATH_DEVICE_ID_VALUE_IS;
  *at(device, RAYPATH_DEVICE_VERSION) = RAYPATH_DEVICE_VERSION_MAJOR_IS << RAYPATH_DEVICE_VERSION_MAJOR_SHIFT;
  *at(device, RAYPATH_DEVICE_CONFIG) = 1u | device->values.contexts << RAYPATH_DEVICE_CONFIG_CONTEXTS_SHIFT |
                                       (device->values.address_width - 32) << RAYPATH_DEVICE_CONFIG_ADDRESS_BITS_SHIFT;
  *at(device, RAYPATH_DEVICE_MEMORY_BYTES) = device->values.memory_width / 8;
  *at(device, RAYPATH_DEVICE_INTERRUPT_HITS) = 1;
}

/* ---- The test ---------------------------------------------------------------------------------------------------- */

#define TRIANGLES 2000
#define RAYS 3000

static float number(void) { return (float)rand() / (float)RAND_MAX * 2 - 1; }

static void require(int good, const char *what) {
  if (good) return;
  fprintf(stderr, "model: %s: %s\n", what, raypath_last_error() == NULL ? "" : raypath_last_error());
  exit(1);
}

static void expect(raypath_driver_result result, raypath_driver_result expected, const char *what) {
  if (result == expected) return;
  fprintf(stderr, "model: %s: found '%s', expected '%s'\n", what, raypath_driver_text(result),
          raypath_driver_text(expected));
  exit(1);
}

/* Traces all rays through the driver, and compares each hit with that of the functional model. */
static uint32_t trace(raypath_driver *driver, const raypath_driver_setup *setup, const raypath_device_ray *rays,
                      const raypath_unit_hit *expected) {
  static uint8_t is_taken[RAYS];
  uint32_t sent = 0, taken = 0, hit_count = 0, idle = 0;
  memset(is_taken, 0, sizeof is_taken);
  expect(raypath_driver_configure(driver, setup), RAYPATH_DRIVER_OK, "configure");
  expect(raypath_driver_start(driver), RAYPATH_DRIVER_OK, "start");
  while (taken < RAYS) {
    raypath_device_hit hits[16];
    sent += raypath_driver_submit(driver, rays + sent, RAYS - sent);
    const uint32_t count = raypath_driver_take(driver, hits, 16);
    for (uint32_t k = 0; k < count; k++) {
      const uint32_t id = hits[k].id[0];
      require(id < RAYS && hits[k].id[1] == 7 && !is_taken[id], "a hit of another ray");
      const raypath_device_hit right = device_hit(&expected[id], hits[k].id);
      require(memcmp(&right, &hits[k], sizeof right) == 0, "a hit differs from the functional model");
      is_taken[id] = 1;
      hit_count += (hits[k].status & 0xff) == RAYPATH_UNIT_HIT;
    }
    taken += count;
    idle = count == 0 ? idle + 1 : 0;
    require(idle < 100000, "hits are missing");
  }
  expect(raypath_driver_stop(driver), RAYPATH_DRIVER_OK, "stop");
  expect(raypath_driver_error(driver), RAYPATH_DRIVER_OK, "error");
  return hit_count;
}

int main(void) {
  static float vertices[3 * TRIANGLES][3];
  static uint32_t indices[TRIANGLES][3];
  static raypath_device_ray rays[RAYS];
  static raypath_unit_ray unit_rays[RAYS];
  static raypath_unit_hit expected[RAYS];
  static model device;
  raypath_unit *unit = NULL;
  raypath_scene *scene = NULL;
  raypath_driver driver;

  for (int k = 0; k < TRIANGLES; k++) {
    const float at_x = number(), at_y = number(), at_z = number();
    for (int v = 0; v < 3; v++) {
      indices[k][v] = (uint32_t)(3 * k + v);
      vertices[3 * k + v][0] = at_x + number() / 10;
      vertices[3 * k + v][1] = at_y + number() / 10;
      vertices[3 * k + v][2] = at_z + number() / 10;
    }
  }
  require(raypath_unit_open("contexts = 16", &unit) == RAYPATH_OK, "unit");
  require(raypath_scene_build(unit, (const float(*)[3])vertices, 3 * TRIANGLES, (const uint32_t(*)[3])indices, TRIANGLES,
                              NULL, 0, NULL, 0, NULL, 0, 0, &scene) == RAYPATH_OK,
          "scene");
  for (uint32_t k = 0; k < RAYS; k++) {
    rays[k] = (raypath_device_ray){.id = {k, 7}, .cull_mask = 255, .root = raypath_scene_root(scene), .t_max = 100};
    for (int axis = 0; axis < 3; axis++) rays[k].origin[axis] = 2 * number(), rays[k].direction[axis] = number();
    unit_rays[k] = unit_ray(&rays[k]);
  }

  /* The scene from 0 on, then both rings. */
  const size_t scene_size = raypath_scene_size(scene), end = (scene_size + 63) / 64 * 64;
  const uint32_t ray_size = 5, hit_size = 3;
  const size_t size = end + (64u << ray_size) + (64u << hit_size);
  uint8_t *memory = calloc(size, 1);
  require(memory != NULL, "memory");
  memcpy(memory, raypath_scene_data(scene), scene_size);
  model_open(&device, unit, memory, size);
  expect(raypath_driver_open(&driver, model_read, model_write, &device), RAYPATH_DRIVER_OK, "open");
  raypath_driver_setup setup = {.scene_end = end,
                                .node_limit = 1u << 24,
                                .rays = {memory + end, end, ray_size},
                                .hits = {memory + end + (64u << ray_size), end + (64u << ray_size), hit_size}};

  require(raypath_unit_trace(unit, raypath_scene_data(scene), scene_size, unit_rays, RAYS, expected) == RAYPATH_OK,
          "trace");
  const uint32_t found = trace(&driver, &setup, rays, expected);
  require(found > RAYS / 10 && found < RAYS, "the scene is hit by few rays, or by all");
  const uint64_t counted = raypath_driver_count(&driver, RAYPATH_DEVICE_COUNT_RAYS);
  require(counted == RAYS, "the counter of rays");

  /* Of a scene that ends early, rays end with an error of the memory. */
  setup.scene_end = end / 2 / 128 * 128;
  require(raypath_unit_trace(unit, raypath_scene_data(scene), setup.scene_end, unit_rays, RAYS, expected) == RAYPATH_OK,
          "trace");
  trace(&driver, &setup, rays, expected);

  /* A wrong index is an error; after an abort, the device works again. */
  setup.scene_end = end;
  expect(raypath_driver_start(&driver), RAYPATH_DRIVER_OK, "start");
  raypath_driver_submit(&driver, rays, 20);
  model_write(&device, RAYPATH_DEVICE_RAY_TAIL, 1000);
  expect(raypath_driver_error(&driver), RAYPATH_DRIVER_RAYS, "error");
  expect(raypath_driver_start(&driver), RAYPATH_DRIVER_RAYS, "start after an error");
  expect(raypath_driver_abort(&driver, 1000), RAYPATH_DRIVER_OK, "abort");
  require(raypath_unit_trace(unit, raypath_scene_data(scene), scene_size, unit_rays, RAYS, expected) == RAYPATH_OK,
          "trace");
  trace(&driver, &setup, rays, expected);

  printf("model: %u rays, %u hit, 3 times through the driver, %lu cycles: equal to libraypath's\n", RAYS, found,
         (unsigned long)device.cycle);
  raypath_unit_model_free(device.unit);
  raypath_scene_free(scene);
  raypath_unit_close(unit);
  free(memory);
  return 0;
}
