#include "net/viewer.hpp"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>

#include <algorithm>
#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>

#include "net/off_thread.hpp"

namespace mien::net {

using protocol::FailureCode;

namespace {

constexpr std::size_t kMaxReplies = 64;     // short answers waiting; a viewer that asks on without reading is not served
constexpr std::size_t kMaxReplyBytes = 4u << 20;
constexpr auto kLastWords = std::chrono::seconds(2);   // to take FAILURE or BYE
constexpr int kSendBuffer = 256 << 10;      // bytes in the kernel: what a seek has to wait for, and enough for 20 Mbit/s at 100 ms
constexpr int kUnsent = 32 << 10;           // of these, bytes that the line has not taken yet: what SELECT and a seek wait for on a slow one

std::string address_of(const asio::ip::tcp::socket& socket) {
    std::error_code error;
    const auto endpoint = socket.remote_endpoint(error);
    return error ? "a viewer that has gone" : fmt::format("{}:{}", endpoint.address().to_string(), endpoint.port());
}

Clock::duration seconds_of(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::clamp(seconds, 0.0, 3600.0)));
}

Result<protocol::BlobPart> part_of(ByteView message, const protocol::WantPart& wanted) {
    if (wanted.offset >= message.size()) return Error{ErrorCode::invalid, fmt::format("static blob {} has no byte {}", wanted.hash.hex().substr(0, 8), wanted.offset)};
    const ByteView rest = message.subspan(wanted.offset);
    const ByteView part = rest.first(std::min<std::size_t>(rest.size(), wanted.bytes));
    return protocol::BlobPart{message.size(), Bytes(part.begin(), part.end())};
}

/// A name for the log: whatever a viewer sends, a line stays a line.
std::string printable(const std::string& text) {
    std::string out;
    for (const char c : text.substr(0, 80)) out += c >= 32 && c < 127 ? c : '?';
    return out;
}

}  // namespace

Viewer::Viewer(asio::ip::tcp::socket socket, ServerShared& shared, std::uint64_t number)
    : shared_(shared), number_(number), peer_(address_of(socket)), wire_(std::move(socket)),
      bell_(wire_.socket().get_executor()), guard_(wire_.socket().get_executor()) {
    std::error_code ignored;
    wire_.socket().set_option(asio::ip::tcp::no_delay(true), ignored);
    wire_.socket().set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
#ifdef TCP_NOTSENT_LOWAT
    (void)::setsockopt(wire_.socket().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsent, sizeof kUnsent);
#endif
    ++shared_.viewers;
}

Viewer::~Viewer() {
    close_stream();
    hold(0);
    --shared_.viewers;
    shared_.log(fmt::format("viewer {} left: {}", number_, why_));
}

void Viewer::start() {
    shared_.log(fmt::format("viewer {} came from {}", number_, peer_));
    const auto run = [this](asio::awaitable<void> task) {
        asio::co_spawn(wire_.socket().get_executor(), std::move(task), [self = shared_from_this()](std::exception_ptr failed) {
            if (!failed) return;
            try {
                std::rethrow_exception(failed);
            } catch (const std::exception& e) {
                self->drop(e.what());
            }
        });
    };
    run(read_messages());
    run(write_messages());
    run(watch());
}

void Viewer::drop(const std::string& why) {
    if (closed_) return;
    closed_ = true;
    why_ = why;
    wire_.close();
    publication_.reset();
    bell_.cancel();
    guard_.cancel();
}

void Viewer::close_with(const protocol::Message& last) {
    if (closing_since_) return;
    closing_since_ = Clock::now();
    last_ = protocol::encode(last);
    playing_ = false;
    publication_.reset();   // viewers need not wait for its last words
    wanted_.clear();
    ring();
}

void Viewer::fail(FailureCode code, const std::string& text) {
    if (!closing_since_) why_ = text;
    close_with(protocol::Failure{code, text});
}

void Viewer::reply(const protocol::Message& message) {
    if (replies_.size() >= kMaxReplies || reply_bytes_ >= kMaxReplyBytes)
        return fail(FailureCode::protocol, "too many questions without taking an answer");
    replies_.push_back(protocol::encode(message));
    reply_bytes_ += replies_.back().size();
    ring();
}

