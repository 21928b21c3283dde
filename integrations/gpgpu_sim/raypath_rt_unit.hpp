// The intersection tests of a ray-tracing unit in GPGPU-Sim style (Vulkan-Sim, Accel-Sim), timed by the datapath.
// docs/integration/gpgpu-sim.md names the lines of the host that call it.
#pragma once

#include <raypath.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <iterator>
#include <list>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace raypath::gpgpu_sim {

/// The work of a node of one type.
struct NodeWork {
  /// Jobs of a ray against four boxes.
  unsigned quadboxes = 0;
  /// Jobs of a ray against a triangle.
  unsigned triangles = 0;
  /// Cycles after the last job, for work outside the datapath such as the transformation of a ray. Any number of nodes
  /// can be in these cycles at a time, as in the host's table.
  unsigned fixed = 0;
};

/// Sums since the unit was made.
struct Counters {
  std::uint64_t cycles = 0;
  std::uint64_t jobs = 0;
  /// Jobs that waited for a pipeline, summed over all cycles.
  std::uint64_t waiting = 0;
  /// Pipelines that had a job to accept and did not, because the host had not taken their outcomes, summed over all
  /// cycles.
  std::uint64_t stalls = 0;
};

/// A unit with one pipeline or several. `cycle` is the clock edge; `issue` and `retire` act in the cycle before it. A
/// node of one job that is issued in cycle c to an idle unit retires in cycle c + latency.
///
/// `Record` identifies the node to the host, for example by warp and thread.
template <typename Record>
class RtUnit {
 public:
  /// `work` has an entry for each type of node. The pipelines are empty, and all of the same configuration.
  RtUnit(std::vector<NodeWork> work, std::vector<Pipeline> pipelines) : work_(std::move(work)) {
    for (Pipeline &pipeline : pipelines) lanes_.push_back({std::move(pipeline), {}, false});
  }

  /// Begins the tests of a node whose data have arrived. Throws `std::out_of_range` for a type without an entry.
  void issue(Record record, std::size_t type) {
    const NodeWork &work = work_.at(type);
    nodes_.push_back({std::move(record), work.quadboxes + work.triangles, work.fixed});
    const auto node = std::prev(nodes_.end());
    for (unsigned i = 0; i < work.quadboxes; ++i) waiting_.push_back({node, RAYPATH_JOB_QUADBOX});
    for (unsigned i = 0; i < work.triangles; ++i) waiting_.push_back({node, RAYPATH_JOB_TRIANGLE});
    if (node->jobs == 0) finish(node);
  }

  /// A node whose tests are complete in this cycle. Call it in every cycle until it returns nothing: it is the sink of
  /// the pipelines, which stall in a cycle without the call.
  std::optional<Record> retire() {
    for (Lane &lane : lanes_) {
      if (lane.taken || !lane.pipeline.output_valid()) continue;
      lane.taken = true;
      if (--lane.inside.front()->jobs == 0) finish(lane.inside.front());
      lane.inside.pop_front();
    }
    if (finished_.empty() || finished_.begin()->first > counters_.cycles) return std::nullopt;
    const auto node = finished_.begin()->second;
    finished_.erase(finished_.begin());
    std::optional<Record> record(std::move(node->record));
    nodes_.erase(node);
    return record;
  }

  /// The clock edge. Throws `std::runtime_error` if the datapath lacks an operation.
  void cycle() {
    for (Lane &lane : lanes_) {
      if (!waiting_.empty()) {
        const auto accepted = lane.pipeline.offer(timing_job(waiting_.front().opcode), 0);
        if (!accepted) throw std::runtime_error(accepted.error().message);
        if (*accepted) {
          lane.inside.push_back(waiting_.front().node);
          waiting_.pop_front();
          counters_.jobs += 1;
        } else {
          counters_.stalls += 1;
        }
      }
      lane.pipeline.step(lane.taken);
      lane.taken = false;
    }
    counters_.cycles += 1;
    counters_.waiting += waiting_.size();
  }

  /// Whether no node is inside.
  bool empty() const { return nodes_.empty(); }

  const Counters &counters() const { return counters_; }

 private:
  struct Node {
    Record record;
    /// Jobs that have not left their pipeline.
    unsigned jobs;
    unsigned fixed;
  };
  using NodeId = typename std::list<Node>::iterator;
  struct Waiting {
    NodeId node;
    std::uint64_t opcode;
  };
  struct Lane {
    Pipeline pipeline;
    /// The nodes of the jobs inside, oldest first: jobs leave in order.
    std::deque<NodeId> inside;
    /// The outcome of this cycle was taken.
    bool taken;
  };

  void finish(NodeId node) { finished_.emplace(counters_.cycles + node->fixed, node); }

  std::vector<NodeWork> work_;
  std::vector<Lane> lanes_;
  std::list<Node> nodes_;
  std::deque<Waiting> waiting_;
  /// By the cycle in which they may retire; equal cycles in the order of completion.
  std::multimap<std::uint64_t, NodeId> finished_;
  Counters counters_;
};

}  // namespace raypath::gpgpu_sim
