#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "net/source.hpp"
#include "net/url.hpp"
#include "protocol/messages.hpp"

namespace mien::net {

struct PublisherOptions {
    std::string software = "mien";                  ///< how it names itself to the server
    std::size_t queue_bytes = 1u << 20;             ///< waiting to be sent: beyond this objects are dropped up to the next group
    std::chrono::milliseconds first_backoff{250};   ///< before the first reconnect; doubles up to last_backoff
    std::chrono::milliseconds last_backoff{4000};
    std::chrono::milliseconds connect_timeout{5000};
    std::chrono::milliseconds ping_interval{5000};
    std::chrono::milliseconds silence_timeout{15000};
    int max_reconnects = -1;                        ///< in a row, once it has worked; -1: never gives up
    std::function<void(const SourceStatus&)> on_status;   ///< on every change, from a thread of the publisher's own
};

struct PublisherStatistics {
    std::uint64_t objects = 0;         ///< given to the socket
    std::uint64_t bytes = 0;           ///< likewise, with framing
    std::uint64_t dropped = 0;         ///< objects that were not sent: no connection, or a line too slow
    std::uint32_t reconnects = 0;      ///< times the server took the stream again; tries that failed do not count
};

/// Sends a live stream to a server (mien-serve --publish), from a thread of its own. When the connection drops it comes back by itself,
/// and the stream goes on at the next group. Numbers of groups and times are the caller's own; where somebody has published the same
/// stream before, they are moved behind what there was.
class Publisher {
public:
    /// header.frames is 0; the blobs are all that the header and its model name. Connects in the background.
    Publisher(Url url, protocol::StreamHeader header, std::vector<protocol::StaticBlob> blobs, PublisherOptions options = {});
    ~Publisher();   ///< what is queued is still sent, END last, for a second at most

    /// Waits until the server has taken the stream. Errors: its refusal, or that it did not answer in time.
    Result<void> wait_ready(std::chrono::milliseconds timeout);

    /// The objects of this slot that follow are of this group. Groups ascend, and all slots come to a new one together.
    void start_group(const protocol::GroupStart& start);
    void send(protocol::LiveBytes object);

    SourceStatus status() const;
    PublisherStatistics statistics() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mien::net
