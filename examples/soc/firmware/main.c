/* Places the scene, sends the rays, and writes the hit of each to the serial line, in the order in which they come. */
#include <generated/csr.h>
#include <generated/mem.h>
#include <generated/soc.h>
#include <irq.h>
#include <stdint.h>
#include <string.h>
#include <system.h>

/* The device writes hits behind the data cache, which writes through. */
#define RAYPATH_DRIVER_DISCARD(address, bytes) ((void)(address), (void)(bytes), flush_cpu_dcache())
#include "raypath_driver.c"

#define RING_SIZE 6
#define INTERRUPTS                                                                          \
  (RAYPATH_DEVICE_INTERRUPT_STATUS_HITS_MASK | RAYPATH_DEVICE_INTERRUPT_STATUS_ERROR_MASK | \
   RAYPATH_DEVICE_INTERRUPT_STATUS_DRAINED_MASK)

extern const struct {
  float origin[3], direction[3], extent;
} rays[], rays_end[];
extern char scene[], scene_end[];
static raypath_device_ray ray_ring[1 << RING_SIZE] __attribute__((section(".rings"), aligned(64)));
static raypath_device_hit hit_ring[1 << RING_SIZE] __attribute__((section(".rings"), aligned(64)));
static raypath_driver device;
static volatile uint32_t events; /* of the interrupts that the loop in `main` has not seen */
static volatile uint32_t interrupts;

void *memcpy(void *restrict to, const void *restrict from, size_t bytes) {
  const char *source = from;
  for (char *byte = to; bytes--; byte++) *byte = *source++;
  return to;
}

void *memset(void *to, int value, size_t bytes) {
  for (char *byte = to; bytes--; byte++) *byte = (char)value;
  return to;
}

/* Called by crt0.S; the device's is the only interrupt that is enabled. */
void isr(void);
void isr(void) {
  events |= raypath_driver_acknowledge(&device);
  interrupts++;
}

static void write(const char *text) {
  for (; *text; text++) {
    while (uart_txfull_read()) continue;
    uart_rxtx_write(*text);
  }
}

static void write_word(uint32_t value) {
  char text[] = " 00000000";
  for (int digit = 8; value; value >>= 4) text[digit--] = "0123456789abcdef"[value & 15];
  write(text);
}

static void check(raypath_driver_result result) {
  if (result == RAYPATH_DRIVER_OK) return;
  write("error: ");
  write(raypath_driver_text(result));
  write("\nend\n");
  for (;;) continue;
}

/* Puts the address of the scene into a child word and those below it. It is a multiple of the power of two that is
 * not less than the scene, so that a word may be placed again, after a reset. */
static uint32_t place(uint32_t word) {
  if (word) word |= (uint32_t)scene;
  if ((word & 63) == 32) {
    uint32_t *children = (uint32_t *)(word & ~127u) + 24;
    for (int child = 0; child < 4; child++) children[child] = place(children[child]);
  }
  return word;
}

int main(void) {
  const raypath_driver_setup setup = {
    .scene_base = (uint32_t)scene,
    .scene_end = (uint32_t)scene_end,
    .node_limit = 1 << 24,
    .rays = {ray_ring, (uint32_t)ray_ring, RING_SIZE},
    .hits = {hit_ring, (uint32_t)hit_ring, RING_SIZE},
  };
  const uint32_t count = rays_end - rays;
  uint32_t sent = 0, taken = 0;
  /* As `raypath render` has them: CullBackFacingTriangles. */
  raypath_device_ray ray = {.flags = 0x10, .cull_mask = 0xff, .root = place(32)};
  raypath_device_hit hit;

  check(raypath_driver_open(&device, raypath_driver_mmio_read, raypath_driver_mmio_write, (void *)RAYPATH_BASE));
  check(raypath_driver_configure(&device, &setup));
  raypath_driver_set_interrupts(&device, INTERRUPTS, 1 << (RING_SIZE - 1));
  irq_setmask(1 << RAYPATH_INTERRUPT);
  irq_setie(1);
  check(raypath_driver_start(&device));
  while (taken != count) {
    for (; sent != count; sent++) {
      ray.id[0] = sent;
      memcpy(ray.origin, rays[sent].origin, sizeof ray.origin);
      memcpy(ray.direction, rays[sent].direction, sizeof ray.direction);
      ray.t_max = rays[sent].extent;
      if (raypath_driver_submit(&device, &ray, 1) == 0) break;
    }
    while (events == 0) continue;
    events = 0;
    check(raypath_driver_error(&device));
    for (; raypath_driver_take(&device, &hit, 1) == 1; taken++) {
      uint32_t words[7];
      memcpy(words, &hit, sizeof words);
      write("hit");
      write_word(words[0]);
      for (int word = 2; word < 7; word++) write_word(words[word]);
      write("\n");
    }
  }
  write("rays, interrupts, cycles:");
  write_word(count);
  write_word(interrupts);
  write_word((uint32_t)raypath_driver_count(&device, RAYPATH_DEVICE_COUNT_CYCLES));
  check(raypath_driver_stop(&device));
  write("\nend\n");
  return 0;
}
