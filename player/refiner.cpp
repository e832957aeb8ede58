#include "player/refiner.hpp"

#include <chrono>

namespace mien::player {

using namespace std::chrono_literals;

Refiner::Refiner(const net::StreamSource& source, const StreamModel& stream, std::unique_ptr<decoder::DetailDecoder> decoder)
    : source_(source), stream_(stream), decoder_(std::move(decoder)), thread_([this] { run(); }) {}

Refiner::~Refiner() {
    stopping_ = true;
    thread_.join();
}

void Refiner::run() {
    std::uint64_t seen = 0;   // bytes of the model: something may have come since the decoder last looked
    while (!stopping_ && !decoder_->complete()) {
        const std::uint64_t here = source_.wait_model(seen, 50ms);
        if (here == seen) continue;
        seen = here;
        if (auto decoded = decode(); !decoded.ok()) {
            const std::lock_guard lock(mutex_);
            trouble_ = "the detail of the face stays as it is: " + decoded.error().message;
            break;
        }
        if (seen >= source_.statistics().model_size) break;   // whatever its maps announce, there is no more
    }
    decoder_.reset();
}

Result<void> Refiner::decode() {
    MIEN_TRY(changed, decoder_->update([this](const Hash& hash) { return source_.blob(hash); }));
    if (!changed.any()) return {};
    auto pictures = std::make_shared<render::DetailPictures>();
    const auto& still = stream_.model.static_albedo;
    if (changed.fine || changed.albedo) pictures->maps = render::map_pictures(decoder_->model(), still ? &*still : nullptr);
    if (changed.medium) pictures->medium = render::medium_coefficients(decoder_->model(), stream_.model.detail->medium_surface());
    const std::lock_guard lock(mutex_);
    if (ready_ && pictures->maps.empty()) pictures->maps = std::move(ready_->maps);
    if (ready_ && pictures->medium.empty()) pictures->medium = std::move(ready_->medium);
    ready_ = std::move(pictures);
    return {};
}

std::shared_ptr<const render::DetailPictures> Refiner::take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(ready_, nullptr);
}

std::string Refiner::trouble() const {
    const std::lock_guard lock(mutex_);
    return trouble_;
}

}  // namespace mien::player
