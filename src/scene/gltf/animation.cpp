#include "scene/gltf/animation.h"

#include "core/text.h"
#include "scene/gltf/accessor.h"

#include <fmt/format.h>

#include <Imath/ImathMatrixAlgo.h>

#include <algorithm>
#include <set>

namespace sightline {
namespace {

using Quaternion = std::array<double, 4>;
using Interpolation = GltfAnimation::Sampler::Interpolation;

/// A sampler's keyframes: ascending `times`, and for each keyframe `width` values, or three such
/// groups (in-tangent, value, out-tangent) for a cubic spline.
struct Keyframes {
    std::vector<float> times, values;
    Interpolation interpolation;
    size_t width;

    /// Component `i` of keyframe `k`; `part` selects a cubic spline's in-tangent, value,
    /// out-tangent.
    double value(size_t k, size_t i, size_t part = 1) const {
        const bool cubic = interpolation == Interpolation::cubic_spline;
        return double(values[cubic ? (3 * k + part) * width + i : k * width + i]);
    }
};

/// The keyframe at or before a time, and the position of the time before the next one.
struct KeyframeSpan {
    size_t key;
    double fraction;  ///< of the span, 0…1
    double duration;  ///< of the span, seconds; 0 beyond the first and last keyframe
};

KeyframeSpan find_span(const Keyframes& keys, double time) {
    const auto next = std::upper_bound(keys.times.begin(), keys.times.end(), time,
                                       [](double t, float key) { return t < double(key); });
    if (next == keys.times.begin()) return {0, 0, 0};
    const size_t key = size_t(next - keys.times.begin()) - 1;
    if (next == keys.times.end()) return {key, 0, 0};
    const double duration = double(*next) - double(keys.times[key]);
    return {key, (time - double(keys.times[key])) / duration, duration};
}

double hermite(const Keyframes& keys, const KeyframeSpan& at, size_t i) {
    const double t = at.fraction, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * keys.value(at.key, i) +
           at.duration * (t3 - 2 * t2 + t) * keys.value(at.key, i, 2) +
           (3 * t2 - 2 * t3) * keys.value(at.key + 1, i) +
           at.duration * (t3 - t2) * keys.value(at.key + 1, i, 0);
}

double sample(const Keyframes& keys, const KeyframeSpan& at, size_t i) {
    if (at.fraction == 0 || keys.interpolation == Interpolation::step) return keys.value(at.key, i);
    if (keys.interpolation == Interpolation::cubic_spline) return hermite(keys, at, i);
    return (1 - at.fraction) * keys.value(at.key, i) + at.fraction * keys.value(at.key + 1, i);
}

/// Of unit length; the zero quaternion becomes the identity.
Quaternion normalized(Quaternion q) {
    double length = 0;
    for (const double x : q) length += x * x;
    length = std::sqrt(length);
    if (!(length > 0)) return {0, 0, 0, 1};
    for (double& x : q) x /= length;
    return q;
}

Quaternion sample_rotation(const Keyframes& keys, const KeyframeSpan& at) {
    Quaternion a, b;
    if (at.fraction == 0 || keys.interpolation != Interpolation::linear) {
        for (size_t i = 0; i < 4; ++i) a[i] = sample(keys, at, i);
        return normalized(a);
    }
    double cosine = 0;
    for (size_t i = 0; i < 4; ++i) {
        a[i] = keys.value(at.key, i);
        b[i] = keys.value(at.key + 1, i);
    }
    a = normalized(a);
    b = normalized(b);
    for (size_t i = 0; i < 4; ++i) cosine += a[i] * b[i];
    const double angle = std::acos(std::min(std::abs(cosine), 1.0)), sine = std::sin(angle);
    double from = 1 - at.fraction, to = at.fraction;
    if (sine > 1e-6) {
        from = std::sin(from * angle) / sine;
        to = std::sin(to * angle) / sine;
    }
    if (cosine < 0) to = -to;  // take the shorter arc
    for (size_t i = 0; i < 4; ++i) a[i] = from * a[i] + to * b[i];
    return normalized(a);
}

/// Keyframe times, which ascend; some may be equal.
std::vector<float> read_times(Document& document, uint32_t accessor, const std::string& place) {
    const auto reject = [&](const std::string& reason) {
        document.fail_part(Fault::channel, place, reason);
    };
    document.require_usable(accessor, Fault::channel, place);
    if (document.accessors[accessor].component_type != ComponentType::float32)
        reject("does not hold floats");
    std::vector<float> times = read_floats<float>(document, accessor, Fault::channel, place);
    if (times.empty()) reject("has no keyframes");
    for (size_t i = 0; i < times.size(); ++i)
        if (!std::isfinite(times[i]) || (i > 0 && times[i] < times[i - 1]))
            reject(fmt::format("times do not ascend at keyframe {}", i));
    if (times[0] < 0)
        document.report(Fault::negative_key_time, place,
                        fmt::format("the first time is {}", times[0]));
    const auto equal = std::ranges::adjacent_find(times);
    if (equal != times.end())
        document.report(Fault::equal_key_times, place,
                        fmt::format("keyframes {} and {} have the same time, {}",
                                    equal - times.begin(), equal - times.begin() + 1, *equal));
    return times;
}

/// Takes the node's matrix apart.
void decompose(GltfNode& node) {
    Vec3d rows[3];
    for (int r = 0; r < 3; ++r) rows[r] = {node.matrix[r][0], node.matrix[r][1], node.matrix[r][2]};
    for (int r = 0; r < 3; ++r) node.scale[r] = rows[r].length();
    if (dot(cross(rows[0], rows[1]), rows[2]) < 0) node.scale.x = -node.scale.x;
    Mat4d rotation;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            rotation[r][c] = node.scale[r] != 0 ? rows[r][c] / node.scale[r] : double(r == c);
    const Imath::Quatd q = Imath::extractQuat(rotation);
    node.rotation = {q.v.x, q.v.y, q.v.z, q.r};
    node.translation = {node.matrix[3][0], node.matrix[3][1], node.matrix[3][2]};
    node.has_matrix = false;
}

/// The count of numbers of a channel's keyframe. Throws FaultyPart if the node has no such
/// property.
size_t width_of(const Document& document, const GltfAnimation::Channel& channel,
                const std::string& place) {
    const GltfNode& node = document.nodes[channel.node];
    if (channel.path != "weights") return channel.path == "rotation" ? 4 : 3;
    const bool morphs = node.mesh != none && !document.meshes[node.mesh].primitives.empty();
    const size_t targets = morphs ? document.meshes[node.mesh].primitives[0].targets.size() : 0;
    if (targets == 0)
        document.fail_part(Fault::channel, place + ".target.path",
                           fmt::format("nodes[{}] has no morph targets", channel.node));
    return targets;
}

std::vector<float> read_output(Document& document, uint32_t accessor, uint64_t keys,
                               const GltfAnimation::Channel& channel, size_t width,
                               const std::string& place) {
    const auto reject = [&](const std::string& reason) {
        document.fail_part(Fault::channel, place, reason);
    };
    document.require_usable(accessor, Fault::channel, place);
    const GltfAccessor& output = document.accessors[accessor];
    const bool scalar = channel.path == "weights";
    const bool may_be_normalized = scalar || channel.path == "rotation";
    if (output.component_type != ComponentType::float32 &&
        !(may_be_normalized && output.normalized))
        reject(may_be_normalized ? "does not hold floats or normalised integers"
                                 : "does not hold floats");
    if (output.columns != 1 || output.rows != (scalar ? 1 : width))
        reject(fmt::format("has {} components, not {}", output.components(), scalar ? 1 : width));
    const uint64_t expected = scalar ? keys * width : keys;
    if (output.count != expected)
        reject(fmt::format("has {} elements, not {}", output.count, expected));
    document.charge(accessor);
    std::vector<float> values(output.count * output.rows);
    copy_floats(document, accessor, values.data(), Fault::channel);
    return values;
}

Keyframes read_keyframes(Document& document, const GltfAnimation& animation,
                         const GltfAnimation::Channel& channel, size_t width,
                         const std::string& place) {
    const GltfAnimation::Sampler& sampler = animation.samplers[channel.sampler];
    const std::string at = fmt::format("{}.samplers[{}]", place, channel.sampler);
    const uint64_t parts = sampler.interpolation == Interpolation::cubic_spline ? 3 : 1;
    Keyframes keys;
    keys.width = width;
    keys.interpolation = sampler.interpolation;
    keys.times = read_times(document, sampler.input, at + ".input");
    if (parts == 3 && keys.times.size() < 2)
        document.report(Fault::one_key_spline, at + ".input",
                        "has one keyframe, but a cubic spline needs two");
    keys.values = read_output(document, sampler.output, parts * keys.times.size(), channel, width,
                              at + ".output");
    return keys;
}

void apply(Document& document, const GltfAnimation& animation, size_t index,
           const std::string& place, double time) {
    const GltfAnimation::Channel& channel = animation.channels[index];
    const std::string at = fmt::format("{}.channels[{}]", place, index);
    const size_t width = width_of(document, channel, at);
    const Keyframes keys = read_keyframes(document, animation, channel, width, place);
    const KeyframeSpan span = find_span(keys, time);
    GltfNode& node = document.nodes[channel.node];
    if (node.has_matrix && channel.path != "weights") {
        document.report(Fault::animated_matrix, at + ".target.node",
                        fmt::format("nodes[{}] has a matrix", channel.node));
        decompose(node);
    }
    const auto vector = [&] {
        return Vec3d(sample(keys, span, 0), sample(keys, span, 1), sample(keys, span, 2));
    };
    if (channel.path == "translation") {
        node.translation = vector();
    } else if (channel.path == "scale") {
        node.scale = vector();
    } else if (channel.path == "rotation") {
        node.rotation = sample_rotation(keys, span);
    } else {
        node.weights.resize(width);
        for (size_t i = 0; i < width; ++i) node.weights[i] = float(sample(keys, span, i));
    }
}

void apply_animation(Document& document, size_t index, double time) {
    static const std::set<std::string> paths{"translation", "rotation", "scale", "weights"};
    const GltfAnimation& animation = document.animations[index];
    const std::string place = fmt::format("animations[{}]", index);
    std::set<std::pair<uint32_t, std::string>> moved;
    for (size_t i = 0; i < animation.channels.size(); ++i) {
        const GltfAnimation::Channel& channel = animation.channels[i];
        if (channel.node == none || !paths.contains(channel.path)) continue;
        if (!moved.emplace(channel.node, channel.path).second) {
            document.report(Fault::duplicate_channel,
                            fmt::format("{}.channels[{}].target", place, i),
                            "another channel has the same target");
            continue;
        }
        try {
            apply(document, animation, i, place, time);
        } catch (const FaultyPart& part) {
            document.report(part);
        }
    }
}

size_t find_animation(const Document& document, const std::string& which) {
    std::vector<std::string> names;
    for (const GltfAnimation& animation : document.animations) names.push_back(animation.name);
    if (const auto found = find_choice(names, which)) return *found;
    document.fail("animations", fmt::format("there is no animation \"{}\"; the file has {}", which,
                                            list_choices(names)));
}

}  // namespace

void animate(Document& document, const std::string& which, double time) {
    if (which == "all") {
        for (size_t i = 0; i < document.animations.size(); ++i) apply_animation(document, i, time);
    } else if (!which.empty()) {
        apply_animation(document, find_animation(document, which), time);
    } else if (!document.animations.empty()) {
        if (document.animations.size() > 1)
            document.report(Fault::first_animation, "animations",
                            fmt::format("--time without --animation, and the file has {}",
                                        document.animations.size()));
        apply_animation(document, 0, time);
    }
}

}  // namespace sightline
