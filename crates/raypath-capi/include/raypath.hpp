/* SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * libraypath for C++17, header only, over raypath.h. Handles close themselves, arrays are spans with their length, and
 * errors are values: no function throws (except std::bad_alloc for the text of an error), and the header compiles with
 * -fno-exceptions.
 */

#ifndef RAYPATH_HPP
#define RAYPATH_HPP

#include "raypath.h"

#include <cassert>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace raypath {

using Ray = raypath_ray;
using Box = raypath_box;
using Vertices = raypath_vertices;
using QuadboxResult = raypath_quadbox_result;
using TriangleResult = raypath_triangle_result;
using Job = raypath_job;
using Result = raypath_result;
using Cost = raypath_cost_counts;
using UnitRay = raypath_unit_ray;
using UnitHit = raypath_unit_hit;
using UnitCandidate = raypath_unit_candidate;
using UnitVerdict = raypath_unit_verdict;
using Neighbour = raypath_neighbour;
using SearchReply = raypath_search_reply;
using SearchInputs = raypath_search_inputs;
using SearchOutputs = raypath_search_outputs;
using UnitInputs = raypath_unit_inputs;
using UnitOutputs = raypath_unit_outputs;
using UnitCounts = raypath_unit_counts;
using UnitStalls = raypath_unit_stalls;
using RayInside = raypath_ray_inside;

/** Why a call failed: its status, below 0, and its message. */
struct Error {
  raypath_status status;
  std::string message;
};

/** A value, or the error that stands in its place. */
template <class T>
class [[nodiscard]] Expected {
 public:
  Expected(T value) : value_(std::move(value)) {}
  Expected(Error error) : error_(std::move(error)) {}

  explicit operator bool() const noexcept { return value_.has_value(); }
  bool has_value() const noexcept { return value_.has_value(); }

  /** The value. There must be one. */
  T &operator*() & noexcept { return assert(value_), *value_; }
  const T &operator*() const & noexcept { return assert(value_), *value_; }
  T &&operator*() && noexcept { return assert(value_), std::move(*value_); }
  T *operator->() noexcept { return assert(value_), &*value_; }
  const T *operator->() const noexcept { return assert(value_), &*value_; }

  /** The error; its status is RAYPATH_OK if there is a value. */
  const Error &error() const noexcept { return error_; }

 private:
  std::optional<T> value_;
  Error error_{RAYPATH_OK, {}};
};

/** Success, or an error. */
using Outcome = Expected<std::monostate>;

/** A contiguous array: a pointer and a length. Arrays, vectors and std::span convert to it. */
template <class T>
class Span {
 public:
  constexpr Span() noexcept = default;
  constexpr Span(T *data, std::size_t size) noexcept : data_(data), size_(size) {}
  template <std::size_t N>
  constexpr Span(T (&array)[N]) noexcept : data_(array), size_(N) {}
  template <class Container,
            class = std::enable_if_t<std::is_convertible_v<
                std::remove_pointer_t<decltype(std::data(std::declval<Container &>()))> (*)[], T (*)[]>>>
  constexpr Span(Container &&container) noexcept : data_(std::data(container)), size_(std::size(container)) {}

  constexpr T *data() const noexcept { return data_; }
  constexpr std::size_t size() const noexcept { return size_; }

 private:
  T *data_ = nullptr;
  std::size_t size_ = 0;
};

namespace detail {

inline Error last_error(raypath_status status) { return {status, raypath_last_error()}; }

inline Error argument(const char *message) { return {RAYPATH_ERROR_ARGUMENT, message}; }

inline Outcome outcome(raypath_status status) {
  if (status < 0) return last_error(status);
  return std::monostate{};
}

template <class Model>
std::vector<std::uint8_t> saved(std::size_t (*save)(const Model *, std::uint8_t *, std::size_t), const Model *model) {
  std::vector<std::uint8_t> bytes(save(model, nullptr, 0));
  save(model, bytes.data(), bytes.size());
  return bytes;
}

struct Close {
  void operator()(raypath_datapath *datapath) const noexcept { raypath_close(datapath); }
  void operator()(raypath_pipeline *pipeline) const noexcept { raypath_pipeline_free(pipeline); }
  void operator()(raypath_unit *unit) const noexcept { raypath_unit_close(unit); }
  void operator()(raypath_scene *scene) const noexcept { raypath_scene_free(scene); }
  void operator()(raypath_query *query) const noexcept { raypath_query_free(query); }
  void operator()(raypath_unit_model *model) const noexcept { raypath_unit_model_free(model); }
};

}  // namespace detail

