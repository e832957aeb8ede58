#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/result.hpp"
#include "protocol/stream.hpp"

namespace mien::net {

class BlobCache;

enum class SourceState {
    connecting,    ///< no header yet, or blobs under way
    playing,       ///< groups flow, or could
    reconnecting,  ///< the connection dropped; `reason` says why; goes on by itself
    ended,         ///< the last group has been handed out; seek() starts again. A live stream goes on by itself when its publisher comes back
    failed,        ///< for good; `reason` says why
};

struct SourceStatus {
    SourceState state = SourceState::connecting;
    std::string reason;
};

/// What a source has done so far; a copy.
struct SourceStatistics {
    std::uint64_t bytes = 0;            ///< read from the socket or the file
    std::uint64_t blob_bytes = 0;       ///< of these, messages of static blobs
    std::uint64_t blobs_from_cache = 0;
    std::uint64_t blobs_fetched = 0;
    std::uint64_t model_bytes = 0;      ///< unpacked, of the static blobs that are here
    std::uint64_t model_size = 0;       ///< likewise, of all in the catalogue; 0: not known yet
    std::string unrefined;              ///< why the refinements that are missing will not come; empty: they will, as far as they were wanted
    std::uint64_t groups = 0;           ///< handed out by next()
    std::uint64_t objects = 0;          ///< of live streams, likewise
    std::uint64_t damaged_groups = 0;   ///< dropped, their checksum or content is wrong
    std::string incomplete;             ///< of a file: why it is not as it was written, its end cut off for instance; empty: it is
    std::uint64_t stale_groups = 0;     ///< dropped, a seek overtook them
    std::uint32_t reconnects = 0;       ///< times the stream went on after its connection was lost; tries that failed do not count
    double round_trip = 0;              ///< seconds, the latest; 0: none measured (files)
    std::optional<double> line;         ///< bit/s that the line takes; none: not known, as for files, or because little is sent
    double until = 0;                   ///< seconds of a recording up to which what is selected of its motion and texture has come; 0: none since the last seek
};

/// What a source hands out: one group of a recording, one object of a live stream, or the end of the stream.
struct Arrival {
    std::uint32_t generation = 0;             ///< what seek() returned; 0 before the first seek
    std::optional<protocol::Group> group;
    std::optional<protocol::LiveObject> object = {};

    bool is_end() const { return !group && !object; }
};

inline constexpr std::uint64_t kWholeModel = ~std::uint64_t(0);

struct SourceOptions {
    double start = 0;                         ///< seconds: where playing begins
    double rate = 1;                          ///< 1: real time; 0: unpaced, as fast as next() is called
    std::shared_ptr<BlobCache> cache;         ///< network only; null: nothing is kept
    /// Network only: bytes (unpacked) that are spent on static blobs before playing begins: what nothing plays without, whatever it takes, and the refinements
    /// that fit beside it (protocol::FetchOrder). What a cache holds is there in any case.
    std::uint64_t start_bytes = kWholeModel;
    bool refine = true;                       ///< network only: the refinements that are left come while the stream plays, one at a time
    std::size_t queue_bytes = 32u << 20;      ///< groups waiting for next(): beyond this the socket is not read
    /// Network only: what is selected at first, asked once before playing begins, when header() and blobs are here; `line` as in SourceStatistics.
    /// Called from a thread of the source's own. Empty: all.
    std::function<std::uint64_t(const protocol::StreamHeader& header, std::optional<double> line)> slots;
    std::string software = "mien";            ///< how the client names itself to the server
    std::chrono::milliseconds first_backoff{250};   ///< before the first reconnect; doubles up to last_backoff
    std::chrono::milliseconds last_backoff{8000};
    std::chrono::milliseconds connect_timeout{5000};
    std::chrono::milliseconds ping_interval{5000};
    std::chrono::milliseconds silence_timeout{15000};   ///< nothing comes although we ping: the connection is dead
    int max_attempts = 4;                     ///< connections tried in a row before the first one has worked
    int max_reconnects = -1;                  ///< and after it has; -1: never gives up
    /// Called on every change of state, from a thread of the source's own, or from inside the call that brought the change
    /// about (`ended` from next()). Must not call the source back.
    std::function<void(const SourceStatus&)> on_status;
};

/// A stream that plays, from a file or a server. Usage:
///
///     auto source = net::open_source("mien://host/name", options);
///     source->wait_ready(10s);                      // header and all static blobs are here, or as many as options.start_bytes asks for
///     decode_model(source->header().model, [&](const Hash& h) { return source->blob(h); });
///     while (auto arrival = source->next(100ms)) ...
///
/// All methods may be called from any thread; next() from one at a time.
class StreamSource {
public:
    virtual ~StreamSource() = default;

    /// Waits until header(), catalogue() and blob() may be used. `unavailable` on time-out; the source's own error when it failed.
    virtual Result<void> wait_ready(std::chrono::milliseconds timeout) = 0;
    virtual const protocol::StreamHeader& header() const = 0;        ///< only when ready
    virtual const protocol::Catalogue& catalogue() const = 0;        ///< only when ready
    /// Unpacked bytes of a static blob; null when the catalogue has no such hash, and of a refinement that is not here yet. Stays valid as long as the
    /// source. When ready.
    virtual const Bytes* blob(const Hash& hash) const = 0;
    /// Waits until more than `bytes` (unpacked) of the static blobs are here, `timeout` at most; how many are. For a thread that takes refinements as they come.
    virtual std::uint64_t wait_model(std::uint64_t bytes, std::chrono::milliseconds timeout) const = 0;

    /// The next group: by group number, then texture last, then slot; none when `timeout` passes without one. After the last group comes one
    /// Arrival that is the end. Groups that an earlier seek made stale never come. A live stream gives its objects instead, each slot's in order
    /// and none left out inside a group; behind the end more may come.
    virtual std::optional<Arrival> next(std::chrono::milliseconds timeout) = 0;

    /// Goes on from the group that contains `seconds` (live: from the newest group); returns the generation number of what comes from now on.
    virtual std::uint32_t seek(double seconds) = 0;
    virtual void pause(bool paused) = 0;             ///< stops the server's clock; files ignore it
    virtual void set_rate(double rate) = 0;          ///< 0: unpaced
    /// Bit s: slot s is wanted, of groups of which nothing has been sent (read) yet. Without a seek some that were sent before may still come.
    virtual void select(std::uint64_t slots) = 0;

    virtual bool live() const { return false; }      ///< only when ready: comes while it is made, and cannot be sought
    virtual SourceStatus status() const = 0;
    virtual SourceStatistics statistics() const = 0;
};

/// A source over a mien:// URL or the path of a stored stream. Network errors show in status(); a bad URL or a file that
/// cannot be opened or read is an error here.
Result<std::unique_ptr<StreamSource>> open_source(std::string_view url_or_path, SourceOptions options = {});

}  // namespace mien::net
