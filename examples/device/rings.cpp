// SPDX-License-Identifier: MIT OR Apache-2.0
// Runs the driver in C on the registers and the engine of the rings. The cluster takes records after random stalls, and
// gives a function of each after a random time, in any order. The memory answers at any time, and checks each address
// against the regions of the registers in the cycle before.
//
//   rings [EPISODES [SEED]]

#include <Vrings.h>
#include <verilated.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <random>
#include <type_traits>
#include <vector>

#include "raypath_driver.h"

using Record = std::array<uint32_t, 16>;

static constexpr unsigned BEATS = DATA_WIDTH > 512 ? 1 : 512 / DATA_WIDTH, BEAT_WORDS = DATA_WIDTH / 32;
static constexpr uint32_t FIRST = 0xfffffff0;
static constexpr uint64_t LAST_ADDRESS = ADDRESS_WIDTH == 64 ? ~0ull : (1ull << ADDRESS_WIDTH % 64) - 1;
static constexpr unsigned TOO_LONG = 100000;

static std::mt19937_64 random_bits;
static uint32_t below(uint64_t bound) { return static_cast<uint32_t>(random_bits() % bound); }
static bool chance(uint32_t of_8) { return below(8) < of_8; }

// A bit of a port of any width.
template <typename T> static bool bit(const T &port, unsigned k) {
  if constexpr (std::is_integral_v<T>) return port >> k & 1;
  else return port[k / 32] >> k % 32 & 1;
}

// What the cluster makes of a ray: its id, and words that depend on all of its words.
static Record answer(const Record &ray) {
  Record hit = {ray[0], ray[1]};
  uint32_t sum = 1;
  for (uint32_t word : ray) sum = (sum ^ word) * 0x9e3779b1u;
  for (unsigned k = 2; k < 16; k++) hit[k] = sum += ray[k] * 0x85ebca6bu + k;
  return hit;
}

struct Settings {
  bool enable, idle, drained, timed_out;
  uint64_t ray_base, hit_base;
  uint32_t ray_size, ray_head, ray_tail, hit_size, hit_head, hit_tail, error, events;

  static bool fits(uint64_t base, uint32_t size) {
    return base <= LAST_ADDRESS && (64ull << (size & 31)) - 1 <= LAST_ADDRESS - base;
  }
  static bool contains(uint64_t base, uint32_t size, uint64_t address) {
    return size <= 20 && fits(base, size) && address >= base && address - base < 64ull << size;
  }
  bool rays_are_wrong() const { return ray_size > 20 || ray_tail - ray_head > 1u << ray_size; }
  bool hits_are_wrong() const { return hit_size > 20 || hit_tail - hit_head > 1u << hit_size; }
  bool fit() const { return fits(ray_base, ray_size) && fits(hit_base, hit_size); }
};

struct Bench {
  VerilatedContext context;
  Vrings top{&context};
  unsigned seed = 0, episode = 0;
  const char *kind = "reset";
  uint64_t cycle = 0, records = 0, requests = 0, nonsense = 0, errors[8] = {};

  // Of 8 cycles, those in which a channel may move.
  uint32_t bus_pace = 8, read_pace = 8, data_pace = 8, aw_pace = 8, w_pace = 8, b_pace = 8, ray_pace = 8, hit_pace = 8;
  uint32_t latency = 1, capacity = 16;
  // The memory is ready only for what is valid.
  bool awaits_valid = false;

  // Software is correct, so that each record has one place and one hit.
  bool is_strict = false, is_flushed = false;
  uint64_t failing_read = ~0ull, failing_write = ~0ull;
  // The record whose read, or write, the memory does not answer; how long it was silent while it owed one; whether that
  // was too long; and what it had answered by then.
  uint64_t silent_read = ~0ull, silent_write = ~0ull, read_silence = 0, write_silence = 0;
  uint64_t in_time = 0, answered_in_time = 0;
  bool read_expires = false, write_expires = false;
  std::vector<Record> ray_memory, hit_memory;
  uint64_t ray_address = 0, hit_address = 0;

  // The rays of the episode, and what became of them, by number.
  std::vector<raypath_device_ray> rays;
  std::vector<bool> is_taken;
  std::vector<uint32_t> accepted;
  uint64_t reads = 0, arrived = 0, next_ray = 0, placed = 0, answered = 0, taken = 0;

