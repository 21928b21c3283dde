/* SPDX-License-Identifier: MIT OR Apache-2.0 */

#include "raypath_driver.h"

#include <string.h>

#define RECORD_BYTES 64u
#define MAX_SIZE 20u
#define ENABLE RAYPATH_DEVICE_CONTROL_ENABLE_MASK

typedef char ray_has_the_size_of_a_record[sizeof(raypath_device_ray) == RECORD_BYTES ? 1 : -1];
typedef char hit_has_the_size_of_a_record[sizeof(raypath_device_hit) == RECORD_BYTES ? 1 : -1];

static uint32_t get(const raypath_driver *device, uint32_t offset) { return device->read(device->context, offset); }

static void set(const raypath_driver *device, uint32_t offset, uint32_t value) {
  device->write(device->context, offset, value);
}

static void set_64(const raypath_driver *device, uint32_t offset, uint64_t value) {
  set(device, offset, (uint32_t)value);
  set(device, offset + 4, (uint32_t)(value >> 32));
}

static int is_idle(const raypath_driver *device) {
  return (get(device, RAYPATH_DEVICE_STATUS) & RAYPATH_DEVICE_STATUS_IDLE_MASK) != 0;
}

static int is_stopped(const raypath_driver *device) {
  return (get(device, RAYPATH_DEVICE_CONTROL) & ENABLE) == 0 && is_idle(device);
}

static void *record(const raypath_driver_ring *ring, uint32_t index) {
  return (char *)ring->records + (size_t)RECORD_BYTES * (index & ((1u << ring->size) - 1));
}

uint32_t raypath_driver_mmio_read(void *registers, uint32_t offset) {
  return ((const volatile uint32_t *)registers)[offset / 4];
}

void raypath_driver_mmio_write(void *registers, uint32_t offset, uint32_t value) {
  ((volatile uint32_t *)registers)[offset / 4] = value;
}

raypath_driver_result raypath_driver_open(raypath_driver *device, raypath_driver_read read, raypath_driver_write write,
                                          void *context) {
  memset(device, 0, sizeof *device);
  device->read = read;
  device->write = write;
  device->context = context;
  if (get(device, RAYPATH_DEVICE_ID) != RAYPATH_DEVICE_ID_VALUE_IS) return RAYPATH_DRIVER_NO_DEVICE;
  if (get(device, RAYPATH_DEVICE_VERSION) >> RAYPATH_DEVICE_VERSION_MAJOR_SHIFT != RAYPATH_DEVICE_VERSION_MAJOR_IS)
    return RAYPATH_DRIVER_VERSION;
  return RAYPATH_DRIVER_OK;
}

uint32_t raypath_driver_config(const raypath_driver *device, uint32_t mask) {
  return (get(device, RAYPATH_DEVICE_CONFIG) & mask) / (mask & (0u - mask));
}

/* Whether the bytes from `base` to `end` are addresses of the memory. */
static raypath_driver_result check_region(const raypath_driver *device, uint64_t base, uint64_t end) {
  const uint32_t bits = 32 + raypath_driver_config(device, RAYPATH_DEVICE_CONFIG_ADDRESS_BITS_MASK);
  const uint64_t last = end - 1; /* The end of the highest region is 2^bits, which is 0 with 64 bits. */
  if ((base | end) % 64 != 0) return RAYPATH_DRIVER_ALIGNMENT;
  if (end == base) return RAYPATH_DRIVER_OK;
  return last < base || (bits < 64 && last >> bits != 0) ? RAYPATH_DRIVER_ADDRESS : RAYPATH_DRIVER_OK;
}

static raypath_driver_result check_ring(const raypath_driver *device, const raypath_driver_ring *ring) {
  if (ring->size > MAX_SIZE) return RAYPATH_DRIVER_SIZE;
  return check_region(device, ring->address, ring->address + ((uint64_t)RECORD_BYTES << ring->size));
}

