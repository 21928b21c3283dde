/* SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * A driver of raypath_device in C99: no allocation, no state of its own, no operating system. The caller gives access
 * to the registers, the memory of the rings, and calls from one thread at a time. The host is little endian.
 *
 *   raypath_driver device;
 *   raypath_driver_open(&device, raypath_driver_mmio_read, raypath_driver_mmio_write, registers);
 *   raypath_driver_configure(&device, &setup);
 *   raypath_driver_start(&device);
 *   sent += raypath_driver_submit(&device, rays + sent, count - sent);
 *   taken += raypath_driver_take(&device, hits + taken, count - taken);
 *   raypath_driver_stop(&device);
 */

#ifndef RAYPATH_DRIVER_H
#define RAYPATH_DRIVER_H

#include <stdint.h>

#include "raypath_device_registers.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Accesses to memory before it are done before accesses to memory and registers after it. */
#ifndef RAYPATH_DRIVER_BARRIER
#define RAYPATH_DRIVER_BARRIER() __atomic_thread_fence(__ATOMIC_SEQ_CST)
#endif

/* For a memory that is not coherent with the caches of the host: writes them back, or drops what they hold. */
#ifndef RAYPATH_DRIVER_CLEAN
#define RAYPATH_DRIVER_CLEAN(address, bytes) ((void)(address), (void)(bytes))
#endif
#ifndef RAYPATH_DRIVER_DISCARD
#define RAYPATH_DRIVER_DISCARD(address, bytes) ((void)(address), (void)(bytes))
#endif

/* A result of the driver. Values from 1 to 7 are the error codes of the device (RAYPATH_DEVICE_STATUS_ERROR_...). */
typedef enum {
  RAYPATH_DRIVER_OK = 0,
  RAYPATH_DRIVER_RAYS = RAYPATH_DEVICE_STATUS_ERROR_RAYS,
  RAYPATH_DRIVER_HITS = RAYPATH_DEVICE_STATUS_ERROR_HITS,
  RAYPATH_DRIVER_REGION = RAYPATH_DEVICE_STATUS_ERROR_REGION,
  RAYPATH_DRIVER_READ = RAYPATH_DEVICE_STATUS_ERROR_READ,
  RAYPATH_DRIVER_WRITE = RAYPATH_DEVICE_STATUS_ERROR_WRITE,
  RAYPATH_DRIVER_TIMEOUT = RAYPATH_DEVICE_STATUS_ERROR_TIMEOUT,
  RAYPATH_DRIVER_RING_TIMEOUT = RAYPATH_DEVICE_STATUS_ERROR_RING_TIMEOUT,
  RAYPATH_DRIVER_NO_DEVICE = 16,
  RAYPATH_DRIVER_VERSION,
  RAYPATH_DRIVER_BUSY,
  RAYPATH_DRIVER_ALIGNMENT,
  RAYPATH_DRIVER_SIZE,
  RAYPATH_DRIVER_ADDRESS
} raypath_driver_result;

/* A ray in memory, 64 bytes. Members of features that the device does not have are ignored. */
typedef struct {
  uint32_t id[2]; /* The hit has the same. */
  uint32_t flags;
  uint32_t cull_mask;
  uint32_t root;
  uint32_t base;
  float t_min;
  float t_max;
  float origin[3];
  uint32_t reserved_0;
  float direction[3];
  uint32_t reserved_1;
} raypath_device_ray;

/* A hit in memory, 64 bytes. Members of features that the device does not have are 0. */
typedef struct {
  uint32_t id[2];
  uint32_t status; /* 7:0 as RAYPATH_UNIT_... of raypath.h, 8: a back face. */
  uint32_t primitive;
  float t;
  float t_num;
  float t_denom;
  uint32_t geometry;
  uint32_t nodes;
  uint32_t triangles;
  uint32_t instance;
  uint32_t custom_index;
  uint32_t shader_offset;
  float u; /* Barycentric coordinates. */
  float v;
  uint32_t reserved;
} raypath_device_hit;

/* A ring: its memory as the host and as the device address it, of 64 << size bytes, aligned to 64. */
typedef struct {
  void *records;
  uint64_t address;
  uint32_t size; /* The logarithm to base 2 of its records: 0 to 20. */
} raypath_driver_ring;

