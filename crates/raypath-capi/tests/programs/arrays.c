/* Arrays of jobs against double precision, in every number of lanes that a block can be filled to. */

#include <raypath.h>

#include "check.h"

#include <math.h>

enum { MOST = 133 };

/* The slab test in double precision: the entry distance, or infinity for a miss. `margin` is the least distance between
   two values that the test compares, relative to them. */
static double slab_test(const raypath_ray *ray, const raypath_box *box, double *margin) {
  double enter = 0.0, leave = ray->extent;
  for (int axis = 0; axis < 3; axis++) {
    const double origin = ray->origin[axis], direction = ray->direction[axis];
    const double a = (box->min[axis] - origin) / direction, b = (box->max[axis] - origin) / direction;
    enter = fmax(enter, fmin(a, b));
    leave = fmin(leave, fmax(a, b));
  }
  *margin = fabs(enter - leave) / fmax(1.0, fabs(leave));
  return enter <= leave ? enter : INFINITY;
}

static void quadboxes(const raypath_datapath *datapath) {
  static raypath_ray rays[MOST];
  static raypath_box boxes[4 * MOST];
  static raypath_quadbox_result results[MOST + 1];
  uint32_t random = 1;
  int hits = 0, misses = 0;
  for (size_t i = 0; i < MOST; i++) {
    float origin[3], direction[3];
    for (int axis = 0; axis < 3; axis++) {
      origin[axis] = 3.0f * next_random(&random);
      direction[axis] = 0.3f * next_random(&random) - origin[axis];
    }
    CHECK(raypath_ray_init(&rays[i], origin, direction, INFINITY) == RAYPATH_OK);
    for (int k = 0; k < 4; k++) {
      for (int axis = 0; axis < 3; axis++) {
        const float a = next_random(&random), b = next_random(&random);
        boxes[4 * i + (size_t)k].min[axis] = fminf(a, b);
        boxes[4 * i + (size_t)k].max[axis] = fmaxf(a, b);
      }
    }
  }
  for (size_t count = 0; count <= MOST; count += count < 70 ? 1 : 21) {
    memset(results, 0xee, sizeof results);
    CHECK(raypath_quadbox(datapath, rays, boxes, count, results) == RAYPATH_OK);
    CHECK(results[count].box_index[0] == 0xee); /* nothing beyond the array is written */
    for (size_t i = 0; i < count; i++) {
      unsigned seen = 0;
      for (int k = 0; k < 4; k++) {
        const raypath_quadbox_result *found = &results[i];
        double margin;
        const double expected = slab_test(&rays[i], &boxes[4 * i + found->box_index[k]], &margin);
        seen |= 1u << found->box_index[k];
        CHECK(k == 0 || found->tmin[k - 1] <= found->tmin[k]);
        if (margin < 1e-5) continue;
        CHECK(found->is_intersect[k] == (expected < INFINITY));
        CHECK(found->is_intersect[k] ? fabs(found->tmin[k] - expected) <= 1e-5 * (1.0 + expected)
                                     : isinf(found->tmin[k]));
        *(found->is_intersect[k] ? &hits : &misses) += 1;
      }
      CHECK(seen == 15);
    }
  }
  CHECK(hits > 1000 && misses > 1000);
}

