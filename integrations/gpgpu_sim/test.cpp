// The unit beside the table of latencies that it replaces, in a host loop like that of Vulkan-Sim's `rt_unit`.
#include "../check.hpp"
#include "raypath_rt_unit.hpp"

#include <algorithm>
#include <array>
#include <random>

using raypath::gpgpu_sim::NodeWork;
using raypath::gpgpu_sim::RtUnit;
using Cycle = std::uint64_t;

namespace {

enum NodeType { Structure, Internal, Instance, Descriptor, Quad, QuadHit, Procedural, NodeTypes };

// The table that Vulkan-Sim's configurations give: cycles of a node of each type.
constexpr std::array<unsigned, NodeTypes> table = {4, 8, 8, 4, 8, 8, 8};

// An internal node has six children, a quad leaf one triangle. The datapath does nothing else.
std::vector<NodeWork> work() {
  std::vector<NodeWork> work(NodeTypes);
  for (unsigned type = 0; type < NodeTypes; ++type) work[type].fixed = table[type];
  work[Internal] = {2, 0, 0};
  work[Quad] = work[QuadHit] = {0, 1, 0};
  return work;
}

constexpr const char *paper = "";
constexpr Cycle latency = 12;

struct Arrival {
  Cycle cycle;
  NodeType type;
};

/// Issues nodes in the cycles in which they arrive. Returns the cycle in which each retires.
std::vector<Cycle> run(RtUnit<std::size_t> &unit, const std::vector<Arrival> &arrivals) {
  std::vector<Cycle> retired(arrivals.size());
  std::size_t issued = 0;
  for (Cycle cycle = 0; issued < arrivals.size() || !unit.empty(); ++cycle) {
    while (const auto node = unit.retire()) retired[*node] = cycle;
    for (; issued < arrivals.size() && arrivals[issued].cycle == cycle; ++issued) {
      unit.issue(issued, arrivals[issued].type);
    }
    unit.cycle();
  }
  return retired;
}

std::vector<Cycle> run_fresh(const std::vector<Arrival> &arrivals, std::size_t count = 1) {
  RtUnit<std::size_t> unit(work(), pipelines(paper, count));
  return run(unit, arrivals);
}

std::vector<Arrival> at_once(std::size_t count, NodeType type) { return std::vector<Arrival>(count, {0, type}); }

void one_node() {
  CHECK_EQUAL(run_fresh(at_once(1, Quad))[0], latency);
  // The second job enters a cycle later.
  CHECK_EQUAL(run_fresh(at_once(1, Internal))[0], latency + 1);
  // Work outside the datapath takes the cycles of the table.
  CHECK_EQUAL(run_fresh(at_once(1, Instance))[0], table[Instance]);
}

/// All threads of a warp test at once. The table returns all in cycle 8; one datapath accepts a job per cycle.
void warp() {
  RtUnit<std::size_t> unit(work(), pipelines(paper, 1));
  const auto retired = run(unit, at_once(32, Quad));
  for (std::size_t thread = 0; thread < 32; ++thread) CHECK_EQUAL(retired[thread], latency + thread);
  CHECK_EQUAL(unit.counters().jobs, 32u);
  CHECK_EQUAL(unit.counters().waiting, 31u * 32 / 2);
  CHECK_EQUAL(unit.counters().stalls, 0u);
  // With four datapaths, four threads at a time.
  const auto four = run_fresh(at_once(32, Quad), 4);
  for (std::size_t thread = 0; thread < 32; ++thread) CHECK_EQUAL(four[thread], latency + thread / 4);
}

/// Half of the threads test boxes, half triangles. The two share the pipeline, which the table does not know.
void boxes_and_triangles() {
  auto arrivals = at_once(32, Internal);
  for (std::size_t thread = 1; thread < 32; thread += 2) arrivals[thread].type = Quad;
  const auto retired = run_fresh(arrivals);
  // A pair of threads has three jobs: two of boxes, one of a triangle.
  for (std::size_t thread = 0; thread < 32; ++thread) {
    const Cycle last_job = 3 * (thread / 2) + (thread % 2 == 0 ? 1 : 2);
    CHECK_EQUAL(retired[thread], latency + last_job);
  }
}

/// The host retires nothing until cycle 100. The pipeline fills: 24 jobs with skid buffers, 13 with credits.
void back_pressure() {
  struct Case {
    const char *configuration;
    std::uint64_t capacity;
  };
  for (const Case &of : {Case{paper, 24}, Case{"preset = \"credit\"", 13}}) {
    RtUnit<std::size_t> unit(work(), pipelines(of.configuration, 1));
    for (std::size_t thread = 0; thread < 32; ++thread) unit.issue(thread, Quad);
    for (Cycle cycle = 0; cycle < 100; ++cycle) unit.cycle();
    CHECK_EQUAL(unit.counters().jobs, of.capacity);
    CHECK_EQUAL(unit.counters().stalls, 100 - of.capacity);
    // Then a job leaves in each cycle, also those that could not enter before.
    for (std::size_t thread = 0; thread < 32; ++thread) {
      CHECK_EQUAL(unit.retire().value_or(99), thread);
      CHECK_EQUAL(unit.retire().has_value(), false);
      unit.cycle();
    }
    CHECK_EQUAL(unit.empty(), true);
  }
}

/// Random arrivals against the rules: jobs enter in order, one in a cycle and datapath, and leave `latency` later.
void random_arrivals() {
  std::mt19937 random(1);
  for (const std::size_t count : {1u, 3u}) {
    std::vector<Arrival> arrivals;
    std::vector<Cycle> entered, expected;
    Cycle cycle = 0;
    for (int node = 0; node < 2000; ++node) {
      // In turn too many and too few for the pipelines.
      cycle += random() % (node / 100 % 2 == 0 ? 2 : 6);
      const auto type = static_cast<NodeType>(random() % NodeTypes);
      arrivals.push_back({cycle, type});
      const NodeWork of = work()[type];
      Cycle last = cycle;
      for (unsigned job = 0; job < of.quadboxes + of.triangles; ++job) {
        Cycle enters = cycle;
        if (entered.size() >= count) enters = std::max(enters, entered[entered.size() - count] + 1);
        entered.push_back(enters);
        last = enters + latency;
      }
      expected.push_back(last + of.fixed);
    }
    const auto retired = run_fresh(arrivals, count);
    for (std::size_t node = 0; node < arrivals.size(); ++node) CHECK_EQUAL(retired[node], expected[node]);
  }
}

/// What the host calls for a node's tests: the table, in which a thread counts its cycles down.
class Table {
 public:
  void issue(std::size_t thread, std::size_t type) { done_.emplace(cycle_ + table[type], thread); }
  std::optional<std::size_t> retire() {
    if (done_.empty() || done_.begin()->first > cycle_) return std::nullopt;
    const std::size_t thread = done_.begin()->second;
    done_.erase(done_.begin());
    return thread;
  }
  void cycle() { ++cycle_; }