void Viewer::hold(std::uint64_t bytes) {
    shared_.queued_bytes += bytes - held_;
    held_ = bytes;
    std::uint64_t peak = shared_.peak_viewer_bytes;
    while (bytes > peak && !shared_.peak_viewer_bytes.compare_exchange_weak(peak, bytes)) {
    }
}

// ---- the viewer's messages ----

asio::awaitable<void> Viewer::read_messages() {
    while (!closing_since_) {
        auto raw = co_await wire_.read(publication_ ? publication_->limit() : protocol::kMaxControlBytes);
        if (closed_) co_return;
        if (!raw) {
            if (raw.error().code == ErrorCode::unavailable) {
                drop(raw.error().message);
                co_return;
            }
            fail(FailureCode::protocol, raw.error().message);
            break;
        }
        bool going = false;
        if (publication_ && !protocol::is_control(raw->type)) going = co_await take_published(std::move(*raw));
        else going = co_await handle(*raw);
        if (!going) break;
    }
    // Closing with unread bytes would reset the connection and take our last words with it.
    if (!closed_) co_await wire_.drain();
    drop(why_);
}

asio::awaitable<bool> Viewer::handle(const RawMessage& raw) {
    // Only what is small may be parsed at all: a few packed bytes of a BLOB could unpack to megabytes.
    if (!protocol::is_control(raw.type)) {
        fail(FailureCode::protocol, "a server takes no " + protocol::name_of(raw.type));
        co_return false;
    }
    const auto parsed = protocol::parse_body(raw.type, raw.body);
    if (!parsed) {
        const bool version = parsed.error().code == ErrorCode::unsupported_version;
        fail(version ? FailureCode::version : FailureCode::protocol, parsed.error().message);
        co_return false;
    }
    const protocol::Message& message = *parsed;
    if (!greeted_) {
        if (!std::holds_alternative<protocol::Hello>(message)) {
            fail(FailureCode::protocol, "HELLO must come first");
            co_return false;
        }
        greeted_ = true;
        shared_.log(fmt::format("viewer {} runs '{}'", number_, printable(std::get<protocol::Hello>(message).software)));
        reply(protocol::Hello{protocol::kWireVersion, "mien-serve"});
    } else if (const auto* ping = std::get_if<protocol::Ping>(&message)) {
        reply(protocol::Pong{ping->token, clock_us()});
    } else if (std::holds_alternative<protocol::ListStreams>(message)) {
        co_await list();
    } else if (std::holds_alternative<protocol::Bye>(message)) {
        drop("it said goodbye");
        co_return false;
    } else if (publication_) {
        fail(FailureCode::protocol, "a publisher sends no " + protocol::name_of(raw.type));
        co_return false;
    } else if (const auto* asked = std::get_if<protocol::Open>(&message)) {
        co_return co_await open(asked->name);
    } else if (const auto* offered = std::get_if<protocol::Publish>(&message)) {
        co_return co_await publish(offered->name);
    } else if (!stream_ && !live_) {
        fail(FailureCode::protocol, protocol::name_of(raw.type) + " must follow OPEN");
        co_return false;
    } else if (const auto* hashes = std::get_if<protocol::Want>(&message)) {
        std::vector<protocol::WantPart> wholes;
        for (const Hash& hash : hashes->hashes) wholes.push_back({hash});
        co_return want(wholes);
    } else if (const auto* part = std::get_if<protocol::WantPart>(&message)) {
        co_return want({*part});
    } else if (const auto* play = std::get_if<protocol::Play>(&message)) {
        playing_ = true;
        paused_ = false;
        rate_ = play->rate / 1000.0;
        generation_ = play->generation;
        set_position(double(play->time_us) / 1e6);
    } else if (const auto* select = std::get_if<protocol::Select>(&message)) {
        slots_ = select->slots;
        if (walk_) walk_->select(slots_);
        ring();
    } else if (!playing_) {
        fail(FailureCode::protocol, protocol::name_of(raw.type) + " must follow PLAY");
        co_return false;
    } else if (const auto* seek = std::get_if<protocol::Seek>(&message)) {
        generation_ = seek->generation;
        set_position(double(seek->time_us) / 1e6);
    } else if (const auto* pause = std::get_if<protocol::Pause>(&message)) {
        base_ = position();
        base_at_ = Clock::now();
        paused_ = pause->paused;
        ring();
    } else if (const auto* rate = std::get_if<protocol::SetRate>(&message)) {
        base_ = position();
        base_at_ = Clock::now();
        rate_ = rate->rate / 1000.0;
        ring();
    } else {
        fail(FailureCode::protocol, "a server takes no " + protocol::name_of(raw.type));
        co_return false;
    }
    co_return !closing_since_;
}

