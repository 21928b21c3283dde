// The datapath in an event-driven simulator in gem5 style: events only in cycles in which something can happen.
// docs/integration/gem5.md shows a `ClockedObject` around it.
#pragma once

#include <raypath.hpp>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

namespace raypath::gem5 {

/// What the unit needs from the object that owns it. Cycles are those of that object's clock.
class Host {
 public:
  virtual ~Host() = default;
  /// The current cycle: `curCycle()`.
  virtual std::uint64_t current_cycle() const = 0;
  /// Calls `EventUnit::edge` in this cycle, instead of in the one that was scheduled before:
  /// `reschedule(event, clockEdge(Cycles(cycle - curCycle())), true)`. The event must come after those in which jobs
  /// are requested in the same cycle, so it has a later priority, for example `CPU_Tick_Pri`.
  virtual void schedule_edge(std::uint64_t cycle) = 0;
  /// Whether `receive` may be called in this cycle. If not, the host calls `EventUnit::response_retry` later.
  virtual bool can_receive() = 0;
  /// Takes an outcome with its tag. A job that is requested in this call belongs to the next cycle.
  virtual void receive(const Result &result) = 0;
  /// A job like the one that was refused can be requested in the next cycle.
  virtual void request_retry() = 0;
};

/// A datapath between events. A job that is requested in cycle c of an idle unit is received in cycle c + latency.
class EventUnit {
 public:
  /// The pipeline is empty; `latency` is that of its datapath.
  EventUnit(Pipeline pipeline, std::uint64_t latency, Host &host)
      : host_(host), pipeline_(std::move(pipeline)), latency_(latency) {}

  /// Offers a job in the current cycle: whether it is accepted. If not, `Host::request_retry` follows. An error is one
  /// of `Pipeline::offer`.
  Expected<bool> request(const Job &job, std::uint64_t tag) {
    const std::uint64_t now = host_.current_cycle();
    advance(now);
    // After the edge of this cycle, the pipeline is in the next.
    const Expected<bool> accepted = cycle_ > now ? false : pipeline_.offer(job, tag);
    if (!accepted) return accepted;
    if (*accepted) {
      earliest_.push_back(now + latency_);
      schedule(std::max(earliest_.front(), cycle_));
    } else {
      refused_ = opcode(job);
      schedule(cycle_);
    }
    return accepted;
  }

  /// The clock edge of the current cycle: the scheduled event.
  void edge() {
    scheduled_.reset();
    const std::uint64_t now = host_.current_cycle();
    advance(now);
    if (cycle_ > now) return;
    blocked_ = pipeline_.output_valid() && !host_.can_receive();
    const auto result = pipeline_.step(!blocked_);
    cycle_ = now + 1;
    if (result) {
      earliest_.pop_front();
      host_.receive(*result);
    }
    if (refused_ && pipeline_.input_ready(*refused_)) {
      refused_.reset();
      host_.request_retry();
    }
    if (refused_) {
      schedule(cycle_);
    } else if (!blocked_ && !earliest_.empty()) {
      schedule(std::max(earliest_.front(), cycle_));
    }
  }

  /// The host can receive again.
  void response_retry() { schedule(std::max(cycle_, host_.current_cycle())); }

  /// The number of jobs inside.
  std::size_t occupancy() const { return earliest_.size(); }

 private:
  /// Brings the pipeline to this cycle, unless it is there or beyond.
  void advance(std::uint64_t cycle) {
    while (cycle_ < cycle) {
      cycle_ += pipeline_.skip(cycle - cycle_);
      // An outcome has waited since then: the host was not ready.
      if (cycle_ < cycle) {
        pipeline_.step(false);
        cycle_ += 1;
      }
    }
  }

  void schedule(std::uint64_t cycle) {
    if (scheduled_ && *scheduled_ <= cycle) return;
    scheduled_ = cycle;
    host_.schedule_edge(cycle);
  }

  static std::uint64_t opcode(const Job &job) {
    const bool names_opcode = job.kind == RAYPATH_JOB_WORDS || job.kind == RAYPATH_JOB_TIMING;
    return names_opcode ? job.input.words.opcode : static_cast<std::uint64_t>(job.kind);
  }

  Host &host_;
  Pipeline pipeline_;
  const std::uint64_t latency_;
  /// The cycle that the pipeline is in.
  std::uint64_t cycle_ = 0;
  /// For each job inside, oldest first, the first cycle in which it can be at the output.
  std::deque<std::uint64_t> earliest_;
  /// The cycle of the event.
  std::optional<std::uint64_t> scheduled_;
  /// The opcode of a job that was refused and not asked for again.
  std::optional<std::uint64_t> refused_;
  /// In the last edge, the host could not receive.
  bool blocked_ = false;
};

}  // namespace raypath::gem5
