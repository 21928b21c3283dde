/* Places the scene, traces the rays of a picture by raypath_device, and writes each hit to the serial line. */
#include <generated/csr.h>
#include <generated/mem.h>
#include <generated/soc.h>
#include <irq.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <system.h>

#define REGISTER(offset) (*(volatile uint32_t *)(RAYPATH_BASE + (offset)))
#define RING 6 /* log2 of the records of a ring */
#define RECORD 16

extern const uint32_t rays[][7], rays_end[][7];
extern uint32_t scene[], scene_end[];
static uint32_t ray_ring[RECORD << RING] __attribute__((section(".rings"), aligned(64)));
static uint32_t hit_ring[RECORD << RING] __attribute__((section(".rings"), aligned(64)));
static volatile uint32_t interrupts;

void isr(void);

void isr(void)
{
	REGISTER(0x080) = REGISTER(0x080);
	interrupts++;
}

static void put(char letter)
{
	while (uart_txfull_read())
		;
	uart_rxtx_write(letter);
}

static void text(const char *letters)
{
	while (*letters)
		put(*letters++);
}

static void number(uint32_t value)
{
	put(' ');
	for (int digit = 28; digit >= 0; digit -= 4)
		put("0123456789abcdef"[value >> digit & 15]);
}

/* Puts the address of the scene into a child word and those below it. */
static uint32_t placed(uint32_t word)
{
	if (word)
		word |= (uint32_t)scene;
	if ((word & 63) == 32) {
		uint32_t *children = (uint32_t *)(word & ~127u) + 24;
		for (int child = 0; child < 4; child++)
			children[child] = placed(children[child]);
	}
	return word;
}

int main(void)
{
	text("raypath");
	number(REGISTER(0x000));
	uint32_t root = placed(32);
	REGISTER(0x028) = (uint32_t)scene;
	REGISTER(0x030) = (uint32_t)scene_end;
	REGISTER(0x040) = (uint32_t)ray_ring;
	REGISTER(0x048) = RING;
	REGISTER(0x060) = (uint32_t)hit_ring;
	REGISTER(0x068) = RING;
	REGISTER(0x088) = 1u << (RING - 1);
	REGISTER(0x084) = 7;
	REGISTER(0x014) = 1;
	irq_setmask(1u << RAYPATH_INTERRUPT);
	irq_setie(1);

	uint32_t count = rays_end - rays, tail = 0, head = 0;
	text("\nrays");
	number(count);
	while (head != count) {
		for (; tail != count && tail - head < 1u << RING; tail++) {
			uint32_t *record = ray_ring + RECORD * (tail & ((1u << RING) - 1));
			const uint32_t *ray = rays[tail];
			record[0] = tail;
			record[1] = record[2] = record[5] = record[6] = 0;
			record[3] = 0xff;
			record[4] = root;
			record[7] = ray[6];
			for (int axis = 0; axis < 3; axis++) {
				record[8 + axis] = ray[axis];
				record[12 + axis] = ray[3 + axis];
			}
		}
		interrupts = 0;
		REGISTER(0x04c) = tail;
		while (!interrupts)
			;
		flush_cpu_dcache();
		for (uint32_t end = REGISTER(0x070); head != end; head++) {
			const uint32_t *hit = hit_ring + RECORD * (head & ((1u << RING) - 1));
			text("\nhit");
			number(hit[0]);
			for (int word = 2; word < 7; word++)
				number(hit[word]);
		}
		REGISTER(0x06c) = head;
	}
	text("\nend");
	number(REGISTER(0x018));
	put('\n');
	return 0;
}
