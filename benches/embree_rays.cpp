// Rays a second of Embree 3's rtcIntersect1 and rtcOccluded1 on one thread, for benches/rays.rs to run beside its own:
//   c++ -O3 -march=native benches/embree_rays.cpp -o embree_rays -lembree3
//   EMBREE_RAYS=$PWD/embree_rays cargo bench --bench rays
// usage: embree_rays FILE. FILE: u32 triangles, 9 floats each; then until its end a set of rays: u32 count, u32 kind
// (0 closest, 1 any), 6 floats each (origin, direction). Prints for every set: Mrays/s, hits, sum of distances.
#include <embree3/rtcore.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <vector>

static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int main(int argc, char **argv) {
    FILE *f = argc == 2 ? std::fopen(argv[1], "rb") : nullptr;
    if (!f) return 1;
    uint32_t n = 0;
    if (std::fread(&n, 4, 1, f) != 1) return 1;
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = rtcNewScene(device);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto *v = (float *)rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * n);
    auto *i = (uint32_t *)rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, n);
    if (std::fread(v, 36, n, f) != n) return 1;
    for (uint32_t k = 0; k < 3 * n; ++k) i[k] = k;
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    double start = now();
    rtcCommitScene(scene);
    std::fprintf(stderr, "embree: built in %.3f s\n", now() - start);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    uint32_t head[2];
    while (std::fread(head, 4, 2, f) == 2) {
        std::vector<float> rays(6 * size_t(head[0]));
        if (std::fread(rays.data(), 24, head[0], f) != head[0]) return 1;
        double best = 1e9, sum = 0;
        uint32_t hits = 0;
        for (int run = 0; run < 3; ++run) {
            hits = 0, sum = 0;
            start = now();
            for (uint32_t k = 0; k < head[0]; ++k) {
                RTCRayHit r;
                std::memcpy(&r.ray.org_x, &rays[6 * k], 12);
                std::memcpy(&r.ray.dir_x, &rays[6 * k + 3], 12);
                r.ray.tnear = 0, r.ray.tfar = std::numeric_limits<float>::infinity();
                r.ray.mask = -1u, r.ray.flags = 0, r.ray.time = 0;
                if (head[1] == 0) {
                    r.hit.geomID = RTC_INVALID_GEOMETRY_ID, r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
                    rtcIntersect1(scene, &context, &r);
                    if (r.hit.geomID != RTC_INVALID_GEOMETRY_ID) ++hits, sum += r.ray.tfar;
                } else {
                    rtcOccluded1(scene, &context, &r.ray);
                    hits += r.ray.tfar < 0;
                }
            }
            double time = now() - start;
            if (time < best) best = time;
        }
        std::printf("%.4f %u %.6g\n", head[0] / best * 1e-6, hits, sum);
    }
    return 0;
}
