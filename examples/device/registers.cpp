// SPDX-License-Identifier: MIT OR Apache-2.0
// Compares raypath_device_registers with PeakRDL's block of the same RDL: the same accesses, with stalls of their own
// on all channels, must read the same and leave the same settings, interrupts and numbers of pulses.
//
//   registers [ROUNDS [SEED]]

#include <Vregisters.h>
#include <verilated.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <set>
#include <vector>

#include "raypath_device_registers.h"

static std::mt19937_64 random_bits;
static uint32_t below(uint32_t bound) { return static_cast<uint32_t>(random_bits() % bound); }

struct Access {
  bool is_write;
  uint32_t address, data, strobe;
};

// One bus: the accesses in order, each phase at any time. `serial`: an access begins when the one before it has ended.
struct Bus {
  int which;
  bool serial;
  std::vector<Access> accesses;
  std::vector<uint32_t> values;
  size_t aw, w, b, ar, r;
  bool aw_waits, w_waits, ar_waits;

  void begin(const std::vector<Access> &all, bool is_serial) {
    accesses = all;
    serial = is_serial;
    values.assign(all.size(), 0);
    aw = w = b = ar = r = 0;
    skip();
  }
  size_t next(size_t k, bool is_write) const {
    while (k < accesses.size() && accesses[k].is_write != is_write) k++;
    return k;
  }
  void skip() { aw = next(aw, true), w = next(w, true), b = next(b, true), ar = next(ar, false), r = next(r, false); }
  bool ends() const { return b == accesses.size() && r == accesses.size(); }
  // Whether the phase of access `k` may begin.
  bool may(size_t k) const { return k < accesses.size() && (!serial || k == std::min(b, r)); }

  void drive(Vregisters &top, uint32_t pace) {
    auto set = [&](CData &port, bool value) { port = static_cast<CData>((port & ~(1 << which)) | (value << which)); };
    aw_waits = may(aw) && (aw_waits || below(8) < pace);
    w_waits = may(w) && (w_waits || below(8) < pace);
    ar_waits = may(ar) && (ar_waits || below(8) < pace);
    set(top.awvalid_i, aw_waits), set(top.wvalid_i, w_waits), set(top.arvalid_i, ar_waits);
    set(top.bready_i, below(8) < pace), set(top.rready_i, below(8) < pace);
    top.awaddr_i[which] = aw_waits ? accesses[aw].address : below(4096);
    top.wdata_i[which] = w_waits ? accesses[w].data : static_cast<uint32_t>(random_bits());
    top.wstrb_i[which] = w_waits ? accesses[w].strobe : below(16);
    top.araddr_i[which] = ar_waits ? accesses[ar].address : below(4096);
  }
  // What the edge takes. Returns false after a wrong answer.
  bool take(const Vregisters &top) {
    auto bit = [&](CData port) { return port >> which & 1; };
    bool good = true;
    if (aw_waits && bit(top.awready_o)) aw++, aw_waits = false;
    if (w_waits && bit(top.wready_o)) w++, w_waits = false;
    if (ar_waits && bit(top.arready_o)) ar++, ar_waits = false;
    if (bit(top.bvalid_o) && bit(top.bready_i)) good = good && b < std::min(aw, w) && top.bresp_o[which] == 0, b++;
    if (bit(top.rvalid_o) && bit(top.rready_i)) {
      good = good && r < ar && top.rresp_o[which] == 0;
      if (good) values[r] = top.rdata_o[which];
      r++;
    }
    skip();
    return good;
  }
};

