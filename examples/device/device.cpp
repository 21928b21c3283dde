// SPDX-License-Identifier: MIT OR Apache-2.0
// Traces rays by the driver in C on the Verilated device, whose memory answers after a random time in any order, and
// compares every hit with the expected one.
//
//   device FOLDER     FOLDER has scene.bin, rays.bin and expected.bin, records of the rings
//
// It traces five times: undisturbed; with a region that leaves out the end of the scene; with a memory that gives no
// block, and no ray, for longer than the timeout; and once more, after a flush.

#include <Vraypath_device.h>
#include <verilated.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "raypath_driver.h"

static constexpr unsigned MEMORY_ERROR = 4;
static constexpr uint32_t RING = 6, TIMEOUT = 2000;

[[noreturn]] static void fail(const std::string &text) {
  std::printf("device: %s\n", text.c_str());
  std::exit(1);
}

static std::vector<uint8_t> file(const std::string &path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) fail("cannot read " + path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// An AXI4 memory, the clock, and the registers.
struct Bench {
  struct Read {
    uint64_t address, due;
    unsigned id, beats, bytes, beat;
  };
  struct Write {
    uint64_t address, due;
    unsigned beats;
  };

  VerilatedContext context;
  Vraypath_device top{&context};
  std::mt19937 random{1};
  std::vector<uint8_t> memory;
  uint64_t cycle = 0, scene_end = 0, bursts = 0, stops_from = ~0ull, stops_until = 0;
  uint64_t rays_at = 0, hits_at = 0;
  bool stops_rays = false;  // else blocks
  std::vector<Read> reads;
  std::deque<Write> writes;
  std::deque<std::vector<uint8_t>> data;
  long current = -1;  // the read whose beat is at the port

  unsigned beat_bytes() const { return sizeof(top.m_axi_rdata); }
  bool chance(unsigned of_8) { return random() % 8 < of_8; }

  // The scene's reads have ids below this one.
  unsigned ring_id() const { return 1u << RING_BIT; }

  void step() {
    top.clk_i = 0;
    const bool is_stopped = cycle >= stops_from && cycle < stops_until;
    if (current < 0 && chance(6)) {
      std::vector<long> due;
      std::map<unsigned, bool> seen;  // reads of an id are answered in order
      for (size_t k = 0; k < reads.size(); k++) {
        const bool is_first = !std::exchange(seen[reads[k].id], true);
        if (is_first && reads[k].due <= cycle && (!is_stopped || (reads[k].id >= ring_id()) != stops_rays))
          due.push_back(static_cast<long>(k));
      }
      if (!due.empty()) current = due[random() % due.size()];
    }
    top.m_axi_rvalid = current >= 0;
    if (current >= 0) {
      const Read &read = reads[static_cast<size_t>(current)];
      const uint64_t address = read.address + read.beat * read.bytes;
      for (unsigned k = 0; k < beat_bytes() / 4; k++) top.m_axi_rdata[k] = random();
      auto *beat = reinterpret_cast<uint8_t *>(&top.m_axi_rdata[0]) + address % beat_bytes();
      std::memcpy(beat, &memory[address], read.bytes);
      top.m_axi_rid = read.id;
      top.m_axi_rresp = 0;
      top.m_axi_rlast = read.beat + 1 == read.beats;
    }
    top.m_axi_arready = chance(6);
    top.m_axi_awready = chance(4);
    top.m_axi_wready = chance(4);
    top.m_axi_bvalid = !writes.empty() && !data.empty() && writes.front().due <= cycle &&
                       data.size() >= writes.front().beats;
    top.m_axi_bresp = 0;
    top.eval();
    const bool takes_read = top.m_axi_arvalid && top.m_axi_arready, gives = top.m_axi_rvalid && top.m_axi_rready;
    const Read read{top.m_axi_araddr, cycle + 1 + random() % 60, static_cast<unsigned>(top.m_axi_arid),
                    top.m_axi_arlen + 1u, 1u << top.m_axi_arsize, 0};
    if (takes_read) {
      const uint64_t from = read.address, to = from + read.beats * read.bytes;
      const bool is_record = read.id >= ring_id();
      if (is_record ? from < rays_at || to > rays_at + (64u << RING) : to > scene_end)
        fail("a read outside of the regions");
      bursts += !is_record;
    }
    if (top.m_axi_awvalid && top.m_axi_awready) {
      const uint64_t from = top.m_axi_awaddr;
      if (from < hits_at || from + 64 > hits_at + (64u << RING)) fail("a write outside of the ring");
      writes.push_back({from, cycle + 1 + random() % 30, top.m_axi_awlen + 1u});
    }
    if (top.m_axi_wvalid && top.m_axi_wready) {
      const auto *bytes = reinterpret_cast<const uint8_t *>(&top.m_axi_wdata[0]);
      data.emplace_back(bytes, bytes + beat_bytes());
    }
    if (top.m_axi_bvalid && top.m_axi_bready) {
      const Write write = writes.front();
      writes.pop_front();
      const unsigned bytes = std::min(beat_bytes(), 64u);
      for (unsigned beat = 0; beat < write.beats; beat++, data.pop_front()) {
        const uint64_t address = write.address + beat * bytes;
        std::memcpy(&memory[address], &data.front()[address % beat_bytes()], bytes);
      }
    }
    top.clk_i = 1;
    top.eval();
    if (takes_read) reads.push_back(read);
    if (gives) {
      Read &given = reads[static_cast<size_t>(current)];
      if (++given.beat == given.beats) reads.erase(reads.begin() + current);
      current = -1;
    }
    cycle++;
  }

  uint32_t read(uint32_t offset) {
    top.s_axi_arvalid = 1;
    top.s_axi_araddr = offset;
    while (top.s_axi_arvalid) {
      const bool is_taken = top.s_axi_arready;
      step();
      if (is_taken) top.s_axi_arvalid = 0;
    }
    top.s_axi_rready = 1;
    while (!top.s_axi_rvalid) step();
    const uint32_t value = top.s_axi_rdata;
    step();
    top.s_axi_rready = 0;
    return value;
  }

  void write(uint32_t offset, uint32_t value) {
    top.s_axi_awvalid = top.s_axi_wvalid = 1;
    top.s_axi_awaddr = offset;
    top.s_axi_wdata = value;
    top.s_axi_wstrb = 15;
    while (top.s_axi_awvalid || top.s_axi_wvalid) {
      const bool aw = top.s_axi_awready, w = top.s_axi_wready;
      step();
      if (aw) top.s_axi_awvalid = 0;
      if (w) top.s_axi_wvalid = 0;
    }
    top.s_axi_bready = 1;
    while (!top.s_axi_bvalid) step();
    step();
    top.s_axi_bready = 0;
  }
};

static void expect(raypath_driver_result result, const char *what) {
  if (result != RAYPATH_DRIVER_OK) fail(std::string(what) + ": " + raypath_driver_text(result));
}

// Whether hits are the same. Of a ray without a hit, the words of one may have any value.
static bool is_same(const raypath_device_hit &a, const raypath_device_hit &b) {
  if ((a.status & 255) == 1) return std::memcmp(&a, &b, sizeof a) == 0;
  return a.id[0] == b.id[0] && (a.status & 255) == (b.status & 255) && a.nodes == b.nodes && a.triangles == b.triangles;
}

struct Outcome {
  size_t taken = 0, failed = 0;
  uint64_t cycles = 0;
};

// Traces rays until all have their hits, `until` hits were taken, or rays time out. A hit that differs must be an
// error.
static Outcome trace(Bench &bench, raypath_driver &device, const std::vector<raypath_device_ray> &rays,
                     const std::vector<raypath_device_hit> &expected, bool may_fail, size_t until) {
  Outcome outcome;
  std::vector<bool> seen(rays.size());
  size_t sent = 0;
  const uint64_t from = bench.cycle;
  while (outcome.taken < std::min(until, rays.size())) {
    sent += raypath_driver_submit(&device, &rays[sent], static_cast<uint32_t>(rays.size() - sent));
    for (unsigned wait = 0; !bench.top.irq_o; wait++) {
      if (wait > 2 * TIMEOUT && raypath_driver_error(&device) == RAYPATH_DRIVER_RING_TIMEOUT) return outcome;
      if (wait == 200000) fail("no interrupt");
      bench.step();
    }
    raypath_driver_acknowledge(&device);
    // Until there is none, so that the next one raises the interrupt.
    raypath_device_hit hits[1 << RING];
    while (const uint32_t count = raypath_driver_take(&device, hits, 1 << RING)) {
      outcome.taken += count;
      for (uint32_t k = 0; k < count; k++) {
        const uint32_t id = hits[k].id[0];
        if (id >= rays.size() || seen[id]) fail("a hit of no ray, or a second one: " + std::to_string(id));
        seen[id] = true;
        if (is_same(hits[k], expected[id])) continue;
        if (!may_fail || (hits[k].status & 255) != MEMORY_ERROR) fail("another hit of ray " + std::to_string(id));
        outcome.failed++;
      }
    }
  }
  outcome.cycles = bench.cycle - from;
  return outcome;
}

int main(int count_of_arguments, char **arguments) {
  if (count_of_arguments != 2) fail("expected a folder with scene.bin, rays.bin and expected.bin");
  const std::string folder = arguments[1];
  Bench bench;
  bench.memory = file(folder + "/scene.bin");
  const uint64_t scene = (bench.memory.size() + 63) / 64 * 64;
  const auto of_rays = file(folder + "/rays.bin"), of_hits = file(folder + "/expected.bin");
  std::vector<raypath_device_ray> rays(of_rays.size() / 64);
  std::vector<raypath_device_hit> expected(of_hits.size() / 64);
  if (rays.empty() || rays.size() != expected.size()) fail("as many rays as hits, and one at least");
  std::memcpy(rays.data(), of_rays.data(), of_rays.size());
  std::memcpy(expected.data(), of_hits.data(), of_hits.size());
  bench.rays_at = scene;
  bench.hits_at = scene + (64u << RING);
  bench.memory.resize(scene + (128u << RING));
  bench.scene_end = scene;

  bench.top.rst_ni = 0;
  for (int k = 0; k < 4; k++) bench.step();
  bench.top.rst_ni = 1;
  raypath_driver device;
  const auto read = [](void *context, uint32_t offset) { return static_cast<Bench *>(context)->read(offset); };
  const auto write = [](void *context, uint32_t offset, uint32_t value) {
    static_cast<Bench *>(context)->write(offset, value);
  };
  expect(raypath_driver_open(&device, read, write, &bench), "open");
  raypath_driver_setup setup = {0, scene, 1u << 24, TIMEOUT,
                                {&bench.memory[bench.rays_at], bench.rays_at, RING},
                                {&bench.memory[bench.hits_at], bench.hits_at, RING}};
  const auto begin = [&](uint64_t end) {
    setup.scene_end = bench.scene_end = end;
    expect(raypath_driver_configure(&device, &setup), "configure");
    raypath_driver_set_interrupts(&device, RAYPATH_DEVICE_INTERRUPT_STATUS_HITS_MASK, 1);
    raypath_driver_clear_counts(&device);
    bench.bursts = 0;
    expect(raypath_driver_start(&device), "start");
  };
  const auto count = [&](uint32_t counter) { return raypath_driver_count(&device, counter); };

  begin(scene);
  const Outcome whole = trace(bench, device, rays, expected, false, rays.size());
  expect(raypath_driver_stop(&device), "stop");
  if (count(RAYPATH_DEVICE_COUNT_RAYS) != rays.size()) fail("another number of rays is counted");
  const bool has_cache = device.read(device.context, RAYPATH_DEVICE_CACHE_BYTES) != 0;
  const uint64_t fetched = count(has_cache ? RAYPATH_DEVICE_COUNT_CACHE_MISSES : RAYPATH_DEVICE_COUNT_FETCHES);
  if (fetched != bench.bursts) fail("another number of reads is counted");
  const uint64_t jobs = count(RAYPATH_DEVICE_COUNT_BOXES) + count(RAYPATH_DEVICE_COUNT_TRIANGLES);
  std::printf("%zu rays: every hit is the model's; %lu jobs in %lu cycles, %lu reads\n", rays.size(),
              static_cast<unsigned long>(jobs), static_cast<unsigned long>(whole.cycles),
              static_cast<unsigned long>(fetched));

  // Lines of caches are still those of the whole scene.
  raypath_driver_invalidate(&device);
  begin(scene / 2 / 64 * 64);
  const Outcome part = trace(bench, device, rays, expected, true, rays.size());
  expect(raypath_driver_stop(&device), "stop");
  if (part.failed == 0) fail("no ray left the region");
  std::printf("half of the scene outside of the region: %zu rays end with an error, no read is outside\n", part.failed);

  raypath_driver_invalidate(&device);
  begin(scene);
  bench.stops_from = bench.cycle + whole.cycles / 3;
  bench.stops_until = bench.stops_from + 3 * TIMEOUT;
  const Outcome stopped = trace(bench, device, rays, expected, true, rays.size());
  if (stopped.failed == 0) fail("no ray met the timeout");
  if (raypath_driver_error(&device) != RAYPATH_DRIVER_TIMEOUT) fail("the timeout is not reported");
  while (bench.cycle < bench.stops_until + 10 * TIMEOUT) bench.step();
  expect(raypath_driver_abort(&device, 1000), "abort");
  std::printf("a memory that stops: %zu rays end with an error\n", stopped.failed);

  begin(scene);
  bench.stops_rays = true;
  bench.stops_from = bench.cycle + whole.cycles / 3;
  bench.stops_until = ~0ull;
  const Outcome silent = trace(bench, device, rays, expected, false, rays.size());
  if (silent.taken == 0 || silent.taken == rays.size()) fail("the rays did not time out");
  if (raypath_driver_abort(&device, 1000) != RAYPATH_DRIVER_BUSY) fail("idle, but the memory owes a ray");
  bench.stops_until = bench.cycle;
  expect(raypath_driver_abort(&device, 1000), "abort");
  std::printf("a memory that gives no ray: %zu rays have hits before the timeout\n", silent.taken);

  begin(scene);
  trace(bench, device, rays, expected, false, rays.size() / 4);
  raypath_driver_flush(&device);
  expect(raypath_driver_abort(&device, 10000), "abort");
  begin(scene);
  trace(bench, device, rays, expected, false, rays.size());
  expect(raypath_driver_stop(&device), "stop");
  std::printf("after a flush: all hits are the model's\n");
}