  [[noreturn]] void fail(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    printf("seed %u, episode %u (%s), cycle %lu: ", seed, episode, kind, cycle);
    vprintf(format, arguments);
    printf("\n");
    va_end(arguments);
    exit(1);
  }
  void check(bool good, const char *text) {
    if (!good) fail("%s", text);
  }

  // ---- The memory ------------------------------------------------------------------
  struct Read {
    uint64_t address, ready;
    bool fails;
  };
  struct Write {
    uint64_t address, ready;
    bool fails;
  };
  std::deque<Read> read_queue;
  std::deque<Write> write_queue;
  std::deque<Record> data_queue;
  Record written = {};
  unsigned read_beat = 0, write_beat = 0;
  Settings before = {};
  bool read_waited = false, aw_waited = false, w_waited = false, ray_waited = false, data_fails = false,
       b_fails = false;
  uint64_t read_address = 0, aw_address = 0;
  Record ray_shown = {};

  Record *place(uint64_t address) {
    static Record nowhere;
    if (address >= ray_address && (address - ray_address) / 64 < ray_memory.size())
      return &ray_memory[(address - ray_address) / 64];
    if (address >= hit_address && (address - hit_address) / 64 < hit_memory.size())
      return &hit_memory[(address - hit_address) / 64];
    for (uint32_t &word : nowhere) word = below(1ull << 32);
    return &nowhere;
  }

  void drive_memory() {
    // A read stops after any of its beats.
    const bool reads_stop = arrived == silent_read && read_beat == silent_read % BEATS;
    const bool writes_stop = answered == silent_write;
    const auto is_ready = [&](uint32_t pace, bool valid) { return chance(pace) && (valid || !awaits_valid); };
    top.read_ready_i = is_ready(read_pace, top.read_valid_o) && read_queue.size() < 8 && !reads_stop;
    top.data_valid_i = !read_queue.empty() && read_queue.front().ready <= cycle && chance(data_pace) && !reads_stop;
    // At least one beat of a record that fails has an error.
    data_fails = data_fails && read_beat != 0;
    const bool is_due = read_beat == BEATS - 1 && !data_fails;
    top.data_error_i = top.data_valid_i && read_queue.front().fails && (is_due || chance(4));
    data_fails = data_fails || top.data_error_i;
    for (unsigned k = 0; k < BEAT_WORDS; k++) top.data_i[k] = below(1ull << 32);
    // The record is read from the memory as late as possible.
    if (top.data_valid_i) {
      const Record &record = *place(read_queue.front().address);
      const unsigned lane = DATA_WIDTH > 512 && (read_queue.front().address & 64) ? 16 : 0;
      for (unsigned k = 0; k < std::min(BEAT_WORDS, 16u); k++)
        top.data_i[lane + k] = record[read_beat * BEAT_WORDS % 16 + k];
    }
    top.m_axi_awready = is_ready(aw_pace, top.m_axi_awvalid) && write_queue.size() < 8 && !writes_stop;
    top.m_axi_wready = is_ready(w_pace, top.m_axi_wvalid) && data_queue.size() < 8 && !writes_stop;
    // So is the record of a hit written.
    top.m_axi_bvalid = !write_queue.empty() && !data_queue.empty() && write_queue.front().ready <= cycle &&
                       chance(b_pace) && !writes_stop;
    top.m_axi_bresp = static_cast<CData>(top.m_axi_bvalid && write_queue.front().fails ? 2 + below(2) : 0);
    top.m_axi_bid = 0;
    if (top.m_axi_bvalid) *place(write_queue.front().address) = data_queue.front();
  }