int main(int count, char **arguments) {
  const unsigned rounds = count > 1 ? static_cast<unsigned>(atoi(arguments[1])) : 3000;
  const unsigned seed = count > 2 ? static_cast<unsigned>(atoi(arguments[2])) : 1;
  random_bits.seed(seed);
  VerilatedContext context;
  context.randReset(2);
  Vregisters top(&context);
  Bus buses[2] = {};
  buses[1].which = 1;
  uint64_t pulses[2][3] = {}, reads = 0, writes = 0, cycles = 0;
  bool good = true;

  auto cycle = [&] {
    top.clk_i = 0, top.eval();
    for (Bus &bus : buses) {
      good = bus.take(top) && good;
      for (int k = 0; k < 3; k++) pulses[bus.which][k] += top.pulses_o[bus.which] >> k & 1;
    }
    top.clk_i = 1, top.eval();
    cycles++;
  };
  auto quiet = [&](unsigned number) {
    for (unsigned k = 0; k < number; k++) {
      for (Bus &bus : buses) bus.drive(top, 8);
      cycle();
    }
  };
  for (Bus &bus : buses) bus.begin({}, true);
  top.rst_ni = 1, top.eval();
  top.rst_ni = 0, quiet(4);
  top.rst_ni = 1, memset(pulses, 0, sizeof pulses), good = true;

  for (unsigned round = 0; round < rounds && good; round++) {
    // The state changes while no access is under way.
    for (unsigned k = below(4); k > 0; k--) {
      for (uint32_t &word : top.status_i.m_storage) word = static_cast<uint32_t>(random_bits());
      top.status_i[5] &= 0x1f;
      top.levels_i = below(8);
      top.events_i = random_bits() & ((1ull << 39) - 1);
      quiet(1);
    }
    top.events_i = 0;
    quiet(2);

    const bool serial = below(2);
    std::vector<Access> accesses(1 + below(20));
    std::set<uint32_t> written;
    for (Access &access : accesses) {
      // Registers, their neighbours, and anything.
      const uint32_t address = below(8) ? below(0x170) : below(4096);
      access = {below(2) != 0, address, static_cast<uint32_t>(random_bits()), below(2) ? 15 : below(16)};
      if (below(8) == 0) access.address = RAYPATH_DEVICE_CONTROL + below(4);
      if (below(8) == 0) access.address = RAYPATH_DEVICE_INTERRUPT_STATUS + 4 * below(3);
      if (access.is_write) written.insert(access.address & ~3u);
    }
    // Reads that overtake writes, or that writes overtake, read something else.
    if (!serial)
      for (Access &access : accesses) {
        const uint32_t word = access.address & ~3u;
        const bool counts = word >= RAYPATH_DEVICE_COUNT_CYCLES && written.count(RAYPATH_DEVICE_CONTROL);
        if (!access.is_write && (written.count(word) || counts)) access.address = RAYPATH_DEVICE_CONFIG;
        // PeakRDL's pulse lasts longer if the next cycle writes other bytes of its register.
        if (word == RAYPATH_DEVICE_CONTROL) access.strobe |= 1;
      }
    const uint32_t pace = 1 + below(8);
    for (Bus &bus : buses) bus.begin(accesses, serial);
    for (unsigned k = 0; !(buses[0].ends() && buses[1].ends()) && good; k++) {
      for (Bus &bus : buses) bus.drive(top, pace);
      cycle();
      if (k == 100000) printf("round %u: found no answer for 100000 cycles\n", round), good = false;
    }
    quiet(3);
    for (size_t k = 0; k < accesses.size(); k++) {
      (accesses[k].is_write ? writes : reads)++;
      if (buses[0].values[k] == buses[1].values[k]) continue;
      printf("round %u: read of 0x%03x: found 0x%08x, expected 0x%08x\n", round, accesses[k].address,
             buses[0].values[k], buses[1].values[k]);
      good = false;
    }
    if (memcmp(&top.settings_o[0], &top.settings_o[1], sizeof top.settings_o[0]) != 0)
      printf("round %u: settings or the interrupt differ\n", round), good = false;
    if (memcmp(pulses[0], pulses[1], sizeof pulses[0]) != 0) printf("round %u: pulses differ\n", round), good = false;
  }
  printf("registers: %lu writes, %lu reads, %lu pulses, %lu cycles, seed %u: %s\n", writes, reads,
         pulses[0][0] + pulses[0][1] + pulses[0][2], cycles, seed, good ? "equal to PeakRDL's" : "FAILED");
  return good ? 0 : 1;
}
