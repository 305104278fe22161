// Rhexis for C++17: objects that own their handles, exceptions instead of statuses. Header only, over rhexis.h.
//
// Objects are moved, not copied. What `positions` and its like return is borrowed until the next call that changes the world. One world
// is used by one thread at a time; an Error with RHEXIS_STATUS_BUSY tells of a second one.
#ifndef RHEXIS_HPP
#define RHEXIS_HPP

#include "rhexis.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace rhexis {

// A call that did nothing, and why.
class Error : public std::runtime_error {
public:
    explicit Error(RhexisStatus status)
        : std::runtime_error(std::string(rhexis_status_name(status)) + ": " + rhexis_last_error_message()), status_(status) {}

    RhexisStatus status() const noexcept { return status_; }

private:
    RhexisStatus status_;
};

inline void check(RhexisStatus status) {
    if (status != RHEXIS_STATUS_OK) {
        throw Error(status);
    }
}

// Throws unless header and library fit.
inline void check_abi(std::uint64_t features = 0) { check(rhexis_check_abi(RHEXIS_ABI_VERSION, features)); }

// Borrowed numbers.
template <typename T> class View {
public:
    View(const T *data, std::size_t count) noexcept : data_(data), count_(count) {}

    const T *data() const noexcept { return data_; }
    std::size_t size() const noexcept { return count_; }
    bool empty() const noexcept { return count_ == 0; }
    const T *begin() const noexcept { return data_; }
    const T *end() const noexcept { return count_ == 0 ? data_ : data_ + count_; }
    const T &operator[](std::size_t i) const { return data_[i]; }

private:
    const T *data_;
    std::size_t count_;
};

// A handle that is destroyed with its owner.
template <typename Handle, RhexisStatus (*destroy)(Handle)> class Owned {
public:
    Owned() noexcept = default;
    explicit Owned(Handle handle) noexcept : handle_(handle) {}
    Owned(Owned &&other) noexcept : handle_(other.release()) {}
    Owned &operator=(Owned &&other) noexcept {
        if (this != &other) {
            reset();
            handle_ = other.release();
        }
        return *this;
    }
    Owned(const Owned &) = delete;
    Owned &operator=(const Owned &) = delete;
    ~Owned() { reset(); }

    Handle handle() const noexcept { return handle_; }

    // Gives the handle away.
    Handle release() noexcept { return std::exchange(handle_, Handle{0}); }

    void reset() noexcept {
        if (handle_.bits != 0) {
            (void)destroy(handle_);
            handle_.bits = 0;
        }
    }

private:
    Handle handle_{0};
};

// A state to go back to.
class Snapshot : public Owned<RhexisSnapshot, rhexis_snapshot_destroy> {
public:
    using Owned::Owned;

    static Snapshot from_bytes(const std::uint8_t *data, std::size_t count) {
        RhexisSnapshot snapshot{};
        check(rhexis_snapshot_from_bytes(data, count, &snapshot));
        return Snapshot(snapshot);
    }

    View<std::uint8_t> bytes() const {
        RhexisViewU8 view{};
        check(rhexis_snapshot_bytes(handle(), &view));
        return {view.data, view.count};
    }
};

// A run that can be repeated.
class Recording : public Owned<RhexisRecording, rhexis_recording_destroy> {
public:
    using Owned::Owned;

    static Recording from_bytes(const std::uint8_t *data, std::size_t count) {
        RhexisRecording recording{};
        check(rhexis_recording_from_bytes(data, count, &recording));
        return Recording(recording);
    }

    View<std::uint8_t> bytes() const {
        RhexisViewU8 view{};
        check(rhexis_recording_bytes(handle(), &view));
        return {view.data, view.count};
    }
};

// A body, an obstacle or a tool. It does not own: the world does.
class Entity {
public:
    Entity(RhexisWorld world, RhexisEntity entity) noexcept : world_(world), entity_(entity) {}

    RhexisWorld world() const noexcept { return world_; }
    RhexisEntity handle() const noexcept { return entity_; }

    void set(const char *component, const std::string &toml) const { check(rhexis_set(world_, entity_, component, toml.c_str())); }