  void check_memory() {
    if (top.read_valid_o) {
      const uint64_t address = top.read_addr_o;
      if (!read_waited) {
        requests++;
        if (!Settings::contains(before.ray_base, before.ray_size, address))
          fail("read of 0x%lx outside the ring 0x%lx of size %u", address, before.ray_base, before.ray_size);
        check(before.enable && before.error == 0, "a read while the engine is disabled or has an error");
        if (is_strict) {
          check(address == ray_address + 64 * ((FIRST + reads) % ray_memory.size()), "a read of another record");
          check(before.ray_tail - FIRST > reads, "a read of a record after the last");
        }
        reads++;
      } else {
        check(address == read_address, "read_addr_o changed before it was taken");
      }
      read_address = address;
      if (top.read_ready_i) read_queue.push_back({address, cycle + 1 + below(latency), reads - 1 == failing_read});
    } else {
      check(!read_waited, "read_valid_o fell before it was taken");
    }
    read_waited = top.read_valid_o && !top.read_ready_i;

    if (top.m_axi_awvalid) {
      const uint64_t address = top.m_axi_awaddr;
      if (!aw_waited) {
        requests++;
        if (!Settings::contains(before.hit_base, before.hit_size, address))
          fail("write of 0x%lx outside the ring 0x%lx of size %u", address, before.hit_base, before.hit_size);
        if (is_strict) {
          check(address == hit_address + 64 * ((FIRST + placed) % hit_memory.size()), "a write of another record");
          check(FIRST + static_cast<uint32_t>(placed) - before.hit_head < hit_memory.size(), "a write to a full ring");
        }
        placed++;
        check(top.m_axi_awlen == BEATS - 1 && 8u << top.m_axi_awsize == std::min(512u, DATA_WIDTH + 0u) &&
                  top.m_axi_awburst == 1 && top.m_axi_awid == 0,
              "a burst of another shape");
      } else {
        check(address == aw_address, "awaddr changed before it was taken");
      }
      aw_address = address;
      if (top.m_axi_awready) write_queue.push_back({address, cycle + 1 + below(latency), placed - 1 == failing_write});
    } else {
      check(!aw_waited, "awvalid fell before it was taken");
    }
    aw_waited = top.m_axi_awvalid && !top.m_axi_awready;

    check(top.m_axi_wvalid || !w_waited, "wvalid fell before it was taken");
    w_waited = top.m_axi_wvalid && !top.m_axi_wready;
    if (top.m_axi_wvalid && top.m_axi_wready) {
      unsigned lane = 0, words = 0;
      while (lane < BEAT_WORDS && !bit(top.m_axi_wstrb, 4 * lane)) lane++;
      for (unsigned k = 0; k < DATA_WIDTH / 8; k++) words += bit(top.m_axi_wstrb, k);
      check(words == std::min(64u, DATA_WIDTH / 8u) && (lane == 0 || lane == 16), "other strobes");
      // The half of a wide beat is that of the address, which may come later.
      for (unsigned k = 0; k < std::min(BEAT_WORDS, 16u); k++)
        written[(write_beat * BEAT_WORDS + k) % 16] = top.m_axi_wdata[lane + k];
      lanes.push_back(lane);
      write_beat++;
      check(top.m_axi_wlast == (write_beat == BEATS), "wlast is not that of the last beat");
      if (write_beat == BEATS) data_queue.push_back(written), write_beat = 0;
    }
    const auto expires = [&](uint64_t owed, bool answers, uint64_t &silence) {
      const bool is_silent = owed != 0 && !answers && !top.timed_out_o;
      const bool is_long = is_silent && top.timeout_o != 0 && silence >= top.timeout_o;
      silence = is_silent ? silence + 1 : 0;
      return is_long;
    };
    read_expires = expires(reads - arrived, top.data_valid_i, read_silence);
    write_expires = expires(placed - answered, top.m_axi_bvalid, write_silence);
    check(top.m_axi_bready, "bready fell");
    if (top.m_axi_bvalid) {
      b_fails = b_fails || top.m_axi_bresp != 0;
      for (unsigned k = 0; k < BEATS; k++) {
        const unsigned half = DATA_WIDTH > 512 && (write_queue.front().address & 64) ? 16 : 0;
        check(lanes.front() == half, "strobes of the other half");
        lanes.pop_front();
      }
      write_queue.pop_front(), data_queue.pop_front(), answered++;
    }
    if (top.data_valid_i && ++read_beat == BEATS) read_beat = 0, read_queue.pop_front(), arrived++;
    if (!top.timed_out_o) in_time = arrived, answered_in_time = write_expires ? answered : ~0ull;
  }
  std::deque<unsigned> lanes;

  // ---- The cluster -----------------------------------------------------------------
  struct Inside {
    Record ray;
    uint64_t ready;
  };
  std::vector<Inside> inside;
  bool offers = false;
  unsigned flush_left = 0;

