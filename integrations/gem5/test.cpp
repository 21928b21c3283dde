// The event-driven unit against a loop over all cycles, with an event queue of our own like that of gem5.
#include "../check.hpp"
#include "raypath_event_unit.hpp"

#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <tuple>
#include <vector>

using raypath::Datapath;
using raypath::Pipeline;
using raypath::gem5::EventUnit;
using Cycle = std::uint64_t;

namespace {

constexpr Cycle latency = 12;

/// Events by tick, then by priority; of these, the one that was scheduled last comes first, as in gem5.
class EventQueue {
 public:
  using Event = std::tuple<Cycle, int, std::int64_t>;
  Event schedule(Cycle tick, int priority, std::function<void()> process) {
    const Event event{tick, priority, --sequence_};
    events_.emplace(event, std::move(process));
    return event;
  }
  void deschedule(const Event &event) { events_.erase(event); }
  Cycle tick() const { return tick_; }
  void run() {
    while (!events_.empty()) {
      const auto first = events_.begin();
      const auto process = std::move(first->second);
      tick_ = std::get<0>(first->first);
      events_.erase(first);
      process();
    }
  }

 private:
  std::map<Event, std::function<void()>> events_;
  std::int64_t sequence_ = 0;
  Cycle tick_ = 0;
};

/// The traffic of a test: the cycle in which the source wants to request each job, and the cycles in which the sink is
/// not ready.
struct Traffic {
  std::vector<raypath::Job> jobs;
  std::vector<Cycle> arrivals;
  std::vector<bool> is_ready;
  bool ready(Cycle cycle) const { return cycle >= is_ready.size() || is_ready[cycle]; }
};

/// What became of the jobs.
struct Outcome {
  std::vector<Cycle> accepted, received;
  std::vector<raypath::Result> results;
  explicit Outcome(std::size_t jobs) : accepted(jobs), received(jobs), results(jobs) {}
};

/// Calls between the unit and the object.
struct Counts {
  std::uint64_t schedules = 0, edges = 0, retries = 0;
};

/// A source and a sink around the unit, like an object derived from `ClockedObject`.
class Object final : public raypath::gem5::Host {
 public:
  Object(EventQueue &queue, const Datapath &datapath, const Traffic &traffic)
      : queue_(queue), traffic_(traffic), unit_(value(Pipeline::create(datapath)), datapath.latency(), *this), outcome_(traffic.jobs.size()) {
    for (const Cycle cycle : traffic.arrivals) at(cycle, default_priority, [this] { arrive(); });
  }

  Cycle current_cycle() const override { return queue_.tick() / period; }
  void schedule_edge(Cycle cycle) override {
    ++counts_.schedules;
    if (is_scheduled_) queue_.deschedule(event_);
    is_scheduled_ = true;
    event_ = at(cycle, cpu_tick_priority, [this] {
      is_scheduled_ = false;
      ++counts_.edges;
      unit_.edge();
    });
  }
  bool can_receive() override {
    const Cycle now = current_cycle();
    if (traffic_.ready(now)) return true;
    Cycle next = now + 1;
    while (!traffic_.ready(next)) ++next;
    at(next, default_priority, [this] { unit_.response_retry(); });
    return false;
  }
  void receive(const raypath::Result &result) override {
    outcome_.received[result.tag] = current_cycle();
    outcome_.results[result.tag] = result;
  }
  void request_retry() override {
    ++counts_.retries;
    waits_ = false;
    at(current_cycle() + 1, default_priority, [this] { request(); });
  }

  const Outcome &outcome() const { return outcome_; }
  const Counts &counts() const { return counts_; }

 private:
  static constexpr Cycle period = 500;
  static constexpr int default_priority = 0, cpu_tick_priority = 50;

  EventQueue::Event at(Cycle cycle, int priority, std::function<void()> process) {
    return queue_.schedule(cycle * period, priority, std::move(process));
  }
  void arrive() {
    ++arrived_;
    request();
  }
  /// Requests the next job that has arrived, unless the unit has refused it or has accepted one in this cycle.
  void request() {
    const Cycle now = current_cycle();
    if (waits_ || next_ == arrived_ || (next_ > 0 && outcome_.accepted[next_ - 1] == now)) return;
    if (value(unit_.request(traffic_.jobs[next_], next_))) {
      outcome_.accepted[next_++] = now;
      if (next_ < traffic_.jobs.size()) at(now + 1, default_priority, [this] { request(); });
    } else {
      waits_ = true;
    }
  }

