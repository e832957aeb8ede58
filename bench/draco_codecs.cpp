#ifdef MIEN_BENCH_DRACO
#include <draco/core/draco_version.h>

#include "bench/draco.hpp"
#endif
#include "bench/geometry_codec.hpp"

namespace mien::bench {

#ifdef MIEN_BENCH_DRACO
std::string draco_library() {
    return std::string("Draco ") + draco::kDracoVersion;
}

void add_draco(GeometryCodecs& list) {
    list.codecs.push_back(draco_delta_codec());
    list.codecs.push_back(draco_animation_codec());
    list.codecs.push_back(draco_mesh_codec(true));
    list.codecs.push_back(draco_mesh_codec(false));
}
#else
void add_draco(GeometryCodecs& list) {
    for (const char* name : {"draco-cloud-delta", "draco-animation", "draco-mesh-best", "draco-mesh-default"})
        list.absent.emplace_back(name, "Draco was not there when the bench was configured");
}
std::uint64_t draco_connectivity_bytes(const Mesh&, bool) {
    return 0;
}
#endif

}  // namespace mien::bench