asio::awaitable<void> Viewer::list() {
    Library* library = &shared_.library;
    const auto work = [library] { return library->list(); };
    Library::Listing listing = co_await off_thread(shared_.files, work);
    protocol::StreamList streams{shared_.live.list()};
    for (auto& recorded : listing.streams)
        if (streams.streams.size() < protocol::kMaxStreams && !shared_.live.find(recorded.name)) streams.streams.push_back(std::move(recorded));
    std::ranges::sort(streams.streams, {}, &protocol::StreamEntry::name);
    reply(streams);
}

asio::awaitable<bool> Viewer::open(const std::string& name) {
    if (auto live = shared_.live.find(name)) {
        open_live(std::move(live));
        co_return true;
    }
    Library* library = &shared_.library;
    const auto work = [library, name] { return library->open(name); };
    auto opened = co_await off_thread(shared_.files, work);
    if (!opened) {
        fail(opened.error().code == ErrorCode::missing ? FailureCode::no_such_stream : FailureCode::damaged, opened.error().message);
        co_return false;
    }
    close_stream();
    stream_ = *opened;
    walk_.emplace(*stream_);
    shared_.log(fmt::format("viewer {} opened '{}'", number_, printable(name)));
    reply(stream_->header());
    reply(stream_->catalogue());
    co_return true;
}

bool Viewer::want(const std::vector<protocol::WantPart>& parts) {
    const auto& blobs = catalogue().blobs;
    for (const protocol::WantPart& part : parts) {
        if (std::ranges::find(blobs, part.hash, &protocol::BlobInfo::hash) == blobs.end()) {
            fail(FailureCode::no_such_blob, fmt::format("the stream has no static blob {}", part.hash.hex().substr(0, 8)));
            return false;
        }
    }
    if (wanted_.size() + parts.size() > blobs.size()) {
        fail(FailureCode::protocol, "more static blobs are asked for than there are");
        return false;
    }
    wanted_.insert(wanted_.end(), parts.begin(), parts.end());
    ring();
    return true;
}

double Viewer::position() const {
    if (paused_ || rate_ == 0) return base_;
    return base_ + rate_ * std::chrono::duration<double>(Clock::now() - base_at_).count();
}

void Viewer::set_position(double seconds) {
    base_ = seconds;
    base_at_ = Clock::now();
    if (live_) restart_live();
    else walk_->start(stream_->group_at(seconds));
    announce_ = true;
    ended_ = false;
    ring();
}

// ---- what the viewer gets ----

asio::awaitable<void> Viewer::write_messages() {
    for (;;) {
        bool going = true;
        if (!replies_.empty()) {
            const Bytes message = std::move(replies_.front());
            replies_.pop_front();
            reply_bytes_ -= message.size();
            going = co_await send(message);
        } else if (last_) {
            const Bytes message = *std::exchange(last_, {});
            if (co_await send(message)) wire_.finish_sending();  // the reader closes when the viewer has
            co_return;
        } else if (playing_ && live_) {
            going = co_await play_live();
        } else if (playing_) {
            going = co_await play_on();
        } else {
            going = co_await rest({});
        }
        if (!going || closed_) co_return;
    }
}

asio::awaitable<bool> Viewer::send(ByteView message) {
    hold(message.size() + reply_bytes_);
    const auto sent = co_await wire_.write(message);
    hold(0);
    if (!sent) {
        drop(sent.error().message);
        co_return false;
    }
    shared_.bytes_sent += message.size();
    co_return true;
}