static void triangles(const raypath_datapath *datapath, uint32_t random, int *hits, int *misses) {
  static raypath_ray rays[MOST];
  static raypath_vertices vertices[MOST];
  static raypath_triangle_result results[MOST];
  for (size_t i = 0; i < MOST; i++) {
    float origin[3] = {next_random(&random), next_random(&random), -4.0f};
    float direction[3] = {0.2f * next_random(&random), 0.2f * next_random(&random), 1.0f};
    CHECK(raypath_ray_init(&rays[i], origin, direction, INFINITY) == RAYPATH_OK);
    for (int axis = 0; axis < 3; axis++) {
      vertices[i].a[axis] = 2.0f * next_random(&random);
      vertices[i].b[axis] = 2.0f * next_random(&random);
      vertices[i].c[axis] = 2.0f * next_random(&random);
    }
  }
  CHECK(raypath_triangle(datapath, rays, vertices, MOST, results) == RAYPATH_OK);
  for (size_t i = 0; i < MOST; i++) {
    /* Cramer's rule: origin + t direction = a + u (b - a) + v (c - a). */
    double e1[3], e2[3], s[3], p[3], q[3];
    for (int k = 0; k < 3; k++) {
      e1[k] = (double)vertices[i].b[k] - vertices[i].a[k];
      e2[k] = (double)vertices[i].c[k] - vertices[i].a[k];
      s[k] = (double)rays[i].origin[k] - vertices[i].a[k];
    }
    const float *d = rays[i].direction;
    for (int k = 0; k < 3; k++) {
      const int x = (k + 1) % 3, y = (k + 2) % 3;
      p[k] = d[x] * e2[y] - d[y] * e2[x];
      q[k] = s[x] * e1[y] - s[y] * e1[x];
    }
    double determinant = 0.0, u = 0.0, v = 0.0, t = 0.0;
    for (int k = 0; k < 3; k++) {
      determinant += e1[k] * p[k];
      u += s[k] * p[k];
      v += d[k] * q[k];
      t += e2[k] * q[k];
    }
    u /= determinant, v /= determinant, t /= determinant;
    if (fabs(determinant) < 1e-2 || fabs(u) < 1e-3 || fabs(v) < 1e-3 || fabs(1.0 - u - v) < 1e-3) continue;
    /* Vertices are counter-clockwise as seen from the front. */
    const int expected = u > 0.0 && v > 0.0 && u + v < 1.0 && t > 0.0 && determinant > 0.0;
    CHECK(results[i].triangle_hit == (uint32_t)expected);
    CHECK(!expected || fabs(results[i].t_num / results[i].t_denom - t) < 1e-3 * t);
    *(expected ? hits : misses) += 1;
  }
}

static void distances(const raypath_datapath *datapath) {
  static float a[MOST * 100], b[MOST * 100], found[MOST], dots[MOST], norms[MOST];
  uint32_t random = 3;
  for (size_t i = 0; i < sizeof a / sizeof *a; i++) a[i] = next_random(&random), b[i] = next_random(&random);
  for (size_t dimensions = 1; dimensions <= 100; dimensions += dimensions < 20 ? 1 : 16) {
    for (size_t count = 0; count <= MOST; count += 19) {
      CHECK(raypath_euclidean(datapath, a, b, dimensions, count, found) == RAYPATH_OK);
      CHECK(raypath_angular(datapath, a, b, dimensions, count, dots, norms) == RAYPATH_OK);
      for (size_t i = 0; i < count; i++) {
        double sum = 0.0, dot = 0.0, magnitude = 0.0, norm = 0.0;
        for (size_t k = 0; k < dimensions; k++) {
          const double x = a[i * dimensions + k], y = b[i * dimensions + k];
          sum += (x - y) * (x - y);
          dot += x * y;
          magnitude += fabs(x * y);
          norm += y * y;
        }
        /* Each value passes through at most as many roundings as there are dimensions, and four more. */
        const double error = (double)(dimensions + 4) * ldexp(1.0, -24);
        CHECK(fabs(found[i] - sum) <= error * sum);
        CHECK(fabs(dots[i] - dot) <= error * magnitude);
        CHECK(fabs(norms[i] - norm) <= error * norm);
      }
    }
  }
}

