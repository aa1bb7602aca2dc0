#pragma once
// Queries of one kind with their exact answers, and the methods that try them.
#include "core/ray.h"
#include "exact/referee.h"

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace sightline {

/// What a method says of one query.
struct MethodAnswer {
    Hit hit;        ///< what was hit; for queries that are not about a scene, geometry 0 or none
    double t = 0;   ///< where, as precisely as the method says
    int count = 0;  ///< of roots, where a family asks for all of them
};

/// How far a right decision is off. See docs/atlas.md.
enum class Measure : uint8_t { t_ulps, backward, stability, normal_angle, gap };
inline constexpr std::array<std::string_view, 5> measure_names = {"t_ulps", "backward", "stability",
                                                                  "normal_angle", "gap"};
inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();
/// `not_measured` where a measure does not apply.
using Measures = std::array<double, measure_names.size()>;
inline constexpr Measures no_measures = {not_measured, not_measured, not_measured, not_measured,
                                         not_measured};

/// One method at work on all queries of a trial.
struct Entrant {
    std::string method;
    std::function<void()> run;                   ///< answers every query; this is what is timed
    std::function<MethodAnswer(size_t)> answer;  ///< to query i, once run
};

/// The queries of a family at one knob value.
class Trial {
  public:
    virtual ~Trial() = default;

    virtual size_t size() const = 0;
    virtual std::vector<Entrant> entrants(const std::vector<std::string>& methods) = 0;

    /// Several threads may ask about different queries at once, here and below.
    virtual Verdict judge(size_t query, const MethodAnswer& answer) const = 0;
    /// Of a right answer only.
    virtual Measures measure(size_t query, const MethodAnswer& answer) const = 0;

    /// Whether the exact answer is a hit.
    virtual bool hits(size_t query) const = 0;

    /// False where moving one input by one float ulp changes the exact answer.
    virtual bool decidable(size_t query) const = 0;

    /// Of the exact t with respect to all inputs, componentwise; NaN: there is none.
    virtual double condition(size_t query) const = 0;
};

/// A surface point that a ray meets, and what moving the inputs does to it.
struct MeetingPoint {
    double t = not_measured;
    Vec3d normal;       ///< unit
    double across = 0;  ///< |normal · direction|
    double reach = 0;   ///< Σ |∂(height over the surface)/∂x| |x| over all inputs x
    double scale = 0;   ///< largest coordinate of origin and point

    /// For a ray: what its origin and direction contribute.
    MeetingPoint() = default;
    MeetingPoint(const Ray& ray, double at, const Vec3d& unit_normal);

    double condition() const { return reach / (across * std::abs(t)); }
    /// All but the normal's angle and the gap.
    Measures errors(double measured_t) const;
};

/// The angle between two directions, in radians, also where it is tiny.
double angle_between(const Vec3d& a, const Vec3d& b);

/// Σ |a_i b_i|.
double absolute_dot(const Vec3d& a, const Vec3d& b);

}  // namespace sightline