asio::awaitable<bool> Viewer::send_blob(Hash hash) {
    if (live_) {
        const auto message = live_->blobs.at(hash);
        ++shared_.blobs_sent;
        co_return co_await send(*message);
    }
    const auto stream = stream_;
    const auto work = [stream, hash] { return stream->blob_message(hash); };
    const auto message = co_await off_thread(shared_.files, work);
    if (closed_) co_return false;
    if (!message) {
        fail(FailureCode::damaged, message.error().message);
        co_return true;
    }
    ++shared_.blobs_sent;
    co_return co_await send(*message);
}

asio::awaitable<bool> Viewer::send_part(protocol::WantPart wanted) {
    const auto stream = stream_;
    const auto kept = live_ ? live_->blobs.at(wanted.hash) : nullptr;
    const auto work = [stream, kept, wanted] { return kept ? part_of(*kept, wanted) : stream->blob_part(wanted.hash, wanted.offset, wanted.bytes); };
    const auto part = co_await off_thread(shared_.files, work);
    if (closed_) co_return false;
    if (!part) {
        fail(part.error().code == ErrorCode::invalid ? FailureCode::protocol : FailureCode::damaged, part.error().message);
        co_return true;
    }
    shared_.blobs_sent += wanted.offset + part->bytes.size() == part->total;
    const Bytes message = protocol::encode(*part);
    co_return co_await send(message);
}

asio::awaitable<bool> Viewer::play_on() {
    const auto stream = stream_;
    const protocol::IndexEntry* next = walk_->peek();
    if (announce_) {
        announce_ = false;
        const Bytes message = protocol::encode(protocol::Playing{generation_, next ? next->group : 0});
        co_return co_await send(message);
    }
    if (!next) {
        if (std::exchange(ended_, true)) co_return co_await rest({});
        const Bytes message = protocol::encode(protocol::End{stream->header().frames});
        co_return co_await send(message);
    }
    const protocol::IndexEntry entry = *next;
    if (paused_ || rate_ > 0) {
        const double early = stream->start_of(entry) - shared_.options.ahead - position();
        if (early > 0 || (paused_ && rate_ == 0)) {
            std::optional<Clock::duration> longest;
            if (!paused_) longest = seconds_of(early / rate_);
            co_return co_await rest(longest);
        }
    }
    walk_->pop();
    const auto work = [stream, entry] { return stream->group_message(entry); };
    const auto message = co_await off_thread(shared_.files, work);
    if (closed_) co_return false;
    if (announce_ || stream_ != stream) co_return true;  // a seek came while the disk was read
    if (!message) {
        shared_.log(fmt::format("viewer {} misses something: {}", number_, message.error().message));
        co_return true;
    }
    ++shared_.groups_sent;
    co_return co_await send(*message);
}

asio::awaitable<bool> Viewer::rest(std::optional<Clock::duration> longest) {
    if (wanted_.empty()) {
        co_await wait(longest);
        co_return true;
    }
    const protocol::WantPart wanted = wanted_.front();
    wanted_.pop_front();
    if (wanted.bytes == 0) co_return co_await send_blob(wanted.hash);
    co_return co_await send_part(wanted);
}

asio::awaitable<void> Viewer::wait(std::optional<Clock::duration> longest) {
    if (longest)
        bell_.expires_after(*longest);
    else
        bell_.expires_at(Clock::time_point::max());
    std::error_code rung;
    co_await bell_.async_wait(asio::redirect_error(asio::use_awaitable, rung));
}

// ---- time-outs ----

asio::awaitable<void> Viewer::watch() {
    const ServerOptions& options = shared_.options;
    const auto shortest = std::min({options.handshake_timeout, options.idle_timeout, options.stall_timeout});
    const auto step = std::clamp(shortest / 4, std::chrono::milliseconds(5), std::chrono::milliseconds(500));
    while (!closed_) {
        std::error_code ignored;
        guard_.expires_after(step);
        co_await guard_.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
        if (closed_) co_return;
        const auto now = Clock::now();
        if (closing_since_) {
            if (now - *closing_since_ > kLastWords) drop(why_);
        } else if (!greeted_ && now - since_ > options.handshake_timeout) {
            fail(FailureCode::timeout, "HELLO did not come in time");
        } else if (now - wire_.last_heard() > options.idle_timeout) {
            drop("nothing was heard of it for too long");
        } else if (wire_.stalled() > options.stall_timeout) {
            drop("it stopped taking what it asked for");
        }
    }
}

}  // namespace mien::net
