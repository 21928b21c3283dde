/* SPDX-License-Identifier: MIT OR Apache-2.0
 * The functions of raypath_agent_pkg.sv: the functional model of a traversal unit, and the memory with its scene. */

#include <raypath.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <svdpi.h>

_Static_assert(sizeof(raypath_unit_ray) == 48 && sizeof(raypath_unit_hit) == 56, "the package has these sizes");

static raypath_unit *unit;
static raypath_unit_parameter_values values;
static unsigned char *scene;
static size_t scene_size;

/* The bytes of a file and a 0; NULL with a message if it cannot be read. */
static unsigned char *contents(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  if (file != NULL && fseek(file, 0, SEEK_END) == 0) {
    *size = (size_t)ftell(file);
    unsigned char *bytes = calloc(*size + 1, 1);
    rewind(file);
    if (bytes != NULL && fread(bytes, 1, *size, file) == *size) return fclose(file), bytes;
  }
  return perror(path), NULL;
}

int raypath_agent_open(const char *configuration, const char *scene_path, int missing) {
  size_t size;
  const unsigned char *toml = contents(configuration, &size);
  scene = contents(scene_path, &scene_size);
  if (toml == NULL || scene == NULL) return 0;
  scene_size -= (size_t)missing < scene_size ? (size_t)missing : scene_size;
  if (raypath_unit_open((const char *)toml, &unit) == RAYPATH_OK &&
      raypath_unit_parameters(unit, &values) == RAYPATH_OK)
    return (int)values.block_bytes;
  fprintf(stderr, "%s: %s\n", configuration, raypath_last_error());
  return 0;
}

int raypath_agent_read(const char *path, svBitVecVal *words) {
  static FILE *file;
  char line[512];
  if (file == NULL && (file = fopen(path, "r")) == NULL) perror(path);
  while (file != NULL && fgets(line, sizeof line, file) != NULL) {
    raypath_unit_ray ray = {.cull_mask = 255};
    float *o = ray.origin, *d = ray.direction;
    if (line[0] == '#') continue;
    if (sscanf(line, "%f%f%f%f%f%f%f", o, o + 1, o + 2, d, d + 1, d + 2, &ray.t_max) != 7) {
      fprintf(stderr, "%s: found '%s', expected 7 numbers\n", path, line);
      exit(1);
    }
    memcpy(words, &ray, sizeof ray);
    return 1;
  }
  return 0;
}

void raypath_agent_trace(const svBitVecVal *words, svBitVecVal *hit_words) {
  raypath_unit_ray ray;
  raypath_unit_hit hit;
  memcpy(&ray, words, sizeof ray);
  if (raypath_unit_trace(unit, scene, scene_size, &ray, 1, &hit) != RAYPATH_OK) {
    fprintf(stderr, "raypath_agent: %s\n", raypath_last_error());
    exit(1);
  }
  if (!values.instances) hit.instance = 0; /* The unit has no such port. */
  memcpy(hit_words, &hit, sizeof hit);
}

int raypath_agent_block(long long address, svBitVecVal *data) {
  if ((unsigned long long)address >= scene_size || scene_size - (size_t)address < values.block_bytes) return 0;
  memset(data, 0, 128);
  memcpy(data, scene + address, values.block_bytes);
  return 1;
}
