// Embree with nothing around it: builds over a scene's triangles and traces recorded rays one by
// one. bare_embree SCENE [RAYS [THREADS]] prints one line of JSON. RAYS is a file of --record-rays.
// bare_embree --ours SCENE times Sightline's build in its place: each starts its threads.
#include "core/error.h"
#include "intersect/embree/embree.h"
#include "intersect/ray_file.h"
#include "scene/gltf/load.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <thread>

namespace {

using namespace sightline;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The bytes that a device holds, and the most that it has held.
struct DeviceMemory {
    std::atomic<ssize_t> bytes{0}, peak{0};

    static bool on_change(void* self, ssize_t change, bool) {
        auto& memory = *static_cast<DeviceMemory*>(self);
        const ssize_t bytes = memory.bytes += change;
        ssize_t peak = memory.peak;
        while (bytes > peak && !memory.peak.compare_exchange_weak(peak, bytes)) {
        }
        return true;
    }
};

/// Attaches one mesh of one instance, with its vertices padded as Embree requires.
void attach(RTCDevice device, RTCScene scene, const Mesh& mesh, const Mat4& to_world) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<Vec3*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                                RTC_FORMAT_FLOAT3, sizeof(Vec3),
                                                                mesh.positions.size()));
    for (size_t i = 0; i < mesh.positions.size(); ++i)
        vertices[i] = transform_point(mesh.positions[i], to_world);
    auto* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(uint32_t), mesh.triangles.size());
    std::memcpy(indices, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(uint32_t));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
}

RTCRay embree_ray(const Ray& from) {
    RTCRay ray{};
    ray.org_x = from.origin[0], ray.org_y = from.origin[1], ray.org_z = from.origin[2];
    ray.dir_x = from.direction[0], ray.dir_y = from.direction[1], ray.dir_z = from.direction[2];
    ray.tnear = from.tnear, ray.tfar = from.tfar;
    ray.mask = ~0u;
    return ray;
}

#if RTC_VERSION_MAJOR >= 4
void intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray); }
void occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray); }
#else
void intersect(RTCScene scene, RTCRayHit& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &ray);
}
void occluded(RTCScene scene, RTCRay& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &ray);
}
#endif

/// Traces the rays and returns the number of hits, so that no call can be optimised away.
uint64_t trace(RTCScene scene, const std::vector<RecordedRay>& rays, std::atomic<size_t>& next) {
    constexpr size_t chunk = 4096;
    uint64_t hits = 0;
    for (size_t begin; (begin = next.fetch_add(chunk)) < rays.size();) {
        const size_t end = std::min(begin + chunk, rays.size());
        for (size_t i = begin; i < end; ++i) {
            if (rays[i].kind == RayKind::shadow) {
                RTCRay ray = embree_ray(rays[i].ray);
                occluded(scene, ray);
                hits += ray.tfar < 0;
            } else {
                RTCRayHit ray{};
                ray.ray = embree_ray(rays[i].ray);
                ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                intersect(scene, ray);
                hits += ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
            }
        }
    }
    return hits;
}

Scene load(const std::string& path) {
    LoadOptions options;
    options.decode_images = false;
    return load_gltf(path, options);
}

void run_ours(const std::string& scene_path) {
    const Scene scene = load(scene_path);
    const auto start = Clock::now();
    const auto intersector = make_embree(scene);
    fmt::print("{{\"build\": {:.6f}}}\n", seconds_since(start));
}

void run(const std::string& scene_path, const std::string& rays_path, unsigned threads) {
    const Scene source = load(scene_path);
    RTCDevice device = rtcNewDevice(fmt::format("threads={}", threads).c_str());
    DeviceMemory memory;
    rtcSetDeviceMemoryMonitorFunction(device, &DeviceMemory::on_change, &memory);
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    for (const Instance& instance : source.instances)
        for (const uint32_t mesh : source.groups[instance.group].meshes)
            attach(device, scene, source.meshes[mesh], instance.object_to_world);
    const ssize_t buffers = memory.bytes;
    const auto build_start = Clock::now();
    rtcCommitScene(scene);
    const double build = seconds_since(build_start);

    const auto rays = rays_path.empty() ? std::vector<RecordedRay>() : read_rays(rays_path).rays;
    std::atomic<size_t> next{0};
    std::atomic<uint64_t> hits{0};
    const auto trace_start = Clock::now();
    {
        std::vector<std::jthread> workers;
        for (unsigned i = 0; i < threads; ++i)
            workers.emplace_back([&] { hits += trace(scene, rays, next); });
    }
    fmt::print(
        "{{\"build\": {:.6f}, \"trace\": {:.6f}, \"rays\": {}, \"hits\": {}, \"bytes\": {}, "
        "\"peak_without_buffers\": {}}}\n",
        build, seconds_since(trace_start), rays.size(), hits.load(), memory.bytes.load(),
        memory.peak - buffers);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        fmt::print(stderr, "usage: bare_embree SCENE [RAYS [THREADS]] | --ours SCENE\n");
        return 2;
    }
    try {
        if (argc == 3 && std::string_view(argv[1]) == "--ours") return run_ours(argv[2]), 0;
        run(argv[1], argc > 2 ? argv[2] : "", argc > 3 ? unsigned(std::atoi(argv[3])) : 2);
    } catch (const Error& error) {
        fmt::print(stderr, "bare_embree: {}\n", error.what());
        return 1;
    }
}