typedef struct {
  uint64_t scene_base; /* The first byte of the scene, aligned to 64. */
  uint64_t scene_end;  /* The first byte after it, aligned to 64. */
  uint32_t node_limit; /* Nodes that a ray may read. */
  uint32_t timeout;    /* Cycles that the memory may owe a beat or an answer; 0: any number. */
  raypath_driver_ring rays;
  raypath_driver_ring hits;
} raypath_driver_setup;

typedef uint32_t (*raypath_driver_read)(void *context, uint32_t offset);
typedef void (*raypath_driver_write)(void *context, uint32_t offset, uint32_t value);

/* A device. The members are the driver's. */
typedef struct {
  raypath_driver_read read;
  raypath_driver_write write;
  void *context;
  raypath_driver_ring rays;
  raypath_driver_ring hits;
  uint32_t ray_tail;
  uint32_t hit_head;
} raypath_driver;

/* Access to registers in the address space of the host; `registers` is the first one. */
uint32_t raypath_driver_mmio_read(void *registers, uint32_t offset);
void raypath_driver_mmio_write(void *registers, uint32_t offset, uint32_t value);

/* Finds the device: NO_DEVICE or VERSION if there is none that this driver knows. Changes nothing in it. */
raypath_driver_result raypath_driver_open(raypath_driver *device, raypath_driver_read read, raypath_driver_write write,
                                          void *context);

/* A field of the register `config`, by its mask: RAYPATH_DEVICE_CONFIG_..._MASK. */
uint32_t raypath_driver_config(const raypath_driver *device, uint32_t mask);

/* Sets the regions. BUSY unless the device is stopped; ALIGNMENT, SIZE or ADDRESS for a region that it cannot have. */
raypath_driver_result raypath_driver_configure(raypath_driver *device, const raypath_driver_setup *setup);

/* Enables the device with empty rings. BUSY unless it is stopped, or the error that was not cleared. */
raypath_driver_result raypath_driver_start(raypath_driver *device);

/* Writes up to `count` rays to the ring, and returns how many. Fewer: the ring is full. */
uint32_t raypath_driver_submit(raypath_driver *device, const raypath_device_ray *rays, uint32_t count);

/* Takes up to `count` hits from the ring, in any order of their rays, and returns how many. */
uint32_t raypath_driver_take(raypath_driver *device, raypath_device_hit *hits, uint32_t count);

/* The error of the device, or OK. */
raypath_driver_result raypath_driver_error(const raypath_driver *device);

/* Whether all submitted rays have their hits in memory, or were dropped. */
int raypath_driver_is_drained(const raypath_driver *device);

/* Disables a device that is drained, after the last hit was taken; else BUSY, and it goes on. */
raypath_driver_result raypath_driver_stop(raypath_driver *device);

/* Disables the device, drops its rays, and clears its error. Hits that were not taken are lost. BUSY: it was not idle
 * after `polls` reads of its status; call again. It stays BUSY while the memory owes something, or until a reset. */
raypath_driver_result raypath_driver_abort(raypath_driver *device, uint32_t polls);

/* Drops the rays inside the device; it goes on with the next ones. */
void raypath_driver_flush(raypath_driver *device);

/* Empties the caches, after the scene was changed. */
void raypath_driver_invalidate(raypath_driver *device);

/* Enables the interrupts of RAYPATH_DEVICE_INTERRUPT_STATUS_..._MASK; that of hits comes with `hits` in the ring. */
void raypath_driver_set_interrupts(raypath_driver *device, uint32_t mask, uint32_t hits);

/* Clears the interrupts, and returns which there were. Take hits after it until there is none: the next one interrupts
 * again. */
uint32_t raypath_driver_acknowledge(raypath_driver *device);

/* A counter RAYPATH_DEVICE_COUNT_..., also while it counts. */
uint64_t raypath_driver_count(const raypath_driver *device, uint32_t counter);

/* Sets all counters to 0. */
void raypath_driver_clear_counts(raypath_driver *device);

/* What a result means, in English. */
const char *raypath_driver_text(raypath_driver_result result);

#ifdef __cplusplus
}
#endif

#endif