/** The ray from `origin` along `direction` with the length `extent` times that of `direction`. */
inline Expected<Ray> ray(const float (&origin)[3], const float (&direction)[3], float extent) {
  Ray made;
  const raypath_status status = raypath_ray_init(&made, origin, direction, extent);
  if (status < 0) return detail::last_error(status);
  return made;
}

/** A configuration with its operations, models and hardware. Any number of threads may use it at once. */
class Datapath {
 public:
  /** Opens a datapath; see raypath_open_with. NULL is the default configuration, and no added operations. */
  static Expected<Datapath> open(const char *toml = nullptr, const char *operations = nullptr) {
    raypath_datapath *opened = nullptr;
    const raypath_status status = raypath_open_with(toml, operations, &opened);
    if (status < 0) return detail::last_error(status);
    return Datapath(opened);
  }

  /** Tests rays against four boxes each: `boxes` has four elements for each ray. */
  Outcome quadbox(Span<const Ray> rays, Span<const Box> boxes, Span<QuadboxResult> results) const {
    if (boxes.size() / 4 != rays.size() || boxes.size() % 4 != 0 || results.size() != rays.size())
      return detail::argument("expected four boxes and one result for each ray");
    return detail::outcome(raypath_quadbox(get(), rays.data(), boxes.data(), rays.size(), results.data()));
  }

  /** Tests rays against a triangle each. */
  Outcome triangle(Span<const Ray> rays, Span<const Vertices> triangles, Span<TriangleResult> results) const {
    if (triangles.size() != rays.size() || results.size() != rays.size())
      return detail::argument("expected one triangle and one result for each ray");
    return detail::outcome(raypath_triangle(get(), rays.data(), triangles.data(), rays.size(), results.data()));
  }

  /** Squared Euclidean distances of pairs of vectors with `dimensions` numbers each. */
  Outcome euclidean(Span<const float> a, Span<const float> b, std::size_t dimensions, Span<float> distances) const {
    if (a.size() != distances.size() * dimensions || b.size() != a.size())
      return detail::argument("expected `dimensions` numbers of a and of b for each distance");
    return detail::outcome(
        raypath_euclidean(get(), a.data(), b.data(), dimensions, distances.size(), distances.data()));
  }

  /** Dot products of pairs of vectors, and squared norms of the vectors of `b`. */
  Outcome angular(Span<const float> a, Span<const float> b, std::size_t dimensions, Span<float> dot_products,
                  Span<float> norms) const {
    if (a.size() != dot_products.size() * dimensions || b.size() != a.size() || norms.size() != dot_products.size())
      return detail::argument("expected `dimensions` numbers of a and of b for each dot product and norm");
    return detail::outcome(raypath_angular(get(), a.data(), b.data(), dimensions, dot_products.size(),
                                           dot_products.data(), norms.data()));
  }

  /** Writes the hardware into a folder; see raypath_generate. */
  Outcome generate(const char *folder) const { return detail::outcome(raypath_generate(get(), folder)); }

  std::uint32_t latency() const noexcept { return raypath_latency(get()); }
  std::size_t capacity() const noexcept { return raypath_capacity(get()); }
  std::size_t lanes() const noexcept { return raypath_lanes(get()); }
  const char *description() const noexcept { return raypath_description(get()); }

  /** Units and flip-flops, counted in the netlist. */
  Cost cost() const noexcept {
    Cost counts{};
    raypath_cost(get(), &counts);
    return counts;
  }

  /** The handle, for functions of raypath.h. */
  const raypath_datapath *get() const noexcept { return handle_.get(); }

 private:
  explicit Datapath(raypath_datapath *opened) noexcept : handle_(opened) {}

  std::unique_ptr<raypath_datapath, detail::Close> handle_;
};

/** The cycle-exact model of a datapath. One thread at a time may use it. */
class Pipeline {
 public:
  static Expected<Pipeline> create(const Datapath &datapath) {
    raypath_pipeline *made = nullptr;
    const raypath_status status = raypath_pipeline_new(datapath.get(), &made);
    if (status < 0) return detail::last_error(status);
    return Pipeline(made);
  }