    bool unset(const char *component) const {
        std::uint8_t was_there = 0;
        check(rhexis_unset(world_, entity_, component, &was_there));
        return was_there != 0;
    }

    std::string get(const char *component) const {
        std::size_t count = 0;
        const RhexisStatus status = rhexis_get(world_, entity_, component, nullptr, 0, &count);
        if (status != RHEXIS_STATUS_BUFFER_TOO_SMALL) {
            check(status);
        }
        std::vector<std::uint8_t> text(count);
        check(rhexis_get(world_, entity_, component, text.data(), text.size(), &count));
        return std::string(text.begin(), text.end() - 1);
    }

    void destroy() const { check(rhexis_entity_destroy(world_, entity_)); }

private:
    RhexisWorld world_;
    RhexisEntity entity_;
};

// A body.
class Body : public Entity {
public:
    using Entity::Entity;

    View<double> positions() const { return view<double, RhexisViewF64>(rhexis_positions); }
    View<float> positions_f32() const { return view<float, RhexisViewF32>(rhexis_positions_f32); }
    View<double> rest_positions() const { return view<double, RhexisViewF64>(rhexis_rest_positions); }
    View<double> velocities() const { return view<double, RhexisViewF64>(rhexis_velocities); }
    View<double> normals() const { return view<double, RhexisViewF64>(rhexis_normals); }
    View<float> normals_f32() const { return view<float, RhexisViewF32>(rhexis_normals_f32); }
    View<std::uint32_t> indices() const { return view<std::uint32_t, RhexisViewU32>(rhexis_indices); }
    View<std::uint64_t> vertex_keys() const { return view<std::uint64_t, RhexisViewU64>(rhexis_vertex_keys); }

    void track_changes() const { check(rhexis_track_changes(world(), handle())); }

    RhexisChanges changes() const {
        RhexisChanges changes{};
        check(rhexis_changes(world(), handle(), &changes));
        return changes;
    }

    RhexisCut cut(const std::vector<RhexisVec3> &points) const {
        RhexisCut made{};
        const double *numbers = points.empty() ? nullptr : &points.front().x;
        check(rhexis_cut(world(), handle(), numbers, points.size(), &made));
        return made;
    }

    RhexisCut puncture(RhexisVec3 point, RhexisVec3 direction, double length) const {
        RhexisCut made{};
        check(rhexis_puncture(world(), handle(), point, direction, length, &made));
        return made;
    }

    void pin(const char *name, const std::vector<std::uint64_t> &vertices) const {
        check(rhexis_pin(world(), handle(), name, vertices.data(), vertices.size()));
    }

    void shift_pins(const char *name, RhexisVec3 way) const { check(rhexis_pins_shift(world(), handle(), name, way)); }
    void unpin_all(const char *name) const { check(rhexis_unpin_all(world(), handle(), name)); }

    RhexisVec3 reaction(const char *name) const {
        RhexisVec3 force{};
        check(rhexis_reaction(world(), handle(), name, &force));
        return force;
    }

private:
    template <typename T, typename Raw> View<T> view(RhexisStatus (*look)(RhexisWorld, RhexisEntity, Raw *)) const {
        Raw raw{};
        check(look(world(), handle(), &raw));
        return {raw.data, raw.count};
    }
};

// Forceps.
class Forceps : public Entity {
public:
    using Entity::Entity;

    std::size_t close(const Body &body, const RhexisGrasp &grasp) const {
        std::size_t held = 0;
        check(rhexis_forceps_close(world(), handle(), body.handle(), &grasp, &held));
        return held;
    }

    std::size_t close_nearest(const Body &body, double reach) const {
        RhexisGrasp grasp{};
        check(rhexis_grasp_init(&grasp));
        grasp.reach = reach;
        return close(body, grasp);
    }

    void move(const RhexisPose &pose, double within) const { check(rhexis_forceps_move(world(), handle(), &pose, within)); }
    void open() const { check(rhexis_forceps_open(world(), handle())); }

