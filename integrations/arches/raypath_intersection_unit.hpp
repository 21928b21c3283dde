// The intersection pipeline of a ray-tracing core in Arches style, timed by the datapath: boxes and triangles share it.
// docs/integration/arches.md names the lines of the host that call it.
#pragma once

#include <raypath.hpp>

#include <cassert>
#include <deque>
#include <optional>
#include <stdexcept>
#include <utility>

namespace raypath::arches {

/// One pipeline with a port for boxes and a port for triangles. A port has the calls of the host's `LatencyFIFO`.
///
/// A cycle is `clock_rise`, then calls of the ports, then `clock_fall`, which is the clock edge. An entry that is
/// written in cycle c to an empty unit can be read in cycle c + latency. Both ports together write one entry in a
/// cycle; if both want to, they alternate.
template <typename T>
class IntersectionUnit {
  /// The opcode of a port's jobs.
  enum class Kind { Triangle = RAYPATH_JOB_TRIANGLE, Box = RAYPATH_JOB_QUADBOX };

 public:
  class Port {
   public:
    /// Whether `write` is possible in this cycle. Ask only with an entry to write: if the other port has written in
    /// this cycle, the next cycle is reserved for this port.
    bool is_write_valid() {
      if (unit_.writer_) {
        if (*unit_.writer_ != kind_) unit_.next_ = kind_;
        return false;
      }
      const bool may_write = !unit_.reserved_ || *unit_.reserved_ == kind_;
      return may_write && unit_.pipeline_.input_ready(static_cast<unsigned>(kind_));
    }

    /// Puts in a job: four boxes or one triangle. Throws `std::runtime_error` if the datapath lacks the operation.
    void write(const T &entry) {
      assert(is_write_valid());
      const auto accepted = unit_.pipeline_.offer(timing_job(static_cast<unsigned>(kind_)), 0);
      if (!accepted) throw std::runtime_error(accepted.error().message);
      assert(*accepted);
      unit_.inside_.emplace_back(kind_, entry);
      unit_.writer_ = kind_;
    }

    /// Whether an entry of this port is at the output in this cycle. Entries leave in the order in which both ports
    /// have written them, so an entry that is not read blocks the entries of both.
    bool is_read_valid() const {
      return !unit_.taken_ && unit_.pipeline_.output_valid() && unit_.inside_.front().first == kind_;
    }

    T &peek() {
      assert(is_read_valid());
      return unit_.inside_.front().second;
    }

    T read() {
      T entry = std::move(peek());
      unit_.inside_.pop_front();
      unit_.taken_ = true;
      return entry;
    }

   private:
    friend class IntersectionUnit;
    Port(IntersectionUnit &unit, Kind kind) : unit_(unit), kind_(kind) {}
    IntersectionUnit &unit_;
    const Kind kind_;
  };

  /// The pipeline is empty.
  explicit IntersectionUnit(Pipeline pipeline) : pipeline_(std::move(pipeline)) {}
  // The ports refer to the unit.
  IntersectionUnit(const IntersectionUnit &) = delete;
  IntersectionUnit &operator=(const IntersectionUnit &) = delete;

  /// Begins a cycle.
  void clock_rise() {
    reserved_ = std::exchange(next_, std::nullopt);
    writer_.reset();
    taken_ = false;
  }

  /// Ends a cycle.
  void clock_fall() { pipeline_.step(taken_); }

  /// Whether no entry is inside.
  bool empty() const { return inside_.empty(); }

 private:
  Pipeline pipeline_;
  /// The entries that were written and not read, oldest first.
  std::deque<std::pair<Kind, T>> inside_;
  /// The port that has written in this cycle, the one that it is reserved for, and that of the next cycle.
  std::optional<Kind> writer_, reserved_, next_;
  /// The entry at the output was read in this cycle.
  bool taken_ = false;

 public:
  Port boxes{*this, Kind::Box}, triangles{*this, Kind::Triangle};
};

}  // namespace raypath::arches