  void drive_cluster() {
    if (flush_left > 0) flush_left--;
    top.cluster_idle_i = inside.empty() && flush_left == 0;
    top.ray_ready_i = flush_left == 0 && inside.size() < capacity && chance(ray_pace);
    if (!offers && !inside.empty() && chance(hit_pace)) {
      std::swap(inside.back(), inside[below(inside.size())]);
      offers = inside.back().ready <= cycle;
    }
    top.hit_valid_i = offers;
    const Record hit = offers ? answer(inside.back().ray) : Record();
    for (unsigned k = 0; k < 16; k++) top.hit_record_i[k] = hit[k];
  }

  void check_cluster() {
    const uint32_t number = inside.empty() ? 0 : inside.back().ray[0];
    if (offers && top.hit_ready_o) {
      inside.pop_back(), offers = false, records++;
      if (is_strict) accepted.push_back(number);
    }
    if (ray_waited && !top.flush_o && flush_left == 0) check(top.ray_valid_o, "ray_valid_o fell before it was taken");
    if (top.ray_valid_o) {
      Record ray;
      for (unsigned k = 0; k < 16; k++) ray[k] = top.ray_record_o[k];
      if (ray_waited) check(ray == ray_shown, "ray_record_o changed before it was taken");
      ray_shown = ray;
      if (top.ray_ready_i) {
        if (is_strict) {
          check(ray[0] < rays.size() && ray[1] == episode && memcmp(&ray, &rays[ray[0]], 64) == 0,
                "a ray is not what was submitted");
          check(is_flushed || failing_read != ~0ull ? ray[0] >= next_ray : ray[0] == next_ray,
                "rays come in another order");
          check(ray[0] < in_time, "a ray came after a timeout");
          next_ray = ray[0] + 1;
        }
        // The element at the end may be offered.
        inside.insert(inside.begin(), {ray, cycle + below(4 * latency)});
      }
    }
    ray_waited = top.ray_valid_o && !top.ray_ready_i && !top.flush_o;
    if (top.flush_o) inside.clear(), offers = false, flush_left = 1 + below(20);
  }

  // ---- A cycle -----------------------------------------------------------------------
  void tick() {
    cycle++;
    drive_memory();
    drive_cluster();
    top.clk_i = 0, top.eval();
    const Settings now = {!!top.enable_o, !!top.idle_o,   !!top.drained_o, !!top.timed_out_o, top.ray_base_o,
                          top.hit_base_o, top.ray_size_o, top.ray_head_o,  top.ray_tail_o,    top.hit_size_o,
                          top.hit_head_o, top.hit_tail_o, top.error_o,     top.events_o};
    check_state(now);
    const bool read_failed = data_fails && read_beat == BEATS - 1 && top.data_valid_i;
    b_fails = false;
    check_memory();
    check_cluster();
    ended_read_fails = read_failed;
    before = now;
    top.clk_i = 1, top.eval();
  }
  bool ended_read_fails = false;
  uint32_t due_events = 0;

  void check_state(const Settings &now) {
    if (now.idle) {
      check(read_queue.empty() && write_queue.empty() && data_queue.empty() && write_beat == 0 && inside.empty() &&
                !top.read_valid_o && !top.m_axi_awvalid && !top.m_axi_wvalid && !top.ray_valid_o && top.cluster_idle_i,
            "idle with work inside");
    }
    if (!before.enable && before.idle)
      check(now.ray_head == FIRST && now.hit_tail == FIRST, "indices of the disabled engine are not the first ones");
    // A wrong setting is reported, and what is reported was wrong.
    if (before.enable && before.error == 0)
      check(now.error != 0 || !(before.rays_are_wrong() || before.hits_are_wrong() || !before.fit()),
            "wrong settings without an error");
    if (before.error != 0) {
      check(now.error == before.error || (now.error == 0 && !before.enable), "the first error does not stay");
    } else if (now.error != 0) {
      errors[now.error]++;
      const bool right = now.error == 1   ? before.rays_are_wrong()
                         : now.error == 2 ? before.hits_are_wrong()
                         : now.error == 3 ? !before.fit()
                         : now.error == 4 ? ended_read_fails
                         : now.error == 5 ? b_fails
                                          : now.error == 7 && (read_expires || write_expires);
      if (!right) fail("error %u without its cause", now.error);
    }
    const bool is_late = !(before.idle && !before.enable) && (before.timed_out || read_expires || write_expires);
    check(now.timed_out == is_late, "timed_out is not that of the memory");
    check(!now.timed_out || now.error != 0, "a timeout without an error");
    // A level that rises sets its event, also while the event is cleared.
    check((now.events & due_events) == due_events, "an event is lost");
    due_events = (now.error != 0 && before.error == 0 ? RAYPATH_DEVICE_INTERRUPT_STATUS_ERROR_MASK : 0) |
                 (now.drained && !before.drained ? RAYPATH_DEVICE_INTERRUPT_STATUS_DRAINED_MASK : 0);
    if (!is_strict) return;
    check(now.ray_head - FIRST <= arrived, "ray_head passed a record that has not arrived");
    check(now.hit_tail - FIRST <= answered, "hit_tail passed a record that is not in memory");
    if (now.drained && now.error == 0 && !is_flushed)
      check(answered == now.ray_tail - FIRST, "drained before all hits are in memory");
  }