  /** Offers a job in this cycle: whether it is accepted. */
  Expected<bool> offer(const Job &job, std::uint64_t tag) {
    const raypath_status status = raypath_pipeline_offer(get(), &job, tag);
    if (status < 0) return detail::last_error(status);
    return status == RAYPATH_OK;
  }

  /** One clock cycle: the result that leaves, if one does. */
  std::optional<Result> step(bool output_ready) {
    Result result;
    if (raypath_pipeline_step(get(), output_ready, &result) != RAYPATH_OK) return std::nullopt;
    return result;
  }

  /** The result at the output in this cycle, which stays until a step takes it. */
  std::optional<Result> peek() const {
    Result result;
    if (raypath_pipeline_peek(get(), &result) != RAYPATH_OK) return std::nullopt;
    return result;
  }

  /** Advances up to `cycles` cycles and stops at a valid output; the number of cycles. */
  std::uint64_t skip(std::uint64_t cycles) noexcept { return raypath_pipeline_skip(get(), cycles); }

  std::size_t occupancy() const noexcept { return raypath_pipeline_occupancy(get()); }
  bool input_ready(std::uint64_t opcode) const noexcept { return raypath_pipeline_input_ready(get(), opcode); }
  bool output_valid() const noexcept { return raypath_pipeline_output_valid(get()); }
  void reset() noexcept { raypath_pipeline_reset(get()); }

  /** The whole state as bytes; see raypath_pipeline_save. */
  std::vector<std::uint8_t> save() const { return detail::saved(raypath_pipeline_save, get()); }
  /** Takes over a saved state; see raypath_pipeline_restore. */
  Outcome restore(Span<const std::uint8_t> bytes) {
    return detail::outcome(raypath_pipeline_restore(get(), bytes.data(), bytes.size()));
  }
  /** A copy with the same state. */
  Expected<Pipeline> clone() const {
    raypath_pipeline *copy = nullptr;
    const raypath_status status = raypath_pipeline_clone(get(), &copy);
    if (status < 0) return detail::last_error(status);
    return Pipeline(copy);
  }

  /** The handle, for functions of raypath.h. */
  raypath_pipeline *get() const noexcept { return handle_.get(); }

 private:
  explicit Pipeline(raypath_pipeline *made) noexcept : handle_(made) {}

  std::unique_ptr<raypath_pipeline, detail::Close> handle_;
};

/** A traversal unit: a ray goes in, its closest or any hit comes out. Any number of threads may use it at once. */
class Unit {
 public:
  /** Opens a unit; see raypath_unit_open. NULL is the default. */
  static Expected<Unit> open(const char *toml = nullptr) {
    raypath_unit *opened = nullptr;
    const raypath_status status = raypath_unit_open(toml, &opened);
    if (status < 0) return detail::last_error(status);
    return Unit(opened);
  }

  /** Traces rays through a scene in memory; see raypath_unit_trace. */
  Outcome trace(Span<const std::uint8_t> scene, Span<const UnitRay> rays, Span<UnitHit> hits) const {
    if (hits.size() != rays.size()) return detail::argument("expected one hit for each ray");
    return detail::outcome(
        raypath_unit_trace(get(), scene.data(), scene.size(), rays.data(), rays.size(), hits.data()));
  }

  /** Does a job at an address of a memory; see raypath_unit_search. */
  Expected<SearchReply> search(Span<const std::uint8_t> memory, std::uint32_t job, Span<Neighbour> neighbours) const {
    SearchReply reply{};
    const raypath_status status = raypath_unit_search(get(), memory.data(), memory.size(), 0, job, neighbours.data(),
                                                      neighbours.size(), &reply);
    if (status < 0) return detail::last_error(status);
    return reply;
  }

  /** Writes the hardware into a folder; see raypath_unit_generate. */
  Outcome generate(const char *folder) const { return detail::outcome(raypath_unit_generate(get(), folder)); }

  const char *description() const noexcept { return raypath_unit_description(get()); }

  raypath_unit_parameter_values parameters() const noexcept {
    raypath_unit_parameter_values values{};
    raypath_unit_parameters(get(), &values);
    return values;
  }

  /** The handle, for functions of raypath.h. */
  const raypath_unit *get() const noexcept { return handle_.get(); }

 private:
  explicit Unit(raypath_unit *opened) noexcept : handle_(opened) {}

  std::unique_ptr<raypath_unit, detail::Close> handle_;
};