/* Words at the ports give the values of the typed arrays. */
static void words(const raypath_datapath *datapath) {
  raypath_operation_info quadbox = {0};
  size_t operation = 0;
  while (quadbox.name == NULL || strcmp(quadbox.name, "quadbox") != 0)
    CHECK(raypath_operation(datapath, operation++, &quadbox) == RAYPATH_OK);
  operation -= 1;
  CHECK(quadbox.initiation_interval == 1 && quadbox.inputs >= 40);

  raypath_ray ray;
  const float origin[3] = {0.25f, -0.5f, -5.0f}, direction[3] = {0.1f, 0.2f, 1.0f};
  CHECK(raypath_ray_init(&ray, origin, direction, 100.0f) == RAYPATH_OK);
  raypath_box boxes[4];
  for (int k = 0; k < 4; k++) {
    const float at = (float)(3 - k);
    boxes[k] = (raypath_box){{-1.0f, -1.0f, at}, {1.0f, 1.0f, at + 0.5f}};
  }
  raypath_quadbox_result typed;
  CHECK(raypath_quadbox(datapath, &ray, boxes, 1, &typed) == RAYPATH_OK);
  CHECK(typed.box_index[0] == 3 && typed.is_intersect[0] == 1);

  static const char *const axes[3] = {"x", "y", "z"};
  uint64_t inputs[64] = {0}, outputs[64] = {0};
  for (size_t i = 0; i < quadbox.inputs; i++) {
    raypath_port port;
    char name[64];
    CHECK(raypath_input(datapath, operation, i, &port) == RAYPATH_OK);
    const float *numbers[4] = {ray.origin, ray.direction, ray.inverse, ray.shear};
    static const char *const fields[4] = {"origin", "dir", "inv", "shear"};
    for (int axis = 0; axis < 3; axis++) {
      for (int field = 0; field < 4; field++) {
        uint32_t bits;
        memcpy(&bits, &numbers[field][axis], sizeof bits);
        snprintf(name, sizeof name, "ray_%s_%s", fields[field], axes[axis]);
        if (strcmp(port.name, name) == 0) inputs[i] = bits;
      }
      for (int k = 0; k < 8; k++) {
        uint32_t bits;
        memcpy(&bits, k % 2 ? &boxes[k / 2].max[axis] : &boxes[k / 2].min[axis], sizeof bits);
        snprintf(name, sizeof name, "aabb_%d_%s_%s", k / 2, axes[axis], k % 2 ? "max" : "min");
        if (strcmp(port.name, name) == 0) inputs[i] = bits;
      }
    }
    uint32_t extent;
    memcpy(&extent, &ray.extent, sizeof extent);
    if (strcmp(port.name, "ray_extent") == 0) inputs[i] = extent;
    if (strcmp(port.name, "ray_kx") == 0) inputs[i] = ray.kx;
    if (strcmp(port.name, "ray_ky") == 0) inputs[i] = ray.ky;
    if (strcmp(port.name, "ray_kz") == 0) inputs[i] = ray.kz;
  }
  CHECK(raypath_run(datapath, "quadbox", inputs, 1, outputs) == RAYPATH_OK);
  for (size_t i = 0; i < quadbox.outputs; i++) {
    raypath_port port;
    char name[64];
    CHECK(raypath_output(datapath, operation, i, &port) == RAYPATH_OK);
    if (strcmp(port.name, "is_intersect") == 0) {
      CHECK(port.kind == RAYPATH_PORT_FLAGS && port.width == 4);
      for (int k = 0; k < 4; k++) CHECK((outputs[i] >> k & 1) == typed.is_intersect[k]);
    }
    for (int k = 0; k < 4; k++) {
      uint32_t bits;
      memcpy(&bits, &typed.tmin[k], sizeof bits);
      snprintf(name, sizeof name, "tmin_%d", k);
      if (strcmp(port.name, name) == 0) CHECK(port.kind == RAYPATH_PORT_NUMBER && outputs[i] == bits);
      snprintf(name, sizeof name, "box_index_%d", k);
      if (strcmp(port.name, name) == 0) CHECK(port.kind == RAYPATH_PORT_WORD && outputs[i] == typed.box_index[k]);
    }
  }
}

int main(void) {
  static const char *const configurations[] = {
      NULL, "preset = \"search\"", "lanes = 2", "lanes = 4", "lanes = 8", "lanes = 32", "tag = 4"};
  for (size_t i = 0; i < sizeof configurations / sizeof *configurations; i++) {
    raypath_datapath *datapath = NULL;
    CHECK(raypath_open(configurations[i], &datapath) == RAYPATH_OK);
    quadboxes(datapath);
    int hits = 0, misses = 0;
    for (uint32_t seed = 1; seed <= 40; seed++) triangles(datapath, 1000003u * seed, &hits, &misses);
    CHECK(hits > 100 && misses > 1000);
    distances(datapath);
    words(datapath);
    raypath_close(datapath);
  }
  return 0;
}
