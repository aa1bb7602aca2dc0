#include "intersect/exact/scene_query.h"

#include "intersect/shapes.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Origins beyond this overflow the traversal's products.
constexpr float farthest_origin = 0x1p90f;

}  // namespace

bool SceneJudge::begin() {
    for (const SurfaceId& id : placed_.unbounded)
        if (!is_hidden(id.geometry) && take(id, {id.primitive, false, -infinity, infinity}, false))
            return true;
    const Vec3& o = ray_.origin;
    return std::max({std::abs(o.x), std::abs(o.y), std::abs(o.z)}) > farthest_origin;
}

void SceneJudge::search_objects() {
    settle();
    const BoxTree& tree = placed_.object_tree;
    if (!tree.root.is_nothing()) traverse(tree, TreeRay(world_ray(), tree), *this);
}

bool SceneJudge::offer(const Finding& finding) {
    settle();
    const SurfaceId id = surface(finding.triangle);
    if (is_hidden(id.geometry)) return false;
    const bool sure =
        finding.certain && finding.low > surely_past_near_ && finding.high < surely_before_far_;
    return take(id, finding, sure);
}

bool SceneJudge::visit(uint32_t first, uint32_t count) {
    for (uint32_t i = first; i < first + count; ++i) {
        const PlacedObject& object = placed_.objects[i];
        bool stop = false;
        if (object.kind == PlacedObject::Kind::meshes)
            stop = enter_meshes(object);
        else if (is_hidden(object.index))
            continue;
        else if (object.kind == PlacedObject::Kind::shape)
            stop = meet_shape(object);
        else
            stop = take({object.instance, object.index, object.primitive},
                        {object.primitive, false, -infinity, infinity}, false);
        if (stop) return true;
    }
    return false;
}

bool SceneJudge::enter_meshes(const PlacedObject& object) {
    tree_ = &placed_.groups[object.index];
    instance_ = object.instance;
    const LocalRay local =
        placed_.entries[object.instance].enter(Vec3d(ray_.origin), Vec3d(direction_), tnear_);
    const TriangleTree& tree = tree_->tree;
    const bool stopped = traverse(tree, TreeRay(local, tree.boxes, tree.largest_edge), *this);
    settle();
    return stopped;
}

bool SceneJudge::meet_shape(const PlacedObject& object) {
    Vec3d origin(ray_.origin), direction(ray_.direction);
    if (!placed_.scene.instances[object.instance].baked) {
        const Entry& entry = placed_.entries[object.instance];
        origin = (origin - entry.translation) * entry.from_world;
        direction = direction * entry.from_world;
    }
    const double tnear = exact_double(ray_.tnear);
    const double tfar = std::min(exact_double(ray_.tfar), to_world(static_cast<double>(reach)));
    const ShapeRoots roots =
        intersect_shape(placed_.scene.shape(object.index), origin, direction, tnear, tfar);
    for (int i = 0; i < roots.count; ++i)
        if (roots.t[i] > tnear) return take_shape({object.instance, object.index, 0}, roots.t[i]);
    return false;
}

bool NearestJudge::take(const SurfaceId& id, const Finding& finding, bool sure) {
    if (sure && finding.high < low_) {
        accept(id, finding.low, finding.high);
        return false;
    }
    if (id == best_) return false;
    const PlacedTriangle triangle = placed_.triangle(id);
    if (!sure && exact_crossing(ray_, triangle) != Crossing::hit) return false;
    if (is_farther(id, triangle)) return false;
    float low = finding.low, high = finding.high;
    if (!std::isfinite(low) || !std::isfinite(high)) {
        const Enclosure t = enclose_t(ray_, triangle);
        low = float_below(to_tree(t.low));
        high = float_above(to_tree(t.high));
    }
    accept(id, low, high);
    return false;
}

bool NearestJudge::is_farther(const SurfaceId& id, const PlacedTriangle& triangle) const {
    if (best_.geometry == none) return false;
    int order = 0;
    if (shape_t_) {
        const double t = exact_hit(ray_, triangle).t;
        order = t < *shape_t_ ? -1 : t > *shape_t_;
    } else {
        order = compare_exactly(ray_, triangle, placed_.triangle(best_));
    }
    return order != 0 ? order > 0 : best_ < id;
}

bool NearestJudge::take_shape(const SurfaceId& id, double t) {
    const double tree_t = to_tree(t);
    if (!(tree_t < static_cast<double>(low_))) {
        if (tree_t > static_cast<double>(reach)) return false;
        const double best = shape_t_ ? *shape_t_ : exact_hit(ray_, placed_.triangle(best_)).t;
        if (t > best || (t == best && best_ < id)) return false;
    }
    accept(id, float_below(tree_t), float_above(tree_t));
    shape_t_ = t;
    return false;
}

void NearestJudge::accept(const SurfaceId& id, float low, float high) {
    best_ = id;
    low_ = low;
    sure_to = std::min(sure_to, low);
    reach = std::min(reach, high);
    shape_t_.reset();
}

void NearestJudge::prefetch_triangle() const {
    if (best_.geometry == none || shape_t_) return;
    __builtin_prefetch(&placed_.scene.meshes[best_.geometry].triangles[best_.primitive]);
}

void NearestJudge::prefetch_corners() const {
    if (best_.geometry == none || shape_t_) return;
    const Mesh& mesh = placed_.scene.meshes[best_.geometry];
    for (const uint32_t corner : mesh.triangles[best_.primitive])
        __builtin_prefetch(&mesh.positions[corner]);
}

bool AnyJudge::take(const SurfaceId& id, const Finding&, bool sure) {
    return blocked_ = sure || exact_crossing(ray_, placed_.triangle(id)) == Crossing::hit;
}

}  // namespace sightline