/** A scene in memory, as a traversal unit reads it. Any number of threads may use it at once. */
class Scene {
 public:
  using Vertex = float[3];
  using Triangle = std::uint32_t[3];
  using Geometry = raypath_unit_geometry;
  using Instance = raypath_unit_instance;

  /** Builds a scene; see raypath_scene_build. Without instances it has one level. */
  static Expected<Scene> build(const Unit &unit, Span<const Vertex> vertices, Span<const Triangle> triangles,
                               Span<const Instance> instances = {}, float reach = 0.0f,
                               Span<const Geometry> geometries = {}, Span<const Box> boxes = {}) {
    raypath_scene *built = nullptr;
    const raypath_status status =
        raypath_scene_build(unit.get(), vertices.data(), vertices.size(), triangles.data(), triangles.size(),
                            boxes.data(), boxes.size(), geometries.data(), geometries.size(), instances.data(),
                            instances.size(), reach, &built);
    if (status < 0) return detail::last_error(status);
    return Scene(built);
  }

  /** Builds a scene of scenes, each placed by the instances whose elements of `members` have its number; see
      raypath_scene_group. */
  static Expected<Scene> group(const Unit &unit, Span<const Scene *const> scenes, Span<const std::uint32_t> members,
                               Span<const Instance> instances, float reach = 0.0f) {
    std::vector<const raypath_scene *> handles;
    for (std::size_t i = 0; i < scenes.size(); ++i) handles.push_back(scenes.data()[i]->get());
    raypath_scene *built = nullptr;
    if (members.size() != instances.size()) return detail::argument("members: expected as many as instances");
    const raypath_status status = raypath_scene_group(unit.get(), handles.data(), handles.size(), members.data(),
                                                      instances.data(), instances.size(), reach, &built);
    if (status < 0) return detail::last_error(status);
    return Scene(built);
  }

  /** The bytes, the first of which has the address 0. */
  Span<const std::uint8_t> bytes() const noexcept { return {raypath_scene_data(get()), raypath_scene_size(get())}; }
  /** The child word of the root, for `root` of a ray. */
  std::uint32_t root() const noexcept { return raypath_scene_root(get()); }
  /** The distance from which rays may come without losing hits. */
  float reach() const noexcept { return raypath_scene_reach(get()); }

  /** The handle, for functions of raypath.h. */
  const raypath_scene *get() const noexcept { return handle_.get(); }

 private:
  explicit Scene(raypath_scene *built) noexcept : handle_(built) {}

  std::unique_ptr<raypath_scene, detail::Close> handle_;
};

/**
 * A ray that waits for its caller at each candidate, as rayQueryEXT does:
 *
 *     while (query.proceed(scene.bytes()))
 *       if (is_opaque_at(query.candidate())) query.confirm();
 */
class Query {
 public:
  static Expected<Query> create(const Unit &unit, const UnitRay &ray) {
    raypath_query *made = nullptr;
    const raypath_status status = raypath_query_new(unit.get(), &ray, &made);
    if (status < 0) return detail::last_error(status);
    return Query(made);
  }

  /** Goes on to the next candidate; false where the ray has ended. What is not confirmed or generated is ignored. */
  bool proceed(Span<const std::uint8_t> scene) noexcept {
    verdict_ = {};
    return raypath_query_proceed(get(), scene.data(), scene.size(), &candidate_) == RAYPATH_CANDIDATE;
  }
  /** The candidate. */
  const UnitCandidate &candidate() const noexcept { return candidate_; }

  /** The triangle is hit. */
  void confirm() noexcept { generate(0.0f); }
  /** What is in the box is hit at this distance, if it is in the ray's range. */
  void generate(float t) noexcept { verdict_.accept = 1, verdict_.t = t, answer(); }
  /** The ray ends with its closest hit. */
  void terminate() noexcept { verdict_.end = 1, answer(); }

  /** The hit of a ray that has ended. */
  Expected<UnitHit> hit() const {
    UnitHit found{};
    const raypath_status status = raypath_query_hit(get(), &found);
    if (status < 0) return detail::last_error(status);
    return found;
  }

  /** The handle, for functions of raypath.h. */
  raypath_query *get() const noexcept { return handle_.get(); }

 private:
  explicit Query(raypath_query *made) noexcept : handle_(made) {}
  void answer() noexcept { raypath_query_answer(get(), &verdict_); }