raypath_driver_result raypath_driver_configure(raypath_driver *device, const raypath_driver_setup *setup) {
  raypath_driver_result result = check_region(device, setup->scene_base, setup->scene_end);
  if (result == RAYPATH_DRIVER_OK) result = check_ring(device, &setup->rays);
  if (result == RAYPATH_DRIVER_OK) result = check_ring(device, &setup->hits);
  if (result == RAYPATH_DRIVER_OK && !is_stopped(device)) result = RAYPATH_DRIVER_BUSY;
  if (result != RAYPATH_DRIVER_OK) return result;
  device->rays = setup->rays;
  device->hits = setup->hits;
  set(device, RAYPATH_DEVICE_NODE_LIMIT, setup->node_limit);
  set(device, RAYPATH_DEVICE_TIMEOUT, setup->timeout);
  set_64(device, RAYPATH_DEVICE_SCENE_BASE, setup->scene_base);
  set_64(device, RAYPATH_DEVICE_SCENE_END, setup->scene_end);
  set_64(device, RAYPATH_DEVICE_RAY_BASE, setup->rays.address);
  set(device, RAYPATH_DEVICE_RAY_SIZE, setup->rays.size);
  set_64(device, RAYPATH_DEVICE_HIT_BASE, setup->hits.address);
  set(device, RAYPATH_DEVICE_HIT_SIZE, setup->hits.size);
  return RAYPATH_DRIVER_OK;
}

raypath_driver_result raypath_driver_start(raypath_driver *device) {
  const raypath_driver_result error = raypath_driver_error(device);
  if (error != RAYPATH_DRIVER_OK) return error;
  if (!is_stopped(device)) return RAYPATH_DRIVER_BUSY;
  device->ray_tail = get(device, RAYPATH_DEVICE_RAY_HEAD);
  device->hit_head = get(device, RAYPATH_DEVICE_HIT_TAIL);
  set(device, RAYPATH_DEVICE_RAY_TAIL, device->ray_tail);
  set(device, RAYPATH_DEVICE_HIT_HEAD, device->hit_head);
  set(device, RAYPATH_DEVICE_CONTROL, ENABLE);
  return RAYPATH_DRIVER_OK;
}

uint32_t raypath_driver_submit(raypath_driver *device, const raypath_device_ray *rays, uint32_t count) {
  const uint32_t places = 1u << device->rays.size;
  const uint32_t used = device->ray_tail - get(device, RAYPATH_DEVICE_RAY_HEAD);
  const uint32_t room = used <= places ? places - used : 0;
  uint32_t k;
  if (count > room) count = room;
  if (count == 0) return 0;
  /* The device has read the records that are overwritten. */
  RAYPATH_DRIVER_BARRIER();
  for (k = 0; k < count; k++) {
    void *place = record(&device->rays, device->ray_tail + k);
    memcpy(place, &rays[k], RECORD_BYTES);
    RAYPATH_DRIVER_CLEAN(place, RECORD_BYTES);
  }
  device->ray_tail += count;
  RAYPATH_DRIVER_BARRIER();
  set(device, RAYPATH_DEVICE_RAY_TAIL, device->ray_tail);
  return count;
}

uint32_t raypath_driver_take(raypath_driver *device, raypath_device_hit *hits, uint32_t count) {
  const uint32_t used = get(device, RAYPATH_DEVICE_HIT_TAIL) - device->hit_head;
  uint32_t k;
  if (used > 1u << device->hits.size) return 0;
  if (count > used) count = used;
  if (count == 0) return 0;
  RAYPATH_DRIVER_BARRIER();
  for (k = 0; k < count; k++) {
    void *place = record(&device->hits, device->hit_head + k);
    RAYPATH_DRIVER_DISCARD(place, RECORD_BYTES);
    memcpy(&hits[k], place, RECORD_BYTES);
  }
  device->hit_head += count;
  /* The device may overwrite them only after they are copied. */
  RAYPATH_DRIVER_BARRIER();
  set(device, RAYPATH_DEVICE_HIT_HEAD, device->hit_head);
  return count;
}

raypath_driver_result raypath_driver_error(const raypath_driver *device) {
  return (raypath_driver_result)((get(device, RAYPATH_DEVICE_STATUS) & RAYPATH_DEVICE_STATUS_ERROR_MASK) >>
                                 RAYPATH_DEVICE_STATUS_ERROR_SHIFT);
}