  // ---- Software -----------------------------------------------------------------------
  raypath_driver device = {};

  void pause() {
    while (!chance(bus_pace)) tick();
  }
  void write(uint32_t offset, uint32_t value, uint32_t strobes = 15) {
    bool aw = false, w = false;
    pause();
    for (unsigned k = 0;; k++) {
      top.s_axi_awvalid = !aw && (top.s_axi_awvalid || chance(bus_pace));
      top.s_axi_wvalid = !w && (top.s_axi_wvalid || chance(bus_pace));
      top.s_axi_awaddr = offset, top.s_axi_wdata = value, top.s_axi_wstrb = strobes;
      top.s_axi_bready = chance(bus_pace);
      top.clk_i = 0, top.eval();
      aw = aw || (top.s_axi_awvalid && top.s_axi_awready), w = w || (top.s_axi_wvalid && top.s_axi_wready);
      const bool ends = top.s_axi_bvalid && top.s_axi_bready;
      tick();
      if (aw) top.s_axi_awvalid = 0;
      if (w) top.s_axi_wvalid = 0;
      if (ends) break;
      check(k < TOO_LONG, "no answer to a write of a register");
    }
    top.s_axi_bready = 0;
  }
  uint32_t read(uint32_t offset) {
    bool ar = false;
    uint32_t value;
    pause();
    for (unsigned k = 0;; k++) {
      top.s_axi_arvalid = !ar && (top.s_axi_arvalid || chance(bus_pace));
      top.s_axi_araddr = offset;
      top.s_axi_rready = chance(bus_pace);
      top.clk_i = 0, top.eval();
      ar = ar || (top.s_axi_arvalid && top.s_axi_arready);
      const bool ends = top.s_axi_rvalid && top.s_axi_rready;
      value = top.s_axi_rdata;
      tick();
      if (ar) top.s_axi_arvalid = 0;
      if (ends) break;
      check(k < TOO_LONG, "no answer to a read of a register");
    }
    top.s_axi_rready = 0;
    return value;
  }

  void expect(raypath_driver_result result, raypath_driver_result expected, const char *what) {
    if (result != expected)
      fail("%s: found '%s', expected '%s'", what, raypath_driver_text(result), raypath_driver_text(expected));
  }

  // New rings, and a number of rays to send.
  void begin(uint32_t ray_size, uint32_t hit_size, uint32_t count) {
    ray_memory.assign(size_t{1} << ray_size, Record());
    hit_memory.assign(size_t{1} << hit_size, Record());
    // The highest region ends with the address space.
    const uint64_t span = 64 * 2 * 64, low = chance(4) ? 64ull * below(1000) : LAST_ADDRESS + 1 - span;
    ray_address = low, hit_address = low + span - 64 * hit_memory.size();
    if (chance(4)) ray_address += span / 2 - 64 * ray_memory.size();
    rays.assign(count, {});
    for (uint32_t k = 0; k < count; k++) {
      Record ray;
      for (uint32_t &word : ray) word = below(1ull << 32);
      ray[0] = k, ray[1] = episode;
      memcpy(&rays[k], &ray, 64);
    }
    is_taken.assign(count, false);
    accepted.clear();
    reads = arrived = next_ray = placed = answered = taken = sent = 0;
    is_flushed = false, is_strict = true, failing_read = failing_write = silent_read = silent_write = ~0ull;
    const raypath_driver_setup setup = {
        0, 0, 1000, 0, {ray_memory.data(), ray_address, ray_size}, {hit_memory.data(), hit_address, hit_size}};
    expect(raypath_driver_configure(&device, &setup), RAYPATH_DRIVER_OK, "configure");
    expect(raypath_driver_start(&device), RAYPATH_DRIVER_OK, "start");
  }
  size_t sent = 0;

