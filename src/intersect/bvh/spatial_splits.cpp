#include "intersect/bvh/spatial_splits.h"

#include "exact/bounded.h"
#include "intersect/embree/build_quality.h"

#include <algorithm>
#include <bit>

namespace sightline {
namespace {

constexpr double max_added_share = 0.3;

double longest_side(const Box3& box) {
    const Vec3d s = Vec3d(box.max) - Vec3d(box.min);
    return std::max({s.x, s.y, s.z});
}

/// A plane that cuts a box. `level` is that of the plane in a hierarchy of halvings.
struct Cut {
    int axis = -1, level = 0;
    float plane = 0;

    explicit operator bool() const { return axis >= 0; }
};

/// A hierarchy of halved cubes over all boxes. A box is cut at the coarsest plane that goes through
/// it, where the boxes of its neighbours end, too.
class CutGrid {
  public:
    explicit CutGrid(const Box3& bounds)
        : origin_(bounds.min),
          cells_per_unit_(longest_side(bounds) > 0 ? cells / longest_side(bounds) : 0) {}

    Cut cut(const Box3& box) const {
        Cut best;
        for (int axis = 0; axis < 3; ++axis) {
            const uint32_t low = cell(box.min[axis], axis), high = cell(box.max[axis], axis);
            const int level = std::bit_width(low ^ high);
            if (level == 0) continue;
            const uint32_t at = high >> (level - 1) << (level - 1);
            const auto plane = static_cast<float>(origin_[axis] + at / cells_per_unit_);
            if (!(box.min[axis] < plane && plane < box.max[axis])) continue;
            const bool longer =
                best && box.max[axis] - box.min[axis] > box.max[best.axis] - box.min[best.axis];
            if (level > best.level || (level == best.level && longer)) best = {axis, level, plane};
        }
        return best;
    }

  private:
    static constexpr double cells = 1 << 20;

    uint32_t cell(float x, int axis) const {
        const double position = (static_cast<double>(x) - origin_[axis]) * cells_per_unit_;
        return static_cast<uint32_t>(std::clamp(position, 0.0, cells));
    }

    Vec3d origin_;
    double cells_per_unit_;
};

/// Extends `box` by the point at which the edge from p to q crosses the plane. Its rounding error
/// is less than seven units of |p| + |q|; sixteen are allowed.
void extend_by_crossing(Box3& box, const Vec3& p, const Vec3& q, const Cut& cut) {
    const double from = exact_double(p[cut.axis]), to = exact_double(q[cut.axis]);
    const double share = (exact_double(cut.plane) - from) / (to - from);
    for (int i = 0; i < 3; ++i) {
        const double a = exact_double(p[i]), b = exact_double(q[i]);
        const double x = a + share * (b - a), error = (std::abs(a) + std::abs(b)) * 0x1p-49;
        const bool on_plane = i == cut.axis;
        box.min[i] = std::min(box.min[i], on_plane ? cut.plane : float_below(x - error));
        box.max[i] = std::max(box.max[i], on_plane ? cut.plane : float_above(x + error));
    }
}

/// A box around the part of the triangle that lies in `box` and on one side of the plane (−1:
/// below); both sides include the plane itself. May be empty.
Box3 part_of(const Corners<float>& triangle, const Box3& box, const Cut& cut, int side) {
    const Vec3* corners[] = {&triangle.a, &triangle.b, &triangle.c};
    Box3 part;
    for (int i = 0; i < 3; ++i) {
        const Vec3 &p = *corners[i], &q = *corners[(i + 1) % 3];
        const float x = p[cut.axis], y = q[cut.axis];
        if (side < 0 ? x <= cut.plane : x >= cut.plane) part.extendBy(p);
        if ((x < cut.plane && y > cut.plane) || (x > cut.plane && y < cut.plane))
            extend_by_crossing(part, p, q, cut);
    }
    for (int i = 0; i < 3; ++i) {
        part.min[i] = std::max(part.min[i], box.min[i]);
        part.max[i] = std::min(part.max[i], box.max[i]);
    }
    return part;
}

class BoxSplitter {
  public:
    BoxSplitter(std::vector<Box3>& boxes, std::vector<uint32_t>& numbers,
                const std::function<Corners<float>(uint32_t)>& corners)
        : boxes_(boxes), numbers_(numbers), corners_(corners), grid_(bounds_of(boxes)) {}