int raypath_driver_is_drained(const raypath_driver *device) {
  return get(device, RAYPATH_DEVICE_RAY_HEAD) == device->ray_tail && is_idle(device);
}

raypath_driver_result raypath_driver_stop(raypath_driver *device) {
  if (!raypath_driver_is_drained(device) || get(device, RAYPATH_DEVICE_HIT_TAIL) != device->hit_head)
    return RAYPATH_DRIVER_BUSY;
  set(device, RAYPATH_DEVICE_CONTROL, 0);
  return RAYPATH_DRIVER_OK;
}

raypath_driver_result raypath_driver_abort(raypath_driver *device, uint32_t polls) {
  set(device, RAYPATH_DEVICE_CONTROL, RAYPATH_DEVICE_CONTROL_FLUSH_MASK);
  for (; polls > 0; polls--) {
    if (!is_idle(device)) continue;
    set(device, RAYPATH_DEVICE_CONTROL, RAYPATH_DEVICE_CONTROL_CLEAR_ERROR_MASK);
    return RAYPATH_DRIVER_OK;
  }
  return RAYPATH_DRIVER_BUSY;
}

/* Writes a pulse, and leaves the device enabled or not. */
static void pulse(raypath_driver *device, uint32_t mask) {
  set(device, RAYPATH_DEVICE_CONTROL, (get(device, RAYPATH_DEVICE_CONTROL) & ENABLE) | mask);
}

void raypath_driver_flush(raypath_driver *device) { pulse(device, RAYPATH_DEVICE_CONTROL_FLUSH_MASK); }

void raypath_driver_invalidate(raypath_driver *device) { pulse(device, RAYPATH_DEVICE_CONTROL_INVALIDATE_MASK); }

void raypath_driver_clear_counts(raypath_driver *device) { pulse(device, RAYPATH_DEVICE_CONTROL_CLEAR_COUNTS_MASK); }

void raypath_driver_set_interrupts(raypath_driver *device, uint32_t mask, uint32_t hits) {
  set(device, RAYPATH_DEVICE_INTERRUPT_HITS, hits);
  set(device, RAYPATH_DEVICE_INTERRUPT_ENABLE, mask);
}

uint32_t raypath_driver_acknowledge(raypath_driver *device) {
  const uint32_t events = get(device, RAYPATH_DEVICE_INTERRUPT_STATUS);
  set(device, RAYPATH_DEVICE_INTERRUPT_STATUS, events);
  return events;
}

uint64_t raypath_driver_count(const raypath_driver *device, uint32_t counter) {
  uint32_t high = get(device, counter + 4);
  for (;;) {
    const uint32_t low = get(device, counter);
    const uint32_t again = get(device, counter + 4);
    if (again == high) return (uint64_t)high << 32 | low;
    high = again;
  }
}

const char *raypath_driver_text(raypath_driver_result result) {
  switch (result) {
  case RAYPATH_DRIVER_OK: return "no error";
  case RAYPATH_DRIVER_RAYS: return "the size of the ring of rays is above 20, or it has more rays than places";
  case RAYPATH_DRIVER_HITS: return "the size of the ring of hits is above 20, or it has more hits than places";
  case RAYPATH_DRIVER_REGION: return "a ring is not inside the memory";
  case RAYPATH_DRIVER_READ: return "the memory reported an error for a ray's record";
  case RAYPATH_DRIVER_WRITE: return "the memory reported an error for a hit's record";
  case RAYPATH_DRIVER_TIMEOUT: return "the memory timed out for a block of the scene";
  case RAYPATH_DRIVER_RING_TIMEOUT: return "the memory timed out for a record of a ring";
  case RAYPATH_DRIVER_NO_DEVICE: return "the register id is not that of a device";
  case RAYPATH_DRIVER_VERSION: return "the device has another version of the registers";
  case RAYPATH_DRIVER_BUSY: return "the device is enabled or not idle";
  case RAYPATH_DRIVER_ALIGNMENT: return "a region is not aligned to 64 bytes";
  case RAYPATH_DRIVER_SIZE: return "the size of a ring is above 20";
  case RAYPATH_DRIVER_ADDRESS: return "a region is not inside the memory of the device";
  }
  return "an unknown error";
}