  void submit(uint32_t most) {
    const uint32_t count = std::min<uint32_t>(most, static_cast<uint32_t>(rays.size() - sent));
    const uint32_t done = raypath_driver_submit(&device, rays.data() + sent, count);
    check(done <= count, "more rays were submitted than there are");
    sent += done;
  }
  void check_hit(const Record &hit) {
    check(hit[0] < rays.size() && hit[1] == episode, "a hit has an id that was not submitted");
    Record ray;
    memcpy(&ray, &rays[hit[0]], 64);
    check(hit == answer(ray), "a hit is not that of its ray");
    check(!is_taken[hit[0]], "a ray has two hits");
    check(taken < accepted.size() && accepted[taken] == hit[0],
          "hits come in another order than the cluster gave them");
    is_taken[hit[0]] = true, taken++;
  }
  uint32_t take(uint32_t most) {
    std::vector<raypath_device_hit> hits(most);
    const uint32_t count = raypath_driver_take(&device, hits.data(), most);
    for (uint32_t k = 0; k < count; k++) {
      Record hit;
      memcpy(&hit, &hits[k], 64);
      check_hit(hit);
    }
    return count;
  }
  // Submits and takes, `steps` times or until all rays have hits.
  void work(unsigned steps) {
    const uint32_t prefers_take = 1 + below(7);
    for (unsigned k = 0; k < steps && taken < rays.size(); k++) {
      if (chance(prefers_take)) take(1 + below(70));
      else submit(1 + below(70));
      if (below(10) == 0) raypath_driver_acknowledge(&device);
      if (below(30) == 0 && sent > taken && failing_read == ~0ull && failing_write == ~0ull && top.timeout_o == 0)
        expect(raypath_driver_stop(&device), RAYPATH_DRIVER_BUSY, "stop before the last hit");
      if (below(20) == 0)
        for (unsigned wait = below(300); wait > 0; wait--) tick();
    }
  }
  void work_until_taken() {
    const uint64_t end = cycle + 1000 * (rays.size() + 1) + TOO_LONG;
    while (taken < rays.size() && cycle < end) work(100);
    if (taken < rays.size()) fail("%lu of %zu hits came", taken, rays.size());
  }
  void work_with_interrupts() {
    raypath_driver_set_interrupts(&device, 7, 1 + below(hit_memory.size()));
    raypath_driver_acknowledge(&device);
    while (taken < rays.size()) {
      submit(100);
      for (unsigned k = 0; !top.irq_o; k++) {
        tick();
        if (k == TOO_LONG) fail("no interrupt: %zu rays sent, %lu hits taken", sent, taken);
      }
      check(raypath_driver_acknowledge(&device) != 0, "an interrupt without an event");
      while (take(1 + below(70)) > 0) {
      }
    }
    raypath_driver_set_interrupts(&device, 0, 1);
  }
  void wait_idle(bool takes) {
    for (unsigned k = 0; !(read(RAYPATH_DEVICE_STATUS) & RAYPATH_DEVICE_STATUS_IDLE_MASK); k++) {
      check(k < TOO_LONG / 8, "the device does not become idle");
      if (takes) take(1 + below(70));
    }
  }
  void stop() {
    for (unsigned k = 0; raypath_driver_stop(&device) != RAYPATH_DRIVER_OK; k++)
      check(k < 1000, "the device does not stop");
    expect(raypath_driver_error(&device), RAYPATH_DRIVER_OK, "error");
  }
  void abort() {
    is_flushed = true;
    for (unsigned k = 0; raypath_driver_abort(&device, 10) != RAYPATH_DRIVER_OK; k++)
      check(k < 1000, "no end of abort");
    expect(raypath_driver_error(&device), RAYPATH_DRIVER_OK, "error after abort");
  }
  void wait_error(raypath_driver_result expected) {
    for (unsigned k = 0; raypath_driver_error(&device) == RAYPATH_DRIVER_OK; k++)
      check(k < TOO_LONG, "an error is not reported"), work(4);
    expect(raypath_driver_error(&device), expected, "error");
  }

