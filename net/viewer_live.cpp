#include <fmt/format.h>

#include <utility>

#include "net/off_thread.hpp"
#include "net/viewer.hpp"

/// Live streams: what a publisher sends, and how a viewer follows it.
namespace mien::net {

using protocol::FailureCode;

namespace {

bool from_this_machine(const asio::ip::tcp::socket& socket) {
    std::error_code error;
    const auto address = socket.remote_endpoint(error).address();
    if (error) return false;
    return address.is_v6() && address.to_v6().is_v4_mapped() ? asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).is_loopback()
                                                             : address.is_loopback();
}

std::string why_not(const std::string& name) {
    if (name.empty() || name[0] == '.' || name.find('/') != std::string::npos) return "a live stream needs a name, without / and not with . first";
    for (const char c : name)
        if (static_cast<unsigned char>(c) < 32 || c == 127) return "the name of a live stream must be printable";
    return {};
}

}  // namespace

void Viewer::close_stream() {
    if (live_) live_->leave(bell_);
    live_.reset();
    walk_.reset();
    stream_.reset();
    playing_ = announce_ = ended_ = false;
    slots_ = ~std::uint64_t(0);
    wanted_.clear();
}

asio::awaitable<bool> Viewer::publish(const std::string& name) {
    const auto refuse = [&](FailureCode code, const std::string& why) {
        fail(code, why);
        return false;
    };
    if (!shared_.options.publish) co_return refuse(FailureCode::no_publishing, "this server takes no live streams; start it with --publish");
    if (!from_this_machine(wire_.socket())) co_return refuse(FailureCode::no_publishing, "live streams are taken from the server's own machine only");
    if (stream_ || live_) co_return refuse(FailureCode::protocol, "PUBLISH does not follow OPEN");
    if (const std::string why = why_not(name); !why.empty()) co_return refuse(FailureCode::protocol, why);
    if (shared_.live.publishers() >= shared_.options.max_publishers)
        co_return refuse(FailureCode::busy, fmt::format("{} publishers are already here", shared_.options.max_publishers));
    if (!shared_.live.claim(name)) co_return refuse(FailureCode::name_taken, fmt::format("somebody else publishes '{}' now", name));
    publication_ = std::make_unique<Publication>(shared_.live, name, shared_.options.live_bytes);
    Library* library = &shared_.library;
    const auto work = [library, name] {
        const auto found = library->open(name);
        return found.ok() || found.error().code != ErrorCode::missing;
    };
    const bool recorded = co_await off_thread(shared_.files, work);
    if (closed_ || closing_since_) co_return false;
    if (recorded) co_return refuse(FailureCode::name_taken, fmt::format("'{}' is the name of a recording here", name));
    co_return true;
}

asio::awaitable<bool> Viewer::take_published(RawMessage raw) {
    // A blob may unpack to many megabytes, and its hash is over them.
    const auto shared_raw = std::make_shared<const RawMessage>(std::move(raw));
    const auto work = [shared_raw] { return protocol::parse_body(shared_raw->type, shared_raw->body); };
    const bool blob = shared_raw->type == static_cast<std::uint8_t>(protocol::MessageType::blob);
    if (blob && !publication_->awaits_blob()) {
        fail(FailureCode::protocol, "a static blob that was not asked for");
        co_return false;
    }
    std::optional<Result<protocol::Message>> message;
    if (blob) message = co_await off_thread(shared_.files, work);
    else message = work();
    if (closed_ || !publication_) co_return false;
    if (!message->ok()) {
        fail(FailureCode::protocol, message->error().message);
        co_return false;
    }
    const bool before = publication_->streaming();
    const auto answers = publication_->take(**message, *shared_raw);
    if (!answers) {
        fail(FailureCode::protocol, answers.error().message);
        co_return false;
    }
    for (const protocol::Message& answer : *answers) reply(answer);
    if (closing_since_) co_return false;
    if (publication_->streaming() && !before) shared_.log(fmt::format("viewer {} publishes '{}'", number_, publication_->name()));
    co_return true;
}

void Viewer::open_live(std::shared_ptr<LiveStream> stream) {
    close_stream();
    live_ = std::move(stream);
    live_->watch(bell_);
    shared_.log(fmt::format("viewer {} follows '{}'", number_, live_->name()));
    reply(live_->header());
    reply(live_->catalogue());
}

void Viewer::restart_live() {
    next_record_ = live_->newest();
    started_ = 0;
    live_group_.reset();
}

asio::awaitable<bool> Viewer::play_live() {
    const auto live = live_;
    if (live->superseded()) {
        fail(FailureCode::no_such_stream, fmt::format("'{}' is another stream now; open it again", live->name()));
        co_return true;
    }
    if (paused_) {
        // Who goes on after a pause goes on with what is new.
        const bool going = co_await rest({});
        if (!paused_ && live_ == live) restart_live();
        co_return going;
    }
    if (next_record_ < live->first()) restart_live();   // it was too slow
    const LiveStream::Record* record = live->at(next_record_);
    if (ended_ && record) ended_ = false, announce_ = true;   // a publisher has come back
    if (announce_) {
        announce_ = false;
        const Bytes message = protocol::encode(protocol::Playing{generation_, record ? record->group : live->next_group()});
        co_return co_await send(message);
    }
    if (!record) {
        if (live->live() || std::exchange(ended_, true)) co_return co_await rest({});
        const Bytes message = protocol::encode(protocol::End{live->frames()});
        co_return co_await send(message);
    }
    ++next_record_;
    const std::uint64_t bit = std::uint64_t(1) << record->slot;
    if (record->start) {
        if (live_group_ != record->group) live_slots_ = slots_;   // numbers never go back here
        live_group_ = record->group;
        live_slots_ & bit ? started_ |= bit : started_ &= ~bit;
    }
    if (!(started_ & bit)) co_return true;
    shared_.groups_sent += record->start;
    const std::shared_ptr<const Bytes> message = record->message;
    co_return co_await send(*message);
}

}  // namespace mien::net
