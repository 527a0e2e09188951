// SPDX-License-Identifier: Apache-2.0
// Ray queries with Embree 3 or 4, which differ in the context argument.
#include "intersect.h"

#include <cstring>

#include "files.h"

#if BN_EMBREE_MAJOR == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#if defined(__SSE__) || defined(_M_X64)
#include <xmmintrin.h>
#endif

struct Geometry {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;

    ~Geometry() {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }
};

namespace {

// Marks rays that pass through the backs of single-sided surfaces.
constexpr unsigned SEES_FRONTS = 1;

// Lets rays continue through cut-outs and through the backs of single-sided surfaces.
void pass_through(const RTCFilterFunctionNArguments *query) {
    const auto &scene = *static_cast<const Scene *>(query->geometryUserPtr);
    const RTCHit hit = rtcGetHitFromHitN(query->hit, query->N, 0);
    const RTCRay ray = rtcGetRayFromRayN(query->ray, query->N, 0);
    const Vec3 normal = {hit.Ng_x, hit.Ng_y, hit.Ng_z};
    const bool unseen = ray.id == SEES_FRONTS && material_of(scene, hit.primID).single_sided &&
                        dot(normal, {ray.dir_x, ray.dir_y, ray.dir_z}) > 0;
    if (unseen || (scene.has_cut_outs && is_cut_out(scene, {hit.primID, hit.u, hit.v})))
        query->valid[0] = 0;
}

RTCRay make_ray(Vec3 from, Vec3 by, float far, float time) {
    return {from.x, from.y, from.z, 0, by.x, by.y, by.z, time, far, 0xffffffffu, 0, 0};
}

template <typename Function, typename Query>
void ask(Function function, const Geometry &geometry, Query &query) {
#if BN_EMBREE_MAJOR == 4
    function(geometry.scene, &query, nullptr);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    function(geometry.scene, &context, &query);
#endif
}

} // namespace

GeometryPointer geometry_build(const Scene &scene) {
    const auto geometry = std::make_shared<Geometry>();
    geometry->device = rtcNewDevice(nullptr);
    if (!geometry->device)
        throw Error("Embree cannot start on this machine, or not with so little --max-memory");

    // Robust mode: rays must not slip through the seam between neighbouring triangles.
    geometry->scene = rtcNewScene(geometry->device);
    rtcSetSceneFlags(geometry->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(geometry->scene, RTC_BUILD_QUALITY_HIGH);

    RTCGeometry mesh = rtcNewGeometry(geometry->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto fill = [mesh](RTCBufferType type, unsigned step, RTCFormat format,
                             const auto &from) {
        const size_t size = sizeof from[0], count = from.size();
        void *to = rtcSetNewGeometryBuffer(mesh, type, step, format, size, count);
        if (to && count > 0) std::memcpy(to, from.data(), size * count);
    };
    fill(RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, scene.vertices);
    fill(RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, scene.triangles);
    if (!scene.motions.empty()) {
        std::vector<Vec3> ends = scene.vertices;
        for (size_t i = 0; i < ends.size(); ++i) ends[i] += scene.motions[i];
        rtcSetGeometryTimeStepCount(mesh, 2);
        fill(RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3, ends);
    }
    if (scene.has_cut_outs || scene.has_single_sided) {
        rtcSetGeometryUserData(mesh, const_cast<Scene *>(&scene)); // read-only
        rtcSetGeometryIntersectFilterFunction(mesh, pass_through);
        if (scene.has_cut_outs) rtcSetGeometryOccludedFilterFunction(mesh, pass_through);
    }
    const RTCError error = rtcGetDeviceError(geometry->device);
    if (error == RTC_ERROR_NONE) {
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(geometry->scene, mesh);
        rtcCommitScene(geometry->scene);
    }
    rtcReleaseGeometry(mesh);
    if (error != RTC_ERROR_NONE || rtcGetDeviceError(geometry->device) != RTC_ERROR_NONE)
        throw Error("Embree cannot build the scene: out of memory; see --max-memory");
    return geometry;
}

void geometry_thread_begin() {
#if defined(__SSE__) || defined(_M_X64)
    const unsigned flush_to_zero = 0x8000, denormals_are_zero = 0x0040;
    _mm_setcsr(_mm_getcsr() | flush_to_zero | denormals_are_zero);
#endif
}

bool intersect(const Geometry &geometry, const Ray &ray, bool seen_by_camera, Hit &hit) {
    RTCRayHit query;
    query.ray = make_ray(ray.origin, ray.direction, INFINITY, ray.time);
    if (seen_by_camera) query.ray.id = SEES_FRONTS;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    ask(rtcIntersect1, geometry, query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit.distance = query.ray.tfar;
    hit.point = {query.hit.primID, query.hit.u, query.hit.v};
    hit.normal = normalize_or({query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}, -ray.direction);
    return true;
}

bool occluded(const Geometry &geometry, Vec3 from, Vec3 to, float time) {
    RTCRay ray = make_ray(from, to - from, 1, time);
    ask(rtcOccluded1, geometry, ray);
    return ray.tfar < 0;
}