  // ---- Episodes ------------------------------------------------------------------------
  void clean() {
    raypath_driver_clear_counts(&device);
    chance(4) ? work_until_taken() : work_with_interrupts();
    check(raypath_driver_count(&device, RAYPATH_DEVICE_COUNT_RAYS) == rays.size(),
          "the counter of rays is not that of hits");
    stop();
    raypath_driver_acknowledge(&device);
    check(raypath_driver_acknowledge(&device) == 0, "an event that was acknowledged stays");
  }
  void flush() {
    work(below(60));
    is_flushed = true;
    const uint64_t dropped = sent;
    if (chance(4)) raypath_driver_flush(&device);
    else write(RAYPATH_DEVICE_CONTROL, 3, 1);
    for (unsigned k = 0; !raypath_driver_is_drained(&device) || sent < rays.size(); k++)
      check(k < TOO_LONG / 8, "not drained after a flush"), submit(70), take(70);
    while (take(70) > 0) {
    }
    for (size_t k = dropped; k < rays.size(); k++) check(is_taken[k], "a ray after a flush has no hit");
    stop();
  }
  // Rays that were read have their hits in memory, also those that the driver has not seen.
  void disable() {
    work(below(60));
    write(RAYPATH_DEVICE_CONTROL, 0);
    const uint64_t read_before = reads;
    wait_idle(true);
    check(reads == read_before && next_ray == arrived && accepted.size() == arrived && answered == arrived,
          "a ray that was read has no hit in memory");
    check(taken + hit_memory.size() >= accepted.size(), "hits were overwritten");
    while (taken < accepted.size()) check_hit(hit_memory[(FIRST + taken) % hit_memory.size()]);
  }
  void aborted() {
    work(below(60));
    abort();
  }
  void read_error() {
    failing_read = below(rays.size());
    wait_error(RAYPATH_DRIVER_READ);
    for (unsigned k = 0; !(read(RAYPATH_DEVICE_STATUS) & RAYPATH_DEVICE_STATUS_IDLE_MASK); k++)
      check(k < TOO_LONG / 8, "not idle after an error"), take(70);
    while (take(70) > 0) {
    }
    check(!is_taken[failing_read] && taken == arrived - 1, "rays that were read have no hits after an error");
    abort();
  }
  void write_error() {
    failing_write = below(rays.size());
    wait_error(RAYPATH_DRIVER_WRITE);
    for (unsigned k = 0; k < 10; k++) take(70);
    check(taken == failing_write, "hits before a write that failed are not in the ring, or later ones are");
    abort();
  }
  // Rays that were read in time have hits, and those before a write that was not answered in time are in the ring.
  void silence() {
    write(RAYPATH_DEVICE_TIMEOUT, 1 + below(400));
    (chance(4) ? silent_read : silent_write) = below(rays.size());
    wait_error(RAYPATH_DRIVER_RING_TIMEOUT);
    check(read(RAYPATH_DEVICE_STATUS) & RAYPATH_DEVICE_STATUS_RING_TIMED_OUT_MASK, "a timeout is not in the status");
    const bool is_owed = silent_read == arrived || silent_write == answered, flushes = chance(2);
    if (is_owed && flushes)
      expect(raypath_driver_abort(&device, 10), RAYPATH_DRIVER_BUSY, "abort with a memory that is silent");
    is_flushed = is_flushed || flushes;
    silent_read = silent_write = ~0ull;
    if (!flushes) {
      wait_idle(true);
      while (take(70) > 0) {
      }
      check(next_ray == in_time && taken == std::min(answered_in_time, in_time),
            "other hits than those in time are in the ring");
    }
    abort();
  }
  void wrong_software() {
    is_strict = false;
    for (unsigned steps = 1 + below(80); steps > 0; steps--) {
      // Settings, and anything.
      static const uint16_t offsets[] = {0x14, 0x20, 0x40, 0x44, 0x48, 0x4c, 0x60,
                                         0x64, 0x68, 0x6c, 0x80, 0x84, 0x88};
      const uint32_t offset = chance(7) ? offsets[below(13)] : below(4096);
      const uint32_t kinds[] = {below(8),
                                below(70),
                                below(1ull << 32),
                                1u << below(32),
                                FIRST + below(70),
                                top.ray_head_o + below(9),
                                top.hit_tail_o - below(9),
                                0u - below(0x2000),
                                top.ray_head_o + (1u << (top.ray_size_o & 31)) + below(3),
                                top.hit_tail_o - (1u << (top.hit_size_o & 31)) - below(3)};
      const bool is_control = offset == RAYPATH_DEVICE_CONTROL;
      write(offset, is_control && chance(7) ? 1 : kinds[below(10)], chance(6) ? 15 : below(16));
      nonsense++;
      if (chance(2)) read(below(4096));
      for (unsigned wait = chance(4) ? below(200) : 0; wait > 0; wait--) tick();
    }
    // Without a flush, the hits of rays inside need room, or are dropped.
    write(RAYPATH_DEVICE_CONTROL, chance(4) ? RAYPATH_DEVICE_CONTROL_FLUSH_MASK : 0);
    for (unsigned k = 0; !(read(RAYPATH_DEVICE_STATUS) & RAYPATH_DEVICE_STATUS_IDLE_MASK); k++) {
      check(k < TOO_LONG / 8, "not idle after wrong settings");
      write(RAYPATH_DEVICE_HIT_HEAD, read(RAYPATH_DEVICE_HIT_TAIL));
    }
    write(RAYPATH_DEVICE_CONTROL, RAYPATH_DEVICE_CONTROL_CLEAR_ERROR_MASK);
    expect(raypath_driver_error(&device), RAYPATH_DRIVER_OK, "error after clear_error");
    write(RAYPATH_DEVICE_INTERRUPT_ENABLE, 0);
  }

