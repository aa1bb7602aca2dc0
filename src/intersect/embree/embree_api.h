#pragma once
// Embree 3.13 and 4.3 under the same names. The only header that includes Embree; for embree.cpp.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "core/error.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sightline {

/// A hit in Embree's ids; `ray` is the RTCRay's.
struct EngineHit {
    unsigned ray;
    float t, u, v;
    unsigned primitive, geometry, instance;
};

#if RTC_VERSION_MAJOR >= 4
/// What callbacks learn about a call.
struct QueryContext : RTCRayQueryContext {
    std::vector<EngineHit>* collected = nullptr;  ///< all hits go here and none ends the search
};

/// Of scenes for Query::collect.
inline constexpr RTCSceneFlags collecting_flag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

/// The arguments of a call.
struct Query {
    explicit Query(bool coherent) {
        rtcInitRayQueryContext(&context);
        rtcInitIntersectArguments(&closest);
        rtcInitOccludedArguments(&any);
        closest.context = any.context = &context;
        if (coherent) closest.flags = any.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    }
    Query(const Query&) = delete;
    Query& operator=(const Query&) = delete;
    /// From now on `filter` gets each hit.
    void collect(std::vector<EngineHit>& hits, RTCFilterFunctionN filter) {
        context.collected = &hits;
        closest.filter = filter;
        closest.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    }
    QueryContext context;
    RTCIntersectArguments closest;
    RTCOccludedArguments any;
};
inline void trace(const int* valid, RTCScene scene, Query& query, RTCRayHit16& rays) {
    rtcIntersect16(valid, scene, &rays, &query.closest);
}
inline void trace(const int* valid, RTCScene scene, Query& query, RTCRay16& rays) {
    rtcOccluded16(valid, scene, &rays, &query.any);
}
inline void trace(RTCScene scene, Query& query, RTCRayHit& ray) {
    rtcIntersect1(scene, &ray, &query.closest);
}
inline void trace(RTCScene scene, Query& query, RTCRay& ray) {
    rtcOccluded1(scene, &ray, &query.any);
}
#else
/// What callbacks learn about a call.
struct QueryContext : RTCIntersectContext {
    std::vector<EngineHit>* collected = nullptr;  ///< all hits go here and none ends the search
};

/// Of scenes for Query::collect.
inline constexpr RTCSceneFlags collecting_flag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

/// The arguments of a call.
struct Query {
    explicit Query(bool coherent) {
        rtcInitIntersectContext(&context);
        if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    }
    /// From now on `filter` gets each hit.
    void collect(std::vector<EngineHit>& hits, RTCFilterFunctionN filter) {
        context.collected = &hits;
        context.filter = filter;
    }
    QueryContext context;
};
inline void trace(const int* valid, RTCScene scene, Query& query, RTCRayHit16& rays) {
    rtcIntersect16(valid, scene, &query.context, &rays);
}
inline void trace(const int* valid, RTCScene scene, Query& query, RTCRay16& rays) {
    rtcOccluded16(valid, scene, &query.context, &rays);
}
inline void trace(RTCScene scene, Query& query, RTCRayHit& ray) {
    rtcIntersect1(scene, &query.context, &ray);
}
inline void trace(RTCScene scene, Query& query, RTCRay& ray) {
    rtcOccluded1(scene, &query.context, &ray);
}
#endif

template <class T, void (*release)(T)>
struct Release {
    void operator()(T handle) const { release(handle); }
};
using DeviceHandle = std::unique_ptr<RTCDeviceTy, Release<RTCDevice, rtcReleaseDevice>>;
using SceneHandle = std::unique_ptr<RTCSceneTy, Release<RTCScene, rtcReleaseScene>>;
using GeometryHandle = std::unique_ptr<RTCGeometryTy, Release<RTCGeometry, rtcReleaseGeometry>>;

/// Records the bytes that a device holds, and its first error.
class Monitor {
  public:
    size_t bytes() const { return static_cast<size_t>(std::max<ssize_t>(bytes_, 0)); }

    void watch(RTCDevice device) {
        rtcSetDeviceMemoryMonitorFunction(device, &Monitor::on_memory, this);
        rtcSetDeviceErrorFunction(device, &Monitor::on_error, this);
    }

    /// Throws Error, or std::bad_alloc, if the device reported one.
    void check() {
        const std::lock_guard lock(mutex_);
        if (is_out_of_memory_) throw std::bad_alloc();
        if (!error_.empty()) throw Error("Embree: " + error_);
    }

  private:
    static bool on_memory(void* self, ssize_t bytes, bool) {
        static_cast<Monitor*>(self)->bytes_ += bytes;
        return true;
    }
    static void on_error(void* self, RTCError code, const char* text) {
        auto& monitor = *static_cast<Monitor*>(self);
        const std::lock_guard lock(monitor.mutex_);
        if (code == RTC_ERROR_OUT_OF_MEMORY) monitor.is_out_of_memory_ = true;
        if (monitor.error_.empty()) monitor.error_ = text && *text ? text : "unknown error";
    }

    std::atomic<ssize_t> bytes_{0};
    std::mutex mutex_;
    std::string error_;
    bool is_out_of_memory_ = false;
};

/// Throws Error if the instruction set is unknown or not supported by the processor.
inline DeviceHandle new_device(const std::string& isa) {
    constexpr std::array known = {"", "sse2", "sse4.2", "avx", "avx2", "avx512"};
    if (std::find(known.begin(), known.end(), isa) == known.end())
        throw Error("unknown instruction set '" + isa + "': sse2, sse4.2, avx, avx2 or avx512");
    // Large pages make builds a fifth faster. The last option lets spatial splits multiply the
    // number of triangles by up to 4; the default is 1.2.
    const std::string config = "set_affinity=0,hugepages=1,max_spatial_split_replications=4" +
                               (isa.empty() ? "" : ",isa=" + isa);
    DeviceHandle device(rtcNewDevice(config.c_str()));
    if (!device) {
        const bool unsupported = rtcGetDeviceError(nullptr) == RTC_ERROR_UNSUPPORTED_CPU;
        throw Error(unsupported ? "this processor lacks " + isa : "Embree cannot be started");
    }
    if (!rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED))
        throw Error("Embree was built without ray masks");
    return device;
}

/// The instruction set in use: the requested one, else the best of the processor, which follows
/// from the packet sizes that Embree supports natively.
inline std::string isa_of(RTCDevice device, const std::string& requested) {
    if (!requested.empty()) return requested;
#if defined(__x86_64__)
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return "avx512";
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED))
        return __builtin_cpu_supports("avx2") ? "avx2" : "avx";
    return __builtin_cpu_supports("sse4.2") ? "sse4.2" : "sse2";
#else
    return "neon";
#endif
}

}  // namespace sightline