    void run() {
        const size_t count = boxes_.size();
        std::vector<float> priorities(count);
        for (size_t i = 0; i < count; ++i) priorities[i] = priority(i);
        const double per_priority = cuts_per_priority(priorities);
        for (size_t i = 0; i < count; ++i) {
            const auto cuts =
                static_cast<uint32_t>(per_priority * static_cast<double>(priorities[i]));
            if (cuts == 0) continue;
            parts_.clear();
            split(corners_(numbers_[i]), boxes_[i], cuts);
            boxes_[i] = parts_.front();
            boxes_.insert(boxes_.end(), parts_.begin() + 1, parts_.end());
            numbers_.insert(numbers_.end(), parts_.size() - 1, numbers_[i]);
        }
    }

  private:
    static Box3 bounds_of(const std::vector<Box3>& boxes) {
        Box3 bounds;
        for (const Box3& box : boxes) bounds.extendBy(box);
        return bounds;
    }

    /// The expected gain: the area in excess of that of the smallest boxes, weighted by the level
    /// of the plane.
    float priority(size_t i) const {
        const Cut cut = grid_.cut(boxes_[i]);
        if (!cut) return 0;
        const Corners<float> triangle = corners_(numbers_[i]);
        const Vec3d a(triangle.a), n = cross(Vec3d(triangle.b) - a, Vec3d(triangle.c) - a);
        const double least = 0.5 * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
        const double gain = std::max(0.0, half_area(boxes_[i]) - least);
        return static_cast<float>(std::cbrt(std::ldexp(gain, cut.level)));
    }

    /// The largest factor with which the added boxes stay within their share.
    static double cuts_per_priority(const std::vector<float>& priorities) {
        const double allowed = max_added_share * static_cast<double>(priorities.size());
        double sum = 0;
        for (const float p : priorities) sum += static_cast<double>(p);
        if (sum == 0) return 0;
        double low = allowed / sum, high = (allowed + static_cast<double>(priorities.size())) / sum;
        for (int round = 0; round < 12; ++round) {
            const double middle = 0.5 * (low + high);
            double cuts = 0;
            for (const float p : priorities) cuts += std::floor(middle * static_cast<double>(p));
            (cuts <= allowed ? low : high) = middle;
        }
        return low;
    }

    void split(const Corners<float>& triangle, const Box3& box, uint32_t cuts) {
        const Cut cut = cuts > 0 ? grid_.cut(box) : Cut();
        if (!cut) {
            parts_.push_back(box);
            return;
        }
        const Box3 below = part_of(triangle, box, cut, -1), above = part_of(triangle, box, cut, 1);
        if (below.isEmpty() && above.isEmpty()) return;  // the box exists by rounding only
        if (below.isEmpty() || above.isEmpty()) {
            split(triangle, below.isEmpty() ? above : below, cuts - 1);
            return;
        }
        const double below_side = longest_side(below), above_side = longest_side(above);
        const auto cuts_below = static_cast<uint32_t>(
            static_cast<double>(cuts - 1) * below_side / (below_side + above_side) + 0.5);
        split(triangle, below, cuts_below);
        split(triangle, above, cuts - 1 - cuts_below);
    }

    std::vector<Box3>& boxes_;
    std::vector<uint32_t>& numbers_;
    const std::function<Corners<float>(uint32_t)>& corners_;
    CutGrid grid_;
    std::vector<Box3> parts_;  ///< of one triangle
};

}  // namespace

void split_boxes(std::vector<Box3>& boxes, std::vector<uint32_t>& numbers,
                 const std::function<Corners<float>(uint32_t)>& corners) {
    if (!boxes.empty()) BoxSplitter(boxes, numbers, corners).run();
}

}  // namespace sightline
