#include "samples/stage_texture.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/parallel.hpp"

namespace mien::samples {

StageTexture::StageTexture(const Actor& actor, const Skin& skin, const std::vector<Instant>& instants)
    : actor_(actor), skin_(skin), instants_(instants) {}

Result<Image> StageTexture::read(std::int64_t frame) {
    if (frame < 0 || frame >= frames())
        return Error{ErrorCode::invalid, fmt::format("the texture has no frame {}", frame)};
    if (frame < first_ || frame >= first_ + std::int64_t(ready_.size())) {
        first_ = frame;
        ready_.assign(std::size_t(std::min<std::int64_t>(2 * thread_count(), frames() - frame)), {});
        parallel_for(std::int64_t(ready_.size()), [&](std::int64_t i) {
            const Instant& instant = instants_[std::size_t(first_ + i)];
            ready_[std::size_t(i)] = skin_.texture(instant, actor_.deform(instant));
        });
    }
    return ready_[std::size_t(frame - first_)];
}

}  // namespace mien::samples