  // The engine alone decides how fast records move.
  void throughput() {
    kind = "throughput", latency = 20, capacity = 16;
    begin(6, 6, 2000);
    const uint64_t start = cycle;
    work_until_taken();
    printf("rings: %.1f cycles a record with a memory of up to 20 cycles\n",
           double(cycle - start) / double(rays.size()));
    stop();
  }

  int run(unsigned episodes) {
    random_bits.seed(seed);
    context.randReset(2), context.randSeed(static_cast<int>(seed));
    top.rst_ni = 1, top.eval();
    top.rst_ni = 0, top.eval(), top.clk_i = 1, top.eval(), top.clk_i = 0, top.eval();
    top.rst_ni = 1, top.s_axi_awvalid = top.s_axi_wvalid = top.s_axi_arvalid = 0;
    const auto read_register = [](void *bench, uint32_t offset) { return static_cast<Bench *>(bench)->read(offset); };
    const auto write_register = [](void *bench, uint32_t offset, uint32_t value) {
      static_cast<Bench *>(bench)->write(offset, value);
    };
    expect(raypath_driver_open(&device, read_register, write_register, this), RAYPATH_DRIVER_OK, "open");
    check(raypath_driver_config(&device, RAYPATH_DEVICE_CONFIG_ADDRESS_BITS_MASK) == ADDRESS_WIDTH - 32,
          "address bits");
    throughput();
    static const struct {
      const char *name;
      void (Bench::*run)();
    } kinds[] = {{"clean", &Bench::clean},
                 {"flush", &Bench::flush},
                 {"disable", &Bench::disable},
                 {"abort", &Bench::aborted},
                 {"read error", &Bench::read_error},
                 {"write error", &Bench::write_error},
                 {"silence", &Bench::silence},
                 {"wrong software", &Bench::wrong_software}};
    for (episode = 1; episode <= episodes; episode++) {
      const auto &chosen = kinds[below(std::size(kinds))];
      kind = chosen.name;
      for (uint32_t *pace : {&bus_pace, &read_pace, &data_pace, &aw_pace, &w_pace, &b_pace, &ray_pace, &hit_pace})
        *pace = chance(4) ? 8 : 1 + below(7);
      latency = chance(4) ? 1 + below(60) : 1, capacity = 1 + below(20), awaits_valid = chance(4);
      begin(below(7), below(7), 1 + below(200));
      (this->*chosen.run)();
    }
    printf("rings: data %u, addresses %u bits, seed %u: %u episodes, %lu cycles, %lu hits, %lu requests, %lu writes of "
           "nonsense, "
           "errors 1 to 5, timeouts: %lu %lu %lu %lu %lu %lu: passed\n",
           DATA_WIDTH, ADDRESS_WIDTH, seed, episodes, cycle, records, requests, nonsense, errors[1], errors[2],
           errors[3], errors[4], errors[5], errors[7]);
    return 0;
  }
};

int main(int count, char **arguments) {
  static Bench bench;
  bench.context.commandArgs(count, arguments);
  bench.seed = count > 2 ? static_cast<unsigned>(atoi(arguments[2])) : 1;
  return bench.run(count > 1 ? static_cast<unsigned>(atoi(arguments[1])) : 300);
}