  EventQueue &queue_;
  const Traffic &traffic_;
  EventUnit unit_;
  Outcome outcome_;
  EventQueue::Event event_;
  bool is_scheduled_ = false, waits_ = false;
  std::size_t arrived_ = 0, next_ = 0;
  Counts counts_;
};

/// The same traffic in a loop over all cycles.
Outcome every_cycle(const Datapath &datapath, const Traffic &traffic) {
  Outcome outcome(traffic.jobs.size());
  Pipeline pipeline = value(Pipeline::create(datapath));
  std::size_t next = 0, left = 0;
  for (Cycle cycle = 0; left < traffic.jobs.size(); ++cycle) {
    const bool has_arrived = next < traffic.jobs.size() && traffic.arrivals[next] <= cycle;
    if (has_arrived && value(pipeline.offer(traffic.jobs[next], next))) outcome.accepted[next++] = cycle;
    if (const auto result = pipeline.step(traffic.ready(cycle))) {
      outcome.received[result->tag] = cycle;
      outcome.results[result->tag] = *result;
      ++left;
    }
  }
  return outcome;
}

/// Runs the traffic through the unit.
std::pair<Outcome, Counts> run(const Datapath &datapath, const Traffic &traffic) {
  EventQueue queue;
  Object object(queue, datapath, traffic);
  queue.run();
  return {object.outcome(), object.counts()};
}

/// Jobs far apart: one event for each, however many cycles lie between.
void sparse() {
  const Datapath datapath = value(Datapath::open());
  Traffic traffic;
  for (Cycle job = 0; job < 1000; ++job) {
    traffic.jobs.push_back(raypath::timing_job(job % 2));
    traffic.arrivals.push_back(job * 1'000'000);
  }
  const auto [outcome, counts] = run(datapath, traffic);
  CHECK_EQUAL(counts.edges, 1000u);
  CHECK_EQUAL(counts.retries, 0u);
  for (std::size_t job = 0; job < 1000; ++job) CHECK_EQUAL(outcome.received[job], job * 1'000'000 + latency);
}

/// A job in every cycle: the event is scheduled once for each.
void burst() {
  const Datapath datapath = value(Datapath::open());
  Traffic traffic;
  for (Cycle job = 0; job < 100; ++job) {
    traffic.jobs.push_back(raypath::timing_job(RAYPATH_JOB_TRIANGLE));
    traffic.arrivals.push_back(job);
  }
  const auto [outcome, counts] = run(datapath, traffic);
  CHECK_EQUAL(counts.schedules, 100u);
  for (std::size_t job = 0; job < 100; ++job) CHECK_EQUAL(outcome.received[job], job + latency);
}

/// Each outcome requests the next job. The edge of its cycle has passed, so the job enters in the next.
void chain() {
  struct Chain final : raypath::gem5::Host {
    EventQueue queue;
    EventUnit unit;
    std::vector<Cycle> received;
    explicit Chain(const Datapath &datapath)
        : unit(value(Pipeline::create(datapath)), datapath.latency(), *this) {}
    bool request() { return value(unit.request(raypath::timing_job(RAYPATH_JOB_QUADBOX), 0)); }
    Cycle current_cycle() const override { return queue.tick(); }
    void schedule_edge(Cycle cycle) override { queue.schedule(cycle, 1, [this] { unit.edge(); }); }
    bool can_receive() override { return true; }
    void receive(const raypath::Result &) override {
      received.push_back(queue.tick());
      if (received.size() < 10) CHECK_EQUAL(request(), false);
    }
    void request_retry() override {
      queue.schedule(queue.tick() + 1, 0, [this] { CHECK_EQUAL(request(), true); });
    }
  };
  Chain chain(value(Datapath::open()));
  chain.queue.schedule(0, 0, [&] { CHECK_EQUAL(chain.request(), true); });
  chain.queue.run();
  CHECK_EQUAL(chain.received.size(), 10u);
  for (std::size_t job = 0; job < 10; ++job) CHECK_EQUAL(chain.received[job], latency + (latency + 1) * job);
}

/// 32 jobs at once, and a sink that is ready from cycle 100. A functional unit with a constant latency would accept all
/// of them by cycle 31 and deliver the first in cycle 12.
void back_pressure() {
  for (const bool skid : {true, false}) {
    const Datapath datapath = value(Datapath::open(skid ? "" : "preset = \"credit\""));
    Traffic traffic;
    traffic.jobs.assign(32, raypath::timing_job(RAYPATH_JOB_QUADBOX));
    traffic.arrivals.assign(32, 0);
    traffic.is_ready.assign(100, false);
    const auto [outcome, counts] = run(datapath, traffic);
    // The source is called back once, in the cycle before it may enter.
    CHECK_EQUAL(counts.retries, 1u);
    const std::size_t capacity = skid ? 24 : 13;
    for (std::size_t job = 0; job < 32; ++job) {
      // The first buffer is free again a latency after the first job has left, the first credit a cycle after.
      const Cycle reopened = 100 + (skid ? latency : 1);
      CHECK_EQUAL(outcome.accepted[job], job < capacity ? job : reopened + job - capacity);
      CHECK_EQUAL(outcome.received[job], 100 + job);
    }
  }
}

/// Random traffic with values: the same cycles and the same values as in the loop over all cycles.
void random_traffic() {
  std::mt19937 random(1);
  const auto number = [&] { return static_cast<float>(random() % 2001) / 1000 - 1; };
  for (const char *configuration : {"", "preset = \"credit\"", "unit-latency = 2"}) {
    const Datapath datapath = value(Datapath::open(configuration));
    Traffic traffic;
    Cycle cycle = 0;
    for (int i = 0; i < 3000; ++i) {
      cycle += random() % (i / 200 % 3 == 0 ? 40 : 3);
      traffic.arrivals.push_back(cycle);
      const float origin[3] = {number(), number(), -5}, direction[3] = {number() / 8, number() / 8, 1};
      const raypath::Ray ray = value(raypath::ray(origin, direction, 100));
      raypath::Job job{};
      job.kind = random() % 2 == 0 ? RAYPATH_JOB_TRIANGLE : RAYPATH_JOB_QUADBOX;
      if (job.kind == RAYPATH_JOB_TRIANGLE) {
        job.input.triangle.ray = ray;
        for (float *vertex : {job.input.triangle.triangle.a, job.input.triangle.triangle.b, job.input.triangle.triangle.c}) {
          for (int axis = 0; axis < 3; ++axis) vertex[axis] = number();
        }
      } else {
        job.input.quadbox.ray = ray;
        for (auto &box : job.input.quadbox.boxes) {
          for (int axis = 0; axis < 3; ++axis) box.max[axis] = (box.min[axis] = number()) + 1;
        }
      }
      traffic.jobs.push_back(job);
    }
    for (Cycle i = 0; i < cycle; ++i) traffic.is_ready.push_back(random() % (i / 300 % 3 == 0 ? 5 : 2) != 0);
    const Outcome expected = every_cycle(datapath, traffic);
    const auto [found, counts] = run(datapath, traffic);
    std::size_t hits = 0;
    for (std::size_t job = 0; job < traffic.jobs.size(); ++job) {
      CHECK_EQUAL(found.accepted[job], expected.accepted[job]);
      CHECK_EQUAL(found.received[job], expected.received[job]);
      const raypath::Result &a = found.results[job], &b = expected.results[job];
      CHECK_EQUAL(a.kind, traffic.jobs[job].kind);
      // And the same as the functional model, which knows no cycles.
      if (a.kind == RAYPATH_JOB_TRIANGLE) {
        raypath::TriangleResult c;
        const auto &input = traffic.jobs[job].input.triangle;
        CHECK_EQUAL(raypath_triangle(datapath.get(), &input.ray, &input.triangle, 1, &c), RAYPATH_OK);
        CHECK_EQUAL(std::memcmp(&a.output.triangle, &c, sizeof c), 0);
        CHECK_EQUAL(std::memcmp(&b.output.triangle, &c, sizeof c), 0);
        hits += c.triangle_hit;
      } else {
        raypath::QuadboxResult c;
        const auto &input = traffic.jobs[job].input.quadbox;
        CHECK_EQUAL(raypath_quadbox(datapath.get(), &input.ray, input.boxes, 1, &c), RAYPATH_OK);
        CHECK_EQUAL(std::memcmp(&a.output.quadbox, &c, sizeof c), 0);
        CHECK_EQUAL(std::memcmp(&b.output.quadbox, &c, sizeof c), 0);
        hits += c.is_intersect[0];
      }
    }
    CHECK_EQUAL(hits > 300, true);
    CHECK_EQUAL(counts.edges < expected.received.back(), true);
  }
}

}  // namespace

int main() {
  sparse();
  burst();
  chain();
  back_pressure();
  random_traffic();
}
