#pragma once

#include <memory>

#include "net/blob_cache.hpp"
#include "net/source.hpp"
#include "net/url.hpp"

namespace mien::net {

/// Plays a stream of a server. Runs a thread of its own; the constructor returns at once and connects in the background.
/// When the connection drops it reconnects with exponential back-off and jitter and goes on where it was, without fetching
/// any blob again; groups that were handed out never come twice. Refinements of the model that options.start_bytes left out come while it plays;
/// when one is damaged, what is here plays on without it.
class Client final : public StreamSource {
public:
    Client(Url url, SourceOptions options);
    ~Client() override;  ///< says goodbye and joins the thread

    Result<void> wait_ready(std::chrono::milliseconds timeout) override;
    const protocol::StreamHeader& header() const override;
    const protocol::Catalogue& catalogue() const override;
    const Bytes* blob(const Hash& hash) const override;
    std::uint64_t wait_model(std::uint64_t bytes, std::chrono::milliseconds timeout) const override;
    std::optional<Arrival> next(std::chrono::milliseconds timeout) override;
    std::uint32_t seek(double seconds) override;
    void pause(bool paused) override;
    void set_rate(double rate) override;
    void select(std::uint64_t slots) override;
    bool live() const override;
    SourceStatus status() const override;
    SourceStatistics statistics() const override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mien::net