  std::unique_ptr<raypath_query, detail::Close> handle_;
  UnitCandidate candidate_{};
  UnitVerdict verdict_{};
};

/** The cycle-exact model of a traversal unit. One thread at a time may use it. */
class UnitModel {
 public:
  static Expected<UnitModel> create(const Unit &unit) {
    raypath_unit_model *made = nullptr;
    const raypath_status status = raypath_unit_model_new(unit.get(), &made);
    if (status < 0) return detail::last_error(status);
    return UnitModel(made);
  }

  /** The outputs in this cycle, which depend on earlier cycles alone. */
  UnitOutputs outputs() const noexcept {
    UnitOutputs now{};
    raypath_unit_model_outputs(get(), &now);
    return now;
  }

  /** The clock edge that ends this cycle; see raypath_unit_model_step. */
  Outcome step(const UnitInputs &inputs) { return detail::outcome(raypath_unit_model_step(get(), &inputs)); }

  /** The same in a unit with searches; see raypath_unit_model_step_with. */
  Outcome step(const UnitInputs &inputs, const SearchInputs &search) {
    return detail::outcome(raypath_unit_model_step_with(get(), &inputs, &search));
  }
  /** The outputs of searches in this cycle; see raypath_unit_model_search_outputs. */
  SearchOutputs search_outputs() const noexcept {
    SearchOutputs now{};
    raypath_unit_model_search_outputs(get(), &now);
    return now;
  }

  /** Advances up to `cycles` cycles and stops where an input could change something; see raypath_unit_model_skip. */
  std::uint64_t skip(std::uint64_t cycles) noexcept { return raypath_unit_model_skip(get(), cycles); }

  /** What the unit did since its last reset. */
  UnitCounts counts() const noexcept {
    UnitCounts counted{};
    raypath_unit_model_counts(get(), &counted);
    return counted;
  }

  /** Where rays, hits, requests and jobs waited since its last reset. */
  UnitStalls stalls() const noexcept {
    UnitStalls counted{};
    raypath_unit_model_stalls(get(), &counted);
    return counted;
  }

  /** The rays in contexts and what they wait for, by context; see raypath_unit_model_rays. */
  std::vector<RayInside> rays() const {
    std::vector<RayInside> inside(raypath_unit_model_rays(get(), nullptr, 0));
    raypath_unit_model_rays(get(), inside.data(), inside.size());
    return inside;
  }

  void reset() noexcept { raypath_unit_model_reset(get()); }

  /** The whole state as bytes; see raypath_unit_model_save. */
  std::vector<std::uint8_t> save() const { return detail::saved(raypath_unit_model_save, get()); }
  /** Takes over a saved state; see raypath_unit_model_restore. */
  Outcome restore(Span<const std::uint8_t> bytes) {
    return detail::outcome(raypath_unit_model_restore(get(), bytes.data(), bytes.size()));
  }
  /** A copy with the same state. */
  Expected<UnitModel> clone() const {
    raypath_unit_model *copy = nullptr;
    const raypath_status status = raypath_unit_model_clone(get(), &copy);
    if (status < 0) return detail::last_error(status);
    return UnitModel(copy);
  }

  /** The handle, for functions of raypath.h. */
  raypath_unit_model *get() const noexcept { return handle_.get(); }

 private:
  explicit UnitModel(raypath_unit_model *made) noexcept : handle_(made) {}

  std::unique_ptr<raypath_unit_model, detail::Close> handle_;
};

/** A job: a ray against four boxes. */
inline Job quadbox_job(const Ray &ray, const Box (&boxes)[4]) {
  Job job{};
  job.kind = RAYPATH_JOB_QUADBOX;
  job.input.quadbox = {ray, {boxes[0], boxes[1], boxes[2], boxes[3]}};
  return job;
}

/** A job: a ray against a triangle. */
inline Job triangle_job(const Ray &ray, const Vertices &triangle) {
  Job job{};
  job.kind = RAYPATH_JOB_TRIANGLE;
  job.input.triangle = {ray, triangle};
  return job;
}

/** A job that has the time of an operation and no values. */
inline Job timing_job(std::uint64_t opcode) {
  Job job{};
  job.kind = RAYPATH_JOB_TIMING;
  job.input.words.opcode = opcode;
  return job;
}

}  // namespace raypath

#endif  // RAYPATH_HPP