 private:
  Cycle cycle_ = 0;
  std::multimap<Cycle, std::size_t> done_;
};

/// A host like `rt_unit`: each thread of a warp walks through its nodes, on each level one of so many addresses; a
/// request to memory serves all threads of the warp that want the address; one response arrives in a cycle. Returns the
/// cycles until all threads are done.
template <typename Unit>
Cycle traverse(Unit &unit, std::size_t warps, std::uint32_t addresses) {
  constexpr std::size_t warp_size = 32;
  constexpr Cycle memory_latency = 40;
  struct Record {
    std::uint32_t address;
    NodeType type;
  };
  enum State { Ready, Waits, Tests };
  struct Thread {
    std::deque<Record> records;
    State state = Ready;
  };
  struct Response {
    Cycle cycle;
    std::size_t warp;
    std::uint32_t address;
  };
  std::mt19937 random(2);
  std::vector<Thread> threads(warps * warp_size);
  std::size_t running = threads.size();
  for (Thread &thread : threads) {
    for (std::uint32_t depth = 0; depth < 24; ++depth) {
      const bool is_leaf = depth % 6 == 5;
      const std::uint32_t address = depth << 16 | random() % addresses;
      thread.records.push_back({address, is_leaf ? Quad : Internal});
    }
  }
  std::deque<Response> responses;
  for (Cycle cycle = 0;; ++cycle) {
    while (const auto id = unit.retire()) {
      Thread &thread = threads[*id];
      thread.state = Ready;
      if (thread.records.empty()) --running;
    }
    if (running == 0) return cycle;
    if (!responses.empty() && responses.front().cycle <= cycle) {
      const Response response = responses.front();
      responses.pop_front();
      for (std::size_t id = response.warp * warp_size; id < (response.warp + 1) * warp_size; ++id) {
        Thread &thread = threads[id];
        if (thread.state != Waits || thread.records.front().address != response.address) continue;
        thread.state = Tests;
        unit.issue(id, thread.records.front().type);
        thread.records.pop_front();
      }
    }
    const auto ready = std::find_if(threads.begin(), threads.end(), [](const Thread &thread) {
      return thread.state == Ready && !thread.records.empty();
    });
    if (ready != threads.end()) {
      const std::size_t warp = static_cast<std::size_t>(ready - threads.begin()) / warp_size;
      const std::uint32_t address = ready->records.front().address;
      for (std::size_t id = warp * warp_size; id < (warp + 1) * warp_size; ++id) {
        Thread &thread = threads[id];
        const bool wants = thread.state == Ready && !thread.records.empty() && thread.records.front().address == address;
        if (wants) thread.state = Waits;
      }
      responses.push_back({cycle + memory_latency, warp, address});
    }
    unit.cycle();
  }
}

/// The same traversals by the table and by datapaths. The page shows the figures.
void comparison(const std::string &page) {
  for (const std::uint32_t addresses : {1u, 4u, 32u}) {
    constexpr std::size_t warps = 4;
    const auto cycles = [&](std::size_t count) {
      RtUnit<std::size_t> unit(work(), pipelines(paper, count));
      const Cycle cycles = traverse(unit, warps, addresses);
      // 20 internal nodes of two jobs and 4 leaves for each thread: no fewer cycles than jobs.
      constexpr Cycle jobs = warps * 32 * (20 * 2 + 4);
      CHECK_EQUAL(unit.counters().jobs, jobs);
      CHECK_EQUAL(cycles >= jobs / count + latency, true);
      return cycles;
    };
    Table table;
    check_row(page, addresses, traverse(table, warps, addresses), cycles(1), cycles(2), cycles(4), cycles(8), cycles(32));
  }
}

}  // namespace

/// The argument is the adapter's page.
int main(int argc, char **argv) {
  CHECK_EQUAL(argc, 2);
  one_node();
  warp();
  boxes_and_triangles();
  back_pressure();
  random_arrivals();
  comparison(read_file(argv[1]));
}