    RhexisForcepsState state() const {
        RhexisForcepsState state{};
        check(rhexis_forceps_state(world(), handle(), &state));
        return state;
    }
};

// A world and all in it.
class World : public Owned<RhexisWorld, rhexis_world_destroy> {
public:
    using Owned::Owned;

    static World empty() {
        RhexisWorld world{};
        check(rhexis_world_create(nullptr, &world));
        return World(world);
    }

    static World empty(const RhexisSettings &settings) {
        RhexisWorld world{};
        check(rhexis_world_create(&settings, &world));
        return World(world);
    }

    static World from_scene(const std::string &text, const char *origin = nullptr) {
        RhexisWorld world{};
        check(rhexis_world_from_scene(text.c_str(), origin, &world));
        return World(world);
    }

    static World from_catalog(const char *name) {
        RhexisWorld world{};
        check(rhexis_world_from_catalog(name, &world));
        return World(world);
    }

    static World from_snapshot(const Snapshot &snapshot) {
        RhexisWorld world{};
        check(rhexis_world_from_snapshot(snapshot.handle(), &world));
        return World(world);
    }

    static World replay(const Recording &recording) {
        RhexisWorld world{};
        check(rhexis_replay(recording.handle(), &world));
        return World(world);
    }

    RhexisReport step(double dt) {
        RhexisReport report{};
        check(rhexis_step(handle(), dt, &report));
        return report;
    }

    RhexisReport advance() {
        RhexisReport report{};
        check(rhexis_advance(handle(), &report));
        return report;
    }

    bool is_finished() const {
        std::uint8_t is_finished = 0;
        check(rhexis_is_finished(handle(), &is_finished));
        return is_finished != 0;
    }

    void set_budget(std::uint32_t iterations, double milliseconds = 0.0) {
        check(rhexis_set_budget(handle(), iterations, milliseconds));
    }

    double time() const {
        double time = 0.0;
        check(rhexis_time(handle(), &time));
        return time;
    }

    std::uint64_t hash() const {
        std::uint64_t hash = 0;
        check(rhexis_hash(handle(), &hash));
        return hash;
    }

    // The next event; none where there are no more. Its text is borrowed until the next call.
    std::optional<RhexisEvent> next_event() {
        RhexisEvent event{};
        check(rhexis_next_event(handle(), &event));
        return event.kind == RHEXIS_EVENT_NONE ? std::nullopt : std::optional<RhexisEvent>(event);
    }

    std::vector<Body> bodies() const {
        std::size_t count = 0;
        const RhexisStatus status = rhexis_bodies(handle(), nullptr, 0, &count);
        if (status != RHEXIS_STATUS_BUFFER_TOO_SMALL) {
            check(status);
        }
        std::vector<RhexisEntity> entities(count);
        check(rhexis_bodies(handle(), entities.data(), entities.size(), &count));
        std::vector<Body> bodies;
        for (const RhexisEntity entity : entities) {
            bodies.emplace_back(handle(), entity);
        }
        return bodies;
    }

    Body body(const RhexisBodyDesc &desc) {
        RhexisEntity entity{};
        check(rhexis_body_create(handle(), &desc, &entity));
        return {handle(), entity};
    }

    Forceps forceps(const RhexisJaws &jaws, const RhexisPose &pose, const char *name = nullptr) {
        RhexisEntity entity{};
        check(rhexis_forceps_create(handle(), name, &jaws, &pose, &entity));
        return {handle(), entity};
    }

    Entity obstacle(const char *toml) {
        RhexisEntity entity{};
        check(rhexis_obstacle_create(handle(), toml, &entity));
        return {handle(), entity};
    }

    Snapshot snapshot() const {
        RhexisSnapshot snapshot{};
        check(rhexis_snapshot_take(handle(), &snapshot));
        return Snapshot(snapshot);
    }

    void restore(const Snapshot &snapshot) { check(rhexis_restore(handle(), snapshot.handle())); }
    void record() { check(rhexis_record(handle())); }

    Recording end_recording() {
        RhexisRecording recording{};
        check(rhexis_record_end(handle(), &recording));
        return Recording(recording);
    }
};

} // namespace rhexis

#endif
