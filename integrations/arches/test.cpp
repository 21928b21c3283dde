// The unit beside the two queues of constant latency that it replaces, in a host loop like that of Arches' `UnitRTCore`.
#include "../check.hpp"
#include "raypath_intersection_unit.hpp"

#include <array>
#include <functional>
#include <queue>
#include <random>
#include <vector>

using raypath::arches::IntersectionUnit;
using Cycle = std::uint64_t;
using Unit = IntersectionUnit<int>;

namespace {

constexpr Cycle latency = 12;
constexpr const char *skid = "", *credit = "preset = \"credit\"";

enum Kind { Box, Triangle };

/// What the host's two queues do: one write for each call of `clock`, readable a constant number of these calls later.
class ConstantLatency {
 public:
  explicit ConstantLatency(Cycle clocks) : clocks_(clocks) {}
  bool is_write_valid() const { return !written_ && entries_.size() < clocks_; }
  void write(int entry) {
    entries_.push({now_ + clocks_, entry});
    written_ = true;
  }
  void clock() {
    now_ += 1;
    written_ = false;
  }
  bool is_read_valid() const { return !entries_.empty() && entries_.front().first <= now_; }
  int read() {
    const int entry = entries_.front().second;
    entries_.pop();
    return entry;
  }

 private:
  Cycle clocks_, now_ = 0;
  bool written_ = false;
  std::queue<std::pair<Cycle, int>> entries_;
};

/// An entry that went through a unit.
struct Passage {
  Kind kind;
  Cycle written, read;
};

/// In each cycle, `wants(kind)` says whether there is an entry to write and `reads(kind)` whether an entry is read if
/// it can be. Returns the entries in the order in which they were written; entries still inside have `read` = 0.
std::vector<Passage> run(const char *configuration, Cycle cycles, const std::function<bool(Cycle, Kind)> &wants,
                         const std::function<bool(Cycle, Kind)> &reads) {
  Unit unit(std::move(pipelines(configuration, 1)[0]));
  std::array<Unit::Port *, 2> ports = {&unit.boxes, &unit.triangles};
  std::vector<Passage> passages;
  for (Cycle cycle = 0; cycle < cycles; ++cycle) {
    unit.clock_rise();
    for (const Kind kind : {Box, Triangle}) {
      Unit::Port &port = *ports[kind];
      if (wants(cycle, kind) && port.is_write_valid()) {
        port.write(static_cast<int>(passages.size()));
        passages.push_back({kind, cycle, 0});
      }
      if (port.is_read_valid() && reads(cycle, kind)) {
        Passage &passage = passages[static_cast<std::size_t>(port.read())];
        CHECK_EQUAL(passage.kind, kind);
        passage.read = cycle;
      }
    }
    unit.clock_fall();
  }
  return passages;
}

bool always(Cycle, Kind) { return true; }

void one_entry() {
  for (const Kind kind : {Box, Triangle}) {
    const auto passages = run(skid, 20, [&](Cycle cycle, Kind of) { return cycle == 3 && of == kind; }, always);
    CHECK_EQUAL(passages.size(), 1u);
    CHECK_EQUAL(passages[0].read, 3 + latency);
  }
}

/// Boxes and triangles want to enter in every cycle: they alternate. Two queues would accept both in every cycle.
void contention() {
  const auto passages = run(skid, 200, always, always);
  CHECK_EQUAL(passages.size(), 200u);
  for (std::size_t i = 0; i < passages.size(); ++i) {
    CHECK_EQUAL(passages[i].kind, i % 2 == 0 ? Box : Triangle);
    CHECK_EQUAL(passages[i].written, i);
    if (i + latency < 200) CHECK_EQUAL(passages[i].read, i + latency);
  }
  // A port that is alone has all cycles.
  const auto boxes = run(skid, 200, [](Cycle, Kind kind) { return kind == Box; }, always);
  CHECK_EQUAL(boxes.size(), 200u);
}

/// Triangles are not read until cycle 100. The first, at the output from cycle 13, blocks the boxes behind it too, and
/// the pipeline fills. Afterwards an entry leaves in each cycle.
void back_pressure() {
  const auto reads = [](Cycle cycle, Kind kind) { return kind == Box || cycle >= 100; };
  for (const char *configuration : {skid, credit}) {
    const std::size_t capacity = configuration == skid ? 24 : 13;
    const auto passages = run(configuration, 300, always, reads);
    std::size_t written_before = 0;
    for (std::size_t i = 0; i < passages.size(); ++i) {
      written_before += passages[i].written < 100;
      if (i == 0) CHECK_EQUAL(passages[i].read, latency);
      if (i > 0 && i < 150) CHECK_EQUAL(passages[i].read, 99 + i);
    }
    // The first box has left.
    CHECK_EQUAL(written_before, capacity + 1);
    // A credit comes back a cycle after an entry has left; skid buffers pass on that they are free from the last to the
    // first, one in a cycle.
    CHECK_EQUAL(passages[capacity + 1].written, configuration == skid ? 100 + latency : 101);
  }
}

/// Random writers and readers against the rule: an entry leaves in the first cycle in which it is read, `latency` after
/// its write or later, and after the entry before it. With credits, the rule of entering is as simple: fewer than 13
/// entries are inside when the cycle begins.
void random_traffic() {
  for (const char *configuration : {skid, credit}) {
    std::mt19937 random(1);
    constexpr Cycle cycles = 5000;
    std::vector<std::array<bool, 2>> wants(cycles), reads(cycles);
    for (Cycle cycle = 0; cycle < cycles; ++cycle) {
      const unsigned phase = cycle / 250 % 4;
      for (const Kind kind : {Box, Triangle}) {
        wants[cycle][kind] = random() % 4 < (phase % 2 == 0 ? 3u : 1u);
        reads[cycle][kind] = random() % 4 < (phase < 2 ? 3u : 1u);
      }
    }
    const auto passages = run(
        configuration, cycles, [&](Cycle cycle, Kind kind) { return wants[cycle][kind]; },
        [&](Cycle cycle, Kind kind) { return reads[cycle][kind]; });
    CHECK_EQUAL(passages.size() > 1000, true);
    Cycle before = 0;
    for (const Passage &passage : passages) {
      Cycle leaves = std::max(passage.written + latency, before + 1);
      while (leaves < cycles && !reads[leaves][passage.kind]) ++leaves;
      CHECK_EQUAL(passage.read, leaves < cycles ? leaves : 0);
      before = leaves;
    }
    if (configuration == skid) continue;
    std::size_t entered = 0;
    for (Cycle cycle = 0; cycle < cycles; ++cycle) {
      std::size_t inside = 0;
      for (std::size_t i = 0; i < entered; ++i) inside += passages[i].read == 0 || passages[i].read >= cycle;
      const bool written = entered < passages.size() && passages[entered].written == cycle;
      const bool wanted = wants[cycle][Box] || wants[cycle][Triangle];
      // A reserved cycle may pass unused, because this source does not insist.
      if (written) CHECK_EQUAL(inside < 13, true);
      if (wants[cycle][Box] && wants[cycle][Triangle]) CHECK_EQUAL(written, inside < 13);
      if (!wanted) CHECK_EQUAL(written, false);
      entered += written;
    }
  }
}

/// The node and triangle pipelines of the host with its constants: 12 and 22 calls of `clock`, which it makes twice in
/// a cycle. A node of up to eight boxes is one write.
struct HostPipelines {
  static constexpr unsigned boxes_per_write = 8, passes = 2;
  ConstantLatency queues[2] = {ConstantLatency(12), ConstantLatency(22)};
  void clock_rise() {}
  void clock_fall() {}
  ConstantLatency &port(Kind kind) { return queues[kind]; }
  void clock(Kind kind) { queues[kind].clock(); }
};

/// The shared pipeline. A node of up to four boxes is one write.
struct SharedPipeline {
  static constexpr unsigned boxes_per_write = 4, passes = 1;
  Unit unit{std::move(pipelines(skid, 1)[0])};
  void clock_rise() { unit.clock_rise(); }
  void clock_fall() { unit.clock_fall(); }
  Unit::Port &port(Kind kind) { return kind == Box ? unit.boxes : unit.triangles; }
  void clock(Kind) {}
};

/// A core with `in_flight` rays, each of which fetches and tests `visits` nodes, every fifth a leaf of `triangles`
/// triangles. A fetch takes 20 cycles. Returns the cycles until 1024 rays are done.
template <typename Pipelines>
Cycle trace(std::size_t in_flight, unsigned boxes, unsigned triangles) {
  constexpr unsigned visits = 20, rays = 1024;
  constexpr Cycle fetch = 20;
  Pipelines pipelines;
  std::vector<unsigned> visited(in_flight, 0);
  std::queue<std::pair<Cycle, int>> fetches;
  std::array<std::queue<int>, 2> tests;
  std::array<unsigned, 2> issued = {0, 0};
  unsigned started = 0, done = 0;
  const auto schedule = [&](Cycle cycle, int ray) {
    unsigned &count = visited[static_cast<std::size_t>(ray)];
    if (count == visits) {
      ++done;
      if (started == rays) return;
      ++started;
      count = 0;
    }
    fetches.push({cycle + fetch, ray});
  };
  for (Cycle cycle = 0;; ++cycle) {
    if (cycle < in_flight) {
      ++started;
      fetches.push({cycle + fetch, static_cast<int>(cycle)});
    }
    if (!fetches.empty() && fetches.front().first <= cycle) {
      const int ray = fetches.front().second;
      fetches.pop();
      const bool is_leaf = ++visited[static_cast<std::size_t>(ray)] % 5 == 0;
      tests[is_leaf ? Triangle : Box].push(ray);
    }
    pipelines.clock_rise();
    for (unsigned pass = 0; pass < Pipelines::passes; ++pass) {
      for (const Kind kind : {Box, Triangle}) {
        auto &port = pipelines.port(kind);
        if (!tests[kind].empty() && port.is_write_valid()) {
          // All writes of a node but the last carry no ray.
          issued[kind] += kind == Box ? Pipelines::boxes_per_write : 1;
          const bool is_last = issued[kind] >= (kind == Box ? boxes : triangles);
          port.write(is_last ? tests[kind].front() : -1);
          if (is_last) {
            tests[kind].pop();
            issued[kind] = 0;
          }
        }
        pipelines.clock(kind);
        if (port.is_read_valid()) {
          const int ray = port.read();
          if (ray >= 0) schedule(cycle, ray);
        }
      }
    }
    pipelines.clock_fall();
    if (done == rays) return cycle;
  }
}

/// The same rays by both. The page shows the figures.
void comparison(const std::string &page) {
  for (const std::size_t in_flight : {1u, 16u, 128u}) {
    for (const auto &[boxes, triangles] : {std::pair{4u, 1u}, std::pair{8u, 3u}}) {
      const Cycle shared = trace<SharedPipeline>(in_flight, boxes, triangles);
      // 16 nodes and 4 leaves for each ray: no fewer cycles than jobs.
      CHECK_EQUAL(shared >= 1024 * (16 * (boxes / 4) + 4 * triangles), true);
      check_row(page, in_flight, boxes, triangles, trace<HostPipelines>(in_flight, boxes, triangles), shared);
    }
  }
}

}  // namespace

/// The argument is the adapter's page.
int main(int argc, char **argv) {
  CHECK_EQUAL(argc, 2);
  one_entry();
  contention();
  back_pressure();
  random_traffic();
  comparison(read_file(argv[1]));
}
