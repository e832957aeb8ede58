#pragma once

#include <functional>
#include <memory>

#include "player/decode_thread.hpp"
#include "player/options.hpp"
#include "player/refiner.hpp"
#include "player/statistics.hpp"

namespace mien::player {

/// A stream that is open: its source, what it announces, and the thread that decodes it.
struct Session {
    std::unique_ptr<net::StreamSource> source;
    std::unique_ptr<StreamModel> stream;
    std::unique_ptr<Refiner> refiner;       ///< null: nothing is missing of the model, or nothing more was asked for
    std::unique_ptr<DecodeThread> decode;   // last: it goes first

    double start = 0;                       ///< seconds: where the source begins
    bool networked = false;                 ///< from a server, not from a file
    bool adapts = false;                    ///< the rung of texture follows the line, as asked

    void collect(Statistics& statistics) const;
    /// Why the model will not get better although something of it is missing, one sentence; empty: nothing is wrong.
    std::string unrefined() const;
    std::uint64_t motion_bytes() const;     ///< of all its rungs
    std::uint64_t texture_bytes() const;    ///< likewise
};

struct SessionOptions {
    net::SourceOptions source;
    bool sound = true;
    std::size_t motion_rungs = 64;          ///< at most
    TextureChoice texture;
    bool sound_first = false;               ///< only the sound is asked for at first, when there is any
    double delay = 0;                       ///< seconds that frames of a live stream wait to be shown evenly
    double wait = 20;                       ///< seconds until the stream must be ready
    /// Where decoded sound goes; may be set by what is known only after the header has come.
    std::function<DecodeThread::SoundSink(const StreamModel&)> sound_sink;
    std::function<bool()> give_up;          ///< asked while waiting; true ends it
};

/// Opens a URL or file and waits until it can play.
Result<Session> open_session(const std::string& input, SessionOptions options);

/// The blob cache that the options ask for; null for none. A folder that cannot be made is told on stderr and done without.
std::shared_ptr<net::BlobCache> open_cache(const Options& options);

}  // namespace mien::player
