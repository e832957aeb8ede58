#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "decoder/detail_decoder.hpp"
#include "player/stream_model.hpp"
#include "render/detail_pictures.hpp"

namespace mien::player {

/// Decodes the refinements of a face model that come while its stream plays, on a thread of its own: what draws only has to hand the result to the GPU.
class Refiner {
public:
    /// `decoder`: what has come so far (StreamModel::growing). `source` and `stream` outlive the refiner.
    Refiner(const net::StreamSource& source, const StreamModel& stream, std::unique_ptr<decoder::DetailDecoder> decoder);
    ~Refiner();

    /// The maps that have changed since they were last taken, with all stages that are decoded; null: none has.
    std::shared_ptr<const render::DetailPictures> take();
    /// Why what came cannot be decoded, one sentence: the maps stay as they are. Empty: nothing is wrong.
    std::string trouble() const;

private:
    void run();
    Result<void> decode();

    const net::StreamSource& source_;
    const StreamModel& stream_;
    std::unique_ptr<decoder::DetailDecoder> decoder_;   // the thread's
    std::atomic<bool> stopping_ = false;
    mutable std::mutex mutex_;
    std::shared_ptr<render::DetailPictures> ready_;
    std::string trouble_;
    std::thread thread_;                                // last: it uses all of the above
};

}  // namespace mien::player
