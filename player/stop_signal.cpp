#include "player/stop_signal.hpp"

#include <signal.h>

#include <atomic>

namespace mien::player {
namespace {

std::atomic<int> came = 0;
static_assert(std::atomic<int>::is_always_lock_free);

void handle(void (*handler)(int), int flags) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = flags;
    for (const int number : {SIGINT, SIGTERM}) ::sigaction(number, &action, nullptr);
}

}  // namespace

StopSignal::StopSignal() {
    came = 0;
    handle([](int number) { came = number; }, int(SA_RESETHAND));
}
StopSignal::~StopSignal() { handle(SIG_DFL, 0); }

int StopSignal::number() { return came; }

}  // namespace mien::player
